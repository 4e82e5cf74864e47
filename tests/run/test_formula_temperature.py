"""A temperature that a case gives as a formula: a moving front, shrinkage, and what check says."""

from pathlib import Path

import numpy as np
import pytest

import staffa
from staffa.case.check.preview import Preview, preview
from staffa.case.check.warnings import warnings
from staffa.case.reading.read import parse_case
from staffa.case.scales.case_scales import derived_numbers
from staffa.case.scales.pace import plan
from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import to_toml
from staffa.io.run_directory import CASE, Run, open_run
from staffa.io.vtkhdf import read_vtkhdf
from staffa.results.summary import summary
from support.commands import forked
from support.pages import without_scripts
from support.restarting import assert_same, cut_run, finish

FRONT = """
title = "drying front"
[domain]
size = [1.0, 0.5]
h = 0.025
[damage]
ell = 0.075
[temperature]
profile = "formula"
T = "-20*exp(-y/0.1)*where(x < 2*t, 1, 0.05)"
[supports]
left = "rollers"
right = "rollers"
[time]
t = [0.1, 0.2, 0.3]
[output]
at = [0.1, 0.3]
"""
IN_UNITS = """
[domain]
size = ["0.2 m", "0.1 m"]
h = "4 mm"
[material]
E = "65 GPa"
nu = 0.2
Gc = "61.5 J/m^2"
expansion = "6e-6 1/K"
[damage]
ell = "12 mm"
[temperature]
profile = "formula"
T = "-200*exp(-y/0.02)*(1 - exp(-t/60))"
face = "bottom"
[time]
t = { start = "10 s", stop = "10 min", shortest = "1 s", longest = "5 min" }
[measures]
depths = ["1 cm"]
"""


def front(*settings: str) -> Case:
    return parse_case(FRONT, settings)


def said(*settings: str, text: str = FRONT) -> Preview:
    return preview(parse_case(text, settings))


class Written:
    """The same temperature as a load of a script."""

    def temperature(self, x, t):
        """In Python."""
        return -20 * np.exp(-x[1] / 0.1) * np.where(x[0] < 2 * t, 1, 0.05)


def test_a_formula_gives_what_the_same_load_of_a_script_gives(tmp_path: Path) -> None:
    staffa.run(front(), tmp_path / "case")
    staffa.run(front("temperature={}"), tmp_path / "script", temperature=Written())
    case, script = (open_run(tmp_path / name) for name in ("case", "script"))
    assert case.steps[-1].energies.surface > 0
    for one, other in zip(case.steps, script.steps, strict=True):
        assert one.energies.elastic == pytest.approx(other.energies.elastic, rel=1e-12)
        assert one.energies.surface == pytest.approx(other.energies.surface, rel=1e-12)
    assert case.manifest.split == script.manifest.split == "no-tension"


@pytest.fixture(scope="module")
def behind(tmp_path_factory) -> Run:
    directory = tmp_path_factory.mktemp("front") / "run"
    staffa.run(front(), directory)
    return open_run(directory)


def test_rock_breaks_behind_a_moving_front_alone(behind: Run) -> None:
    """Ahead of it the drop is 1, less than the 2.2 that damages rock. The front is at 2 t."""
    reached = []
    for time, reach in ((0.1, 0.2), (0.3, 0.6)):
        (step,) = [s for s in behind.steps if s.time == pytest.approx(time)]
        grid, fields = read_vtkhdf(behind.path / step.fields)
        x, y = grid.points[:, 0], grid.points[:, 1]
        expected = -20 * np.exp(-y / 0.1) * np.where(x < 2 * time, 1, 0.05)
        assert fields["T"] == pytest.approx(expected, abs=1e-5)
        damaged = x[fields["alpha"] > 0.05]
        assert damaged.size and damaged.max() < reach + 2 * 0.075
        reached.append(damaged.max())
    assert reached[1] > reached[0] + 0.3, "it has followed the front"


def test_a_run_without_a_face_has_no_depths_no_tau_and_no_drop(behind: Run, tmp_path) -> None:
    manifest = behind.manifest
    assert manifest.profile == "formula" and manifest.face is None
    assert set(manifest.taus) == {None} and {step.tau for step in behind.steps} == {None}
    assert not manifest.scales["dT"] and manifest.scales["severity"] is None
    assert not behind.steps[-1].measures.tips or behind.steps[-1].measures.front == 0
    facts = {fact.name: fact.text for fact in summary(behind)}
    assert "face" not in facts["body"] and "severity" not in facts["damage"]
    assert "a formula of the temperature" in facts["damage"]


def test_depths_count_from_the_face_that_is_given(tmp_path: Path) -> None:
    case = front('temperature.face="bottom"', "measures.depths=[0.05]", "time.t=[0.3]", "output={}")
    staffa.run(case, tmp_path / "run")
    run = open_run(tmp_path / "run")
    assert run.manifest.face == "bottom" and not run.manifest.cools
    assert run.steps[-1].measures.tips and run.steps[-1].measures.sections
    assert "depths from face 'bottom'" in {fact.name: fact.text for fact in summary(run)}["body"]


@pytest.mark.slow
def test_a_page_is_drawn_of_it(behind: Run) -> None:
    assert forked("report", behind.path).returncode == 0
    page = without_scripts((behind.path / "report.html").read_text())
    assert (behind.path / "pictures" / "cracks.png").exists() and "drying front" in page
    assert "severity" not in page and "ΔT its largest" in page


def test_rock_that_only_warms_does_not_break_by_default(tmp_path: Path) -> None:
    """Held on all sides it is pressed by 20 times the drop that would break it."""
    held = [f'supports.{side}="rollers"' for side in ("bottom", "top")]
    case = front('temperature.T="50*t/0.3"', *held, "output={}")
    steps = staffa.run(case, tmp_path / "run")
    assert steps[-1].energies.elastic > 100 and steps[-1].energies.surface == 0


def test_a_jump_at_the_start_belongs_to_the_first_step(tmp_path: Path) -> None:
    """A change that does not depend on time acts, and as a face that is cold at once."""
    case = front('temperature.T="-9*exp(-y/0.15)"', "output={}")
    first, *later = staffa.run(case, tmp_path / "run")
    assert first.energies.surface > 0
    assert later[-1].energies.total == pytest.approx(first.energies.total, rel=1e-6)


def test_a_stopped_run_goes_on_to_the_bit(behind: Run, tmp_path: Path) -> None:
    cut_run(front(), tmp_path / "cut", 9)
    finish(tmp_path / "cut", 60)
    assert_same(open_run(tmp_path / "cut"), behind)


def test_a_case_is_written_and_read_as_the_same(behind: Run) -> None:
    text = to_toml(front())
    assert 'face = "none"' in text and 'T = "-20*exp' in text
    assert to_toml(parse_case(text)) == text == (behind.path / CASE).read_text()
    assert not front().temperature.has_face and front('temperature.face="top"').temperature.has_face


def test_steps_that_adapt_end_where_the_formula_jumps() -> None:
    steps = "time.t={start=0.01,stop=0.5,shortest=0.001,longest=0.1}"
    case = front('temperature.T="-9*y*where((t > 0.2) & (t < 0.3), 1, 0.2)"', steps, "output={}")
    pace = plan(case, derived_numbers(case)).pace
    assert pace is not None and pace.growth is None
    assert {round(t, 6) for t in pace.knots} == {0.2, 0.3}


def test_check_tells_the_changes_and_what_may_press() -> None:
    known = said()
    facts = {name: (value, told) for name, value, told in known.facts}
    assert facts["change of temperature"][0] == "-20 to 0"
    assert facts["energy split"][0] == "no-tension"
    assert facts["will it crack"][0] == "perhaps" and "severity" not in facts
    assert not any("sqrt(kappa t)" in name for name in facts)
    in_units = {name: value for name, value, _ in said(text=IN_UNITS).facts}
    assert in_units["change of temperature"] == "-200 K to 0 K"


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        (('temperature.T="0*t"',), "temperature.T is 0 at all places"),
        (('temperature.T="-0.5*t*exp(-y)"',), "hardly anything will crack: temperature.T spans"),
        (('temperature.T="-9*exp(-y)*sin(10*pi*t)"',), "temperature.T: at t = 0.15, between the"),
        (('temperature.T="-9*exp(-y)*t"',), "the rock is uniform and temperature.T changes along"),
        (('damage.split="none"',), "a formula of the temperature, which may warm"),
    ],
)
def test_check_warns(settings, sentence) -> None:
    assert any(sentence in warning for warning in said(*settings).warnings), said(*settings)


def test_a_front_that_passes_between_steps_is_no_warning() -> None:
    case = front()
    assert not [w for w in warnings(case, derived_numbers(case)) if "temperature.T" in w]

"""Two runs side by side: do they agree, from when on not, in tables, in pictures, on a page."""

import json
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from case.test_bad_input import check_sentence, files_in, sentence_of, staffa
from report.test_report import (
    BOX,
    ELL,
    SLAB,
    TAUS,
    N,
    assert_shows_something,
    cut_into_columns,
    drawn_run,
    rewritten,
)
from staffa.case.reading.read import parse_case
from staffa.case.reading.ready_cases import ready_case
from staffa.case.schema.toml_text import to_toml
from staffa.compare.agreement import agreement, gap_between_steps
from staffa.compare.differences import case_differences, manifest_differences
from staffa.compare.figures import damage_difference as damage_difference
from staffa.compare.figures import pair_figures
from staffa.compare.open_pair import place_of, read_pair
from staffa.compare.pair import Pair, caveats
from staffa.compare.side_by_side import common_times, results, shown_difference
from staffa.errors import StaffaError
from staffa.io.own_files import GENERATOR, write_aside
from staffa.io.run_directory import CASE, MANIFEST, STEPS, Run, fields_name, open_run
from staffa.io.vtkhdf import VtkMesh
from staffa.plot.frames import Frame, read_frames
from staffa.records.manifest import Own
from staffa.records.status import Status
from staffa.records.step import Energies, Step
from staffa.report.drawing import draw_pair
from staffa.results.tables import ABSENT, Table
from support.pages import without_scripts

BODY = """title = "A drawn slab"
[domain]
size = {size}
h = 0.025
[damage]
ell = 0.04
[temperature]
severity = 54.0
[time]
tau = [0.02, 0.5]
"""
IN_UNITS = """title = "A drawn slab"
[domain]
size = ["25 mm", "10 mm"]
h = "0.25 mm"
[material]
E = "70 GPa"
Gc = "10 J/m^2"
expansion = "9e-6 1/K"
kappa = "0.5 mm^2/s"
[damage]
ell = "0.4 mm"
[temperature]
severity = 54.0
[time]
tau = [0.02, 0.5]
"""
LATE = 15  # from this step on the changed runs differ


def run_at(path: Path, size: tuple[float, ...] = SLAB, *, n: int = 16, **changes: object) -> Run:
    """A drawn run whose case can be read."""
    drawn_run(path, size, n=n, **changes)
    write_aside(path / CASE, BODY.format(size=list(size)))
    return open_run(path)


def changed(run: Run, change: Callable[[Step], Step], *, first: int = 0) -> Run:
    """The run with other records from a step on."""
    return rewritten(run, [change(s) if s.index >= first else s for s in run.steps])


def stiffer(step: Step) -> Step:
    """A step with a total energy that is a twentieth higher, all of it elastic."""
    e = step.energies
    return replace(step, energies=Energies(elastic=e.elastic + 0.05 * e.total, surface=e.surface))


def with_a_crack_less(step: Step) -> Step:
    m = step.measures
    assert m is not None
    return replace(step, measures=replace(m, tips=m.tips[:-1]))


def told(pair: Pair) -> dict[str, str]:
    return {fact.name: fact.text for fact in agreement(pair)}


def cells(found: Table, row: str) -> tuple[str, ...]:
    return next(line[1:] for line in found.rows if line[0] == row)


@pytest.fixture
def coarse(monkeypatch: pytest.MonkeyPatch) -> None:
    """Pictures of few pixels, for tests that do not look at them."""
    monkeypatch.setattr("staffa.plot.style.DPI", 40)


@pytest.fixture(scope="module")
def slab(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A drawn run that kept its fields twice: pictures of many panels take long."""
    kept = tuple(i in (16, 24) for i in range(len(TAUS)))
    return run_at(tmp_path_factory.mktemp("slab") / "run", requested=kept).path


@pytest.fixture
def pair(slab: Path, tmp_path: Path) -> Pair:
    """The same run twice."""
    shutil.copytree(slab, tmp_path / "a")
    shutil.copytree(slab, tmp_path / "b")
    return read_pair(tmp_path / "a", tmp_path / "b")


def again(pair: Pair) -> Pair:
    """Read again, after a change."""
    return read_pair(pair.first.run.path, pair.second.run.path)


# ---- numbers ------------------------------------------------------------------------------------


def test_the_same_run_twice_agrees_in_everything(pair) -> None:
    found = told(pair)
    assert found["common times"] == "25 of 25 and of 25 steps, tau = 0.02 to tau = 0.5"
    assert found["total energy"] == "the same, to round-off, at all common times"
    assert found["number of cracks"] == "the same at all common times"
    assert found["deepest crack"] == "as deep at all common times"
    assert not any(fact.alarm for fact in agreement(pair))
    assert case_differences(pair).rows == manifest_differences(pair).rows == ()
    assert {row[3] for row in results(pair).rows} <= {"0", ABSENT}
    assert list(caveats(pair)) == []


def test_runs_are_said_to_differ_from_the_first_time_on_at_which_they_do(pair) -> None:
    changed(pair.second.run, lambda s: with_a_crack_less(stiffer(s)), first=LATE)
    other = again(pair)
    found, at = told(other), f"tau = {TAUS[LATE]:.4g}"
    # 5 % of the one are 1/21 of the other, over which it is taken.
    assert found["total energy"].startswith(f"more than 1 % apart from {at} on; at most 4.8 %")
    assert f"elastic {1 / 21:.1e}" in found["largest differences"]
    assert "surface 0.0e+00" in found["largest differences"]
    assert found["number of cracks"].startswith(f"first differs at {at}, {N} and {N - 1};")
    assert [fact.name for fact in agreement(other) if fact.alarm] == [
        "total energy",
        "number of cracks",
    ]
    assert cells(results(other), "cracks") == (str(N), str(N - 1), "-1")
    assert cells(results(other), "total energy")[2] == "+5 %"
    apart = [row[-1] for row in common_times(other).rows]
    assert apart == ["0 %"] * 5 + ["4.8 %"] * 3


def test_runs_that_come_together_again_are_not_said_to_differ_from_then_on(pair) -> None:
    run = pair.second.run
    rewritten(run, [stiffer(s) if s.index == LATE else s for s in run.steps])
    assert "on, later closer again; at most 4.8 %" in told(again(pair))["total energy"]
    assert told(again(pair))["total energy"].endswith("0 % at the last common time")


def test_small_differences_are_within_a_percent(pair) -> None:
    def little(step: Step) -> Step:
        return replace(step, energies=replace(step.energies, elastic=step.energies.elastic + 1e-3))

    changed(pair.second.run, little, first=LATE)
    assert told(again(pair))["total energy"].startswith("within 1 % at all common times: at most 0")


def test_the_energy_of_loads_is_shown_where_there_are_any(pair) -> None:
    assert not any("loads" in row[0] for row in results(pair).rows)

    def loaded(step: Step) -> Step:
        return replace(step, energies=replace(step.energies, loads=-20.0))

    for run, more in ((pair.first.run, loaded), (pair.second.run, lambda s: loaded(stiffer(s)))):
        changed(run, more)
    other = again(pair)
    assert cells(results(other), "energy of loads") == ("-20", "-20", "0")
    # At tau = .02 there are no cracks: 1.02 elastic, of which a twentieth more, and -20.
    row = common_times(other).rows[0]
    assert row[-1] == f"{100 * 0.051 / 21.071:.2g} %" and row[-2] == "-18.98 / -18.93"


def test_loads_that_take_the_total_to_zero_blow_up_no_difference(pair) -> None:
    """Over the sizes of the energies, added up: a twentieth of the elastic one at most."""

    def floating(step: Step) -> Step:
        e = step.energies
        return replace(step, energies=replace(e, loads=-e.elastic - e.surface))

    def more(step: Step) -> Step:
        e = step.energies
        return replace(step, energies=replace(e, elastic=1.01 * e.elastic))

    for run, change in ((pair.first.run, floating), (pair.second.run, lambda s: more(floating(s)))):
        changed(run, change)
    other = again(pair)
    assert told(other)["total energy"].startswith("within 1 % at all common times")
    assert "; loads 0.0e+00" in told(other)["largest differences"]
    assert "over the larger sum of their sizes" in told(other)["largest differences"]
    _, apart = gap_between_steps(other)
    assert 0 < apart.max() <= 0.005


def test_times_of_one_run_alone_are_left_to_the_curves(pair) -> None:
    run = pair.second.run
    rewritten(run, [s for s in run.steps if s.index % 3 == 0])
    other = again(pair)
    assert told(other)["common times"].startswith("9 of 25 and of 9 steps")
    assert other.common[:, 0].tolist() == list(range(0, 25, 3))
    at, apart = gap_between_steps(other)
    assert at == pytest.approx(TAUS)
    # Where cracks nucleate, at tau = .06, energies leap; 0.06 is a time of both, 0.04 and 0.02 not.
    leap = [s.energies.total for s in run.steps[:4]]
    ends = leap[0], leap[3]
    between = np.interp(TAUS[1:3], TAUS[[0, 3]], ends)
    expected = abs(between - leap[1:3]) / np.maximum(between, leap[1:3])
    assert apart[1:3] == pytest.approx(expected)
    assert "total energies, interpolated, at most" in told(other)["between steps"]


def test_runs_without_a_common_time_are_compared_between_their_steps(pair) -> None:
    def later(step: Step) -> Step:
        assert step.tau is not None
        return replace(step, tau=step.tau + 0.003)

    changed(pair.second.run, later)
    other = again(pair)
    found = told(other)
    assert found["common times"] == "0 of 25 and of 25 steps"
    assert set(found) == {"common times", "between steps"}
    assert common_times(other).rows == ()
    assert "no time in common" in common_times(other).notes[0]
    assert any("end at different times" in sentence for sentence in caveats(other))


def test_only_keys_that_differ_are_listed_with_their_defaults(pair) -> None:
    path = pair.second.run.path / CASE
    text = BODY.format(size=[2.5, 1.0]).replace("ell = 0.04", 'ell = 0.04\nlaw = "AT2"')
    write_aside(path, text.replace("[time]", "[toughness]\namplitude = 0.1\n[time]"))
    assert case_differences(again(pair)).rows == (
        ("damage.law", '"AT1"', '"AT2"'),
        ("toughness.amplitude", "0.0", "0.1"),
        ("toughness.correlation_length", ABSENT, "0.08"),  # 2 ell, where there is a field
    )


def test_faces_that_a_shape_names_are_compared_too() -> None:
    case = ready_case("wellbore")
    other = parse_case(to_toml(case), ['heat.hole.T="60 °C"'])

    def differing(own_load: object) -> list[str]:
        run = SimpleNamespace(manifest=SimpleNamespace(own_load=own_load, own=None))
        sides = [SimpleNamespace(case=c, run=run) for c in (case, other)]
        found = case_differences(SimpleNamespace(sides=sides, names=("a", "b")))
        return [row[0] for row in found.rows]

    assert differing(None) == ["heat.hole"]
    assert differing("a load") == [], "the case's cooling does not act under a load of a script"


def test_laws_of_scripts_are_told_by_their_identities(tmp_path) -> None:
    mine = Own(identity="Mine(p=2)", values=(0.0, 1.0))
    yours = replace(mine, identity="Yours()")
    near, apart = (replace(mine, values=(0.0, 1.0 + d)) for d in (1e-13, 1e-3))

    def told(one: dict[str, Own], other: dict[str, Own], mesh: str = "m") -> tuple:
        for name, own in (("a", one), ("b", other)):
            shutil.rmtree(tmp_path / name, ignore_errors=True)
            run_at(tmp_path / name, own=own, mesh=mesh if name == "b" else "m")
        return case_differences(read_pair(tmp_path / "a", tmp_path / "b")).rows

    said = "Mine(p=2), of a script"
    assert told({"damage": mine}, {"damage": yours}) == (
        ("damage.law", said, "Yours(), of a script"),
    )
    assert told({"damage": mine, "split": yours}, {}) == (
        ("damage.law", said, '"AT1"'),
        ("damage.split", "Yours(), of a script", '"none"'),
    )
    assert told({"damage": mine}, {"damage": near}) == ()
    assert told({"damage": mine}, {"damage": apart}) == (
        ("damage.law", said, f"{said}, but with other values"),
    )
    assert told({"temperature": mine}, {"temperature": apart}, mesh="finer") == ()
    later = replace(apart, at=(0.0, 2.0))
    assert told({"temperature": mine}, {"temperature": later}) == (), "it was tried at other times"
    (row,) = told({"temperature": mine}, {"temperature": apart})
    assert row[2] == f"{said}, but with other values"
    for plane, rows in (("strain", ["material.plane"]), ("stress", ["damage.split"])):
        told({"split": mine}, {"split": apart})
        write_aside(
            tmp_path / "b" / CASE,
            f'{BODY.format(size=list(SLAB))}[material]\nplane = "{plane}"\n',
        )
        found = case_differences(read_pair(tmp_path / "a", tmp_path / "b")).rows
        assert [row[0] for row in found] == rows, "tried at as many strains in the same plane only"
    assert told({"temperature": mine}, {})[0] == ("temperature", said, "of the case")


def test_the_same_number_in_another_unit_is_no_difference(pair) -> None:
    write_aside(pair.first.run.path / CASE, IN_UNITS)
    write_aside(pair.second.run.path / CASE, IN_UNITS.replace('"10 mm"', '"1 cm"'))
    assert case_differences(again(pair)).rows == ()


def test_facts_of_the_runs_that_differ_are_listed(tmp_path) -> None:
    run_at(tmp_path / "a")
    run_at(tmp_path / "b", n=8, ranks=3, mesh="other", tip_reach=0.06, adaptive=True)
    pair = read_pair(tmp_path / "a", tmp_path / "b")
    assert manifest_differences(pair).rows == (
        ("ranks", "2", "3"),
        ("adaptive", "no", "yes"),
        ("mesh", "0123456789abcdef", "other"),
        ("tip reach", ABSENT, "0.06"),
    )
    assert told(pair)["deepest crack"].startswith("at most 0.06 apart (1.5 ell)")


def in_units(path: Path) -> Run:
    """The drawn slab again, of 25 x 10 mm and in SI: lengths times L = 10 mm, energies Gc L."""
    L, size = 0.01, 0.01 * 10

    def enlarged(step: Step) -> Step:
        m, e = step.measures, step.energies
        assert m is not None
        tips = tuple(
            replace(t, position=tuple(L * x for x in t.position), depth=L * t.depth) for t in m.tips
        )
        measures = replace(
            m,
            tips=tips,
            sections=tuple(replace(s, height=L * s.height) for s in m.sections),
            front=L * m.front,
            length_surface=L * m.length_surface,
            length_geometry=L * m.length_geometry,
        )
        energies = Energies(elastic=size * e.elastic, surface=size * e.surface)
        return replace(step, time=200 * step.time, energies=energies, measures=measures)

    times = tuple(200 * float(tau) ** 2 / 4 for tau in TAUS)
    lengths = {"h": 0.025 * L, "ell": ELL * L, "L": L, "times": times}
    run = drawn_run(path, scaled=False, **lengths)
    write_aside(path / MANIFEST, manifest_text(run, size=[2.5 * L, L]))
    write_aside(path / CASE, IN_UNITS)
    return changed(open_run(path), enlarged)


def manifest_text(run: Run, **changes: object) -> str:
    record = json.loads((run.path / MANIFEST).read_text(encoding="utf-8"))
    return json.dumps(record | changes)


def test_a_scaled_run_agrees_with_the_same_one_in_units(tmp_path) -> None:
    run_at(tmp_path / "bare")
    in_units(tmp_path / "dressed")
    pair = read_pair(tmp_path / "dressed", tmp_path / "bare")
    found = told(pair)
    assert found["total energy"] == "the same, to round-off, at all common times"
    assert found["deepest crack"] == "as deep at all common times"
    (said,) = caveats(pair)
    assert said.startswith("bare is scaled and dressed has units: lengths are over L, energies")
    whole = results(pair)
    assert cells(whole, "total energy (Gc L)")[2] == "0"
    assert cells(whole, "spacing (L)") == ("0.1562", "0.1562", "0")
    assert cells(whole, "cracks at 0.2 L") == ("8", "8", "0")
    assert cells(whole, "generation 1, depth (L)") == ("0.14", "0.14", "0")


def test_without_tau_a_scaled_run_has_no_time_in_common_with_one_in_units(tmp_path) -> None:
    bare, dressed = run_at(tmp_path / "bare"), in_units(tmp_path / "dressed")
    for run in (bare, dressed):
        changed(run, lambda step: replace(step, tau=None))
    pair = read_pair(bare.path, dressed.path)
    assert pair.clock is None and len(pair.common) == 0
    assert any("no time in common" in sentence for sentence in caveats(pair))
    assert cells(results(pair), "last time") == (ABSENT, ABSENT, ABSENT)
    drawn = draw_pair(pair, tmp_path / "out")
    assert drawn.pictures == () and any("no clock" in reason for reason in drawn.skipped)


def test_of_bodies_of_two_sizes_no_difference_is_given_that_depends_on_size(tmp_path) -> None:
    run_at(tmp_path / "a")
    run_at(tmp_path / "b", (2.0, 1.0))
    pair = read_pair(tmp_path / "a", tmp_path / "b")
    assert set(told(pair)) == {"common times", "deepest crack"}
    assert "(2.5 x 1, 2 x 1)" in " ".join(caveats(pair))
    assert cells(results(pair), "total energy")[2] == ABSENT
    assert cells(results(pair), "deepest crack")[2] == "0"
    assert "apart" not in common_times(pair).header


def test_columns_are_compared_at_equal_depths(tmp_path) -> None:
    cut_into_columns(run_at(tmp_path / "a", BOX, n=4), (6, 6, 5), (6, 7))
    cut_into_columns(run_at(tmp_path / "b", BOX, n=4), (6, 6, 6, 6, 6))
    found = results(read_pair(tmp_path / "a", tmp_path / "b"))
    assert cells(found, "cells at 0.1")[:2] == ("4", "6")
    assert cells(found, "spacing at 0.1") == ("0.5", "0.5", "0")
    assert not any(row[0].startswith("cells at 0.2") for row in found.rows), "of one run only"


def test_two_dimensions_are_compared_with_three_in_depths_and_times(tmp_path) -> None:
    run_at(tmp_path / "flat")
    run_at(tmp_path / "solid", BOX, n=4)
    pair = read_pair(tmp_path / "flat", tmp_path / "solid")
    assert "flat is 2-D and solid is 3-D" in " ".join(caveats(pair))
    assert common_times(pair).header == ("tau", "cracks", "spacing", "deepest crack")
    assert not any("energy" in row[0] for row in results(pair).rows)
    assert cells(results(pair), "first crack, tau") == ("0.06", "0.06", "0")
    assert cells(results(pair), "deepest crack")[2] == "0"
    drawn = draw_pair(pair, tmp_path / "out")
    assert [picture.name for picture in drawn.pictures] == ["growth-of-both.png"]
    assert len(drawn.skipped) == 2


@pytest.mark.parametrize(
    ("a", "b", "said"),
    [
        (4, 4, "0"),
        (4, 2, "-2"),
        (2.0, 2.5, "+25 %"),
        (1.0, 0.99997, "-0.003 %"),
        (1.0, 1 + 1e-15, "0"),
        (0.0, 1.0, ABSENT),
        (None, 1.0, ABSENT),
    ],
)
def test_a_difference_is_of_the_second_against_the_first(a, b, said) -> None:
    assert shown_difference(a, b) == said


# ---- fields -------------------------------------------------------------------------------------


def test_fields_of_one_mesh_are_compared_in_whatever_order_its_points_come(pair) -> None:
    """Another number of ranks writes them in another order."""
    run = pair.first.run
    (one,), _ = read_frames(run, [run.steps[-1]])
    order = np.random.default_rng(0).permutation(len(one.alpha))
    grid = VtkMesh(points=one.grid.points[order], cells=one.grid.cells, type=one.grid.type)
    higher = one.alpha + 0.1 * one.grid.points[:, 0]
    other = replace(one, grid=grid, alpha=higher[order])
    found = damage_difference(one, other)
    assert found is not None
    assert found == pytest.approx(0.1 * one.grid.points[:, 0])
    smaller = with_points(other, 0.01 * other.grid.points)
    assert damage_difference(one, smaller) is None
    assert damage_difference(one, smaller, 100.0) == pytest.approx(found)


def test_fields_of_two_meshes_are_not_subtracted(pair) -> None:
    run = pair.first.run
    (one,), _ = read_frames(run, [run.steps[-1]])
    moved = one.grid.points.copy()
    moved[7, 0] += 0.01
    assert damage_difference(one, with_points(one, moved)) is None
    assert damage_difference(one, with_points(one, moved[:-1])) is None


def with_points(frame: Frame, points: np.ndarray) -> Frame:
    return replace(frame, grid=replace(frame.grid, points=points))


# ---- the page -----------------------------------------------------------------------------------


def test_the_page_holds_the_tables_and_pictures_that_show_something(pair, tmp_path) -> None:
    changed(pair.second.run, stiffer, first=LATE)
    other = again(pair)
    drawn = draw_pair(other, tmp_path / "deep" / "out")
    assert [picture.stem for picture in drawn.pictures] == [
        "cracks-of-both",
        "energies-of-both",
        "growth-of-both",
    ]
    assert drawn.skipped == () and drawn.tables == ()
    for picture in drawn.pictures:
        assert_shows_something(picture)
    text = without_scripts(drawn.page.read_text(encoding="utf-8"))
    assert text.count("data:image/png;base64,") == 3 and "://" not in text
    assert "<title>a and b</title>" in text and text.count('class="alarm"') == 1
    for found in (results(other), common_times(other)):
        for row in found.rows:
            assert "".join(f"<td>{cell}</td>" for cell in row) in text
    assert "Version, ranks, mesh and derived numbers do not differ." in text
    runs = [side.run.path for side in pair.sides]
    assert f"staffa compare {runs[0]} {runs[1]} --out {tmp_path / 'deep' / 'out'}" in text
    assert not list((tmp_path / "deep").rglob("*.staffa-part"))


@pytest.mark.usefixtures("coarse")
def test_a_page_is_written_over_an_earlier_one_and_touches_nothing_else(pair, tmp_path) -> None:
    changed(pair.second.run, lambda step: replace(stiffer(step), fields=None))
    runs = [files_in(side.run.path) for side in pair.sides]
    out = tmp_path / "out"
    out.mkdir()
    (out / "report.html").write_text(f"earlier {GENERATOR}")
    (out / "tips.csv").write_text("mine")
    drawn = draw_pair(again(pair), place_of(pair, out))
    assert "4.8 %" in drawn.page.read_text(encoding="utf-8")
    assert (out / "tips.csv").read_text() == "mine"
    assert [files_in(side.run.path) for side in pair.sides] == runs


@pytest.mark.usefixtures("coarse")
def test_lost_fields_are_left_out_with_the_name_of_the_run(pair, tmp_path) -> None:
    (pair.second.run.path / fields_name(24)).unlink()
    drawn = draw_pair(pair, tmp_path / "out")
    assert len(drawn.pictures) == 3
    assert drawn.skipped == (f"b: {fields_name(24)} is left out: it is not there",)
    for step in pair.first.run.steps:
        (pair.first.run.path / fields_name(step.index)).unlink(missing_ok=True)
    drawn = draw_pair(pair, tmp_path / "out")
    assert [picture.stem for picture in drawn.pictures] == ["energies-of-both", "growth-of-both"]
    assert any("no time whose fields" in reason for reason in drawn.skipped)


def test_pictures_of_two_cases_in_unlike_units_are_in_those_of_the_first(tmp_path) -> None:
    """One of 25 mm, one of 0.025 m: both are 25 mm long in the picture."""
    in_units(tmp_path / "mm")
    meters = in_units(tmp_path / "m")
    units = {"length": {"name": "m"}, "time": {"name": "h", "size": 3600.0}}
    write_aside(meters.path / MANIFEST, manifest_text(meters, units=units))
    figures, _ = pair_figures(read_pair(tmp_path / "mm", tmp_path / "m"))
    panels = [axes for axes in figures["cracks-of-both"]().axes if axes.get_xlabel()[:1] == "x"]
    assert {axes.get_xlabel() for axes in panels} == {"x (mm)"} and len(panels) == 3
    assert [axes.get_xlim() for axes in panels] == [pytest.approx((0, 25))] * 3
    for axes in panels[:2]:
        assert "t = 12.5 s" in axes.get_title(loc="left")


def test_numbers_of_cracks_have_whole_ticks_also_where_there_are_none(pair) -> None:
    def uncracked(step: Step) -> Step:
        assert step.measures is not None
        return replace(step, measures=replace(step.measures, tips=(), front=0.0))

    for side in pair.sides:
        changed(side.run, uncracked)
    figures, _ = pair_figures(again(pair))
    axes = figures["growth-of-both"]().axes[-1]
    assert axes.get_ylabel() == "cracks" and axes.get_ylim()[0] == 0
    ticks = list(axes.get_yticks())
    assert len(ticks) >= 2 and ticks == [round(tick) for tick in ticks]


@pytest.mark.slow
@pytest.mark.usefixtures("coarse")
def test_long_bodies_are_drawn_in_one_column(tmp_path) -> None:
    for name in ("a", "b"):
        run_at(tmp_path / name, (5.0, 1.0), n=6)
    pair = read_pair(tmp_path / "a", tmp_path / "b")
    assert len(draw_pair(pair, tmp_path / "out").pictures) == 3


@pytest.mark.slow
def test_bodies_in_three_dimensions_are_rendered_side_by_side(tmp_path) -> None:
    for name in ("a", "b"):
        run_at(tmp_path / name, BOX, n=10, requested=(False,) * 24 + (True,))
    drawn = draw_pair(read_pair(tmp_path / "a", tmp_path / "b"), tmp_path / "out")
    assert drawn.pictures[0].stem == "cracks-of-both", drawn.skipped
    assert_shows_something(drawn.pictures[0])


# ---- what is refused ----------------------------------------------------------------------------


def refused(one: Path, other: Path) -> str:
    return sentence_of(lambda: read_pair(one, other))


def test_the_same_run_by_two_names_is_refused(pair, tmp_path) -> None:
    here = pair.first.run.path
    (tmp_path / "link").symlink_to(here)
    for same in (here, tmp_path / "link"):
        check_sentence(refused(here, same), "are the same run", "name two different ones")


def test_what_is_no_run_is_refused(pair, tmp_path) -> None:
    here = pair.first.run.path
    check_sentence(refused(here, tmp_path / "none"), "none is no run directory", "`staffa run`")
    check_sentence(refused(tmp_path, here), "is no run directory", "name a folder")
    (tmp_path / "e").mkdir()
    here.rename(tmp_path / "e" / "seed-7")
    said = refused(pair.second.run.path, tmp_path / "e")
    check_sentence(said, "e is an ensemble", "name one of its runs", "e/seed-7")


def test_a_run_that_is_not_finished_is_refused(pair) -> None:
    run = pair.second.run
    rewritten(run, list(run.steps[:7]))
    said = refused(pair.first.run.path, run.path)
    check_sentence(said, "b is not finished (7 of 25 steps; still going on", "let it end")
    bad = replace(run.steps[-1], status=Status.NOT_CONVERGED, reason="out of sweeps")
    rewritten(run, [*run.steps[:-1], bad])
    said = refused(run.path, pair.first.run.path)
    check_sentence(said, "is not finished (not converged at step 24", "out of sweeps")


@pytest.mark.parametrize(
    ("name", "content"),
    [
        (MANIFEST, "no JSON"),
        (MANIFEST, "[3]"),
        (MANIFEST, '{"format": 1}'),
        (MANIFEST, '{"format": 1, "times": 3, "taus": 3, "requested": 3, "size": 3}'),
        (MANIFEST, '{"format": 9, "version": "9.0.0"}'),
        (STEPS, "no JSON\n"),
        (STEPS, "{}\n"),
        (CASE, "no TOML"),
        (CASE, 'title = "no body"\n'),
        (CASE, None),
    ],
)
def test_a_damaged_run_is_refused(pair, name, content) -> None:
    file = pair.second.run.path / name
    file.unlink()
    if content is not None:
        file.write_text(content)
    said = refused(pair.first.run.path, pair.second.run.path)
    check_sentence(said.replace(str(pair.second.run.path), "b"), "b")
    with pytest.raises(StaffaError) as caught:
        again(pair)
    assert caught.value.exit_code == 2


def test_records_that_are_no_text_are_damaged(pair) -> None:
    (pair.second.run.path / STEPS).write_bytes(b"\xff\xfe\n")
    check_sentence(refused(pair.first.run.path, pair.second.run.path), "line 1 is damaged")


def test_a_page_goes_where_no_run_and_no_ensemble_is(pair, tmp_path) -> None:
    here = pair.first.run.path
    assert place_of(pair, None) == Path("runs/a-vs-b")
    check_sentence(sentence_of(lambda: place_of(pair, here)), "holds a run already")
    check_sentence(sentence_of(lambda: place_of(pair, here / CASE)), "is a file")
    (tmp_path / "e").mkdir()
    pair.second.run.path.rename(tmp_path / "e" / "seed-0")
    check_sentence(sentence_of(lambda: place_of(pair, tmp_path / "e")), "holds an ensemble")


@pytest.mark.slow
def test_the_command_prints_the_tables_and_says_where_the_page_is(pair, tmp_path) -> None:
    changed(pair.second.run, stiffer, first=LATE)
    done = staffa(tmp_path, "compare", "a", "b")
    assert done.returncode == 0, done.stderr
    for said in ("more than 1 % apart", "The cases do not differ.", "generation 1, depth", "4.8 %"):
        assert said in done.stdout
    assert done.stdout.splitlines()[-1] == "runs/a-vs-b/report.html"
    assert (tmp_path / "runs" / "a-vs-b" / "report.html").is_file()


@pytest.mark.slow
def test_the_command_refuses_in_one_sentence_and_writes_nothing(pair, tmp_path) -> None:
    before = files_in(tmp_path)
    done = staffa(tmp_path, "compare", "a", "b", "--out", "b")
    assert done.returncode == 2 and done.stdout == "", done
    assert (
        done.stderr == "staffa: --out b holds a run already; choose another folder or remove it\n"
    )
    assert files_in(tmp_path) == before

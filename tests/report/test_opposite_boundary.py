"""A crack that has come to the side across from the cooled face, in the summary and on the page."""

from dataclasses import replace
from pathlib import Path

import pytest

from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case
from staffa.io.run_directory import Run, open_run
from staffa.records.manifest import Manifest
from staffa.records.status import Status
from staffa.records.step import Energies, Measures, Step, Tip
from staffa.report.page import page
from staffa.results.summary import summary
from staffa.runs.run import run as run_case

ELL, H, L = 0.04, 0.01, 1.0
REACH = 0.035  # from the last damaged vertex to the sharp tip


def drawn(depths: list[float], **changes: object) -> Run:
    """A run whose deepest crack has these depths, a step each."""
    times = tuple(0.1 * (i + 1) for i in range(len(depths)))
    whole = Manifest(
        version="0.1.0", commit=None, created="2026-01-01T00:00:00+00:00", ranks=1, title="deep",
        law="AT1", scaled=True, size=(2.0, L), face="bottom", h=H, ell=ELL, L=L, cells=20000,
        unknowns=60000, mesh="0", toughness_factor=1.1, times=times, taus=times,
        requested=(False,) * len(depths), scales={"dT": 10.0}, versions={}, petsc_options={},
        tip_reach=REACH,
    )  # fmt: skip
    manifest = replace(whole, **changes)  # type: ignore[arg-type]
    return Run(
        path=Path("deep"), case="", manifest=manifest, steps=tuple(map(step, range(9), depths))
    )


def step(index: int, depth: float) -> Step:
    tips = (Tip(position=(0.5, depth), depth=depth),) if depth else ()
    measures = Measures(
        sections=(), tips=tips, front=depth, length_surface=depth, length_geometry=depth
    )
    time = 0.1 * (index + 1)
    return Step(
        index=index, time=time, tau=time, energies=Energies(elastic=1.0, surface=depth), sweeps=3,
        status=Status.CONVERGED, reason="converged", measures=measures,
    )  # fmt: skip


def told(run: Run) -> str | None:
    return next((fact.text for fact in summary(run) if fact.name == "opposite boundary"), None)


def test_the_first_step_that_reaches_it_is_told() -> None:
    """Within ell of it: a sharp tip at 0.96, which is REACH beyond the recorded one."""
    run = drawn([0.3, 0.92, 0.93, 0.99])
    found = told(run)
    assert found is not None and found.startswith(
        "a crack reached it by step 2, t = 0.3, tau = 0.3"
    )
    assert "at a depth of 0.965 of 1" in found and "no more of deep rock" in found
    assert "a crack reached it by step 2" in page(run, (), (), ())


@pytest.mark.parametrize("depths", [[0.3, 0.92], [0.0, 0.0]])
def test_of_cracks_that_stop_before_nothing_is_told(depths: list[float]) -> None:
    assert told(drawn(depths)) is None


def test_without_a_cooled_face_there_is_no_opposite_boundary() -> None:
    assert told(drawn([0.99], face=None)) is None


# A quenched plate of alumina, half of its thickness, that rollers hold or that may shorten.
PLATE = """
[domain]
size = ["4 mm", "5 mm"]
h = "50 um"
[material]
E = "370 GPa"
nu = 0.22
Gc = "42 J/m^2"
expansion = "8e-6 1/K"
k = "20 W/(m K)"
rho = "3900 kg/m^3"
c = "900 J/(kg K)"
[damage]
ell = "150 um"
[toughness]
amplitude = 0.1
[temperature]
profile = "heat"
face = "bottom"
[heat]
initial = "500 °C"
bottom = { h = "20000 W/(m^2 K)", T = "20 °C" }
[time]
t = { start = "20 ms", stop = "1 s", steps = 8 }
[output]
at = ["20 ms", "100 ms", "300 ms", "1 s"]
"""
HELD = ("supports.left=rollers", "supports.right=rollers", "supports.top=rollers")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("supports", "through"),
    [
        (HELD, True),
        pytest.param(("supports.section=stretch",), False, marks=pytest.mark.long),
    ],
)
def test_a_plate_between_rollers_cracks_through_and_both_say_so(
    supports: tuple[str, ...], through: bool, tmp_path: Path
) -> None:
    """Depths of 5.00 mm, through, and 3.59 mm."""
    case = parse_case(PLATE, supports)
    noted = [
        n for n in preview(case).notes if "supports of left, right: the body is constrained" in n
    ]
    assert bool(noted) == through
    run_case(case, tmp_path / "run")
    run = open_run(tmp_path / "run")
    assert (told(run) is not None) == through
    measures = run.steps[-1].measures
    assert measures is not None
    deepest = run.manifest.sharp(measures.front)
    assert deepest == pytest.approx(5e-3 if through else 3.59e-3, abs=0.05e-3), "to a cell"

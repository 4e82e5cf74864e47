"""The steps of a run as a pandas frame."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

import staffa
from report.test_report import HEIGHTS, SLAB, TAUS, N, drawn_run, rewritten
from staffa.errors import InputError
from staffa.io.step_columns import DERIVED, fields_of
from staffa.records.manifest import QuantityRecord
from staffa.records.status import Status
from staffa.records.step import Fluid, Heat, Step
from support.paths import DOCS

PAGE = DOCS / "reference" / "results.md"


@pytest.fixture
def run_folder(tmp_path: Path) -> Path:
    """A drawn run with a rejected step, and a last one with heat, a fluid and forces."""
    run = drawn_run(tmp_path / "run", n=2, tip_reach=0.03)
    last = run.steps[-1]
    assert last.measures is not None
    whole = replace(
        last,
        measures=replace(last.measures, fluid=Fluid(pressure=2e6, volume=1e-3)),
        heat=Heat(stored=-3.0, entered={"bottom": -3.0}),
        reactions={"left": (5.0, -7.0)},
    )
    rewritten(run, [*run.steps[:-1], replace(last, status=Status.REJECTED), whole])
    return run.path


def test_a_frame_has_a_row_for_each_step_that_was_kept(run_folder: Path) -> None:
    run = staffa.open_run(str(run_folder))
    frame = run.to_frame()
    assert frame["step"].tolist() == list(range(len(TAUS))) == [s.index for s in run.steps]
    assert frame["tau"].tolist() == pytest.approx(TAUS)
    assert set(frame["status"]) == {"converged"}
    totals = [step.energies.total for step in run.steps]
    assert frame["energies_total"].tolist() == totals
    assert (frame["energies_elastic"] + frame["energies_surface"]).tolist() == totals


def test_a_run_without_steps_has_a_frame_without_rows(run_folder: Path) -> None:
    run = staffa.open_run(run_folder)
    manifest = replace(run.manifest, quantities=(QuantityRecord(name="lid", unit="m", numbers=2),))
    steps = tuple(replace(step, quantities={"lid": (7.0, 8.0)}) for step in run.steps)
    whole = replace(run, manifest=manifest, steps=steps).to_frame()
    empty = replace(run, manifest=manifest, steps=()).to_frame()
    # What depends on depths, supports and boundaries is known from the first step on.
    told_by_steps = ("cracks_at_", "reaction_", "heat_from_")
    assert len(empty) == 0
    assert list(empty) == [name for name in whole if not name.startswith(told_by_steps)]


def test_what_a_step_lacks_is_not_a_number(run_folder: Path) -> None:
    frame = staffa.open_run(run_folder).to_frame()
    assert frame["heat_stored"].isna().tolist() == [True] * 24 + [False]
    last = frame.iloc[-1]
    assert (last["heat_stored"], last["heat_from_bottom"]) == (-3.0, -3.0)
    assert (last["measures_fluid_pressure"], last["measures_fluid_volume"]) == (2e6, 1e-3)
    assert (last["reaction_left_x"], last["reaction_left_y"]) == (5.0, -7.0)
    assert frame["stability_bifurcation"].dtype == float and frame["stability_failure"][0] is None


def test_cracks_are_counted_and_the_deepest_ends_at_its_sharp_tip(run_folder: Path) -> None:
    frame = staffa.open_run(run_folder).to_frame()
    uncracked, last = frame.iloc[0], frame.iloc[-1]
    assert (uncracked["cracks"], uncracked["deepest"]) == (0, 0.0)
    assert last["cracks"] == N and last["deepest"] == pytest.approx(0.53)
    assert last["spacing"] == pytest.approx(SLAB[0] / N)
    assert [last[f"cracks_at_{depth:g}"] for depth in HEIGHTS] == [16, 8, 4]


def test_a_quantity_takes_the_column_of_no_other_number(run_folder: Path) -> None:
    run = staffa.open_run(run_folder)
    manifest = replace(run.manifest, quantities=(QuantityRecord(name="deepest", unit="m"),))
    steps = tuple(replace(step, quantities={"deepest": (7.0,)}) for step in run.steps)
    frame = replace(run, manifest=manifest, steps=steps).to_frame()
    assert frame["deepest"].tolist() == run.to_frame()["deepest"].tolist()
    assert frame["quantities_deepest"].tolist() == [7.0] * len(steps)


def test_every_number_and_text_of_a_step_has_a_column_that_the_documentation_lists(
    run_folder: Path,
) -> None:
    columns = set(staffa.open_run(run_folder).to_frame())
    section = PAGE.read_text(encoding="utf-8").split("## All steps as a frame")[1].split("\n## ")[0]
    names = [field.name for field in fields_of()]
    assert len(set(names)) == len(names) and {*names, *DERIVED} <= columns
    assert [name for name in (*names, *DERIVED) if f"`{name}`" not in section] == []
    by_name = {"heat_from_bottom", "reaction_left_x", "reaction_left_y"}
    rest = columns - {*names, *DERIVED} - by_name
    assert rest == {f"cracks_at_{depth:g}" for depth in HEIGHTS}
    scalars = {name for name, kind in Step.__annotations__.items() if kind in (int, float, str)}
    assert scalars - {"index"} <= set(names)


def test_without_pandas_a_sentence_says_how_to_get_it(run_folder: Path, monkeypatch) -> None:
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(InputError, match=r"needs pandas.*pip install 'staffa\[frames\]'"):
        staffa.open_run(run_folder).to_frame()


def test_a_frame_needs_no_finite_elements_and_a_run_no_pandas(run_folder: Path) -> None:
    code = (
        "import sys, staffa\n"
        "run = staffa.open_run(sys.argv[1])\n"
        "early = 'pandas' in sys.modules\n"
        "run.to_frame()\n"
        "heavy = {'dolfinx', 'petsc4py', 'mpi4py', 'ufl'} & set(sys.modules)\n"
        "print(early, sorted(heavy), 'pandas' in sys.modules)"
    )
    said = subprocess.run(
        [sys.executable, "-c", code, run_folder], capture_output=True, text=True, check=True
    )
    assert said.stdout.strip() == "False [] True"

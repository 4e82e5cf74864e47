"""The yardstick still runs, its two sides compute the same thing, and costs are foretold."""

import json
import shutil
import subprocess

import numpy as np
import pytest

from bench.common.cases import CASES
from bench.scaling import laws, pages
from bench.startup import run as startup
from bench.yardstick import table
from staffa.case.check.preview import preview
from staffa.case.reading.read import read_case
from support.paths import ROOT

BENCH = ROOT / "bench"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["A30k", "C120k", "D100k"])
def test_both_sides_take_the_same_path_without_newton(name: str, monkeypatch) -> None:
    """The script and plain alternation are two codes of one method: sweeps and energies agree."""
    from dataclasses import replace
    from functools import partial
    from types import SimpleNamespace

    from staffa.backend.stack import MPI

    from dolfinx import fem

    from bench.common.ours import Ours
    from bench.yardstick import script as script_module
    from staffa.backend import jit

    case = CASES[name]
    coarse = {2: (20, 20), 3: (6, 6, 6)}[case.dim]
    case = replace(case, counts=coarse, ell=0.2, tolerance=1e-3, times=case.times[:2])
    # DOLFINx's own cache waits in vain for a form that a killed process left half made.
    form = partial(jit.form, comm=MPI.COMM_SELF)
    monkeypatch.setattr(script_module, "fem", SimpleNamespace(**vars(fem) | {"form": form}))
    script = script_module.Script(case, MPI.COMM_SELF)
    ours = Ours(case, MPI.COMM_SELF, acceleration="none")
    for index, time in enumerate(case.times):
        state = {key: values.copy() for key, values in script.state().items()}
        ours.put(state, case.times[index - 1] if index else None)
        sweeps, found = script.step(time), ours.step(time)
        assert abs(found["sweeps"] - sweeps) <= 1
        assert found["energy"]() == pytest.approx(script.total_energy(), rel=1e-6)


def test_the_finest_cells_beside_the_script_are_no_longer_than_its_own() -> None:
    for case in CASES.values():
        assert case.halvings >= 2
        assert 0.9 * case.longest < case.finest(case.halvings) <= case.longest * (1 + 1e-9), (
            case.name
        )
    large = CASES["E680k"]
    assert min(large.size) / large.ell >= 20 - 1e-9
    assert large.ell / large.h >= 3 - 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("name", ["A30k", "C120k", "D100k"])
def test_a_mesh_that_follows_the_cracks_leads_to_the_script_s_energy(name: str) -> None:
    """From one state and by one step: no coarse cell is damaged, and the basin is the same."""
    from dataclasses import replace

    from staffa.backend.stack import MPI

    from bench.common.followed import Followed
    from bench.common.ours import Ours

    case = CASES[name]
    coarse, ell = {2: ((24, 24), 0.15), 3: ((8, 8, 8), 0.375)}[case.dim]
    case = replace(case, counts=coarse, ell=ell, times=case.times[:2])
    ours, followed = Ours(case, MPI.COMM_SELF), Followed(case, MPI.COMM_SELF)
    ours.put_at_rest()
    ours.step(case.times[0])
    start = ours.fields()
    expected = ours.step(case.times[1])["energy"]()
    followed.put(start, case.times[0])
    found = followed.step(case.times[1])
    assert found["coarse_damage"] <= (0.01 if case.law == "AT1" else 0.1)
    basin = ours.basin(start, case.times[1], followed.damage())
    assert basin["energy"] == pytest.approx(expected, rel=1e-3)


def test_the_tables_of_the_documents_are_those_of_the_results() -> None:
    """Pages that quote `bench/yardstick/table.py` have its output."""
    results = json.loads((BENCH / "yardstick" / "results.json").read_text())
    pages = {
        "performance.md": (table.ratios, table.refined, table.growth, table.ranks),
        "how-to/choose-a-solver.md": (table.presets,),
    }
    for page, tables in pages.items():
        text = (ROOT / "docs" / page).read_text(encoding="utf-8")
        for rows in tables:
            assert "\n".join(rows(results)) in text, f"docs/{page} is not up to date"


def drawn(scatter: float = 0.0) -> list[dict]:
    """Runs of 8 sweeps that follow a law: 2 s (N/R/10^4)^1.1 R^0.2 each, 0.3 GB R + 3 kB N."""
    noise = np.random.default_rng(1)
    return [
        {
            "unknowns": N,
            "ranks": R,
            "sweeps": 8,
            "seconds": 16 * (N / R / 1e4) ** 1.1 * R**0.2 * np.exp(scatter * noise.normal()),
            "peak_bytes": 0.3e9 * R + 3e3 * N,
        }
        for N in (1e4, 3e4, 1e5, 3e5)
        for R in (1, 2)
    ]


def test_a_law_that_runs_follow_is_found_and_foretells() -> None:
    found = laws.law(drawn())
    assert (found.p, found.s) == pytest.approx((1.1, 0.2)), f"{found}"
    assert (found.bytes_a_rank, found.bytes_an_unknown) == pytest.approx((0.3e9, 3e3))
    far = laws.predict(found, unknowns=3e7, ranks=500, steps=10, sweeps=4)
    assert far.seconds_a_sweep == pytest.approx(2 * 6**1.1 * 500**0.2)
    assert far.hours == pytest.approx(40 * far.seconds_a_sweep / 3600)
    assert far.core_hours == pytest.approx(500 * far.hours)
    assert pytest.approx(0.3 * 500 + 90) == far.GB
    assert far.factor == pytest.approx(1, abs=1e-6), "nothing scatters"


def test_the_factor_holds_scattered_runs_and_grows_with_the_distance() -> None:
    runs = drawn(0.05)
    pairs = laws.held_out(runs)
    assert {run["unknowns"] for run, _ in pairs} == {3e5}
    for run, foretold in pairs:
        off = 3600 * foretold.hours / run["seconds"]
        assert max(off, 1 / off) < foretold.factor < 1.5, f"{off} against {foretold.factor}"
    found = laws.law(runs)
    near, far = (
        laws.predict(found, unknowns=6e4 * ranks, ranks=ranks, steps=1, sweeps=1).factor
        for ranks in (2, 512)
    )
    assert 1 < near < far


def test_a_law_of_too_few_runs_is_refused() -> None:
    with pytest.raises(ValueError, match="four runs"):
        laws.law(drawn()[:2])


def test_the_costs_in_the_documents_are_those_of_the_results() -> None:
    """The page and the head of the batch script have the fit of `bench.scaling.run`."""
    results = pages.measured()
    assert pages.page(results) in pages.PAGE.read_text(encoding="utf-8")
    script = pages.SCRIPT.read_text(encoding="utf-8")
    assert pages.head(results) in script
    assert script.index(pages.head(results)) < script.index("set -euo"), "#SBATCH after a command"
    assert pages.PICTURE.exists() == (results is not None)


def test_the_batch_script_is_one_and_its_case_is_sound() -> None:
    checked = subprocess.run([shutil.which("bash") or "bash", "-n", pages.SCRIPT], timeout=60)
    assert checked.returncode == 0
    assert pages.CASE.name in pages.SCRIPT.read_text(encoding="utf-8")
    found = preview(read_case(pages.CASE)).warnings
    assert all("of memory are needed" in sentence for sentence in found), found


def test_commands_that_compute_nothing_start_within_their_bounds() -> None:
    """The last measurement, which `make bench` repeats, and the number of it in the document."""
    found = json.loads((BENCH / "startup" / "results.json").read_text())
    assert found["bounds"] == startup.BOUNDS
    for command, bound in startup.BOUNDS.items():
        assert 0 < found["cpu"][command] <= bound, f"{command}: {found['cpu'][command]} s"
    page = (ROOT / "docs" / "performance.md").read_text(encoding="utf-8")
    assert f"`staffa --help` takes {found['cpu']['staffa --help']:.1f} s" in page

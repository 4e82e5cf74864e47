"""The yardstick still runs, and its two sides compute the same thing."""

import importlib
import json
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
BENCH = ROOT / "bench"


@pytest.fixture
def bench(monkeypatch: pytest.MonkeyPatch):
    """Imports a module of the benchmark."""
    monkeypatch.syspath_prepend(str(BENCH))
    return importlib.import_module


@pytest.mark.slow
@pytest.mark.parametrize("name", ["A30k", "C120k", "D100k"])
def test_both_sides_take_the_same_path_without_newton(name: str, bench) -> None:
    """The script and plain alternation are two codes of one method: sweeps and energies agree."""
    from dataclasses import replace

    from staffa.stack import MPI

    case = bench("cases").CASES[name]
    coarse = {2: (20, 20), 3: (6, 6, 6)}[case.dim]
    case = replace(case, counts=coarse, ell=0.2, tolerance=1e-3, times=case.times[:2])
    script = bench("script").Script(case, MPI.COMM_SELF)
    ours = bench("ours").Ours(case, MPI.COMM_SELF, acceleration="none")
    for index, time in enumerate(case.times):
        state = {key: values.copy() for key, values in script.state().items()}
        ours.put(state, case.times[index - 1] if index else None)
        sweeps, found = script.step(time), ours.step(time)
        assert abs(found["sweeps"] - sweeps) <= 1
        assert found["energy"]() == pytest.approx(script.total_energy(), rel=1e-6)


@pytest.mark.slow
@pytest.mark.mpi
def test_a_side_alone_writes_down_its_step(tmp_path: Path) -> None:
    """The machinery of turns, on the smallest of the cases that run.py knows."""
    mpiexec = Path(sys.executable).parent / "mpiexec"
    command = [
        mpiexec,
        "-n",
        "2",
        sys.executable,
        BENCH / "side.py",
        "alone",
        "A30k",
        tmp_path,
        "1",
    ]
    subprocess.run(command, check=True, timeout=300)
    record = json.loads((tmp_path / "alone-0-0.json").read_text())
    assert (
        record["sweeps"] > 1
        and record["wall_s"] > 0
        and record["peak_MB"] > record["libraries_MB"] > 100
    )


def test_the_tables_of_the_documents_are_those_of_the_results(bench) -> None:
    """What `bench/table.py` prints stands in the pages that quote it."""
    table = bench("table")
    results = json.loads((BENCH / "results.json").read_text())
    pages = {
        "performance.md": (table.ratios, table.growth, table.ranks),
        "how-to-choose-a-solver.md": (table.presets,),
    }
    for page, tables in pages.items():
        text = (ROOT / "docs" / page).read_text(encoding="utf-8")
        for rows in tables:
            assert "\n".join(rows(results)) in text, f"docs/{page} is not up to date"

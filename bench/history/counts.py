"""Sweeps and iterations of small cases, on uniform meshes and on those that follow the cracks.

    python -m bench.history.counts

Counts do not depend on the machine's speed. The command appends today's to `counts.json`, under
the commit that it runs at; `tests/scripts/test_history.py` holds today's against the last.
"""

import json
from collections import Counter
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from staffa.backend.stack import MPI

from bench.common.cases import COUNTED, BenchCase
from bench.common.followed import followed_problem, no_measures
from bench.common.machine import versions
from bench.common.ours import mesh, problem
from staffa.evolution.march import Observers, march_session
from staffa.evolution.session import Session
from staffa.evolution.system import build
from staffa.model.domain import cell_count

HISTORY = Path(__file__).parent / "counts.json"
MESHES = ("uniform", "refined")
# Largest change of a count against the last one on record, as a fraction.
ALLOWED = 0.05


def counts(case: BenchCase, meshes: str) -> dict[str, int]:
    """Take all steps of a case, from the very start; what they took together.

    Parameters
    ----------
    case : one of `COUNTED`.
    meshes : one of `MESHES`.
    """
    comm = MPI.COMM_SELF
    if meshes == "refined":
        whole = followed_problem(case, comm)
    else:
        whole = replace(problem(case, mesh(case, comm)), second_order=None)
    session, found = Session(whole, build(whole)), Counter[str]()

    def swept(moment: object, sweep: object) -> None:
        found["sweeps_of_all_tries"] += 1

    for step in march_session(session, Observers(measure=no_measures, watch=swept)):
        found["sweeps"] += step.sweeps
        found["newton_iterations"] += step.effort.iterations
        found["newton_moves"] += step.effort.moves
        found["changes_of_mesh"] += step.mesh.changes if step.mesh else 0
    parts = session.system.alternation  # of the last mesh alone
    found["factorizations_or_set_ups"] = parts.elastic.linear.renewals
    found["displacement_iterations"] = parts.elastic.linear.iterations
    found["damage_iterations"] = sum(solver.iterations for solver in parts.bounded)
    found["cells"] = cell_count(session.domain)
    session.destroy()
    return dict(found)


def measured() -> dict[str, dict[str, int]]:
    """Counts of every case on both kinds of mesh."""
    return {
        f"{name}, {meshes}": counts(case, meshes)
        for name, case in COUNTED.items()
        for meshes in MESHES
    }


def last() -> dict:
    """Return the last entry of the history."""
    return json.loads(HISTORY.read_text())[-1]


def main() -> None:
    """Append today's counts; those of the same commit are replaced."""
    entry = {
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "versions": versions(),
        "counts": measured(),
    }
    entries = json.loads(HISTORY.read_text()) if HISTORY.exists() else []
    kept = [one for one in entries if one["versions"]["commit"] != entry["versions"]["commit"]]
    HISTORY.write_text(json.dumps([*kept, entry], indent=1) + "\n")
    for name, found in entry["counts"].items():
        print(f"{name:20}", " ".join(f"{key} {number}" for key, number in found.items()))


if __name__ == "__main__":
    main()

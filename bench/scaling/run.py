"""Cost of a cooled brick by size, ranks and cells; writes `results.json` and the pages.

    python -m bench.scaling.run [--largest UNKNOWNS] [--medium RUN] [--out FILE]

Each run is written down when it is done, and none that is there is run again: stop it and start it
as you like; delete FILE to measure again. On a quiet machine of two cores all but the largest size
took seven minutes, and that took four for hexahedra alone.
RUN: a finished run directory of a brick, for the number of sweeps in a step, and to hold its cost
against the prediction. Part of `make bench`.
"""

import argparse
import json
import resource
import subprocess
import sys
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter, process_time

from bench.common.machine import ROOT, environment, machine, versions

RESULTS = Path(__file__).parent / "results.json"
# Columns of cells along x and along y of a brick that is as deep as the ready case: a body that
# is wider by more rock of the same kind. About 10k, 30k, 100k and 300k displacement unknowns.
# Bricks of 22 and 39 columns are twice those of 15 and 27: as much for each of two ranks.
COLUMNS = (15, 22, 27, 39, 50, 87)
CELLS = ("hexahedron", "tetrahedron")
H = 0.077  # ell/1.8
RANKS = (1, 2)
# One step from rest until cracks are everywhere. It ends after this number of sweeps, converged or
# not: all sizes do the same work, Newton's moves included, in the expensive part of a run.
TAU, SWEEPS = 0.4, 8
TIMEOUT = 1200


def settings(columns: int, cells: str) -> list[str]:
    """Settings that make the ready case `brick` one of these runs."""
    width = columns * H
    return [
        f"domain.size=[{width}, {width}, 1.0]",
        f"domain.h={H}",
        f"domain.cells={cells}",
        f"time.tau=[{TAU}]",
        "output.at=[]",
        f"solver.sweeps={SWEEPS}",
    ]


def one(columns: int, cells: str) -> dict | None:
    """One of the runs, on the ranks there are; what it took, on rank 0."""
    from staffa.backend.stack import MPI

    import staffa

    libraries = _peak_bytes()
    comm = MPI.COMM_WORLD
    started = perf_counter()
    problem = staffa.problem(staffa.ready_case("brick", settings(columns, cells)))
    system = staffa.build(problem)
    built = perf_counter() - started
    cpu = process_time()
    step = next(iter(staffa.march(problem, system)))
    cpu = process_time() - cpu
    space = system.state.u.function_space
    unknowns = space.dofmap.index_map.size_global * space.dofmap.index_map_bs
    elastic = system.alternation.elastic
    found = {
        "cells": cells,
        "columns": columns,
        "ranks": comm.size,
        "unknowns": int(unknowns),
        "build_s": round(comm.allreduce(built, op=MPI.MAX), 2),
        "seconds": round(comm.allreduce(step.seconds, op=MPI.MAX), 2),
        "cpu_s": round(comm.allreduce(cpu), 2),
        "sweeps": step.sweeps,
        "energy": step.energies.total,
        "multigrid_iterations": elastic.linear.iterations,
        "multigrid_set_ups": elastic.linear.renewals,
        "newton_iterations": step.effort.iterations,
        "damage_iterations": sum(solver.iterations for solver in system.alternation.bounded),
        "peak_bytes": comm.allreduce(_peak_bytes()),
        "libraries_bytes": comm.allreduce(libraries),
    }
    return found if comm.rank == 0 else None


def _peak_bytes() -> int:
    """Largest resident memory of this rank so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def launch(columns: int, cells: str, ranks: int) -> dict:
    """One of the runs, in separate processes."""
    mpiexec = Path(sys.executable).parent / "mpiexec"
    this = [sys.executable, "-m", "bench.scaling.run", "--one", str(columns), cells]
    done = subprocess.run(
        [mpiexec, "-n", str(ranks), *this],
        env=environment(),
        cwd=ROOT,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
        timeout=TIMEOUT,
    )
    found = json.loads(done.stdout.splitlines()[-1])
    stamp = {"date": datetime.now(UTC).isoformat(timespec="seconds"), "versions": versions()}
    return found | stamp | {"machine": machine()}


def medium(folder: Path) -> dict:
    """Sweeps and seconds of a finished run of a brick, rejected steps included."""
    from staffa.case.reading.read import parse_case
    from staffa.io.run_directory import open_run

    run = open_run(folder)
    if not run.finished or len(run.manifest.size) != 3:
        raise SystemExit(f"--medium {folder} is not a finished run in 3-D; name one that is")
    every = [*run.steps, *run.superseded, *run.rejected]
    return {
        "title": run.manifest.title,
        "commit": run.manifest.commit,
        "cells": parse_case(run.case).domain.cells,
        "unknowns": run.manifest.unknowns * 3 // 4,  # the manifest counts the damage too
        "ranks": run.manifest.ranks,
        "steps": len(run.steps),
        "sweeps": sum(step.sweeps for step in every),
        "seconds": round(sum(step.seconds for step in every), 1),
    }


def main() -> None:
    """Run what is missing, from small to large, and write the pages."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--one", nargs=2, metavar=("COLUMNS", "CELLS"), help="one run, to stdout")
    parser.add_argument("--largest", type=float, default=float("inf"), help="unknowns, at most")
    parser.add_argument("--medium", type=Path, metavar="RUN", help="a finished run directory")
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    if arguments.one:
        found = one(int(arguments.one[0]), arguments.one[1])
        if found:
            print(json.dumps(found))
        return
    results = json.loads(arguments.out.read_text()) if arguments.out.exists() else {"runs": []}
    keys = [(n, cells, ranks) for n in COLUMNS for cells in CELLS for ranks in RANKS]
    there = {(run["columns"], run["cells"], run["ranks"]) for run in results["runs"]}
    for key in keys:
        # 3 (n + 1)^2 displacements in each of 14 layers of vertices.
        if key in there or 42 * (key[0] + 1) ** 2 > arguments.largest:
            continue
        results["runs"].append(launch(*key))
        arguments.out.write_text(json.dumps(results, indent=1) + "\n")
        print(line(results["runs"][-1]), flush=True)
    if arguments.medium:
        results["medium"] = medium(arguments.medium)
        arguments.out.write_text(json.dumps(results, indent=1) + "\n")
    if arguments.out == RESULTS and "medium" not in results:
        print("the pages stay as they are: they also need a finished run, --medium RUN")
    elif arguments.out == RESULTS:
        from bench.scaling import pages

        pages.write(results)


def line(run: dict) -> str:
    """One run on one line; what it had of its cores tells whether the machine was quiet."""
    had = run["cpu_s"] / (run["ranks"] * run["seconds"])
    return (
        f"{run['cells']:12}{run['unknowns']:9d} on {run['ranks']}: {run['seconds']:8.1f} s, "
        f"{run['sweeps']} sweeps, {run['peak_bytes'] / 1e9:.2f} GB, {100 * had:.0f} % of its cores"
    )


if __name__ == "__main__":
    main()

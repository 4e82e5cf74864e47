"""Growth of the time of a step with the unknowns and with ell, on a mesh that follows one crack.

    python -m bench.growth.run [FAMILY ...] [--largest UNKNOWNS] [--out FILE]

The displacement around the tip of a crack is prescribed on the sides of a plate (1 x 1) or a thick
plate (1 x 1 x 1/5), and the tip moves at each step by as much: the crack follows it. So crack and
steps are the same on every mesh.

- `unknowns-2d`, `unknowns-3d`: ell is fixed, and h falls, from 30k to 1M displacement unknowns;
- `ell-2d`, `ell-3d`: ell falls by a factor of 4, and h with it.

The coarsest cells are as long, at any h. Each run is written down when it is
done, and none that is there is run again; delete FILE to measure again. In FILE: exponents p with
seconds ~ unknowns^p, or ell^-p. Part of `make bench`.
"""

import argparse
import json
import resource
import subprocess
import sys
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from time import process_time

import numpy as np

from bench.common.machine import ROOT, environment, machine, versions

RESULTS = Path(__file__).parent / "results.json"
SIZE = {2: (1.0, 1.0), 3: (1.0, 1.0, 0.2)}
NU = 0.2
# The tip at the end of each step. The first puts the crack in place; each other moves it by about
# as much as the least ell of a family.
TIPS = (0.4, 0.42, 0.44, 0.46, 0.48, 0.5, 0.52)
# Stress intensity of the sides over sqrt(E Gc): the crack follows on cells of any toughness.
STRONGER = 1.15
# Longest edge of the cells at the start, which follows the body.
COARSEST = {2: 0.25, 3: 0.2}


@dataclass(frozen=True, kw_only=True)
class Run:
    """One run of a family.

    family : its name. ell : regularization length. cells : cells in ell. dim : 2 or 3.
    unknowns : displacement unknowns at the end, about.
    """

    family: str
    dim: int
    ell: float
    cells: float
    unknowns: float

    @property
    def name(self) -> str:
        """Family, ell and cells in it."""
        return f"{self.family}, ell = {self.ell:g}, h = ell/{self.cells:g}"


def family(name: str, dim: int, *runs: tuple[float, float, float]) -> tuple[Run, ...]:
    """Runs from (ell, cells in ell, unknowns about)."""
    return tuple(
        Run(family=name, dim=dim, ell=ell, cells=cells, unknowns=n) for ell, cells, n in runs
    )


FAMILIES = {
    "unknowns-2d": family(
        "unknowns-2d", 2, (0.08, 8, 3e4), (0.08, 16, 1.2e5), (0.08, 32, 4.5e5), (0.08, 48, 1e6)
    ),
    "ell-2d": family("ell-2d", 2, (0.06, 4, 9e3), (0.03, 4, 1.8e4), (0.015, 4, 3.6e4)),
    "unknowns-3d": family(
        "unknowns-3d", 3, (0.1, 4, 3e4), (0.1, 6, 1e5), (0.1, 9, 3.4e5), (0.1, 13, 1e6)
    ),
    "ell-3d": family("ell-3d", 3, (0.08, 3, 2e4), (0.04, 3, 8e4), (0.02, 3, 3.2e5)),
}


def moved(x: np.ndarray, t: float, *, axis: int, dim: int) -> np.ndarray:
    """A component of the displacement around a crack that ends at x = t, in mode I, with E = 1."""
    line = SIZE[dim][1] / 2
    r, theta = np.hypot(x[0] - t, x[1] - line), np.arctan2(x[1] - line, x[0] - t)
    along = (np.cos, np.sin)[axis](theta / 2)
    kappa = (3 - NU) / (1 + NU) if dim == 2 else 3 - 4 * NU
    return STRONGER * (1 + NU) * np.sqrt(r / (2 * np.pi)) * (kappa - np.cos(theta)) * along


def plate(run: Run):
    """The problem of a run, on a mesh that is fine around the crack."""
    from staffa.backend.stack import MPI

    from staffa.evolution.carry import refined_at_cracks
    from staffa.evolution.problem import Material, Problem, Refinement, Solvers
    from staffa.evolution.schedule import schedule
    from staffa.geometry.block import SIDES, halvings
    from staffa.loads.closed_form import NoLoad
    from staffa.model.domain import block
    from staffa.model.supports import SideSupport, rollers
    from staffa.physics.damage import AT1

    size, h = SIZE[run.dim], run.ell / run.cells
    domain = block(
        MPI.COMM_SELF,
        size=size,
        h=h,
        cells="triangle" if run.dim == 2 else "tetrahedron",
        halvings=halvings(COARSEST[run.dim], h, size),
    )
    components = {axis: partial(moved, axis=axis, dim=run.dim) for axis in range(2)}
    around = [side for side in SIDES[run.dim] if domain.axes[side] < 2]
    sides = [SideSupport(side=side, components=components) for side in around]
    sides += [rollers(domain, side) for side in SIDES[run.dim] if side not in around]
    return refined_at_cracks(
        Problem(
            domain=domain,
            material=Material(
                E=1.0,
                nu=NU,
                Gc=1.0,
                expansion=1.0,
                ell=run.ell,
                law=AT1(),
                state="plane stress" if run.dim == 2 else "solid",
                cracked=lambda x: (abs(x[1] - size[1] / 2) < 0.6 * h) & (x[0] < TIPS[0]),
            ),
            load=NoLoad(),
            schedule=schedule(TIPS),
            sides=tuple(sides),
            solvers=Solvers(displacement="direct" if run.dim == 2 else "iterative"),
            refinement=Refinement(ahead=2 * run.ell),
            second_order=None,
        )
    )


def one(run: Run) -> dict:
    """Take the steps of a run; what each after the first took."""
    from staffa.evolution.march import march_session
    from staffa.evolution.session import Session
    from staffa.evolution.system import build

    problem = plate(run)
    session = Session(problem, build(problem))
    steps, cpu = [], []
    marching, before = march_session(session), process_time()
    for step in marching:
        steps.append(step)
        cpu.append(process_time() - before)
        before = process_time()
    last = steps[-1].mesh
    assert last is not None
    return {
        **vars(run),
        "unknowns": run.dim * last.vertices,
        "cells_of_mesh": last.cells,
        "h": session.domain.h,
        "seconds": [step.seconds for step in steps[1:]],
        "cpu_s": cpu[1:],
        "sweeps": [step.sweeps for step in steps[1:]],
        "changes_of_mesh": [step.mesh.changes for step in steps[1:] if step.mesh],
        "energy": [step.energies.total for step in steps],
        "peak_MB": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024,
    }


def exponents(runs: dict[str, dict]) -> dict[str, dict]:
    """Fit the CPU time of a step by powers of unknowns and of 1/ell, in each family.

    Beside it stand the exponents of the sweeps, of the time of steps whose mesh stays as it is, and
    of the unknowns.
    """
    found = {}
    for name in FAMILIES:
        rows = [run for run in runs.values() if run["family"] == name]
        if len(rows) < 3:
            continue
        of = "1/ell" if name.startswith("ell") else "unknowns"
        at = [1 / run["ell"] if of == "1/ell" else run["unknowns"] for run in rows]
        calm = [
            [
                s
                for s, changed in zip(run["cpu_s"], run["changes_of_mesh"], strict=True)
                if not changed
            ]
            for run in rows
        ]
        found[name] = {
            "of": of,
            "exponent": slope(at, [np.mean(run["cpu_s"]) for run in rows]),
            "of_sweeps": slope(at, [np.mean(run["sweeps"]) for run in rows]),
            "of_unknowns": slope(at, [run["unknowns"] for run in rows]),
            "on_the_same_mesh": slope(at, [np.mean(some) for some in calm]) if all(calm) else None,
        }
    return found


def slope(at: list[float], values: list[float]) -> float:
    """Return the exponent p of values ~ at^p, by least squares."""
    return round(float(np.polyfit(np.log(at), np.log(values), 1)[0]), 3)


def main() -> None:
    """Run what is missing, from small to large."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("families", nargs="*", help=f"of {', '.join(FAMILIES)}; else all")
    parser.add_argument("--one", nargs=2, metavar=("FAMILY", "NUMBER"), help="one run, to stdout")
    parser.add_argument("--largest", type=float, default=float("inf"), help="unknowns, at most")
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(one(FAMILIES[arguments.one[0]][int(arguments.one[1])])))
        return
    results = json.loads(arguments.out.read_text()) if arguments.out.exists() else {"runs": {}}
    for chosen in arguments.families or FAMILIES:
        for number, run in enumerate(FAMILIES[chosen]):
            if run.name in results["runs"] or run.unknowns > arguments.largest:
                continue
            results["runs"][run.name] = launch(chosen, number)
            results["exponents"] = exponents(results["runs"])
            arguments.out.write_text(json.dumps(results, indent=1) + "\n")
            print(line(run, results["runs"][run.name]), flush=True)
    for name, found in exponents(results["runs"]).items():
        print(
            f"{name}: CPU time of a step ~ ({found['of']})^{found['exponent']}, "
            f"{found['on_the_same_mesh']} on the same mesh; sweeps ^{found['of_sweeps']}, "
            f"unknowns ^{found['of_unknowns']}"
        )


def launch(chosen: str, number: int) -> dict:
    """One of the runs, in a separate process."""
    command = [sys.executable, "-m", "bench.growth.run", "--one", chosen, str(number)]
    done = subprocess.run(
        command, env=environment(), cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True
    )
    found = json.loads(done.stdout.splitlines()[-1])
    return found | {"versions": versions(), "machine": machine()}


def line(run: Run, found: dict) -> str:
    """One run on one line."""
    steps = len(found["cpu_s"])
    return (
        f"{run.name:40}{found['unknowns']:9d} unknowns: {sum(found['cpu_s']) / steps:8.2f} s CPU "
        f"and {sum(found['sweeps']) / steps:.1f} sweeps a step"
    )


if __name__ == "__main__":
    main()

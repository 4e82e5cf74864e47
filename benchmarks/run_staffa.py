"""Run the cases with `staffa` in three ways, and write what was found as CSV files.

    python -m benchmarks.run_staffa [WAY [CASE ...]]

A way is a name in `WAYS`; without one, all of them, and without a case, all cases. Runs of the
command line stay in runs/benchmarks, and what is there is not run again.
The way `staffa` takes from `verification` what `make verify` has measured with the same settings.
"""

import csv
import json
import sys
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np

from benchmarks.make_tables import STARTS
from staffa.evolution.problem import Problem
from staffa.io.run_directory import Run
from verification.arrays.run import sharp_tip, stopped
from verification.common.runs import READY, run_once
from verification.common.symmetric_cracks import even_bands
from verification.energies.run import BODIES
from verification.onset.run import RATIOS, SEEDS, bands
from verification.surfing.run import CELLS

HERE = Path(__file__).parent
SUBMISSIONS = HERE / "submissions"
ROOT = HERE.parent
# The defaults; these with backtracking, which looks for lower minima; alternate minimization alone.
WAYS: dict[str, tuple[str, ...]] = {
    "staffa": (),
    "staffa-backtracking": ("solver.backtracking=true",),
    "alternate-minimization": (
        "solver.acceleration=none",
        "solver.guess=none",
        "solver.stability=none",
    ),
}
DEFAULTS, ALONE = "staffa", "alternate-minimization"
VERIFIED = ROOT / "verification"
# A row of a submission: quantity, where it holds (None for a single number), value.
Row = tuple[str, float | None, float]

# The crack of the bar costs 1.0828 Gc on these cells; with these, 1, at the strength asked for.
BAR = (
    "material.Gc=0.92357",
    "damage.ell=0.092357",
    "toughness.bands=[{lower=[0.48,0.0],upper=[0.52,0.3],factor=0.99}]",
    f"time.t={[0.7, *(round(0.762 + 0.002 * i, 3) for i in range(10)), 1.0]}",
    "output.at=[1.0]",
)
LENGTH, HEIGHT = 1.0, 0.3


def _run(way: str, case: str, name: str, *settings: str) -> Run:
    """A run of a ready case, made unless it is there already."""
    path = (READY / f"{case}.toml").relative_to(ROOT).as_posix()
    return run_once(path, f"../benchmarks/{way}/{name}", (*settings, *WAYS[way]))


def _verified(file: str, check: str, **quantities: str) -> list[Row]:
    """Figures that `make verify` measured with the defaults, by the names in its records."""
    figures = json.loads((VERIFIED / file / "expected.json").read_text())[check]["figures"]
    found = {figure["what"]: figure["measured"] for figure in figures}
    return [(name.replace("_", " "), None, found[what]) for name, what in quantities.items()]


def bar(way: str) -> list[Row]:
    """Largest stress, and energy of the crack."""
    run = _run(way, "bar", "bar", *BAR)
    strain = np.array([0.25 * step.time for step in run.steps])
    energies = [step.energies for step in run.steps]
    # An even bar of linear rock: half of stress times strain is its energy.
    stress = [2 * e.elastic / s / LENGTH / HEIGHT for e, s in zip(energies, strain, strict=True)]
    return [("strength", None, max(stress)), ("crack energy", None, energies[-1].surface)]


def surfing(way: str) -> list[Row]:
    """Speed and cost of a crack that a tip drives."""
    from fem.test_surfing import THRESHOLDS, ride

    if way == DEFAULTS:
        on = "AT1, h = ell/4"
        what = {"speed": "speed over that of the tip", "cost": "energy of a new unit of crack"}
        return _verified("surfing", "surfing", **{k: f"{v}, {on}" for k, v in what.items()})
    change = _alone if way == ALONE else _unchanged
    found = ride("AT1", cells_per_ell=4, radius=8, cells=CELLS["AT1"], change=change)
    speed = float(found.speed[THRESHOLDS.index(0.8)])
    return [("speed", None, speed), ("cost", None, found.toughness / found.factor)]


def _unchanged(problem: Problem) -> Problem:
    return problem


def _alone(problem: Problem) -> Problem:
    solvers = replace(problem.solvers, acceleration="none", guess="none")
    return replace(problem, solvers=solvers, second_order=None)


def _growth(run: Run, quantity: str) -> list[Row]:
    """Length of the sharp crack, step by step."""
    return [
        (quantity, step.tau, step.measures.front + sharp_tip(run))
        for step in run.steps
        if step.tau is not None and step.measures is not None
    ]


def array(way: str) -> list[Row]:
    """Length of an even array's cracks, ends fixed and free."""
    rows = []
    for section in ("fixed", "free"):
        run = _run(way, "array", f"array-{section}", f"supports.section={section}")
        rows += _growth(run, f"length, {section}")
    return rows


# Columns of cells by the spacing; odd: the crack is the middle one.
COLUMNS = {0.2: 65, 0.3: 97}


def spacing(way: str) -> list[Row]:
    """Length of an even array's cracks at other spacings."""
    rows = []
    for p, columns in COLUMNS.items():
        h, middle, depth = p / columns, p / 2, STARTS[p]
        # As in the ready case `array`: rock beside the initial crack is too tough to break.
        shallow, near = depth - 0.03, 0.02
        sides = ((0.0, middle - near), (middle + near, p))
        tough = [f"{{lower=[0.0,0.0],upper=[{p},{shallow}],factor=110.0}}"] + [
            f"{{lower=[{a},{shallow}],upper=[{b},{depth - 0.01}],factor=110.0}}" for a, b in sides
        ]
        settings = (
            f"domain.size=[{p},1.0]",
            f"domain.h={h}",
            f"toughness.bands=[{','.join(tough)}]",
            f"cracks=[{{start=[{middle},0.0],end=[{middle},{depth}]}}]",
            "time.tau={start=0.05,stop=0.16,steps=12}",
            "output.at=[0.16]",
        )
        rows += _growth(_run(way, "array", f"spacing-{p}", *settings), f"length, p = {p}")
    return rows


def _arrest(run: Run) -> list[Row]:
    """Length and tau at which a crack stops; infinite if both are equally long at the end."""
    last = run.steps[-1].measures
    assert last is not None
    if np.ptp([tip.depth for tip in last.tips]) < 3 * run.manifest.h:
        return [("arrest length", None, np.inf), ("arrest tau", None, np.inf)]
    a, tau = stopped(run, (0, 1))
    return [("arrest length", None, a), ("arrest tau", None, tau)]


def _verified_arrest(what: str) -> list[Row]:
    """An arrest with ell = 0.00433."""
    names = {"arrest_length": f"a, {what}", "arrest_tau": f"tau, {what}"}
    return _verified("arrays", "doubling", **names)


def doubling(way: str) -> list[Row]:
    """The arrest of one of two equal cracks."""
    if way == DEFAULTS:
        return _verified_arrest("alike, by default")
    times = "time.tau={start=0.08,stop=0.12,steps=21}"
    even = even_bands(READY / "two-cracks.toml")
    return _arrest(_run(way, "two-cracks", "doubling", even, times, "output.at=[0.12]"))


def pair(way: str) -> list[Row]:
    """The arrest of one of two cracks that is tougher by 1 %."""
    if way == DEFAULTS:
        return _verified_arrest("toughness 1 % apart")
    return _arrest(_run(way, "two-cracks", "pair", "output.at=[0.112]"))


def onset(way: str) -> list[Row]:
    """Distance of the first bands of damage, and the time at which they are seen."""
    if way == DEFAULTS:
        names = {"wavelength": "wavelength", "depth_of_cooling": "sqrt(kappa t)"}
        of = f"over sqrt(ell ell0), bands from noise, dT/dT_c = {RATIOS[0]:g}"
        return _verified("onset", "onset", **{k: f"{v} {of}" for k, v in names.items()})
    found = np.array([bands(RATIOS[0], seed, *WAYS[way]) for seed in SEEDS]).mean(axis=0)
    return [("wavelength", None, float(found[0])), ("depth of cooling", None, float(found[1]))]


def energies(way: str) -> list[Row]:
    """Total energy of a slab against tau."""
    case, *settings = BODIES["slab"]
    run = _run(way, case.stem, "energies", *settings)
    return [("total energy", step.tau, step.energies.total) for step in run.steps]


CASES: dict[str, Callable[[str], list[Row]]] = {
    found.__name__: found
    for found in (bar, surfing, array, spacing, doubling, pair, onset, energies)
}


def write(file: Path, rows: Iterable[Row]) -> None:
    """Write rows as a CSV file of a submission."""
    file.parent.mkdir(parents=True, exist_ok=True)
    with file.open("w", newline="") as opened:
        to = csv.writer(opened, lineterminator="\n")
        to.writerow(("quantity", "at", "value"))
        for quantity, at, value in rows:
            to.writerow((quantity, "" if at is None else f"{at:.6g}", f"{value:.6g}"))


def main(arguments: list[str]) -> None:
    """Run the ways and the cases that are named, or all."""
    for way in arguments[:1] or WAYS:
        for name in arguments[1:] or CASES:
            write(SUBMISSIONS / way / f"{name}.csv", CASES[name](way))


if __name__ == "__main__":
    main(sys.argv[1:])

"""What is verified: ready cases against sharp-crack computations, second order against theory."""

import csv
import shutil
import subprocess
import sys
from collections.abc import Callable
from dataclasses import dataclass
from math import pi, sqrt
from pathlib import Path

import numpy as np

from staffa.io.run_directory import Run, read_run

HERE = Path(__file__).parent
ROOT = HERE.parent
SHARP = "sharp-crack finite elements"


@dataclass(frozen=True, kw_only=True)
class Figure:
    """A number beside what it should be; the tolerance is absolute, or a fraction of it."""

    what: str
    source: str
    reference: float
    measured: float
    tolerance: float
    relative: bool = False

    @property
    def met(self) -> bool:
        """Whether it is within the tolerance."""
        scale = abs(self.reference) if self.relative else 1.0
        return bool(abs(self.measured - self.reference) <= self.tolerance * scale)


@dataclass(frozen=True, kw_only=True)
class Check:
    """A title, a text for the page, and what measures the figures."""

    title: str
    text: str
    measure: Callable[[], list[Figure]]


def ready_case(name: str, folder: str, *settings: str) -> Run:
    """A ready case run from the command line, in runs/verify."""
    where = ROOT / "runs" / "verify" / folder
    shutil.rmtree(where, ignore_errors=True)
    case = ROOT / "src" / "staffa" / "cases" / f"{name}.toml"
    command = [Path(sys.executable).parent / "staffa", "run", case, "--out", where, "--quiet"]
    subprocess.run([*command, *(f"--set={s}" for s in settings)], check=True)
    return read_run(where)


def array_growth(section: str, generation: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """tau and length of the cracks of an even array of spacing 0.1285."""
    with (HERE / "data" / "array_growth.csv").open() as file:
        rows = [r for r in csv.DictReader(file) if r["mech"] == section]
    rows = [r for r in rows if int(r["generation"]) == generation]
    tau, a = np.array([(float(r["tau_erfc_y_over_tau"]), float(r["a"])) for r in rows]).T
    order = np.argsort(tau)
    return tau[order], a[order]


DOUBLING = {"fixed": (0.1022, 0.1406), "free": (0.1117, 0.1478)}


def array(section: str) -> list[Figure]:
    """Depth of the tip at alpha > .8 against tau, where the crack grows and up to doubling."""
    run = ready_case("array", f"array-{section}", f"supports.section={section}")
    tau, a = array_growth(section)
    figures = []
    for step in run.steps:
        if step.tau is None or not 0.06 - 1e-9 <= step.tau <= DOUBLING[section][0]:
            continue
        assert step.measures is not None
        expected = float(np.interp(step.tau, tau, a))
        figures.append(
            Figure(
                what=f"length at tau = {step.tau:.3f}, section {section}",
                source=SHARP,
                reference=expected,
                measured=step.measures.front,
                tolerance=max(run.manifest.ell, 0.03 * expected),
            )
        )
    return figures


def arrest(run: Run) -> tuple[float, float]:
    """Final depth of the shallower of two cracks, and the tau at which it was within h of it."""
    middle = run.manifest.size[0] / 2
    depths = np.array(
        [
            [
                max(
                    (t.depth for t in s.measures.tips if (t.position[0] > middle) == side),
                    default=0,
                )
                for side in (False, True)
            ]
            for s in run.steps
            if s.measures is not None
        ]
    )
    slow = depths[:, int(np.argmin(depths[-1]))]
    when = int(np.argmax(slow >= slow[-1] - run.manifest.h))
    return float(slow[-1]), float(run.steps[when].tau or 0.0)


WAYS = {
    "alternate minimization alone": ("solver.stability=none",),
    "with backtracking": ("solver.stability=none", "solver.backtracking=true"),
    "with stability": ("solver.stability=follow",),
}


def doubling() -> list[Figure]:
    """Where the slower of two cracks stops, found in three ways."""
    figures = []
    for way, settings in WAYS.items():
        run = ready_case("two-cracks", f"two-cracks-{way.split()[-1]}", *settings)
        a1, tau1 = arrest(run)
        for what, reference, measured in (("a1", 0.1356, a1), ("tau1", 0.100, tau1)):
            figures.append(
                Figure(
                    what=f"{what}, {way}",
                    source=f"{SHARP}, toughness 1 % apart",
                    reference=reference,
                    measured=measured,
                    tolerance=0.05,
                    relative=True,
                )
            )
    return figures


def second_order() -> list[Figure]:
    """The bar at onset, and the Rayleigh quotient on the space and on the cone."""
    sys.path.insert(0, str(ROOT / "tests"))
    from test_stability import onset, rayleigh

    variation = rayleigh(1000)
    space = variation.on_the_space()
    cone = variation.on_the_cone(space)
    variation.destroy()
    theory = "Leon Baldelli and Maurini 2021"
    rows = [
        ("length at which an AT1 bar loses uniqueness, over ell", pi * sqrt(2 / 3), onset(0), 0.02),
        ("length at which it loses stability, over ell", 3.42, onset(1), 0.02),
        ("Rayleigh quotient on the space", 9.8696, space.value, 1e-3),
        ("Rayleigh quotient on the cone", 86.482, cone.value, 1e-3),
        ("length of its minimizer on the cone", 0.33782, float((cone.b > 1e-6).mean()), 5e-3),
    ]
    return [
        Figure(
            what=what,
            source="theory" if "AT1" in what or "loses" in what else theory,
            reference=reference,
            measured=measured,
            tolerance=tolerance,
            relative=True,
        )
        for what, reference, measured, tolerance in rows
    ]


CHECKS = {
    "second-order": Check(
        title="Uniqueness and stability",
        text="Eigenvalues on the space and on the cone, against closed forms. Tolerances are "
        "fractions of the reference.",
        measure=second_order,
    ),
    "array-fixed": Check(
        title="An even array of cracks, section held",
        text="The case `array`: the tip where alpha exceeds 0.8, against sharp cracks, as far as "
        "the first doubling; no correction for the smeared tip. Tolerance: the larger of "
        "ell = 0.013 and 3 %.",
        measure=lambda: array("fixed"),
    ),
    "array-free": Check(
        title="An even array of cracks, section free to stretch and bend",
        text='The same with `supports.section = "free"`.',
        measure=lambda: array("free"),
    ),
    "doubling": Check(
        title="Which of two cracks stops, and when",
        text="The case `two-cracks`: toughness 1 % apart, section held. a1: final depth of the "
        "slower crack; tau1: when it was within a cell of it. Tolerances are fractions of the "
        "reference.",
        measure=doubling,
    ),
}

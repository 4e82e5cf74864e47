"""An even array of cracks, and two cracks of which one stops, against sharp cracks."""

import numpy as np
from figures import Figure
from runs import ready_case
from sharp import DOUBLING, SHARP, array_growth

from staffa.io.run_directory import Run


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

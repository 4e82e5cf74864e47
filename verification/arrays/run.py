"""An even array of cracks, and cracks of which every other one stops, against sharp cracks."""

from pathlib import Path

import numpy as np

from staffa.io.run_directory import Run
from staffa.measure.tip import reach
from verification.common.figures import Check, Figure
from verification.common.runs import fresh_run, ready_case
from verification.common.sharp import DOUBLING, PAIR, SHARP, array_growth, first_doubling
from verification.common.symmetric_cracks import ON_A_SIDE, TWO_CRACKS, even_bands

P = 0.1285


def sharp_tip(run: Run, layers: int = 1) -> float:
    """Distance of the sharp tip beyond the last damage; a crack on a side breaks two layers."""
    m = run.manifest
    found = reach(m.law, threshold=0.8, ell=m.ell, h=m.h)
    assert found is not None
    return found + (layers - 1) * m.h / 2


def array(section: str) -> list[Figure]:
    """Length against tau, where the crack grows and up to doubling."""
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
                measured=step.measures.front + sharp_tip(run),
                tolerance=max(run.manifest.ell, 0.03 * expected),
            )
        )
    assert run.steps[-1].measures is not None
    deep = run.steps[-1].measures.front + sharp_tip(run)
    return [*figures, alone(run, f"section {section}", [deep], run.manifest.toughness_factor)]


def alone(run: Run, what: str, lengths: list[float], toughness: float) -> Figure:
    """The surface length at the last step over that of the cracks that the case is about.

    toughness: energy of a unit of these cracks over Gc. Branches sideways made it 1.3 and more.
    """
    measures = run.steps[-1].measures
    assert measures is not None
    surface = measures.length_surface * run.manifest.toughness_factor
    return Figure(
        what=f"surface length over that of the cracks, {what}",
        source="nothing else breaks",
        reference=1.0,
        measured=surface / (toughness * sum(lengths)),
        tolerance=0.1,
    )


def stopped(run: Run, among: tuple[int, ...]) -> tuple[float, float]:
    """Length at which the first of these cracks (numbered along x) stopped, and tau then."""
    depths = np.array(
        [
            [tip.depth for tip in step.measures.tips]
            for step in run.steps
            if step.measures is not None
        ]
    )
    slow = depths[:, min(among, key=lambda number: depths[-1, number])]
    when = int(np.argmax(slow > slow[-1] - run.manifest.h / 2))
    return float(slow[-1]) + sharp_tip(run, layers=2), float(run.steps[when].tau or 0.0)


def compared(
    what: str, source: str, found: tuple[float, float], expected: tuple[float, float], within: float
) -> list[Figure]:
    """Length and tau of an arrest."""
    return [
        Figure(
            what=f"{name}, {what}",
            source=source,
            reference=reference,
            measured=measured,
            tolerance=within,
            relative=True,
        )
        for name, measured, reference in zip(("a", "tau"), found, expected, strict=True)
    ]


def alone_on_sides(run: Run, what: str, half: tuple[bool, ...]) -> Figure:
    """The same of cracks of which those on a plane of symmetry have half of their energy here."""
    measures = run.steps[-1].measures
    assert measures is not None
    lengths = [
        (tip.depth + sharp_tip(run, layers=2)) / (2 if side else 1)
        for tip, side in zip(measures.tips, half, strict=True)
    ]
    return alone(run, what, lengths, ON_A_SIDE["two-cracks"][1])


def doubling() -> list[Figure]:
    """The first doubling with an imperfection and without, and the second."""
    uneven = fresh_run(TWO_CRACKS, "doubling-uneven")
    even = (even_bands(), "time.tau={start=0.08,stop=0.12,steps=21}")
    alone = fresh_run(TWO_CRACKS, "doubling-even", *even, "solver.stability=none")
    tested = fresh_run(TWO_CRACKS, "doubling-even-tested", *even)
    left = fresh_run(TWO_CRACKS, "doubling-even-follow", *even, "solver.stability=follow")
    escapes = [s.tau for s in left.steps if s.stability and s.stability.escapes]
    four = fresh_run(Path(__file__).parent / "four-cracks.toml", "doubling-four")
    tau, a = first_doubling("fixed", P)
    return [
        alone_on_sides(uneven, "toughness 1 % apart", (True, True)),
        alone_on_sides(left, "alike, left along the mode", (True, True)),
        alone_on_sides(four, "three cracks", (True, False, True)),
        *compared("toughness 1 % apart", SHARP, stopped(uneven, (0, 1)), PAIR[::-1], 0.05),
        *compared(
            "alike, left along the mode",
            f"{SHARP}, no imperfection",
            stopped(left, (0, 1)),
            (a, tau),
            0.05,
        ),
        *compared("alike, by default", SHARP, stopped(tested, (0, 1)), (a, tau), 0.05),
        Figure(
            what="tau at which the second order is first not stable, alike",
            source=f"{SHARP}, loss of stability",
            reference=tau,
            measured=float(escapes[0] or 0.0) if escapes else float("nan"),
            tolerance=0.05,
            relative=True,
        ),
        Figure(
            what="difference in length at tau = 0.12 by alternate minimization alone, alike",
            source="none, where nothing breaks the symmetry",
            reference=0.0,
            measured=float(np.ptp([tip.depth for tip in alone.steps[-1].measures.tips])),
            tolerance=alone.manifest.h / 2,
        ),
        *compared(
            "second doubling, toughness 1 % apart",
            SHARP,
            stopped(four, (0, 2)),
            (0.3217, 0.2155),
            0.07,
        ),
    ]


CHECKS = {
    "array-fixed": Check(
        title="An even array of cracks, ends fixed",
        text="The case `array` against sharp cracks, as far as the first doubling. Tolerance: the "
        "larger of ell = 0.013 and 3 %.",
        measure=lambda: array("fixed"),
    ),
    "array-free": Check(
        title="An even array of cracks, ends free to stretch and bend",
        text='The same with `supports.section = "free"`.',
        measure=lambda: array("free"),
    ),
    "doubling": Check(
        title="Every other crack arrests",
        text=(
            "`verification/common/two-cracks.toml` (ends fixed): cracks on two planes of symmetry. "
            "a: length at which the slower one arrests; tau: when it got there. Then the same with "
            "two equal cracks. Alternate minimization alone lets them grow together. "
            '`solver.stability = "follow"` finds that this is no longer stable, and leaves along '
            "the mode; the default tests for a descent direction. "
            "`verification/arrays/four-cracks.toml` goes on to the second doubling. "
            "Tolerances are fractions of the reference."
        ),
        measure=doubling,
    ),
}

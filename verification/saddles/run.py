"""The second-order test of each step: uniform rock beside seeded rock, and what a search misses."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from unittest.mock import patch

import numpy as np

import staffa
from staffa.case.reading.ready_cases import ready_case
from staffa.evolution import saddle
from staffa.evolution.problem import Problem
from staffa.minimize import lanczos
from staffa.records.step import Step
from verification.common.figures import Check, Figure, Found
from verification.common.symmetric_cracks import even_bands

SLAB = Path(__file__).parent / "case.toml"
SEEDS = (1, 2, 3, 4, 5)
BODIES = {
    "squares": ("domain.cells=quadrilateral",),
    "triangles": (),
    "unstructured triangles": ("domain.cells=unstructured",),
    "hexahedra": (
        "domain.size=[0.4,0.4,0.2]",
        "domain.h=0.02",
        "domain.cells=hexahedron",
        "damage.ell=0.04",
        "time.tau=[0.16,0.32,0.48]",
        "supports.top=rollers",
        "supports.front=rollers",
        "supports.back=rollers",
    ),
}
# A search of this many iterations that does not end early finds what is there.
MANY = 80


def marched(*settings: str) -> list[Step]:
    """The steps of the slab."""
    problem = staffa.problem(staffa.read_case(SLAB, settings))
    system = staffa.build(problem)
    steps = list(staffa.march(problem, system))
    system.destroy()
    return steps


def saddles() -> Found:
    """Energies of uniform rock over those of seeded rock, and the table of searches."""
    figures, rows = [], []
    for body, settings in BODIES.items():
        alone = marched(*settings, "solver.stability=none")[-1].energies.total
        steps = marched(*settings)
        seeded = np.array(
            [
                marched(*settings, "toughness.amplitude=0.05", f"toughness.seed={seed}")[-1]
                .energies.total
                for seed in SEEDS
            ]
        )  # fmt: skip
        mean, total = seeded.mean(), steps[-1].energies.total
        figures.append(
            Figure(
                what=f"total energy at the last step over the mean of five seeds, {body}",
                source="the same body with 5 % of scatter in the toughness",
                reference=1.0,
                measured=float(total / mean),
                tolerance=0.03,
                bound="most",
            )
        )
        left = sum(step.curvature.escapes for step in steps)
        spread = np.ptp(seeded) / mean
        rows.append(
            f"| {body} | {alone:.4f} | {total:.4f} | {left} | {mean:.4f} | "
            f"{seeded.min():.4f} to {seeded.max():.4f} ({100 * spread:.1f} %) |"
        )
    head = (
        "| cells | without the test | with it | saddles left | mean of five seeds | of these |\n"
        "| --- | --- | --- | --- | --- | --- |"
    )
    return Found(figures=figures, text="\n".join([head, *rows, "", *searches()]))


def searches() -> Iterator[str]:
    """A table of what searches of the default length miss, beside long ones."""
    pair = (even_bands(), "time.tau={start=0.09,stop=0.11,steps=21}", "output.at=[]")
    cases = {
        "uniform slab": staffa.read_case(SLAB),
        "seeded slab": staffa.read_case(SLAB, ["toughness.amplitude=0.05"]),
        "even pair of cracks": ready_case("two-cracks", pair),
    }
    yield (
        "States that were not left (`solver.stability = \"none\"`), searched again by "
        f"{MANY} iterations that do not end early:"
    )  # fmt: skip
    yield ""
    yield "| states | negative by 80 iterations | missed by the default | iterations | longest |"
    yield "| --- | --- | --- | --- | --- |"
    for name, case in cases.items():
        found = list(_searched(replace(staffa.problem(case), second_order=None)))
        negative = [short.value for short, long in found if long.value < -saddle_tolerance()]
        missed = sum(value >= -saddle_tolerance() for value in negative)
        counts = [short.iterations / (2 if len(short.b) else 1) for short, _ in found]
        yield (
            f"| {name}, {len(found)} | {len(negative)} | {missed} | "
            f"{np.mean(counts):.1f} | {max(counts):.0f} |"
        )


def saddle_tolerance() -> float:
    """The curvature below which, in size, a state counts as no saddle."""
    from staffa.evolution.problem import SecondOrder

    return SecondOrder().tolerance


def _searched(problem: Problem) -> Iterator[tuple[lanczos.Softest, lanczos.Softest]]:
    """Each state's default search, and a long one."""
    system = staffa.build(problem)
    model, tolerance = system.alternation.model, saddle_tolerance()
    for _ in staffa.march(problem, system):
        short = saddle._softest(problem, system, model, tolerance, saddle.BALANCED)
        with patch.object(lanczos, "KNOWN", 0.0), patch.object(saddle, "ITERATIONS", MANY):
            long = saddle._softest(problem, system, model, tolerance, saddle.BALANCED)
        if short and long:
            yield short, long
    system.destroy()


CHECKS = {
    "saddles": Check(
        title="Uniform rock, without a seed",
        text=(
            "A slab and a block of uniform rock, cooled uniformly from one face "
            "(`verification/saddles/case.toml`). Alternate minimization alone stays on the state "
            "that is uniform along the face, which is a saddle. The second-order test of each step "
            "finds that, leaves it, and keeps the lowest state beside it."
        ),
        measure=saddles,
    ),
}

"""A cut through a block cooled from below, its opposite boundary clamped or free."""

from collections.abc import Iterator
from pathlib import Path

from staffa.io.run_directory import Run
from staffa.physics.doubling import spacing_at
from verification.common.figures import Check, Figure, Found
from verification.common.runs import fresh_run

CASE = Path(__file__).parent / "case.toml"
TOPS = ("clamped", "free")


def opposite_boundary() -> Found:
    """Spacing against depth with a clamped opposite boundary; deep cracks with a free one."""
    runs = {top: fresh_run(CASE, f"strip-{top}", f"supports.top={top}") for top in TOPS}
    assert not any(step.audit.violations for run in runs.values() for step in run.steps)
    figures = [*spaced(runs["clamped"]), *unloaded(runs["free"])]
    return Found(figures=figures, text=table(runs))


def cracks(run: Run) -> dict[float, int]:
    """Number of cracks at each depth at the last step."""
    measures = run.steps[-1].measures
    assert measures is not None
    return {section.height: section.cracks for section in measures.sections}


def spaced(run: Run) -> Iterator[Figure]:
    """Spacing at each depth, from where cracks stop to where they have stopped."""
    ell0 = run.manifest.scales["ell0"] * run.manifest.toughness_factor
    found = cracks(run)
    for depth, number in found.items():
        p = float(spacing_at(depth, ell0))
        yield Figure(
            what=f"clamped: width over cracks at depth {depth:g}",
            source="sharp-crack finite elements, half-space: from p to 2 p",
            reference=1.5 * p,
            measured=run.manifest.size[0] / max(number, 1),
            tolerance=0.5 * p,
        )
    least, *_, greatest = found
    yield Figure(
        what=f"clamped: part of the cracks at depth {least:g} that reach {greatest:g}",
        source="some stop and some go on: from a third to 0.9",
        reference=(1 / 3 + 0.9) / 2,
        measured=found[greatest] / max(found[least], 1),
        tolerance=(0.9 - 1 / 3) / 2,
    )


def unloaded(run: Run) -> Iterator[Figure]:
    """That a free opposite boundary lets the first deep crack unload all of the strip."""
    yield Figure(
        what="free: cracks at the greatest depth",
        source="one unloads the strip, or two that came at once",
        reference=1.5,
        measured=list(cracks(run).values())[-1],
        tolerance=0.5,
    )
    yield Figure(
        what="free: depth of the deepest crack",
        source="it goes through",
        reference=1.0,
        measured=run.steps[-1].measures.front,
        tolerance=run.manifest.h,
    )


def table(runs: dict[str, Run]) -> str:
    """Cracks by depth."""
    found = {top: cracks(run) for top, run in runs.items()}
    depths = list(found["clamped"])
    rows = [
        ["opposite boundary", *(f"depth {depth:g}" for depth in depths)],
        ["---"] * (1 + len(depths)),
    ]
    rows += [[top, *(f"{found[top][depth]}" for depth in depths)] for top in TOPS]
    lines = "\n".join("| " + " | ".join(row) + " |" for row in rows)
    return f"Cracks across the strip at the last step:\n\n{lines}"


CHECKS = {
    "opposite-boundary": Check(
        title="Deep rock constrains what is cooled",
        text=(
            "`verification/opposite_boundary/case.toml`, a cut through the ready case `brick`, 20 "
            "times as long as it is deep. Its opposite boundary is clamped, in place of deeper "
            "rock, or free. If free, the strip is a bar between its ends, which one crack through "
            "it unloads. ell0 counts with the effective Gc. Cracks at the least depths are those "
            "of nucleation."
        ),
        measure=opposite_boundary,
    ),
}

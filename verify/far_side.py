"""A cut through a block cooled from below, its far side held by the deeper rock, or free."""

from collections.abc import Iterator

from figures import Figure, Found
from runs import verify_case

from staffa.io.run_directory import Run
from staffa.physics.doubling import spacing_at

HELD = ("clamped", "free")
DEEP = 0.4  # where a strip that its first crack has unloaded has no more than
FEW = 2.0


def far_side() -> Found:
    """Spacing against depth with the far side held; how many cracks are deep with it free."""
    runs = {held: verify_case("strip", f"strip-{held}", f"supports.top={held}") for held in HELD}
    figures = [*spaced(runs["clamped"]), unloaded(runs["free"])]
    return Found(figures=figures, text=table(runs))


def cracks(run: Run) -> dict[float, int]:
    """How many are at each depth at the last step."""
    measures = run.steps[-1].measures
    assert measures is not None
    return {section.height: section.cracks for section in measures.sections}


def spaced(run: Run) -> Iterator[Figure]:
    """Spacing at each depth, from where cracks stop to where they have stopped."""
    for depth, number in cracks(run).items():
        p = float(spacing_at(depth, run.manifest.scales["ell0"]))
        yield Figure(
            what=f"held: width over cracks at depth {depth:g}",
            source="sharp-crack finite elements, half-space: from p to 2 p",
            reference=1.5 * p,
            measured=run.manifest.size[0] / max(number, 1),
            tolerance=0.5 * p,
        )


def unloaded(run: Run) -> Figure:
    """That a free far side lets the first deep crack unload all of the strip."""
    return Figure(
        what=f"free: cracks at depth {DEEP:g}",
        source=f"one unloads the strip; at most {FEW:g}",
        reference=FEW / 2,
        measured=cracks(run)[DEEP],
        tolerance=FEW / 2,
    )


def table(runs: dict[str, Run]) -> str:
    """Cracks by depth."""
    found = {held: cracks(run) for held, run in runs.items()}
    depths = list(found["clamped"])
    rows = [["far side", *(f"depth {depth:g}" for depth in depths)], ["---"] * (1 + len(depths))]
    rows += [[held, *(f"{found[held][depth]}" for depth in depths)] for held in HELD]
    lines = "\n".join("| " + " | ".join(row) + " |" for row in rows)
    return f"Cracks across the strip at the last step:\n\n{lines}"

"""Messages on radial cracks: hoop tension that drives the damage of a body of revolution."""

from collections.abc import Iterator, Sequence

from staffa.records.step import Step

# A smaller share of a step's damage is not reported.
FEW = 0.05
FIRST = 5  # steps that are named
OUT = (
    "in the rock radial cracks form, in planes through the axis, which a body of revolution cannot "
    "have; for them take the section across the axis, or a 3-D body"
)


def is_radial(step: Step) -> bool:
    """Return True if hoop tension drives the damage of a step, or part of it."""
    return step.hoop is not None and step.hoop > FEW


def radial(step: Step) -> Iterator[str]:
    """Yield a message on one step, if there is one."""
    if is_radial(step):
        yield f"{step.hoop:.0%} of the damage of this step is driven around the axis: {OUT}"


def radial_steps(steps: Sequence[Step]) -> str | None:
    """Return a message on all steps of a run, or None."""
    found = [step for step in steps if is_radial(step)]
    if not found:
        return None
    worst = max(found, key=lambda step: step.hoop or 0.0)
    which = ", ".join(str(step.index) for step in found[:FIRST])
    more = f" and {len(found) - FIRST} more" if len(found) > FIRST else ""
    return (
        f"the stress around the axis is the largest tension where damage grows at "
        f"step{'s' * (len(found) > 1)} {which}{more} (up to {worst.hoop:.0%} of a step's damage, "
        f"at step {worst.index}): {OUT}"
    )

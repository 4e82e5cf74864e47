"""Tolerances as kinds of values: bounded, since beyond them a run would leave out the physics."""

from typing import Annotated

from staffa.case.schema.field_types import PositiveNumber
from staffa.case.schema.json_schema import Rule


def _between(least: float, most: float, why: str) -> Rule:
    """Return a rule for a value from least to most, both included; why: the reason for most."""

    def bounded(value: float) -> float:
        if not least <= value <= most:
            raise ValueError(f"it must lie between {least:g} and {most:g}: with more, {why}")
        return value

    return Rule(bounded, minimum=least, maximum=most)


# Below the least, round-off decides. Damage begins at a force of 1, in the unit of `residual`.
Change = Annotated[PositiveNumber, _between(1e-12, 0.01, "steps end while cracks still grow")]
Residual = Annotated[
    PositiveNumber, _between(1e-8, 0.9, "no force starts a crack, and a step ends undamaged")
]
Better = Annotated[PositiveNumber, _between(1e-14, 0.1, "no earlier state is ever gone back to")]
Agreement = Annotated[
    PositiveNumber, _between(1e-8, 0.1, "the heat does not follow the cracks that change it")
]

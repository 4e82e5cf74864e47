"""Energies of a state."""

from dataclasses import dataclass

# What is left of a large number taken from another, over it, is no size to judge by.
ROUND_OFF = 1e-6


@dataclass(frozen=True, kw_only=True)
class Energies:
    """Energies of a state: in 2-D per unit thickness (J/m), else of the whole body (J), or scaled.

    With forces, `elastic` and `loads` count from the equilibrium before the first step.

    Attributes
    ----------
    elastic
        Stored elastic energy.
    surface
        Energy of the cracks, as the damage has it.
    loads
        Minus the work of the external loads.
    friction
        Work that the faces of cracks lost in friction.
    at_rest
        Sum of the absolute elastic energy and work at the equilibrium before the first step.
    """

    elastic: float
    surface: float
    loads: float = 0.0
    friction: float = 0.0
    at_rest: float = 0.0

    @property
    def total(self) -> float:
        """Sum of all energies of the state."""
        return self.elastic + self.surface + self.loads + self.friction

    @property
    def scale(self) -> float:
        """Scale of differences of energies; the total itself may be near zero."""
        return abs(self.elastic) + abs(self.surface) + self.work + abs(self.friction)

    @property
    def work(self) -> float:
        """Size of the work of the loads, with the round-off of the equilibrium before."""
        return abs(self.loads) + ROUND_OFF * self.at_rest

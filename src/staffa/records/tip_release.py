"""Energy release rate of a crack tip."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Release:
    """Energy that a crack releases, an area by which it grows (see `measure.energy_release`).

    Attributes
    ----------
    position
        Place of the tip, in 3-D of a point of the front (m).
    direction
        Unit vector in which the crack would go on.
    G
        Energy release rate (J/m^2); None where it is not known.
    uncertainty
        Difference of two rings around the tip (J/m^2).
    radius
        Radius of the larger ring (m).
    reason
        Why G is not known; None where it is.
    """

    position: tuple[float, ...]
    direction: tuple[float, ...]
    G: float | None = None
    uncertainty: float | None = None
    radius: float | None = None
    reason: str | None = None

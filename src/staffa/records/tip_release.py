"""Energy release rate of a crack tip, as it is handed from floor to floor and kept on disk."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Release:
    """Energy that a crack releases, an area by which it grows (see `measure.release`).

    position: of the tip, in 3-D of a point of the front (m); direction: the unit vector in which
    the crack would go on. G (J/m^2), None where it is not known for the reason given; uncertainty:
    difference of two rings around the tip (J/m^2). radius: of the larger one (m).
    """

    position: tuple[float, ...]
    direction: tuple[float, ...]
    G: float | None = None
    uncertainty: float | None = None
    radius: float | None = None
    reason: str | None = None

"""Second-order tests of the energy at a state."""

from dataclasses import dataclass

from staffa.records.status import Verdict


@dataclass(frozen=True, kw_only=True)
class Stability:
    """Second order of the energy at a state, over Gc/(4 c_w ell); see `minimize.stability`.

    Attributes
    ----------
    bifurcation
        Smallest value on the space V; None where no damage may move, so that the state is unique.
    stability
        Smallest value in the cone of admissible rates; None where `bifurcation` is not negative, so
        that the state is stable.
    negative
        Number of eigenvalues below zero on the space V.
    escapes
        Times that the state was left along a mode of negative value and minimized again.
    failure
        Why the test found nothing; None if it did. The step is kept in both cases.
    """

    bifurcation: float | None
    stability: float | None
    negative: int
    escapes: int = 0
    failure: str | None = None


@dataclass(frozen=True, kw_only=True)
class Curvature:
    """Second-order test of a step's state (see `minimize.lanczos`).

    Attributes
    ----------
    smallest
        Curvature of the energy along the softest direction found, over that without the coupling of
        displacement and damage. It is negative where the energy falls along the direction, and None
        where the state was not tested or no damage may move.
    iterations
        Iterations of the last search.
    escapes
        Times that a state was left for one of lower energy.
    bifurcation
        True where the curvature is negative but the energy does not fall along the direction within
        the bounds of the damage.
    reason
        Why the state was not tested, or was kept with a negative curvature; None otherwise.
    """

    smallest: float | None = None
    iterations: int = 0
    escapes: int = 0
    bifurcation: bool = False
    reason: str | None = None

    @property
    def verdict(self) -> Verdict:
        """Result of the test; it follows from the other fields, so files do not hold it."""
        if self.smallest is None and self.reason is not None:
            return Verdict.NOT_TESTED
        if self.bifurcation:
            return Verdict.BIFURCATION
        return Verdict.MINIMUM if self.reason is None else Verdict.SADDLE

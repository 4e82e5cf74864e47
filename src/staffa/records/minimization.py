"""Records of a minimization: when it ends, what it did, and how it ended."""

from dataclasses import asdict, dataclass, replace

from staffa.records.energies import Energies
from staffa.records.status import Status

# An energy that is the difference of terms of this size is known to so much of them, at best, over
# the least that an audit allows: a body that moves or expands freely stores none, but for this.
CANCELED = 1e-9


@dataclass(frozen=True, kw_only=True)
class Stop:
    """Conditions under which a state counts as a minimum; dimensionless.

    Attributes
    ----------
    change
        Largest change of the damage in the last sweep, which starts from a displacement in
        equilibrium.
    residual
        Largest residual force on the damage over Gc/(4 c_w ell), at a displacement that is in
        equilibrium again.
    sweeps
        Number of sweeps after which the minimization gives up.
    """

    change: float = 1e-4
    residual: float = 1e-1
    sweeps: int = 5000


@dataclass(frozen=True, kw_only=True)
class SolverStatistics:
    """Counts of what a minimization did besides sweeps.

    Attributes
    ----------
    moves
        Proposals of Newton's method that were taken.
    refused
        Proposals of Newton's method, and first guesses, that did not lower the energy, so that a
        plain sweep followed.
    iterations
        Iterations of the linear solver within Newton's proposals.
    fallbacks
        Times that the second damage solver took over.
    plain
        Times that the minimization started again without proposals.
    halvings
        Times that a time step was cut in two.
    guesses
        First guesses that were taken: of a coarser mesh, or of a try of the step on coarser cells.
    coarse_sweeps
        Sweeps on the coarser mesh.
    direct
        Times that a factorization took over from the iterative solver of the displacement.
    """

    moves: int = 0
    refused: int = 0
    iterations: int = 0
    fallbacks: int = 0
    plain: int = 0
    halvings: int = 0
    guesses: int = 0
    coarse_sweeps: int = 0
    direct: int = 0

    def __add__(self, other: "SolverStatistics") -> "SolverStatistics":
        """Return the counts of both together."""
        return SolverStatistics(**{k: v + getattr(other, k) for k, v in asdict(self).items()})


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """The end of a minimization.

    Attributes
    ----------
    status
        The status that it ended with.
    reason
        The sentence on its end that a user reads.
    sweeps
        Number of sweeps.
    change
        Largest change of the damage in the last sweep.
    residual
        Largest residual force on the damage, see `Stop`.
    largest_rise
        Largest rise of the total energy in half a sweep, over the scale of the energy.
    energies
        Energies of the state.
    before
        Total energy of the state that it started with.
    effort
        What it did besides sweeps.
    spread
        Size of the terms that the energy is the difference of, see `ElasticSolver.spread`.
    """

    status: Status
    reason: str
    sweeps: int
    change: float
    residual: float
    largest_rise: float
    energies: Energies
    before: float
    effort: SolverStatistics = SolverStatistics()
    spread: float = 0.0

    @property
    def converged(self) -> bool:
        """True if it reached what `Stop` asks for."""
        return self.status == Status.CONVERGED

    @property
    def scale(self) -> float:
        """Scale against which an error of the energy is judged; positive."""
        return max(self.energies.scale, CANCELED * self.spread, 1e-300)

    def then(self, other: "Outcome") -> "Outcome":
        """Return the outcome of this minimization and of another that went on from it."""
        return replace(
            other,
            sweeps=self.sweeps + other.sweeps,
            largest_rise=max(self.largest_rise, other.largest_rise),
            before=self.before,
            effort=self.effort + other.effort,
            spread=max(self.spread, other.spread),
        )

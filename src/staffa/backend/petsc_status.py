"""The end of a solver of PETSc or SLEPc as a `Status`, whatever kind of solver it is."""

from dataclasses import dataclass
from typing import Any

from staffa.backend.stack import PETSc  # noqa: F401

from staffa.records.status import Status

# Parts of the names of reasons, the more special before the more general. The names of all kinds
# of solvers are made of these; they change a little from one PETSc to the next.
PARTS = {
    "INDEFINITE": Status.INDEFINITE,
    "NONSYMMETRIC": Status.INDEFINITE,
    "NAN": Status.NOT_FINITE,
    "DOMAIN": Status.NOT_FINITE,
    "PC": Status.NOT_PREPARED,
    "BREAKDOWN": Status.BROKE_DOWN,
    "SYMMETRY_LOST": Status.BROKE_DOWN,
    "DTOL": Status.DIVERGED,
    "LINE_SEARCH": Status.STALLED,
    "LS_FAILURE": Status.STALLED,
    "LOCAL_MIN": Status.STALLED,
    "TR_": Status.STALLED,
    "COUNT": Status.NOT_CONVERGED,
    "MAX": Status.NOT_CONVERGED,
    "ITS": Status.NOT_CONVERGED,
}


@dataclass(frozen=True, kw_only=True)
class Ended:
    """The end of a solver.

    Attributes
    ----------
    status : of the solver.
    name : PETSc's own name of the reason, for who looks it up.
    """

    status: Status
    name: str

    @property
    def converged(self) -> bool:
        """True if the solver converged by its own measure."""
        return self.status is Status.CONVERGED

    @property
    def sentence(self) -> str:
        """A clause that says what happened, with PETSc's name of it."""
        return f"{self.status.sentence} ({self.name})"


# The end of a solver that had nothing to do.
DONE = Ended(status=Status.CONVERGED, name="nothing to do")


def how_it_ended(solver: Any) -> Ended:
    """Return how a solver ended that has been called.

    Parameters
    ----------
    solver : a KSP, SNES, TAO or EPS.
    """
    reason = int(solver.getConvergedReason())
    names = {v: k for k, v in vars(solver.ConvergedReason).items() if isinstance(v, int)}
    name = names.get(reason, str(reason))
    if reason > 0:
        return Ended(status=Status.CONVERGED, name=name)
    found = (status for part, status in PARTS.items() if part in name)
    return Ended(status=next(found, Status.FAILED), name=name)

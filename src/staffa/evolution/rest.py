"""Initial equilibrium of a session, on a mesh that is fine enough for it."""

from collections.abc import Callable

from staffa.errors import LoadError
from staffa.evolution.initial_equilibrium import come_to_rest
from staffa.evolution.resolution import TooCoarseError
from staffa.evolution.session import Session
from staffa.evolution.snapshot import restore, snapshot
from staffa.records.energies import Energies


def rest_on_fine_mesh(session: Session, pause: Callable[[], None]) -> None:
    """Find the initial equilibrium; split cells and find it again where they are too coarse.

    Collective.

    Parameters
    ----------
    session : in the state as it was built.
    pause : called after each sweep.

    Raises
    ------
    PartedError, LoadError, SolveError
        See `come_to_rest`.
    """
    while True:
        system = session.system
        first = snapshot(system)
        try:
            _come_to_rest(session, pause)
            return
        except TooCoarseError as error:
            restore(system, first)
            session.refine(error.wanted)
            session.system.energy.rest = Energies(elastic=0.0, surface=0.0)


def _come_to_rest(session: Session, pause: Callable[[], None]) -> None:
    try:
        come_to_rest(session.problem, session.system, lambda sweep: pause())
    except LoadError:
        session.system.require_fine()  # on a finer mesh the loads may not crack the rock
        raise
    session.system.require_fine()

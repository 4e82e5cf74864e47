"""Observers of the time loop: what is done at each step besides the step itself."""

from collections.abc import Callable
from dataclasses import dataclass

from staffa.evolution.measures import measured
from staffa.evolution.restart_state import RestartState
from staffa.evolution.session import Session
from staffa.minimize.alternate import Sweep
from staffa.records.step import Measures, Moment
from staffa.records.tip_release import Release


@dataclass(frozen=True, kw_only=True)
class Observers:
    """Calls of those who follow the time loop.

    All but `watch`, `keep` and `pause` get the session, are collective, and hold nothing of its
    mesh.

    Attributes
    ----------
    measure : (session, moment) -> measures of the state; by default those that the problem asks
        for, without knowing the step before.
    probe : values of the fields at points.
    save : (session, moment, converged) -> name of the file that was written, or None.
    quantities : numbers of the script's own quantities, by name; stops the run where one is none.
    release : G at the tips of a state that was saved.
    watch : called after each sweep, with the step's moment.
    keep : called before each step and after the last with the restart state, and True if it must be
        kept now; collective.
    pause : raises `StoppedError` where the run is to stop, on all ranks.
    """

    measure: Callable[[Session, Moment], Measures | None] = measured
    probe: Callable[[Session], tuple[tuple[float, ...], ...]] = lambda session: ()
    save: Callable[[Session, Moment, bool], str | None] = lambda session, moment, converged: None
    quantities: Callable[[Session], dict[str, tuple[float, ...]]] = lambda session: {}
    release: Callable[[Session], tuple[Release, ...]] = lambda session: ()
    watch: Callable[[Moment, Sweep], None] = lambda moment, sweep: None
    keep: Callable[[RestartState, bool], None] = lambda restart, now: None
    pause: Callable[[], None] = lambda: None

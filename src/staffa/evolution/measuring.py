"""Measures of a problem's states: what is looked at, and how, from the problem itself."""

from collections.abc import Callable

from staffa.evolution.problem import Problem
from staffa.evolution.system import System
from staffa.evolution.toughness import toughness_factor
from staffa.measure.coarse import local
from staffa.measure.crack import Gauge, measures, planes
from staffa.records import Measures


def measuring(
    problem: Problem, system: System, factor: float | None = None
) -> Callable[[], Measures]:
    """The function that measures the system's state whenever it is called. Collective.

    factor: the discrete toughness over Gc; measured on the same cells if it is not given.
    """
    factor = toughness_factor(problem) if factor is None else factor
    gauge = Gauge(
        face=problem.face,
        depths=problem.measuring.depths,
        threshold=problem.measuring.threshold,
        prominence=problem.material.ell,
        h=problem.domain.h,
        toughness_factor=factor,
        local=local(problem.domain, factor),
    )
    below = planes(problem.domain, gauge, problem.material.ell)
    return lambda: measures(problem.domain, system.state, system.energy, gauge, below)

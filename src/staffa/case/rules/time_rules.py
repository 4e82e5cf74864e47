"""Rules on the times: that they increase, can be reached, and include the outputs."""

from itertools import pairwise

import numpy as np

from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount
from staffa.case.schema.time_keys import AdaptiveTau, AdaptiveTime, UniformTau, UniformTime
from staffa.case.schema.toml_text import inline
from staffa.errors import InputError


def counts_in(case: Case) -> str:
    """Return the key that gives the times, tau or t."""
    return "tau" if case.time.tau is not None else "t"


# A step shorter than this part of the whole is lost in the round-off of the times.
SHORTEST = 1e-12


def adaptive(case: Case) -> AdaptiveTau | AdaptiveTime | None:
    """Return the keys of adaptive time steps; None if the times are given."""
    given = getattr(case.time, counts_in(case))
    return given if isinstance(given, AdaptiveTau | AdaptiveTime) else None


def times_given(case: Case) -> np.ndarray:
    """Return the times of the case, in tau or in t as it counts them; of adaptive steps the two
    ends."""
    given = getattr(case.time, counts_in(case))
    if isinstance(given, UniformTau | UniformTime):
        return np.linspace(given.start, given.stop, given.steps)
    if isinstance(given, AdaptiveTau | AdaptiveTime):
        return np.array([given.start, given.stop], dtype=float)
    return np.array(given, dtype=float)


def times_increase(case: Case) -> None:
    """Require tau or t, in increasing order; tau only where heat diffuses."""
    keys, name = case.time, counts_in(case)
    if (keys.tau is None) == (keys.t is None):
        how = "neither is given" if keys.tau is None else "both are given"
        raise InputError(f"time.tau and time.t: {how}; give exactly one of them")
    if keys.tau is not None and case.temperature.profile == "none":
        raise InputError(
            'time.tau has no meaning without cooling (temperature.profile = "none"); give time.t'
        )
    if keys.tau is not None and not case.temperature.cools_a_face:
        raise InputError(
            f'time.tau has no meaning with temperature.profile = "{case.temperature.profile}", '
            f"where nothing is known to diffuse; give time.t"
        )
    given = getattr(keys, name)
    if not isinstance(given, tuple):
        if given.stop <= given.start:
            raise InputError(
                f"time.{name}: stop = {inline(given.stop)} must be larger than start = "
                f"{inline(given.start)}"
            )
        return
    if not given:
        raise InputError(f"time.{name} = [] is empty; give at least one time")
    _increase(f"time.{name}", given)


def table_agrees(
    where: str, t: tuple[float, ...], values: tuple[float, ...], values_key: str
) -> None:
    """Require that a table in time has as many values as times, and that the times increase.

    Parameters
    ----------
    where : the key of the table, for messages.
    t : times (s, or scaled).
    values : values at these times.
    values_key : key of the values in the table, for messages.
    """
    if not t or len(t) != len(values):
        raise InputError(
            f"{where}: t has {len(t)} numbers and {values_key} has {len(values)}; give as many of "
            f"each, and at least one"
        )
    _increase(f"{where}.t", t)


def _increase(where: str, times: tuple[float, ...]) -> None:
    for before, after in pairwise(times):
        if after <= before:
            raise InputError(
                f"{where}: {inline(after)} comes after {inline(before)}; put the times in "
                f"increasing order, no two of them equal"
            )


def adaptive_steps_are_possible(case: Case) -> None:
    """Require bounds in order, and an advance of a cell at least."""
    steps, name = adaptive(case), counts_in(case)
    if steps is None:
        return
    if steps.longest < steps.shortest:
        raise InputError(
            f"time.{name}: longest = {inline(steps.longest)} must not be smaller than shortest = "
            f"{inline(steps.shortest)}; take a longer or a shorter one"
        )
    if steps.shortest < SHORTEST * steps.stop:
        raise InputError(
            f"time.{name}: shortest = {inline(steps.shortest)} is less than {SHORTEST:g} of stop = "
            f"{inline(steps.stop)}, which no clock can tell apart; take a longer one"
        )
    for time in case.output.at:
        if time < steps.start:
            raise InputError(
                f"output.at: {inline(time)} lies before time.{name}.start = {inline(steps.start)}; "
                f"leave it out or start earlier"
            )
    cell = (case.domain.h or case.outline.h) / float(case.damage.ell)
    if steps.advance < 2 * cell:
        raise InputError(
            f"time.{name}: advance = {inline(steps.advance)} ell is less than two cells, "
            f"{2 * cell:.3g} ell, and a crack runs by whole cells; take a larger advance"
        )


def cooling_has_started(case: Case) -> None:
    """Refuse a step at t = 0 if the face drops at once: its boundary layer would be as thin as a
    node."""
    jumps = case.temperature.profile in ("half-space", "slab")
    if jumps and times_given(case)[0] == 0:
        raise InputError(
            "time.t: the first time is 0, when only the face itself is cold, a layer that no mesh "
            "sees; start later, about when sqrt(kappa t) is domain.h"
        )


def outputs_count_as_times_do(case: Case) -> None:
    """Refuse an output time with a unit in a case that counts in tau."""
    for time in case.output.at:
        if time.has_units and case.time.tau is not None:
            raise InputError(
                f"output.at: {inline(time)} is a time, but the case counts in tau; give tau here"
            )


def outputs_are_within(case: Case) -> None:
    """Require that times of outputs lie in the run, each once."""
    name, last = counts_in(case), float(times_given(case)[-1])
    end = f"{last:g}" if name == "tau" else amount(case, last, "s", digits=6)
    for time in case.output.at:
        if not 0 < time <= last * (1 + 1e-12):
            raise InputError(
                f"output.at: {inline(time)} lies outside the run, which goes to {name} = {end}; "
                f"leave it out or go on longer"
            )
    for before, after in pairwise(sorted(case.output.at)):
        if before == after:
            raise InputError(f"output.at: {inline(after)} is there twice; leave one out")

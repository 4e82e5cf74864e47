"""Changes that cracks make to the production of a run: its numbers less those of its shadow."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from math import inf, isfinite, nan

import numpy as np

from staffa.io.production_rows import BREAKTHROUGH, LATE, Production, first_time
from staffa.plot.production_curves import closed_form_temperature

CHANGED = 0.01  # relative change of a rate, pressure, area or time from which it counts as one


@dataclass(frozen=True, kw_only=True)
class CrackChanges:
    """Production of the same steps with cracks and without, of n steps.

    Attributes
    ----------
    pairs : production with cracks and without, of each step.
    """

    pairs: Sequence[tuple[Production, Production]]

    @property
    def last(self) -> tuple[Production, Production]:
        """Both at the last step."""
        return self.pairs[-1]

    @cached_property
    def time(self) -> np.ndarray:
        """Ends of the steps (s), shape (n,)."""
        return np.array([one.time for one, _ in self.pairs])

    @cached_property
    def T(self) -> np.ndarray:
        """Temperature of the produced water with cracks less that without (K), shape (n,).

        It is 0 in a step without a producer.
        """
        changes = [one.T - other.T for one, other in self.pairs]
        return np.array([change if isfinite(change) else 0.0 for change in changes])

    @property
    def resolved_T(self) -> float:
        """Change of temperature that is resolved (K): twice the tolerance of the simulator's steps
        times the drop, as of two runs; or the error beside a closed form, where that is larger."""
        facts = self.last[0].facts
        cold = facts.T if facts.T_injected is None else facts.T_injected
        return max(2 * facts.tolerance * abs(facts.T - cold), self.error)

    @property
    def resolved_energy(self) -> float:
        """Relative change of the energy that is resolved: twice that tolerance."""
        return 2 * self.last[0].facts.tolerance

    @cached_property
    def error(self) -> float:
        """Largest difference of the water without cracks to a closed form (K), 0 without one."""
        without = [other for _, other in self.pairs]
        exact = closed_form_temperature(without[-1].facts, np.array([p.elapsed for p in without]))
        if exact is None:
            return 0.0
        return float(np.nanmax(np.abs(exact - np.array([p.T for p in without])), initial=0.0))

    @property
    def energy(self) -> float:
        """Relative change of the energy by the end."""
        return relative(*(one.heat for one in self.last))

    @property
    def water(self) -> float:
        """Relative change of the mass of water produced by the end."""
        return relative(*(one.produced for one in self.last))

    @property
    def impedance(self) -> float:
        """Relative change of the impedance at the end."""
        return relative(*(one.impedance for one in self.last))

    @property
    def area(self) -> float:
        """Relative change of the exchange area at the end; NaN where one is not known."""
        return relative(*(one.area for one in self.last))

    @cached_property
    def level(self) -> float:
        """Drawdown whose times are compared: 0.1, or 0.01 where neither reaches that."""
        return LATE if min(self._times(LATE)) < inf else BREAKTHROUGH

    @cached_property
    def breakthrough(self) -> tuple[float, float]:
        """Times of that drawdown with cracks and without (s); infinite if not reached."""
        return self._times(self.level)

    def _times(self, level: float) -> tuple[float, float]:
        with_cracks, without = (
            first_time(found, [one.drawdown for one in found], level)
            for found in zip(*self.pairs, strict=True)
        )
        return with_cracks, without

    @property
    def later(self) -> bool:
        """True if that drawdown comes later with cracks."""
        one, other = self.breakthrough
        return one > (1 + CHANGED) * other

    @property
    def earlier(self) -> bool:
        """True if that drawdown comes earlier with cracks."""
        one, other = self.breakthrough
        return other > (1 + CHANGED) * one

    @property
    def warmer(self) -> bool:
        """True if the water is warmer with cracks at some time, by more than is resolved."""
        return bool(self.T.max() > self.resolved_T)

    @property
    def colder(self) -> bool:
        """True if the water is colder with cracks at some time, by more than is resolved."""
        return bool(self.T.min() < -self.resolved_T)


def relative(one: float, other: float) -> float:
    """Return the change of a number over its value without cracks; NaN where that is none.

    Parameters
    ----------
    one : the number with cracks.
    other : the number without.
    """
    return (one - other) / other if isfinite(other) and other else nan

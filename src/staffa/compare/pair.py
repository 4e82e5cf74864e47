"""Two runs side by side: on which clock, in which units, and as far as which body allows."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import isclose, sqrt

import numpy as np

from staffa.case.schema.case import Case
from staffa.display_units import Shown
from staffa.io.run_directory import Run
from staffa.plot.labels import has_tau
from staffa.records.step import Step

# Times and sizes that differ by less are the same: rounding in tau = 2 sqrt(kappa t)/L makes 1e-15.
SAME = 1e-6


@dataclass(frozen=True, kw_only=True)
class Side:
    """One of the two runs.

    name: what tells it from the other. length, energy, time: what its lengths (m), energies (J/m,
    in 3-D J) and times (s) are divided by: the units of the first run, or L and Gc L (in 3-D
    Gc L^2) where only one of the runs has units.
    """

    name: str
    run: Run
    case: Case
    length: float = 1.0
    energy: float = 1.0
    time: float = 1.0

    @property
    def dim(self) -> int:
        """2 or 3."""
        return len(self.run.manifest.size)

    @property
    def extents(self) -> int:
        """2 where volumes and energies are per thickness, else 3."""
        return 2 if self.run.manifest.plane else 3

    @property
    def kind(self) -> str:
        """The kind of body, in words."""
        return "of revolution" if self.run.manifest.axial else f"{self.dim}-D"


@dataclass(frozen=True, kw_only=True)
class Pair:
    """Two runs. mixed: one is scaled, the other has units."""

    first: Side
    second: Side
    mixed: bool

    @property
    def sides(self) -> tuple[Side, Side]:
        """Both."""
        return self.first, self.second

    @property
    def names(self) -> tuple[str, str]:
        """Of both."""
        return self.first.name, self.second.name

    @property
    def dim(self) -> int | None:
        """2 or 3, None if one body has two and the other three, or only one is of revolution."""
        return self.first.dim if self.first.kind == self.second.kind else None

    @property
    def alike(self) -> bool:
        """True for bodies of one size, so that energies, lengths and numbers can agree."""
        one, other = (np.array(side.run.manifest.size) / side.length for side in self.sides)
        return self.dim is not None and np.allclose(one, other, rtol=SAME, atol=0.0)

    @property
    def clock(self) -> str | None:
        """The clock of both: the time "t", or "tau" where either is scaled or a tau is not the
        same time in both; None without either."""
        if all(has_tau(side.run.steps) for side in self.sides) and self.root is None:
            return "tau"
        return None if self.mixed else "t"

    @property
    def root(self) -> float | None:
        """sqrt(time) over tau, if both runs have units and in both it is the same."""
        if any(side.run.manifest.scaled for side in self.sides):
            return None
        late = [side.run.steps[-1] for side in self.sides]
        roots = [sqrt(step.time) / step.tau for step in late if step.tau]
        return roots[0] if len(roots) == 2 and isclose(*roots, rel_tol=SAME) else None

    @property
    def shown(self) -> Shown:
        """The units of the first run."""
        return self.first.run.manifest.shown

    @property
    def length_unit(self) -> str:
        """Unit of lengths: that of the first run, "L", or nothing where both are scaled."""
        return "L" if self.mixed else self.shown.length.name

    @property
    def energy_unit(self) -> str:
        """Of energies of bodies of one dimension."""
        if self.mixed:
            return "Gc L" if self.first.extents == 2 else "Gc L²"
        return self.shown.energy.name

    @property
    def time_unit(self) -> str:
        """Unit of the clock, nothing if that is tau."""
        return self.shown.time.name if self.clock == "t" else ""

    def at(self, step: Step) -> float | None:
        """When a step is, on the clock of both."""
        if self.clock is None:
            return None
        return step.tau if self.clock == "tau" else step.time / self.first.time

    def moment(self, at: float | None) -> str:
        """A time on that clock in words."""
        unit = f" {self.time_unit}" if self.time_unit else ""
        return "no common clock" if at is None else f"{self.clock} = {at:.4g}{unit}"

    def common(self) -> list[tuple[Step, Step]]:
        """The steps that both runs have at the same time, in order."""
        if self.clock is None:
            return []
        there = self.second.run.steps
        times = np.array([self.at(step) for step in there], dtype=float)
        found = []
        for step in self.first.run.steps:
            near = np.flatnonzero(np.isclose(times, self.at(step) or 0.0, rtol=SAME, atol=0.0))
            found += [(step, there[i]) for i in near[:1]]
        return found


def pair_title(pair: Pair) -> str:
    """Both names."""
    return f"{pair.first.name} and {pair.second.name}"


def caveats(pair: Pair) -> Iterator[str]:
    """What cannot be compared, and what is compared in other units, as sentences."""
    one, other = pair.names
    if pair.mixed:
        bare, dressed = (one, other) if pair.first.run.manifest.scaled else (other, one)
        told = f", energies over {pair.energy_unit}" if pair.dim else ""
        yield f"{bare} is scaled and {dressed} has units: lengths are over L{told}, times in tau."
    if pair.dim is None:
        yield (
            f"{one} is {pair.first.kind} and {other} is {pair.second.kind}: depths and times are "
            f"compared, energies and lengths are not."
        )
    elif not pair.alike:
        unit = f" {pair.length_unit}" if pair.length_unit else ""
        sizes = (
            " x ".join(f"{x / side.length:g}" for x in side.run.manifest.size) + unit
            for side in pair.sides
        )
        yield (
            f"The bodies differ in size ({', '.join(sizes)}): energies, lengths and numbers of "
            f"cracks are those of each whole body, and their differences are left out."
        )
    if pair.clock is None:
        yield "A run without tau has no time in common with one in other units."
        return
    ends = [pair.at(side.run.steps[-1]) or 0.0 for side in pair.sides]
    if not isclose(*ends, rel_tol=SAME):
        yield f"The runs end at different times: {one} at {pair.moment(ends[0])}, {other} at " + (
            f"{pair.moment(ends[1])}."
        )

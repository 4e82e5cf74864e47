"""Two runs side by side: on which clock, in which units, and as far as which body allows."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from math import isclose, sqrt

import numpy as np

from staffa.case.schema.case import Case
from staffa.display_units import NONE, Shown, Unit
from staffa.io.run_directory import Run
from staffa.io.step_columns import rows_of
from staffa.plot.labels import has_tau
from staffa.records.step import Step

# Times and sizes that differ by less are the same: rounding in tau = 2 sqrt(kappa t)/L makes 1e-15.
SAME = 1e-6
# Readings of a step: the column of `Run.to_frame`, and the kind of its unit. Those without a unit
# and lengths are compared of all bodies, the others of two of one kind.
READINGS = {
    "cracks": ("cracks", ""),
    "spacing": ("spacing", "length"),
    "deepest crack": ("deepest", "length"),
    "crack size": ("measures_length_surface", "size"),
    "crack size, by geometry": ("measures_length_geometry", "size"),
    "elastic energy": ("energies_elastic", "energy"),
    "surface energy": ("energies_surface", "energy"),
    "energy of loads": ("energies_loads", "energy"),
    "work of friction": ("energies_friction", "energy"),
    "total energy": ("energies_total", "energy"),
    "production temperature": ("production_T", "T"),
    "produced power": ("production_power", "power"),
    "produced energy": ("production_heat", "heat"),
    "highest pressure": ("production_pressure", "pressure"),
    "production temperature without cracks": ("production_T_without", "T"),
    "produced energy without cracks": ("production_heat_without", "heat"),
    "highest pressure without cracks": ("production_pressure_without", "pressure"),
}
WATER = ("T", "power", "heat", "pressure")  # kinds of units of runs whose water circulates
IF_ANY = ("energy of loads", "work of friction")  # left out where they vanish


@dataclass(frozen=True, kw_only=True)
class Side:
    """One of the two runs, of n steps.

    Attributes
    ----------
    name : what tells it from the other.
    run, case : the run and its case.
    water : units of temperature, power, heat and pressure of the water, of both runs.
    length, energy, time : what its lengths (m), energies (J/m, in 3-D J) and times (s) are over:
        the units of the first run, or L and Gc L (in 3-D Gc L^2) where only one run has units.
    """

    name: str
    run: Run
    case: Case
    water: Mapping[str, Unit] = field(default_factory=dict)
    length: float = 1.0
    energy: float = 1.0
    time: float = 1.0

    @property
    def extents(self) -> int:
        """2 where volumes and energies are per thickness, else 3."""
        return 2 if self.run.manifest.plane else 3

    @property
    def kind(self) -> str:
        """The kind of body, in words."""
        m = self.run.manifest
        return "of revolution" if m.axial else f"{len(m.size)}-D"

    @property
    def size(self) -> np.ndarray:
        """Extent of the body along each axis, shape (2 or 3,)."""
        return np.array(self.run.manifest.size) / self.length

    @cached_property
    def readings(self) -> dict[str, np.ndarray]:
        """Numbers of each step by their names, shape (n,); NaN where a step does not have one."""
        size = self.length ** (self.extents - 1)
        over = {"": 1.0, "length": self.length, "size": size, "energy": self.energy}
        units = {kind: Unit(size=one) for kind, one in over.items()} | dict(self.water)
        rows = rows_of(self.run.manifest, self.run.steps)
        return {
            name: units.get(kind, NONE).of(np.array([row.get(column, np.nan) for row in rows]))
            for name, (column, kind) in READINGS.items()
        }

    @property
    def sizes(self) -> np.ndarray:
        """Sum of the absolute energies, which loads cannot bring near zero, shape (n,)."""
        parts = ("elastic energy", "surface energy", *IF_ANY)
        return np.abs([self.readings[name] for name in parts]).sum(axis=0)


@dataclass(frozen=True, kw_only=True)
class Pair:
    """Two runs.

    Attributes
    ----------
    first, second : the runs.
    mixed : True if one is scaled and the other has units.
    """

    first: Side
    second: Side
    mixed: bool

    @property
    def sides(self) -> tuple[Side, Side]:
        """Both."""
        return self.first, self.second

    @property
    def names(self) -> tuple[str, str]:
        """Names of both runs."""
        return self.first.name, self.second.name

    @property
    def dim(self) -> int | None:
        """2 or 3; None for bodies of two kinds."""
        return len(self.first.size) if self.first.kind == self.second.kind else None

    @property
    def alike(self) -> bool:
        """True for bodies of one size, so that energies, lengths and numbers can agree."""
        one, other = (side.size for side in self.sides)
        return self.dim is not None and np.allclose(one, other, rtol=SAME, atol=0.0)

    @property
    def root(self) -> float | None:
        """sqrt(time) over tau, if both runs have units and in both it is the same."""
        if any(side.run.manifest.scaled for side in self.sides):
            return None
        late = [side.run.steps[-1] for side in self.sides]
        roots = [sqrt(step.time) / step.tau for step in late if step.tau]
        return roots[0] if len(roots) == 2 and isclose(*roots, rel_tol=SAME) else None

    @cached_property
    def clock(self) -> str | None:
        """The clock of both: the time "t", or "tau" where either is scaled or a tau is not the
        same time in both; None without either."""
        if all(has_tau(side.run.steps) for side in self.sides) and self.root is None:
            return "tau"
        return None if self.mixed else "t"

    @cached_property
    def times(self) -> tuple[np.ndarray, np.ndarray]:
        """Times of the steps of both on that clock, shape (n,) each; NaN without one."""

        def at(side: Side, step: Step) -> float | None:
            if self.clock is None:
                return np.nan
            if self.clock == "tau":
                return step.tau
            return float(step.time / side.time)

        one, other = (np.array([at(s, step) for step in s.run.steps], float) for s in self.sides)
        return one, other

    @cached_property
    def common(self) -> np.ndarray:
        """Places of the steps that both runs have at the same time, shape (m, 2)."""
        one, other = self.times
        near = np.isclose(other, one[:, None], rtol=SAME, atol=0.0)
        there = np.flatnonzero(near.any(axis=1))
        return np.column_stack([there, near[there].argmax(axis=1)])

    def both(self, name: str) -> tuple[np.ndarray, np.ndarray]:
        """Return a reading of both at the common times, shape (m,) each."""
        one, other = (s.readings[name][at] for s, at in zip(self.sides, self.common.T, strict=True))
        return one, other

    @property
    def shown(self) -> Shown:
        """The units of the first run."""
        return self.first.run.manifest.shown

    @property
    def length_unit(self) -> str:
        """Unit of lengths after a blank: that of the first run, L, or nothing where scaled."""
        return " L" if self.mixed else self.shown.length.behind

    @cached_property
    def units(self) -> dict[str, str]:
        """The readings that can be compared, with their units."""
        length, energy = self.length_unit.strip(), self.shown.energy.name
        plane = self.first.extents == 2
        if self.mixed:
            energy = "Gc L" if plane else "Gc L²"
        units = {"": "", "length": length, "energy": energy}
        units |= {kind: self.first.water.get(kind, NONE).name for kind in WATER}
        units["size"] = length if plane or not length else f"{length}²"
        return {
            name: units[kind]
            for name, (_, kind) in READINGS.items()
            if self.dim or kind in ("", "length", *WATER)
            if name not in IF_ANY or any(side.readings[name].any() for side in self.sides)
            if kind not in WATER or any(np.isfinite(s.readings[name]).any() for s in self.sides)
        }

    def knows(self, name: str) -> bool:
        """Return True if a reading can be compared, and each run has it at some step."""
        return name in self.units and all(
            np.isfinite(side.readings[name]).any() for side in self.sides
        )

    def named(self, name: str) -> str:
        """Return the name of a reading with its unit."""
        unit = f" ({self.units[name]})" if self.units[name] else ""
        return name.replace("size", "length" if self.first.extents == 2 else "area") + unit

    @property
    def time_unit(self) -> str:
        """Unit of the clock after a blank, nothing if that is tau."""
        return self.shown.time.behind if self.clock == "t" else ""

    def moment(self, at: float) -> str:
        """Return a time on that clock in words."""
        return f"{self.clock} = {at:.4g}{self.time_unit}"


def pair_title(pair: Pair) -> str:
    """Both names."""
    return f"{pair.first.name} and {pair.second.name}"


def caveats(pair: Pair) -> Iterator[str]:
    """Sentences on what cannot be compared, and what is compared in other units."""
    one, other = pair.names
    if pair.mixed:
        bare, dressed = (one, other) if pair.first.run.manifest.scaled else (other, one)
        told = f", energies over {pair.units['total energy']}" if pair.dim else ""
        yield f"{bare} is scaled and {dressed} has units: lengths are over L{told}, times in tau."
    if pair.dim is None:
        yield (
            f"{one} is {pair.first.kind} and {other} is {pair.second.kind}: depths and times are "
            f"compared, energies and lengths are not."
        )
    elif not pair.alike:
        sizes = (" x ".join(f"{x:g}" for x in side.size) + pair.length_unit for side in pair.sides)
        yield (
            f"The bodies differ in size ({', '.join(sizes)}): energies, lengths and numbers of "
            f"cracks are those of each whole body, and their differences are left out."
        )
    if pair.clock is None:
        yield "A run without tau has no time in common with one in other units."
    elif not isclose(*(ends := [times[-1] for times in pair.times]), rel_tol=SAME):
        when = f"{one} at {pair.moment(ends[0])}, {other} at {pair.moment(ends[1])}"
        yield f"The runs end at different times: {when}."

"""Units in which results are shown: those of the case, else a readable SI prefix."""

from collections.abc import Mapping
from dataclasses import dataclass
from math import inf

# Length of a body (m) from which its lengths are shown in this unit.
LENGTHS = {"km": 1e3, "m": 1.0, "mm": 1e-3, "µm": 1e-6, "nm": 0.0}
# Units of time (s), the longest first.
DAY, YEAR = 86400.0, 365.25 * 86400.0
TIMES = {"a": YEAR, "d": DAY, "h": 3600.0, "min": 60.0, "s": 1.0, "ms": 1e-3, "µs": 1e-6}
PREFIXES = {
    **{"P": 1e15, "T": 1e12, "G": 1e9, "M": 1e6, "k": 1e3},
    **{"": 1.0, "m": 1e-3, "µ": 1e-6, "n": 1e-9},
}
METERS = {"km": 1e3, "m": 1.0, "cm": 1e-2, "mm": 1e-3, "µm": 1e-6, "nm": 1e-9}
# A crack's mean opening over the depth of the body, as an order of magnitude.
SLENDER = 1e-5
POWERS = {1: "", 2: "²", 3: "³"}
PLAIN = str.maketrans(
    {"²": "2", "³": "3", "µ": "u", "μ": "u", "°": "deg", "·": "_", "*": "_", "%": "percent"}
)


@dataclass(frozen=True, kw_only=True)
class Unit:
    """Unit in which numbers are shown.

    Attributes
    ----------
    name : its name, empty for a number without a unit, as in a scaled case.
    size : size of one unit, in SI units.
    zero : SI value from which it counts (K); 0 but for a scale of temperature.
    """

    name: str = ""
    size: float = 1.0
    zero: float = 0.0

    def of[V](self, value: V) -> V:
        """Return an SI value, or an array of them, counted in this unit."""
        # No bound says that V is a number or an array, and stays one of its kind.
        return (value - self.zero) / self.size  # type: ignore[operator, return-value]

    def text(self, value: float, digits: int = 4) -> str:
        """Return an SI value in words: "3.2 mm"."""
        return f"{self.of(value):.{digits}g}{self.behind}"

    @property
    def behind(self) -> str:
        """Return the text that follows a number: a blank and the name, or nothing."""
        return f" {self.name}" if self.name else ""

    def header(self, name: str) -> str:
        """Return a heading of a column for people: "spacing (mm)"."""
        return f"{name} ({self.name})" if self.name else name

    def label(self, name: str) -> str:
        """Return a label of an axis, which also says where there is no unit: "spacing (scaled)"."""
        return f"{name} ({self.name or 'scaled'})"

    def column(self, name: str) -> str:
        """Return a heading of a column for programs: "spacing_mm", "fx_kN_per_m"."""
        plain = self.name.translate(PLAIN).replace("/", "_per_")
        return f"{name}_{plain}" if plain else name

    def power(self, exponent: int) -> "Unit":
        """Return this unit of length as one of area or volume."""
        if exponent == 1 or not self.name:
            return self
        return Unit(name=self.name + POWERS[exponent], size=self.size**exponent)


NONE = Unit()
KELVIN = Unit(name="K")


@dataclass(frozen=True, kw_only=True)
class Shown:
    """Units of one run; without names where the case is scaled.

    Attributes
    ----------
    length : lengths of the body.
    opening : opening of cracks.
    crack : length of cracks in 2-D, area in 3-D.
    volume : volume of cracks, area in 2-D.
    energy, heat, force : per thickness in 2-D.
    stress : stresses and pressures.
    temperature : temperatures.
    difference : differences of temperatures.
    time : times.
    release : energy per area of crack, also in 2-D.
    """

    length: Unit = NONE
    opening: Unit = NONE
    crack: Unit = NONE
    volume: Unit = NONE
    energy: Unit = NONE
    heat: Unit = NONE
    force: Unit = NONE
    stress: Unit = NONE
    temperature: Unit = NONE
    difference: Unit = NONE
    time: Unit = NONE
    release: Unit = NONE


@dataclass(frozen=True, kw_only=True)
class Magnitudes:
    """Orders of magnitude by which prefixes are chosen, in SI units; energy, heat and force of a
    2-D body per thickness.

    Attributes
    ----------
    extent : largest extent of the body (m).
    depth : L (m).
    last : time at the end of the run (s).
    energy : energy (J, in 2-D J/m).
    heat : heat (J, in 2-D J/m).
    force : force (N, in 2-D N/m).
    stress : stress (Pa).
    """

    extent: float
    depth: float
    last: float
    energy: float = 1.0
    heat: float = 1.0
    force: float = 1.0
    stress: float = 1e6


def choose_display_units(
    dim: int, sizes: Magnitudes, written: Mapping[str, Unit] | None = None
) -> Shown:
    """Choose the units of a run that has units: the written ones, else readable prefixes.

    Parameters
    ----------
    dim : 2 where energies, volumes and forces are per thickness, else 3.
    sizes : typical sizes of the run's quantities (SI).
    written : units that the case file is written in, of "length", "time", "temperature", "stress"
        and "volume"; absent where it has several or none.
    """
    written = written or {}
    length = written.get("length", _length(sizes.extent))
    return Shown(
        length=length,
        opening=Unit(name="µm", size=1e-6) if sizes.depth >= 1e-4 else Unit(name="nm", size=1e-9),
        crack=length.power(dim - 1),
        volume=written.get("volume", _volume(dim, length, sizes.depth)),
        energy=prefixed("J/m" if dim == 2 else "J", sizes.energy),
        heat=prefixed("J/m" if dim == 2 else "J", sizes.heat),
        force=prefixed("N/m" if dim == 2 else "N", sizes.force),
        stress=written.get("stress", prefixed("Pa", sizes.stress)),
        temperature=written.get("temperature", KELVIN),
        difference=KELVIN,
        time=written.get("time", _time(sizes.last)),
        release=Unit(name="J/m²"),
    )


def _length(extent: float) -> Unit:
    """Return the unit in which a body of this extent (m) is one or more."""
    name = next(name for name, least in LENGTHS.items() if extent >= 0.9995 * least)
    return Unit(name=name, size=METERS[name])


def _time(last: float) -> Unit:
    """Return the unit in which the last time (s) is one or more; two or more from minutes on."""
    found = (
        (name, size) for name, size in TIMES.items() if last >= 0.9995 * size * (1 + (size > 1))
    )
    name, size = next(found, ("s", 1.0))
    return Unit(name=name, size=size)


def prefixed(name: str, size: float) -> Unit:
    """Return the unit in which a magnitude is between 1 and 1000, as far as prefixes go.

    Parameters
    ----------
    name : name of the unit without a prefix.
    size : the magnitude, in it.
    """
    found = ((prefix, factor) for prefix, factor in PREFIXES.items() if size >= factor)
    prefix, factor = next(found, ("n", 1e-9)) if 0 < size < inf else ("", 1.0)
    return Unit(name=prefix + name, size=factor)


def _volume(dim: int, length: Unit, depth: float) -> Unit:
    """Return the power of a length below the meter, else one in which an opening that is SLENDER,
    over all of the depth (m), is one or more."""
    if length.size < 1:
        return length.power(dim)
    size = SLENDER * depth**dim
    found = (Unit(name=name, size=m).power(dim) for name, m in METERS.items() if m != 1e3)
    return next((unit for unit in found if size >= unit.size), Unit(name="m").power(dim))

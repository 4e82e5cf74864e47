"""From the `--over` options of a study to the points of its parameters."""

import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import isfinite, prod
from typing import Any

import numpy as np

from staffa.case.reading.read import setting_names, setting_parts, typed_value
from staffa.case.schema.toml_text import inline
from staffa.errors import InputError
from staffa.io.study_directory import Parameter, Point
from staffa.units import NUMBER, WRITTEN, unit_name

# "a:b UNIT" and "a:b:n UNIT".
RANGE = re.compile(rf"{NUMBER}\s*:{NUMBER}\s*(?::\s*(\d+))?(?![\d.])([^:]*)")
DIGITS, SAMPLE_DIGITS = 12, 6  # of the values of a range, and of a Latin hypercube
LARGEST_STUDY = 1000  # members: as many as an array of Slurm has by default
EXAMPLE = '--over material.Gc="40:90:6 J/m^2", or --over material.Gc="40, 60, 90 J/m^2"'
SEED = "toughness.seed"


@dataclass(frozen=True, kw_only=True)
class Varied:
    """One `--over` option.

    Attributes
    ----------
    given : the option as it was given.
    key : key of the case, as `--set` takes it.
    values : its values as TOML; empty for a range from which samples are drawn.
    low, high : ends of such a range.
    unit : unit of such a range; empty without one.
    """

    given: str
    key: str
    values: tuple[str, ...] = ()
    low: float = 0.0
    high: float = 0.0
    unit: str = ""


def study_points(
    over: Sequence[str], *, samples: int | None = None, seed: int = 0
) -> tuple[tuple[Parameter, ...], tuple[Point, ...]]:
    """Return the parameters of a study and its points, numbered from 1.

    Without samples they are the grid of all values, the last parameter fastest; with them a Latin
    hypercube in the ranges (scipy.stats.qmc.LatinHypercube).

    Parameters
    ----------
    over : texts "section.key=VALUES", VALUES being "a:b:n UNIT", "a, b, c UNIT" or a list of TOML;
        with samples "a:b UNIT".
    samples : number of points of a Latin hypercube; None for a grid.
    seed : seed of the hypercube.

    Raises
    ------
    InputError
        An option has no key, no values, values in several units, or one twice; two points are
        equal; or there are too many.
    """
    if not over:
        raise InputError(f"a study needs keys to vary; write them like {EXAMPLE}")
    varied = [_varied(text, sampled=samples is not None) for text in over]
    keys = [one.key for one in varied]
    for key in keys:
        if keys.count(key) > 1:
            raise InputError(f"--over {key} is given twice; give all of its values in one --over")
    number = prod(len(one.values) for one in varied) if samples is None else samples
    _require_few(number)
    rows = list(product(*(one.values for one in varied)) if samples is None else ())
    if samples is not None:
        if samples < 2:
            raise InputError(f"--samples {samples}: take 2 or more, or one run with `staffa run`")
        rows = _hypercube(varied, samples, seed)
    columns = [
        _readable(one, texts) for one, texts in zip(varied, zip(*rows, strict=True), strict=True)
    ]
    if len(set(zip(*(values for _, values in columns), strict=True))) < len(rows):
        raise InputError(
            f"--over {' --over '.join(over)}: two points are equal, since values have "
            f"{DIGITS if samples is None else SAMPLE_DIGITS} digits; give wider ranges or fewer "
            f"points, and each value once"
        )
    points = tuple(
        Point(number=n, texts=tuple(texts), values=tuple(values[n - 1] for _, values in columns))
        for n, texts in enumerate(rows, start=1)
    )
    units = zip(varied, columns, strict=True)
    return tuple(Parameter(key=one.key, unit=unit) for one, (unit, _) in units), points


def _require_few(number: int) -> None:
    if number > LARGEST_STUDY:
        raise InputError(
            f"these are {number:,} points, and a study has at most {LARGEST_STUDY:,}; give fewer "
            f"values, or draw some of the points with --samples"
        )


def _varied(given: str, *, sampled: bool) -> Varied:
    """Return one option, read."""
    try:
        names, (_, text) = setting_names(given), setting_parts(given)
    except InputError:
        names, text = [], ""
    if not names or not text.strip():
        raise InputError(f"--over {given}: write it like {EXAMPLE}")
    key = ".".join(name if re.fullmatch(r"[\w-]+", name) else inline(name) for name in names)
    if key == SEED:
        raise InputError(
            f"--over {given}: seeds are no parameter; --seeds 4 runs each point with four of them"
        )
    value = typed_value(text)
    found = RANGE.fullmatch(value if isinstance(value, str) else text)
    if sampled:
        return _range(given, key, found)
    if found:
        return Varied(given=given, key=key, values=tuple(_even(given, found)))
    items = value if isinstance(value, list) else _items(text)
    values = tuple(inline(item) for item in items)
    if len(values) < 2:
        raise InputError(
            f"--over {given}: that is one value; give 2 or more, like {EXAMPLE}, or fix it with "
            f"--set"
        )
    if len(set(values)) < len(values):
        raise InputError(f"--over {given}: a value is given twice; give each once")
    return Varied(given=given, key=key, values=values)


def _range(given: str, key: str, found: re.Match[str] | None) -> Varied:
    if found is None or found[3] is not None:
        raise InputError(
            f'--over {given}: --samples draws from ranges; write it like --over {key}="40:100 '
            f'J/m^2", without a number of values'
        )
    low, high = _ends(given, found)
    if not low < high:
        raise InputError(f"--over {given}: the range must go up; write its smaller end first")
    return Varied(given=given, key=key, low=low, high=high, unit=found[4].strip())


def _ends(given: str, found: re.Match[str]) -> tuple[float, float]:
    """Return the ends of a range, whose distance is a number too."""
    low, high = float(found[1]), float(found[2])
    if not isfinite(high - low):
        raise InputError(f"--over {given}: its numbers are too large; give smaller ones")
    return low, high


def _even(given: str, found: re.Match[str]) -> Iterator[str]:
    """Yield the values of "a:b:n UNIT" as TOML."""
    (low, high), count = _ends(given, found), int(found[3] or 0)
    if count < 2 or low == high:
        raise InputError(
            f"--over {given}: from a to b in n values, n at least 2 and b another number than a; "
            f"write it like {EXAMPLE}"
        )
    _require_few(count)
    for value in np.linspace(low, high, count):
        yield _with_unit(f"{value:.{DIGITS}g}", found[4].strip())


def _with_unit(number: str, unit: str) -> str:
    return inline(f"{number} {unit}") if unit else number


def _items(text: str) -> list[Any]:
    """Return the values of "a, b, c UNIT": the unit of the last is that of bare numbers."""
    parts = [part.strip() for part in text.split(",")]
    last = WRITTEN.fullmatch(parts[-1])
    unit = last[2].strip() if last else ""
    if unit and all(re.fullmatch(NUMBER, part) for part in parts[:-1]):
        parts = [f"{part} {unit}" for part in parts[:-1]] + parts[-1:]
    return [typed_value(part) for part in parts]


def _hypercube(varied: Sequence[Varied], samples: int, seed: int) -> list[tuple[str, ...]]:
    """Return the points of a Latin hypercube, each value as TOML with six digits."""
    from scipy.stats import qmc

    drawn = qmc.LatinHypercube(d=len(varied), rng=seed).random(samples)
    low, high = np.array([(one.low, one.high) for one in varied]).T
    return [
        tuple(
            _with_unit(f"{v:.{SAMPLE_DIGITS}g}", one.unit)
            for v, one in zip(row, varied, strict=True)
        )
        for row in low + drawn * (high - low)
    ]


def _readable(varied: Varied, texts: Sequence[str]) -> tuple[str, list[float | str]]:
    """Return the unit of the values of a parameter, and each: a number in it, else a text."""
    found = [_number(tomllib.loads(f"value = {text}")["value"]) for text in texts]
    if any(one is None for one in found):
        return "", [inline(tomllib.loads(f"value = {text}")["value"]).strip('"') for text in texts]
    known = [one for one in found if one is not None]
    units = list(dict.fromkeys(unit for unit, _ in known))
    if len(units) > 1:
        raise InputError(
            f"--over {varied.given}: its values are in {units[0] or 'no unit'} and in "
            f"{units[1] or 'no unit'}; give all in one unit"
        )
    return units[0], [number for _, number in known]


def _number(value: Any) -> tuple[str, float] | None:
    """Return unit and number of a value; None for one that is no number."""
    if isinstance(value, int | float) and not isinstance(value, bool):
        return "", float(value)
    written = WRITTEN.fullmatch(value) if isinstance(value, str) else None
    if written is None or not written[2].strip():
        return None
    try:
        return unit_name(written[2].strip()), float(written[1])
    except InputError:
        return None

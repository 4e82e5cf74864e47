"""Properties as functions of temperature: pure functions of floats, arrays or forms alike."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from staffa.physics.split import positive

# Gauss points in a panel: exact for polynomials of degree 13.
POINTS = 7
# Functions that formulas may call, by name.
type Functions = Mapping[str, Callable[..., Any]]


@dataclass(frozen=True, kw_only=True)
class Algebra:
    """Arithmetic of the numbers that a law is computed with.

    numbers: turns an array into one whose entries take part in it; functions: by name, as formulas
    call them; panels: into so many parts an integral of a formula is cut.
    """

    numbers: Callable[[np.ndarray], Any]
    functions: Functions
    panels: int = 1


ARRAYS = Algebra(
    numbers=np.asarray,
    functions={
        **{name: getattr(np, name) for name in ("abs", "ceil", "cos", "cosh", "exp", "expm1")},
        **{name: getattr(np, name) for name in ("floor", "log", "log10", "log1p", "sin", "sinh")},
        **{name: getattr(np, name) for name in ("sqrt", "tan", "tanh", "where", "arctan2")},
        **{name: getattr(np, name) for name in ("arccos", "arcsin", "arctan")},
    },
    panels=16,
)


class Law(Protocol):
    """Factor on a property at a temperature, over the property at a reference temperature.

    T: temperature (K), or scaled as the case is; x: the place, whose entries are x, y and z.
    """

    def at(self, T: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """The factor."""
        ...

    def integral(self, start: Any, end: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """Its integral over temperature from `start` to `end` (K)."""
        ...


@dataclass(frozen=True, kw_only=True)
class LinearTable:
    """Piecewise linear between the temperatures T (K), increasing, and constant beyond them.

    value: the factor at each, shape (n,) as T.
    """

    T: tuple[float, ...]
    value: tuple[float, ...]

    @cached_property
    def _bends(self) -> np.ndarray:
        """Change of the slope at each temperature, shape (n,)."""
        slopes = np.diff(self.value) / np.diff(self.T)
        return np.diff(np.concatenate([[0.0], slopes, [0.0]]))

    def at(self, T: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """See `Law`."""
        total = algebra.numbers(np.array(self.value[:1]))[0]
        for knot, bend in self._rows(algebra):
            total = total + bend * positive(T - knot)
        return total

    def integral(self, start: Any, end: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """See `Law`."""
        total = algebra.numbers(np.array(self.value[:1]))[0] * (end - start)
        for knot, bend in self._rows(algebra):
            total = total + bend / 2 * (positive(end - knot) ** 2 - positive(start - knot) ** 2)
        return total

    def _rows(self, algebra: Algebra) -> list[tuple[Any, Any]]:
        knots, bends = algebra.numbers(np.array(self.T)), algebra.numbers(self._bends)
        return [(knots[i], bends[i]) for i in range(len(self.T))]


@dataclass(frozen=True, kw_only=True)
class Written:
    """A formula of temperature and place, over its value at the temperature `reference` (K).

    text: the formula, by which two laws are the same; value: (T, x, functions) -> its value.
    """

    text: str
    reference: float
    value: Callable[[Any, Any, Functions], Any] = field(compare=False, repr=False)

    def at(self, T: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """See `Law`."""
        value, functions = self.value, algebra.functions
        return value(T, x, functions) / value(self.reference, x, functions)

    def integral(self, start: Any, end: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """See `Law`; by Gauss's rule in `algebra.panels` equal parts."""
        points, weights = np.polynomial.legendre.leggauss(POINTS)
        half = (end - start) / (2 * algebra.panels)
        total = 0.0
        for panel in range(algebra.panels):
            for point, weight in zip(points.tolist(), weights.tolist(), strict=True):
                total = total + weight * self.at(start + half * (2 * panel + 1 + point), x, algebra)
        return half * total


@dataclass(frozen=True, kw_only=True)
class Secant:
    """Expansion as secant coefficients from a reference temperature (K).

    The free strain between two temperatures is mean(T) (T - reference) at one, less that at the
    other, so that it is zero at the temperature that is free of stress, whatever the reference.
    """

    mean: Law
    reference: float

    def at(self, T: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """See `Law`: the secant coefficient."""
        return self.mean.at(T, x, algebra)

    def integral(self, start: Any, end: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """See `Law`: the free strain over the coefficient at its reference temperature (K)."""
        late = self.mean.at(end, x, algebra) * (end - self.reference)
        return late - self.mean.at(start, x, algebra) * (start - self.reference)

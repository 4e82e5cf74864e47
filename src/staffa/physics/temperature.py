"""Properties as functions of temperature: pure functions of floats, arrays or forms."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

import numpy as np

from staffa.physics.strained import positive

# Gauss points in a panel: exact for polynomials of degree 13.
POINTS = 7
# Functions that formulas may call, by name.
type Functions = Mapping[str, Callable[..., Any]]


@dataclass(frozen=True, kw_only=True)
class Algebra:
    """Arithmetic in which a law is computed.

    Attributes
    ----------
    numbers : turns an array into one whose entries can be used in this arithmetic.
    functions : functions by the names that formulas call.
    panels : number of parts into which the integral of a formula is divided.
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
    """Factor on a property at a temperature, over the property at a reference temperature."""

    def at(self, T: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """Return the factor.

        Parameters
        ----------
        T : temperature (K), or scaled as the case is.
        x : position, with entries x, y and z (m).
        algebra : arithmetic of the numbers.
        """
        ...

    def integral(self, start: Any, end: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """Return the integral of the factor over temperature (K).

        Parameters
        ----------
        start : temperature from which it is integrated (K).
        end : temperature up to which it is integrated (K).
        x : position, with entries x, y and z (m).
        algebra : arithmetic of the numbers.
        """
        ...


@dataclass(frozen=True, kw_only=True)
class LinearTable:
    """Piecewise linear law, constant beyond its ends.

    Attributes
    ----------
    T : temperatures, increasing (K), shape (n,).
    value : factor at each, shape (n,).
    """

    T: tuple[float, ...]
    value: tuple[float, ...]

    @cached_property
    def _bends(self) -> np.ndarray:
        """Change of the slope at each temperature, shape (n,)."""
        slopes = np.diff(self.value) / np.diff(self.T)
        return np.diff(np.concatenate([[0.0], slopes, [0.0]]))

    def at(self, T: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """Return the factor; T, x and algebra as in `Law.at`."""
        total = algebra.numbers(np.array(self.value[:1]))[0]
        for knot, bend in self._rows(algebra):
            total = total + bend * positive(T - knot)
        return total

    def integral(self, start: Any, end: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """Return the integral of the factor; start, end, x and algebra as in `Law.integral`."""
        total = algebra.numbers(np.array(self.value[:1]))[0] * (end - start)
        for knot, bend in self._rows(algebra):
            total = total + bend / 2 * (positive(end - knot) ** 2 - positive(start - knot) ** 2)
        return total

    def _rows(self, algebra: Algebra) -> list[tuple[Any, Any]]:
        knots, bends = algebra.numbers(np.array(self.T)), algebra.numbers(self._bends)
        return [(knots[i], bends[i]) for i in range(len(self.T))]


@dataclass(frozen=True, kw_only=True)
class Written:
    """Formula of temperature and position, over its value at a reference temperature.

    Attributes
    ----------
    text : the formula; laws with equal text are equal.
    reference : reference temperature (K).
    value : function (T, x, functions) -> value of the formula.
    """

    text: str
    reference: float
    value: Callable[[Any, Any, Functions], Any] = field(compare=False, repr=False)

    def at(self, T: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """Return the factor; T, x and algebra as in `Law.at`."""
        value, functions = self.value, algebra.functions
        return value(T, x, functions) / value(self.reference, x, functions)

    def integral(self, start: Any, end: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """Return the integral of the factor by Gauss's rule in `algebra.panels` equal parts.

        The parameters start, end, x and algebra are as in `Law.integral`.
        """
        points, weights = np.polynomial.legendre.leggauss(POINTS)
        half = (end - start) / (2 * algebra.panels)
        total = 0.0
        for panel in range(algebra.panels):
            for point, weight in zip(points.tolist(), weights.tolist(), strict=True):
                total = total + weight * self.at(start + half * (2 * panel + 1 + point), x, algebra)
        return half * total


@dataclass(frozen=True, kw_only=True)
class Secant:
    """Expansion given as secant coefficients from a reference temperature.

    The free strain between two temperatures is mean(T) (T - reference) at one, less that at the
    other. So it is zero at the stress-free temperature, whatever the reference.

    Attributes
    ----------
    mean : secant coefficient over its reference value, as a law.
    reference : temperature from which the coefficients are counted (K).
    """

    mean: Law
    reference: float

    def at(self, T: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """Return the secant coefficient; T, x and algebra as in `Law.at`."""
        return self.mean.at(T, x, algebra)

    def integral(self, start: Any, end: Any, x: Any, algebra: Algebra = ARRAYS) -> Any:
        """Return the free strain over the coefficient at its reference temperature (K).

        The parameters start, end, x and algebra are as in `Law.integral`.
        """
        late = self.mean.at(end, x, algebra) * (end - self.reference)
        return late - self.mean.at(start, x, algebra) * (start - self.reference)

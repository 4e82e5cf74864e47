"""A formula has the values that its text says, and nothing in it is written to."""

import math
import operator
import subprocess
import sys
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from staffa.errors import InputError
from staffa.properties.formula import FUNCTIONS, formula, formula_variables, trial

KNOWN = formula_variables(3)
X = np.random.default_rng(1).uniform(0.05, 0.95, (3, 257))
T = 0.75
# Functions of Python by the names that formulas have for them, one number at a time.
OTHER_NAMES = {"abs": abs, "arccos": math.acos, "arcsin": math.asin, "arctan": math.atan}
OF_TWO = {"arctan2": math.atan2}
# Both round; numpy is within a few units in the last place of the C library.
CLOSE = {"rtol": 1e-14, "atol": 1e-15}


def values(text: str) -> np.ndarray:
    return trial(formula(text, KNOWN), KNOWN, X, T)


def pointwise(function: Callable[..., float]) -> np.ndarray:
    """The same by Python's own arithmetic, point by point, of x, y, z and t."""
    return np.array([function(*map(float, point), T) for point in X.T])


@pytest.mark.parametrize("name", [name for name in FUNCTIONS if name not in ("where", *OF_TWO)])
def test_each_function_of_one_number_is_the_one_of_its_name(name: str) -> None:
    exact = OTHER_NAMES.get(name) or getattr(math, name)
    np.testing.assert_allclose(
        values(f"{name}(x*y)"), pointwise(lambda x, y, z, t: exact(x * y)), **CLOSE
    )


@pytest.mark.parametrize("name", OF_TWO)
def test_each_function_of_two_numbers_is_the_one_of_its_name(name: str) -> None:
    exact = OF_TWO[name]
    found = values(f"{name}(x - 0.5, y - 0.5)")
    np.testing.assert_allclose(
        found, pointwise(lambda x, y, z, t: exact(x - 0.5, y - 0.5)), **CLOSE
    )


SIGNS = {
    "x + y*z - t/x": lambda x, y, z, t: x + y * z - t / x,
    "-x**2": lambda x, y, z, t: -(x**2),
    "(-x)**-3": lambda x, y, z, t: (-x) ** -3,
    "x**y": lambda x, y, z, t: x**y,
    "+x % 0.3": lambda x, y, z, t: x % 0.3,
    "(x - 1) % 0.3": lambda x, y, z, t: (x - 1) % 0.3,
    "pi*t": lambda x, y, z, t: math.pi * t,
    "7": lambda x, y, z, t: 7.0,
    "1/3": lambda x, y, z, t: 1 / 3,
    "2**-1 + 9**0.5": lambda x, y, z, t: 3.5,
    "1 + (x > 0.5)*3": lambda x, y, z, t: 4.0 if x > 0.5 else 1.0,
}


@pytest.mark.parametrize("text", SIGNS)
def test_signs_compute_as_those_of_python(text: str) -> None:
    np.testing.assert_allclose(values(text), pointwise(SIGNS[text]), **CLOSE)


COMPARISONS: dict[str, Callable[[Any, Any], Any]] = {
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": operator.ne,
}


@pytest.mark.parametrize("sign", COMPARISONS)
def test_conditions_choose_point_by_point(sign: str) -> None:
    compare = COMPARISONS[sign]
    found = values(f"where(floor(3*x) {sign} floor(3*y), z, t)")
    chosen = compare(np.floor(3 * X[0]), np.floor(3 * X[1]))
    assert 0 < chosen.sum() < chosen.size
    assert np.array_equal(found, np.where(chosen, X[2], T))


def test_conditions_are_joined_and_turned_round() -> None:
    x, y, z = X
    found = values("where((x > 0.5) & (y > 0.5) | ~(z > 0.5), 1, 0)")
    assert np.array_equal(found, ((x > 0.5) & (y > 0.5) | ~(z > 0.5)).astype(float))
    assert values("where(~(1 > 0), 1, 2)")[0] == 2, "also of constants"


def test_a_formula_without_points_has_no_values() -> None:
    """As on a rank that owns nothing."""
    for text in ("7", "where(x > t, sin(y), 2)"):
        assert formula(text, KNOWN)(np.zeros((3, 0)), T).shape == (0,)


@pytest.mark.parametrize("text", ["sin(x, y)", "arctan2(x, y, z)", "arctan2(x)", "abs()"])
def test_too_many_operands_are_refused_and_not_written_to(text: str) -> None:
    """numpy takes the operand after the last for the place of the result."""
    before = X.copy()
    with pytest.raises(InputError, match="what its functions are given"):
        values(text)
    assert np.array_equal(before, X)


def test_values_cannot_be_written_into_the_points() -> None:
    with pytest.raises(ValueError, match="read-only"):
        values("x")[0] = 1.0


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("where(x, 1, 2)", "it cannot be computed"),
        ("where(x > 1, 2)", "it cannot be computed"),
        ("~x", "it cannot be computed"),
        ("x & y", "it cannot be computed"),
        ("-(x > 1)", "it cannot be computed"),
        ("sin(x > 1)", "true or false and no number"),
        ("(x > 1) + (y > 1)", "true or false and no number"),
        ("1 > 0", "true or false and no number"),
        ("where(x > 2, 1/0, 2)", "its value is not finite"),
        ("where(x > 2, 9**999, 2)", "its value is not finite"),
        ("0**-1", "its value is not finite"),
        ("(-x)**0.5", "not finite at t = 0.75"),
        ("(-8)**0.5", "its value is complex; it must be a real number"),
        ("x*1e400", "not finite at t = 0.75"),
    ],
)
def test_what_is_no_number_everywhere_is_refused(text: str, said: str) -> None:
    with pytest.raises(InputError, match=said):
        values(text)


def test_the_longest_and_deepest_formula_is_computed() -> None:
    assert np.array_equal(values("-" * 198 + "x"), X[0])
    np.testing.assert_allclose(values("+".join("x" * 100)), 100 * X[0], rtol=1e-13)


def test_formulas_need_numpy_alone() -> None:
    code = (
        "import sys; from staffa.properties.formula import formula; import numpy as np\n"
        "formula('where(x > 0, exp(x), 1)', ('x',))(np.ones((3, 4)), 0.0)\n"
        "sys.exit('numexpr' in sys.modules)"
    )
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0

"""Formulas that a case file brings along, "293 - 5*t", read as such and as nothing else."""

import ast
import operator
import warnings
from collections.abc import Callable, Mapping
from math import pi
from typing import Any

import numpy as np

from staffa.errors import InputError, did_you_mean

LONGEST = 200  # characters
# Functions of numpy, by their names there; `where` stands last.
FUNCTIONS = (
    *("abs", "arccos", "arcsin", "arctan", "arctan2", "ceil", "cos", "cosh", "exp", "expm1"),
    *("floor", "log", "log10", "log1p", "sin", "sinh", "sqrt", "tan", "tanh", "where"),
)
ALLOWED = (
    *(ast.Expression, ast.BinOp, ast.UnaryOp, ast.Compare, ast.Call, ast.Name, ast.Constant),
    *(ast.Load, ast.Add, ast.Sub, ast.Mult, ast.Div, ast.Mod, ast.Pow, ast.UAdd, ast.USub),
    *(ast.Lt, ast.LtE, ast.Gt, ast.GtE, ast.Eq, ast.NotEq, ast.BitAnd, ast.BitOr, ast.Invert),
)
# Values at points x, shape (3, n), and a time t: shape (n,).
Evaluated = Callable[[np.ndarray, float], np.ndarray]


def formula_variables(dim: int, *, time: bool = True) -> tuple[str, ...]:
    """Return the names of the variables of a formula."""
    return (*(("t",) if time else ()), *"xyz"[:dim])


def formula(text: str, names: tuple[str, ...]) -> Evaluated:
    """Return the function of points and time that a text gives.

    Its variables and values are in SI, or scaled as the case is.

    Parameters
    ----------
    text : the formula.
    names : variables that it may use, of t, x, y, z.

    Raises
    ------
    InputError
        It is no formula of these. Its value may still be no number: see `trial`.
    """
    tree = _plain(text, names)

    def value(x: np.ndarray, t: float) -> np.ndarray:
        with np.errstate(all="ignore"):
            found = _computed(tree, known(x, t), NUMPY)
        return np.broadcast_to(found, x.shape[1:])

    return value


def trial(value: Evaluated, names: tuple[str, ...], x: np.ndarray, t: float) -> np.ndarray:
    """Return the values of a formula, if they are finite numbers.

    Parameters
    ----------
    value : the formula.
    names : names of its variables.
    x : points (m), shape (3, n).
    t : time (s).

    Raises
    ------
    InputError
        They cannot be computed, are no numbers, or not finite.
    """
    try:
        found = value(x, t)
    except (ZeroDivisionError, OverflowError):
        raise InputError("its value is not finite; it must be so everywhere") from None
    except TypeError:  # of numpy, where an operation has no meaning
        raise InputError(
            "it cannot be computed; check what its functions are given and that comparisons stand "
            "in parentheses"
        ) from None
    if found.dtype == np.complex128:
        raise InputError("its value is complex; it must be a real number everywhere")
    if found.dtype != np.float64:
        raise InputError("it is true or false and no number; write it like where(x > 1, 5, 2)")
    if not np.all(np.isfinite(found)):
        at = known(x[:, np.argmin(np.isfinite(found))], t)
        where = ", ".join(f"{name} = {at[name]:g}" for name in names)
        raise InputError(f"its value is not finite at {where}; it must be so everywhere")
    return found


def known(x: np.ndarray, t: float) -> dict[str, Any]:
    """Return the values of a formula's variables at one or more points, by name."""
    return {"x": x[0], "y": x[1], "z": x[2], "t": np.float64(t), "pi": pi}


def vocabulary(names: tuple[str, ...]) -> str:
    """Return a sentence that lists the parts of a formula of these names."""
    signs = "+ - * / **, < > & |"
    return f"it may use numbers, pi, {', '.join(names)}, {signs}, and {', '.join(FUNCTIONS)}"


def _plain(text: str, names: tuple[str, ...]) -> ast.expr:
    """Return the formula after a check of each of its parts, with whole numbers as others.

    So 9**9**9**9 is at once too large, and not computed digit by digit.
    """
    words = vocabulary(names)
    try:
        with warnings.catch_warnings(action="ignore"):  # of what is refused here anyway
            tree = ast.parse(text.strip(), mode="eval")
        parts = list(ast.walk(tree))
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        raise InputError(f"that is no formula; {words}") from None
    called = {id(part.func) for part in parts if isinstance(part, ast.Call)}
    for part in parts:
        if isinstance(part, ast.Name):
            there = FUNCTIONS if id(part) in called else (*names, "pi")
            if part.id not in there:
                hint = did_you_mean(part.id, there)
                raise InputError(
                    f"'{part.id[:40]}' is not known there; {words}{hint and '.'}{hint}"
                )
        elif not _is_plain(part):
            raise InputError(f"that is more than a formula; {words}")
    whole: ast.Expression = _Floats().visit(tree)
    return whole.body


def _is_plain(part: ast.AST) -> bool:
    if isinstance(part, ast.Call):
        return isinstance(part.func, ast.Name) and not part.keywords
    if isinstance(part, ast.Compare):
        return len(part.ops) == 1
    if isinstance(part, ast.Constant):
        return type(part.value) in (int, float)
    return isinstance(part, ALLOWED)


def uses(text: str, name: str) -> bool:
    """Return True if a formula depends on something, by its name; False of a text that is none."""
    try:
        tree = ast.parse(text.strip(), mode="eval")
    except (SyntaxError, ValueError, RecursionError, MemoryError):
        return False
    return any(isinstance(part, ast.Name) and part.id == name for part in ast.walk(tree))


def _on_arrays(function: np.ufunc) -> Callable[..., Any]:
    """Return a function of numpy that takes its operands alone.

    numpy would write the result into one operand too many.
    """

    def value(*operands: Any) -> Any:
        if len(operands) != function.nin:
            raise TypeError(f"{function.__name__} takes {function.nin} operands")
        return function(*operands)

    return value


def _where(condition: Any, yes: Any, no: Any) -> Any:
    """Return `yes` where a condition is true, else `no`; a number is no condition."""
    if np.asarray(condition).dtype != np.bool_:
        raise TypeError("where takes a condition")
    return np.where(condition, yes, no)


# Each of FUNCTIONS, for arrays.
NUMPY = {name: _on_arrays(getattr(np, name)) for name in FUNCTIONS[:-1]} | {"where": _where}
# Those that have no derivative, or that not every arithmetic has.
NOT_GENERIC = ("ceil", "floor")
GENERIC: dict[type, Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.Pow: operator.pow,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
}
SIGNS = GENERIC | {
    ast.Mod: operator.mod,
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
}
# Before one operand; the `~` of Python makes a number of True.
BEFORE: dict[type, Callable[[Any], Any]] = {
    ast.USub: lambda value: -value,
    ast.UAdd: lambda value: value,
    ast.Invert: np.invert,
}
# Values by name, and functions by name -> the value.
Generic = Callable[[Mapping[str, Any], Mapping[str, Callable[..., Any]]], Any]


def generic(text: str, names: tuple[str, ...]) -> Generic:
    """Return the formula as a function of anything with arithmetic, such as forms.

    Raises
    ------
    InputError
        It is no formula of these names, or holds what not every arithmetic has.
    """
    tree = _plain(text, names)
    for part in ast.walk(tree):
        sign = getattr(part, "op", None) or (part.ops[0] if isinstance(part, ast.Compare) else None)
        missing = isinstance(part, ast.Name) and part.id in NOT_GENERIC
        if missing or not (sign is None or type(sign) in (*GENERIC, ast.USub, ast.UAdd)):
            raise InputError(
                "a formula of T may not use %, &, |, ~, ==, !=, ceil and floor, along which it has "
                "no derivative; put one where() into another for two conditions"
            )
    return lambda known, functions: _computed(tree, {"pi": pi, **known}, functions)


def _computed(
    part: ast.AST, known: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]]
) -> Any:
    """Return the value of a part of a formula."""

    def value(part: ast.AST) -> Any:
        return _computed(part, known, functions)

    match part:
        case ast.Constant():
            return part.value
        case ast.Name():
            return known[part.id]
        case ast.UnaryOp():
            return BEFORE[type(part.op)](value(part.operand))
        case ast.BinOp():
            return SIGNS[type(part.op)](value(part.left), value(part.right))
        case ast.Compare():
            return SIGNS[type(part.ops[0])](value(part.left), value(part.comparators[0]))
        case ast.Call(func=ast.Name() as called):
            return functions[called.id](*map(value, part.args))
    raise TypeError(ast.dump(part))  # `_plain` lets nothing else through


class _Floats(ast.NodeTransformer):
    def visit_Constant(self, node: ast.Constant) -> ast.Constant:
        try:
            return ast.Constant(float(node.value))  # type: ignore[arg-type]
        except OverflowError:
            raise InputError("it holds a number that is too large; shorten it") from None

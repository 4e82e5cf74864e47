"""Properties of temperature in forms: a law for each rock, at the temperature of each point."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import ufl
from dolfinx import fem
from dolfinx import mesh as dmesh

from staffa.model.domain import middles
from staffa.physics.temperature import Algebra, Law

type Expression = ufl.core.expr.Expr
# A rock's law, None for no dependence on temperature, and its local cells, ghosts included.
type LawInCells = tuple[Law | None, np.ndarray]

FUNCTIONS = {
    "abs": abs,
    "arccos": ufl.acos,
    "arcsin": ufl.asin,
    "arctan": ufl.atan,
    "arctan2": ufl.atan2,
    "cos": ufl.cos,
    "cosh": ufl.cosh,
    "exp": ufl.exp,
    "expm1": lambda x: ufl.exp(x) - 1,
    "log": ufl.ln,
    "log10": lambda x: ufl.ln(x) / np.log(10.0),
    "log1p": lambda x: ufl.ln(1 + x),
    "sin": ufl.sin,
    "sinh": ufl.sinh,
    "sqrt": ufl.sqrt,
    "tan": ufl.tan,
    "tanh": ufl.tanh,
    "where": ufl.conditional,
}


@dataclass(kw_only=True)
class Spent:
    """Energy (J, in 2-D J/m) that cracks have cost up to the damage `alpha`, at the toughness of
    the moments at which they grew."""

    alpha: fem.Function
    energy: float = 0.0


def algebra(mesh: dmesh.Mesh) -> Algebra:
    """Arithmetic of forms; numbers of tables are constants, so that compiled forms serve any."""
    return Algebra(numbers=lambda values: fem.Constant(mesh, values), functions=FUNCTIONS)


def middle_of_cell(mesh: dmesh.Mesh) -> fem.Function:
    """The middle of each cell (m), as a function that is constant in each."""
    place = fem.Function(fem.functionspace(mesh, ("Discontinuous Lagrange", 0, (3,))))
    place.x.array.reshape(-1, 3)[place.function_space.dofmap.list[:, 0]] = middles(mesh).T
    return place


def by_law(
    mesh: dmesh.Mesh,
    rocks: Sequence[LawInCells],
    value: Callable[[Law | None], Expression],
) -> Expression:
    """The value that each cell's law has; rocks: that of all cells first, then those that differ.

    Rocks of equal laws share one expression.
    """
    laws = distinct(rocks)
    if len(laws) == 1:
        return value(laws[0])
    # Not a product: elsewhere a formula may have no value.
    parts = [
        ufl.conditional(ufl.gt(share_of(mesh, rocks, law), 0.5), value(law), 0.0) for law in laws
    ]
    return sum(parts[1:], parts[0])


def distinct(rocks: Sequence[LawInCells]) -> list[Law | None]:
    """The laws that differ."""
    laws: list[Law | None] = []
    for law, _ in rocks:
        if law not in laws:
            laws.append(law)
    return laws


def share_of(mesh: dmesh.Mesh, rocks: Sequence[LawInCells], law: Law | None) -> fem.Function:
    """1 in the cells of a law, 0 in the others."""
    here = fem.Function(fem.functionspace(mesh, ("Discontinuous Lagrange", 0)))
    cell = here.function_space.dofmap.list[:, 0]
    for other, where in rocks:
        here.x.array[cell[where]] = float(other == law)
    return here

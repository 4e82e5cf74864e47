"""Temperature-dependent properties in forms: the law of each rock at each point's temperature."""

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
# Law of a rock, None if it does not depend on temperature, and its local cells, ghosts included.
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
    """Surface energy of cracks up to a damage, at the Gc of the times at which they grew.

    Attributes
    ----------
    alpha : damage up to which it is counted.
    energy : the energy (J, in 2-D J/m).
    """

    alpha: fem.Function
    energy: float = 0.0


def algebra(mesh: dmesh.Mesh) -> Algebra:
    """Return the arithmetic of forms; numbers of tables are constants, not literals."""
    return Algebra(numbers=lambda values: fem.Constant(mesh, values), functions=FUNCTIONS)


def middle_of_cell(mesh: dmesh.Mesh) -> fem.Function:
    """Return the center of each cell (m), as a function that is constant in each cell."""
    place = fem.Function(fem.functionspace(mesh, ("Discontinuous Lagrange", 0, (3,))))
    place.x.array.reshape(-1, 3)[place.function_space.dofmap.list[:, 0]] = middles(mesh).T
    return place


def by_law(
    mesh: dmesh.Mesh,
    rocks: Sequence[LawInCells],
    value: Callable[[Law | None], Expression],
) -> Expression:
    """Return an expression with the value of each cell's law.

    Rocks of equal laws share one expression.

    Parameters
    ----------
    mesh : the mesh.
    rocks : law and cells of each rock: that of all cells first, then those that differ.
    value : function that returns the expression of a law.
    """
    laws = distinct(rocks)
    if len(laws) == 1:
        return value(laws[0])
    # Not a product: in other cells a formula may have no value.
    parts = [
        ufl.conditional(ufl.gt(share_of(mesh, rocks, law), 0.5), value(law), 0.0) for law in laws
    ]
    return sum(parts[1:], parts[0])


def distinct(rocks: Sequence[LawInCells]) -> list[Law | None]:
    """Return the laws that differ."""
    laws: list[Law | None] = []
    for law, _ in rocks:
        if law not in laws:
            laws.append(law)
    return laws


def share_of(mesh: dmesh.Mesh, rocks: Sequence[LawInCells], law: Law | None) -> fem.Function:
    """Return 1 in the cells of a law, 0 in the others.

    Parameters
    ----------
    mesh : the mesh.
    rocks : law and cells of each rock.
    law : the law.
    """
    here = fem.Function(fem.functionspace(mesh, ("Discontinuous Lagrange", 0)))
    cell = here.function_space.dofmap.list[:, 0]
    for other, where in rocks:
        here.x.array[cell[where]] = float(other == law)
    return here

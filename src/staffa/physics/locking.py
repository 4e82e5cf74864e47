"""Elements that do not lock in nearly incompressible rock.

If the volume can hardly change, linear triangles and tetrahedra, and fully integrated
quadrilaterals and hexahedra, have fewer degrees of freedom than constraints: they lock, and the
body is too stiff. A quadratic displacement has enough degrees of freedom. For quadrilaterals and
hexahedra the volume change is integrated with one point a cell, all else as before (selective
reduced integration: Malkus and Hughes 1978). Linear simplices have one strain a cell, so reduced
integration changes nothing there.
"""

from staffa.geometry.block import UNSTRUCTURED

LINEAR, QUADRATIC, REDUCED = "linear", "quadratic", "reduced"
ELEMENTS = (LINEAR, QUADRATIC, REDUCED)
# How stiff linear elements are, see `too_stiff`: measured on pressed rings of 4 to 20 cells across
# the wall (`verification/locking/run.py`). Triangles four to a square have constraints that repeat.
MEASURED = {
    "quadrilateral": 0.2,
    "hexahedron": 0.2,
    "triangle": 0.05,
    "tetrahedron": 0.5,
    UNSTRUCTURED: 0.5,
}
# Poisson's ratio from which linear elements are not the default where the volume is constrained.
FROM = 0.45


def cures(cells: str) -> str:
    """Return the elements that do not lock on cells of a shape ("triangle", ...; see `grid`)."""
    return REDUCED if cells in ("quadrilateral", "hexahedron") else QUADRATIC


def too_stiff(nu: float, cells: str, across: float) -> float:
    """Return about the part of a displacement that linear elements lack.

    It is x/(1 + x) with x = c lambda/mu (h/L)^2. For h much less than L this is the error C lambda
    h^2 of theory (Mustapha et al. 2024, arXiv 2407.06831), and with nu = 1/2 nothing moves.

    Parameters
    ----------
    nu : Poisson's ratio, less than 1/2.
    cells : shape of the cells, as in `Domain.cell_kind`.
    across : number of cells L/h over the length L on which the strain changes.
    """
    x = MEASURED[cells] * 2 * nu / (1 - 2 * nu) / across**2
    return x / (1 + x)

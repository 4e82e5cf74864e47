"""Permeability of fractures: planes through the cells, and rows of cells along sides."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from staffa.reservoir.grid import Grid
from staffa.reservoir.simulator import Fracture, ReservoirModel

# Opening (m) above which a fracture is no more permeable. Its pressure drop is that of some pascals
# by then, and beside rock of 1e-20 m^2 Newton's method finds no solution from 20 mm on.
WIDEST = 5e-3
# Cells over which a plane is spread: fluxes between two cells lose an oblique fracture else. The
# quarter takes in those two cells along one axis and one along the other, or 0.77 of the flow of a
# fracture at 45 degrees is kept, and not 0.92.
CELLS = 2.25
NEAR = 1e-6  # of the radius: rounding does not decide on cells that are as far as that
SAMPLES = 20  # points of a plane in the length of the smallest cell
# Bounds of the number of points of a segment, and of rings of a disc.
POINTS, RINGS = (1, 10**6), (16, 300)


@dataclass(frozen=True, kw_only=True)
class Plane:
    """A flat fracture in the rock: a segment in 2-D, a disc in 3-D.

    Attributes
    ----------
    opening : its opening (m).
    start, end : ends of the segment (m), shape (2,); None for a disc.
    center, normal : center of the disc (m) and direction across it, shape (3,); None for a segment.
    radius : radius of the disc (m); None for a segment.
    """

    opening: float
    start: tuple[float, float] | None = None
    end: tuple[float, float] | None = None
    center: tuple[float, float, float] | None = None
    normal: tuple[float, float, float] | None = None
    radius: float | None = None


def of_opening(opening: np.ndarray | float, height: float) -> np.ndarray:
    """Return the permeability (m^2) of a row of cells beside half a fracture: w^3/(24 b).

    An opening of more than `WIDEST` counts as that.

    Parameters
    ----------
    opening : opening w of the whole fracture (m).
    height : height of the whole fracture's cells (m); the row is half as high, b.
    """
    return np.minimum(opening, WIDEST) ** 3 / (12 * height)


def spreading(grid: Grid, radius: float, among: np.ndarray) -> "scipy.sparse.csr_matrix":
    """Return the matrix that spreads what cells hold over the cells around them, and keeps sums.

    Each cell gives to those with a center within the radius, in proportion to their volumes.

    Parameters
    ----------
    grid : the cells.
    radius : distance (m).
    among : indices of the cells that take part, shape (n,); the others give and get nothing.
    """
    tree = scipy.spatial.cKDTree(grid.centers[among, : grid.dim])
    near = tree.sparse_distance_matrix(tree, radius * (1 + NEAR), output_type="coo_matrix")
    getting, giving = among[near.row], among[near.col]
    shape = (grid.size, grid.size)
    shares = scipy.sparse.csr_matrix((grid.volumes[getting], (getting, giving)), shape=shape)
    totals = np.asarray(shares.sum(axis=0)).ravel()
    return scipy.sparse.csr_matrix(
        shares @ scipy.sparse.diags_array(1 / np.where(totals > 0, totals, 1.0))
    )


def rock_cells(grid: Grid) -> np.ndarray:
    """Return the indices of the cells that are not in the row of a fracture, shape (n,)."""
    rows = [grid.row(side) for side in grid.rows]
    return np.setdiff1d(np.arange(grid.size), np.concatenate([*rows, []]).astype(np.int64))


def with_planes(
    grid: Grid, permeability: np.ndarray, planes: Sequence[Plane], spread: float | None = None
) -> np.ndarray:
    """Return the permeability of the rock with fractures in it: k_0 + (A/|c|) w^3/12 along them.

    Parameters
    ----------
    grid : the cells.
    permeability : permeability of the rock (m^2), shape (n_cells,).
    planes : the fractures.
    spread : radius over which they are spread (m); None for `CELLS` of the largest cell that they
        cross.

    Returns
    -------
    np.ndarray
        Along each axis, shape (n_cells, 3); as it was, without fractures.
    """
    if not planes:
        return np.array(permeability, dtype=float)
    among = rock_cells(grid)
    total = np.repeat(np.array(permeability, dtype=float)[:, None], 3, axis=1)
    for plane in planes:
        area = _area_in_cells(grid, plane)
        crossed = area > 0
        largest = grid.sizes[crossed, : grid.dim].max(initial=0.0)
        radius = CELLS * largest if spread is None else spread
        spread_area = spreading(grid, radius, among) @ area
        added = spread_area / grid.volumes * min(plane.opening, WIDEST) ** 3 / 12
        total += added[:, None] * along_axes(_normal(plane)[None])
    return total


def along_axes(normals: np.ndarray) -> np.ndarray:
    """Return the factor of the conductance of cracks along each axis, shape (n, 3).

    It is 1 - n_i^2 + |n_i| max |n_j|, j another axis: none across a crack that lies along two axes,
    so that a dead end along an axis is no detour, and 1 in all directions at 45 degrees. A
    flux between two cells knows no full tensor, whose diagonal 1 - n_i^2 alone would keep half of
    the flow through an oblique crack: water goes along it in steps, each along an axis.

    Parameters
    ----------
    normals : unit normals of the cracks, shape (n, 2 or 3).
    """
    n = np.zeros((len(normals), 3))
    n[:, : normals.shape[1]] = np.abs(normals)
    others = np.stack([np.delete(n, axis, axis=1).max(axis=1) for axis in range(3)], axis=1)
    return np.asarray(1 - n**2 + n * others)


def largest_along(permeability: np.ndarray) -> np.ndarray:
    """Return the permeability along the axis along which it is largest, shape (n_cells,).

    Parameters
    ----------
    permeability : that of all directions, shape (n_cells,), or along each axis, (n_cells, 3).
    """
    return permeability if permeability.ndim == 1 else np.asarray(permeability.max(axis=1))


def _normal(plane: Plane) -> np.ndarray:
    """Return the unit normal of a plane, shape (2,) or (3,)."""
    if plane.normal is not None:
        across = np.array(plane.normal, dtype=float)
    else:
        x, y = np.array(plane.end, dtype=float) - np.array(plane.start, dtype=float)
        across = np.array([-y, x])
    return np.asarray(across / np.linalg.norm(across))


def with_rows(model: ReservoirModel) -> ReservoirModel:
    """Return the model with the fractures along its sides put into their rows of cells.

    The row stands for half of a fracture whose real height is w/2. It gets the permeability
    w^3/(24 b) and the porosity w/(2 b), so it holds the water of the fracture. The rest of the row
    has no heat capacity: in a thin fracture, the heat that water carries is all that counts.

    Parameters
    ----------
    model : the reservoir, with the properties of the rock in all cells.
    """
    k, porosity, rho_c = (
        np.array(a, dtype=float) for a in (model.permeability, model.porosity, model.rho_c)
    )
    for fracture in model.fractures:
        row = model.grid.row(fracture.side)
        k[row] = of_opening(fracture.opening, fracture.height)  # of all axes
        porosity[row] = _water_of(fracture)
        rho_c[row] = 0.0
    return replace(model, permeability=k, porosity=porosity, rho_c=rho_c)


def _water_of(fracture: Fracture) -> float:
    """Return the share of the row that the water of the fracture fills."""
    return min(fracture.opening / fracture.height, 1.0)


def _area_in_cells(grid: Grid, plane: Plane) -> np.ndarray:
    """Return the area (m^2) of a plane in each cell, shape (n_cells,)."""
    points, areas = _segment(grid, plane) if plane.center is None else _disc(grid, plane)
    cells, inside = grid.cells_around(points)
    return np.bincount(cells[inside], weights=areas[inside], minlength=grid.size)


def _finest(grid: Grid) -> float:
    """Return a step that samples each cell of the body more than once (m)."""
    return float(min(np.diff(edges).min() for edges in grid.edges[: grid.dim]))


def _segment(grid: Grid, plane: Plane) -> tuple[np.ndarray, np.ndarray]:
    """Return points along a segment, shape (n, 2), and the area that each stands for (m^2)."""
    start, end = np.asarray(plane.start, dtype=float), np.asarray(plane.end, dtype=float)
    length = float(np.linalg.norm(end - start))
    n = int(np.clip(np.ceil(SAMPLES * length / _finest(grid)), *POINTS))
    parts = (np.arange(n) + 0.5) / n
    thickness = float(grid.edges[2][-1] - grid.edges[2][0])
    return start + parts[:, None] * (end - start), np.full(n, length * thickness / n)


def _disc(grid: Grid, plane: Plane) -> tuple[np.ndarray, np.ndarray]:
    """Return points of a disc on rings, shape (n, 3), and the area that each stands for (m^2)."""
    radius = float(plane.radius or 0.0)
    normal = np.asarray(plane.normal, dtype=float)
    normal = normal / np.linalg.norm(normal)
    one = np.cross(normal, np.eye(3)[int(np.argmin(np.abs(normal)))])
    one /= np.linalg.norm(one)
    other = np.cross(normal, one)
    rings = int(np.clip(np.ceil(SAMPLES / 4 * radius / _finest(grid)), *RINGS))
    points, areas = [], []
    for ring in range(rings):
        inner, outer = radius * ring / rings, radius * (ring + 1) / rings
        n = 12 * ring + 6
        angle = 2 * np.pi * (np.arange(n) + 0.5) / n
        around = np.cos(angle)[:, None] * one + np.sin(angle)[:, None] * other
        points.append(np.asarray(plane.center) + (inner + outer) / 2 * around)
        areas.append(np.full(n, np.pi * (outer**2 - inner**2) / n))
    return np.concatenate(points), np.concatenate(areas)

"""Sides and regions of a block, found by position."""

from collections.abc import Callable, Mapping

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
from dolfinx import mesh as dmesh

from staffa.geometry.block import face_axis, face_position
from staffa.geometry.places import SAME
from staffa.geometry.simplices import Simplices

# Corners this much nearer to the center tell a cell's region: round-off does not.
WITHIN = 1 - 1e-6
ROUND_OFF = 1e-9  # of a number of points
AT_ONCE = 1_000_000  # points

# True for points, shape (3, n), in a part of the body: shape (n,).
Part = Callable[[np.ndarray], np.ndarray]


def side_facets(
    mesh: dmesh.Mesh, lower: tuple[float, ...], size: tuple[float, ...], name: str
) -> np.ndarray:
    """Return the facets of a side of a block. Collective.

    Parameters
    ----------
    mesh : its mesh.
    lower, size : lower corner and extent along each axis (m).
    name : name of the side.
    """
    tolerance, axis = SAME * max(size), face_axis(name, len(size))
    position = lower[axis] + face_position(name, size)
    mesh.topology.create_connectivity(mesh.topology.dim - 1, mesh.topology.dim)
    return np.asarray(
        dmesh.locate_entities_boundary(
            mesh, mesh.topology.dim - 1, lambda x: np.abs(x[axis] - position) <= tolerance
        )
    )


def region_cells(mesh: dmesh.Mesh, parts: Mapping[str, Part]) -> dict[str, np.ndarray]:
    """Return the cells of each part, ghosts included: the last part counts where several overlap.

    Parameters
    ----------
    mesh : mesh of the block.
    parts : the regions.
    """
    if not parts:
        return {}
    x = middles(mesh)
    number = np.full(x.shape[1], -1)
    for k, inside in enumerate(parts.values()):
        number[inside(x)] = k
    return {name: np.flatnonzero(number == k).astype(np.int32) for k, name in enumerate(parts)}


def parted_cells(
    parts: Mapping[str, Part], spacing: float, mesh: Simplices, cells: np.ndarray
) -> np.ndarray:
    """Mark cells that are in several regions, shape (n,).

    Parameters
    ----------
    parts : the regions.
    spacing : largest distance (m) between neighboring points at which a cell is looked at.
    mesh : the whole mesh.
    cells : cells that are looked at, shape (n,).
    """
    corners, found = mesh.x[mesh.cells[cells]], np.zeros(len(cells), dtype=bool)
    if not parts or not len(cells):
        return found
    one, other = np.triu_indices(mesh.dim + 1, 1)
    longest = np.linalg.norm(corners[:, one] - corners[:, other], axis=2).max(axis=1)
    counts = np.ceil(longest / spacing - ROUND_OFF).astype(int)
    for count in np.unique(counts):
        lattice = _lattice(mesh.dim, int(count))
        same = np.flatnonzero(counts == count)
        for some in np.array_split(same, 1 + len(same) * len(lattice) // AT_ONCE):
            center = corners[some].mean(axis=1, keepdims=True)
            at = center + WITHIN * (lattice @ corners[some] - center)
            number = _numbers(parts, at.reshape(-1, mesh.dim)).reshape(at.shape[:2])
            found[some] = (number != number[:, :1]).any(axis=1)
    return found


def _lattice(dim: int, count: int) -> np.ndarray:
    """Return weights of the corners for evenly spaced points of a simplex, shape (k, dim + 1)."""
    steps = np.indices((count + 1,) * dim).reshape(dim, -1).T
    steps = steps[steps.sum(axis=1) <= count]
    return np.column_stack([count - steps.sum(axis=1), steps]) / count


def _numbers(parts: Mapping[str, Part], x: np.ndarray) -> np.ndarray:
    """Return the number of the part at points of shape (n, dim), -1 for none."""
    found = np.full(len(x), -1)
    for k, inside in enumerate(parts.values()):
        found[inside(_in_space(x))] = k
    return found


def _in_space(x: np.ndarray) -> np.ndarray:
    return np.pad(x, ((0, 0), (0, 3 - x.shape[1]))).T


def middles(mesh: dmesh.Mesh) -> np.ndarray:
    """Return the center of each cell (m), ghosts included, shape (3, n)."""
    dim = mesh.topology.dim
    cells = mesh.topology.index_map(dim)
    every = np.arange(cells.size_local + cells.num_ghosts, dtype=np.int32)
    return np.asarray(dmesh.compute_midpoints(mesh, dim, every).T)

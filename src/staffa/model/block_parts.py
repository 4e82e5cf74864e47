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


def parted_cells(parts: Mapping[str, Part], mesh: Simplices, cells: np.ndarray) -> np.ndarray:
    """Mark cells with a corner, or the middle of an edge, in another region than the center.

    Parameters
    ----------
    parts : the regions.
    mesh : the whole mesh.
    cells : cells that are looked at, shape (n,).
    """
    corners = mesh.x[mesh.cells[cells]]
    center = corners.mean(axis=1, keepdims=True)
    one, other = np.triu_indices(mesh.dim + 1)
    at = center + WITHIN * ((corners[:, one] + corners[:, other]) / 2 - center)
    here, there = np.full(len(corners), -1), np.full(at.shape[:2], -1)
    for k, inside in enumerate(parts.values()):
        here[inside(_in_space(center[:, 0]))] = k
        there[inside(_in_space(at.reshape(-1, mesh.dim))).reshape(there.shape)] = k
    return np.asarray((there != here[:, None]).any(axis=1))


def _in_space(x: np.ndarray) -> np.ndarray:
    return np.pad(x, ((0, 0), (0, 3 - x.shape[1]))).T


def middles(mesh: dmesh.Mesh) -> np.ndarray:
    """Return the center of each cell (m), ghosts included, shape (3, n)."""
    dim = mesh.topology.dim
    cells = mesh.topology.index_map(dim)
    every = np.arange(cells.size_local + cells.num_ghosts, dtype=np.int32)
    return np.asarray(dmesh.compute_midpoints(mesh, dim, every).T)

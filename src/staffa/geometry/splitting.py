"""Cells of other kinds as triangles and tetrahedra: what a mesh of squares or cubes is read as."""

from itertools import combinations

import numpy as np

from staffa.errors import InputError

# Faces of a cell, as Gmsh and VTK number its corners, each seen from outside the same way round.
FACES = {
    5: ((0, 3, 2, 1), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)),
    6: ((0, 2, 1), (3, 4, 5), (0, 1, 4, 3), (1, 2, 5, 4), (2, 0, 3, 5)),
    8: ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
}


def sides(cells: np.ndarray, dim: int) -> list[np.ndarray]:
    """Return the edges of 2-D cells, or the faces of 3-D cells, by corners, shape (k, n) each.

    Parameters
    ----------
    cells : corners in order, shape (m, n).
    dim : dimension of the cells.
    """
    width = cells.shape[1]
    if dim == 2:
        found: tuple[tuple[int, ...], ...] = tuple((i, (i + 1) % width) for i in range(width))
    else:
        found = FACES.get(width, ((0, 1, 2), (0, 1, 3), (1, 2, 3), (0, 2, 3)))
    return [cells[:, side] for side in found]


def around_middle(x: np.ndarray, cells: np.ndarray, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Return middles of quadrilaterals and four triangles around each, which favor no diagonal.

    Parameters
    ----------
    x : points (m), shape (n, 3).
    cells : corners in order, shape (k, 4).
    where : the key and its value, with which every sentence begins.

    Returns
    -------
    middles, shape (k, 3), which get the numbers n, n + 1, ...; and triangles, shape (4 k, 3),
    those of one quadrilateral after another.

    Raises
    ------
    InputError
        One of them is folded, or not convex enough to hold its middle.
    """
    middle = len(x) + np.arange(len(cells))
    sides = [(cells[:, i], cells[:, (i + 1) % 4], middle) for i in range(4)]
    triangles = np.stack([np.column_stack(side) for side in sides], axis=1)
    middles = x[cells].mean(axis=1)
    corners = np.concatenate([x, middles])[triangles][..., :2]
    _are_convex(np.linalg.det(corners[..., 1:, :] - corners[..., :1, :]), where)
    return middles, triangles.reshape(-1, 3)


def fans(faces: np.ndarray) -> np.ndarray:
    """Split quadrilaterals into two triangles each, shape (2 k, 3).

    The cut runs from the corner with the least number, so that two cells split a shared face alike.

    Parameters
    ----------
    faces : corners in order, shape (k, 4).
    """
    order = (np.argmin(faces, axis=1)[:, None] + np.arange(4)) % 4
    a, b, c, d = np.take_along_axis(faces, order, axis=1).T
    return np.stack([np.column_stack([a, b, c]), np.column_stack([a, c, d])], 1).reshape(-1, 3)


def tetrahedra(x: np.ndarray, cells: np.ndarray, where: str) -> tuple[np.ndarray, np.ndarray]:
    """Split hexahedra, prisms or pyramids into tetrahedra on the same points; return their cells
    too.

    Each cell is a cone from its corner of the least number to its faces beyond, which are parted
    likewise (Dompierre et al., How to subdivide pyramids, prisms and hexahedra into tetrahedra,
    8th International Meshing Roundtable, 1999): cells that share a face part it alike.

    Parameters
    ----------
    x : points (m), shape (n, 3).
    cells : corners, shape (k, 5, 6 or 8).
    where : the key and its value, with which every sentence begins.

    Raises
    ------
    InputError
        A cell is folded, or not convex enough.
    """
    first, found, of = np.argmin(cells, axis=1), [], []
    for corner in range(cells.shape[1]):
        mine = np.flatnonzero(first == corner)
        for face in FACES[cells.shape[1]]:
            if corner in face:
                continue
            beyond = cells[mine][:, face]
            triangles = fans(beyond) if len(face) == 4 else beyond
            owner = np.repeat(mine, len(triangles) // max(len(mine), 1))
            found.append(np.column_stack([cells[owner, corner], triangles]))
            of.append(owner)
    parts, owner = np.concatenate(found), np.concatenate(of)
    corners = x[parts]
    volumes = np.linalg.det(corners[:, 1:] - corners[:, :1])
    least = np.full(len(cells), np.inf)
    most = np.full(len(cells), -np.inf)
    np.minimum.at(least, owner, volumes)
    np.maximum.at(most, owner, volumes)
    _are_convex(np.column_stack([least, most]), where)
    return parts, owner


def _are_convex(contents: np.ndarray, where: str) -> None:
    """Refuse cells of whose parts, a row each, some are turned over and some are not."""
    wrong = int((np.sign(contents).min(axis=1) != np.sign(contents).max(axis=1)).sum())
    if wrong:
        raise InputError(
            f"{where}: {wrong} of its {len(contents)} cells with more corners than a triangle or a "
            f"tetrahedron are folded or not convex; mesh the body again, or without recombining"
        )


def bulge(x: np.ndarray, corners: int) -> float:
    """Return the largest distance of an edge's middle from the straight edge, of second order.

    A node beside the corners belongs to the two of them that it is nearest to the middle of: also
    nodes in the middle of a face or a cell, which are in the middle of a diagonal.

    Parameters
    ----------
    x : nodes of each cell, its corners first, shape (k, n, 3).
    corners : number of corners.
    """
    if not x.size:
        return 0.0
    ends = np.array(list(combinations(range(corners), 2)))
    straight = x[:, ends].mean(axis=2)
    beside = [straight - x[:, node, None] for node in range(corners, x.shape[1])]
    return float(max(np.linalg.norm(off, axis=2).min(axis=1).max() for off in beside))

"""Cells and names of a file, of any kinds and orders, made a mesh of simplices or an error."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from staffa.errors import InputError
from staffa.geometry.places import SAME
from staffa.geometry.simplices import Simplices, count_bodies, facets, keys
from staffa.geometry.splitting import around_middle, fans, tetrahedra

KINDS = {0: "a point", 1: "a curve", 2: "a surface", 3: "a volume"}
# Names of the cells, by dimension and number of corners.
CELLS = {
    (2, 4): "quadrilaterals",
    (3, 5): "pyramids",
    (3, 6): "prisms",
    (3, 8): "hexahedra",
}


@dataclass(frozen=True, kw_only=True)
class Block:
    """Cells of one kind.

    Attributes
    ----------
    dim : dimension of the cells.
    corners : numbers of their corners, shape (k, n).
    name : name of each cell, empty without one, shape (k,).
    order : order of the cells in the file.
    bulge : largest distance of an edge's middle from the straight edge, in the file's unit; None if
        unknown.
    """

    dim: int
    corners: np.ndarray
    name: np.ndarray
    order: int = 1
    bulge: float | None = 0.0


def assembled(x: np.ndarray, blocks: Sequence[Block], where: str) -> Simplices:
    """Return the triangles or tetrahedra of what a file holds, with its names.

    Parameters
    ----------
    x : points (m), shape (n, 3), in the order of their numbers.
    blocks : cells, facets and other parts of the file.
    where : the key and its value, with which every sentence begins.

    Raises
    ------
    InputError
        There are no cells, or they are no body, or not finite; names overlap, or name nothing that
        staffa knows.
    """
    dim = 3 if any(block.dim == 3 and len(block.corners) for block in blocks) else 2
    body = [block for block in blocks if block.dim == dim and len(block.corners)]
    sides = [block for block in blocks if block.dim == dim - 1 and len(block.corners)]
    if not body:
        named = any((block.name != "").any() for block in blocks)
        left_out = " (Gmsh saves only what has a name: give the body one)" if named else ""
        raise InputError(
            f"{where} has no triangles and no tetrahedra; mesh the body, and save it{left_out}"
        )
    used = np.unique(np.concatenate([block.corners.ravel() for block in body]))
    for stray in sorted(_astray(sides, used)):
        raise InputError(_stray(where, stray))
    x = x[used]
    if not np.all(np.isfinite(x)):
        raise InputError(
            f"{where} has points that are not finite; mesh the body, and save it again"
        )
    if dim == 2 and np.ptp(x[:, 2]) > SAME * np.ptp(x, axis=0).max():
        raise InputError(f"{where} is a surface in space; give a volume, or a plane z = constant")
    x, cells, cell_name = _cells(x, [_renumbered(block, used) for block in body], where)
    rows, row_name = _facets([_renumbered(block, used) for block in sides], dim)
    faces, cracks = _parted(cells, rows, row_name, where)
    mesh = Simplices(
        x=x[:, :dim],
        cells=cells,
        regions=_regions(cells, cell_name, where),
        faces=faces,
        cracks=cracks,
        notes=tuple(_notes(body, where)),
    )
    _is_sound(mesh, where)
    return mesh


def _astray(sides: Sequence[Block], used: np.ndarray) -> set[str]:
    """Return the names of facets with a corner that no cell has."""
    return {
        str(name)
        for block in sides
        for name in block.name[~np.isin(block.corners, used).all(axis=1)]
        if name
    }


def _renumbered(block: Block, used: np.ndarray) -> Block:
    """Return the rows of a block whose corners are all used, by their places among these."""
    inside = np.isin(block.corners, used).all(axis=1)
    corners = np.searchsorted(used, block.corners[inside]).astype(np.int64)
    return Block(dim=block.dim, corners=corners, name=block.name[inside])


def _cells(
    x: np.ndarray, blocks: Sequence[Block], where: str
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return points, with the middles of quadrilaterals, simplices, and the name of each."""
    found, names = [], []
    for block in blocks:
        cells, name = block.corners, block.name
        if (block.dim, cells.shape[1]) == (2, 4):
            middles, cells = around_middle(x, cells, where)
            x, name = np.concatenate([x, middles]), np.repeat(name, 4)
        elif cells.shape[1] > block.dim + 1:
            cells, of = tetrahedra(x, cells, where)
            name = name[of]
        found.append(cells)
        names.append(name)
    return x, np.concatenate(found), np.concatenate(names)


def _facets(blocks: Sequence[Block], dim: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of the facets, quadrilaterals as two triangles, and the name of each."""
    rows, names = [np.zeros((0, dim), dtype=np.int64)], [np.zeros(0, dtype=object)]
    for block in blocks:
        whole = block.corners.shape[1] == dim
        rows.append(block.corners if whole else fans(block.corners))
        names.append(block.name if whole else np.repeat(block.name, 2))
    return np.concatenate(rows), np.concatenate(names)


def _notes(blocks: Sequence[Block], where: str) -> list[str]:
    """Return notes on changes that reading the cells made."""
    found = []
    for (dim, corners), kind in CELLS.items():
        of_it = [b for b in blocks if (b.dim, b.corners.shape[1]) == (dim, corners)]
        number = sum(len(block.corners) for block in of_it)
        if number:
            into = "four triangles each" if dim == 2 else "tetrahedra"
            found.append(f"{where}: its {number:,} {kind} are read as {into}")
    curved = [block for block in blocks if block.order > 1]
    if curved:
        bulges = [block.bulge for block in curved]
        known = [bulge for bulge in bulges if bulge is not None]
        told = f", by which they move {max(known):.2g} of its unit at most" if known else ""
        found.append(
            f"{where}: its cells are of order {max(block.order for block in curved)} and read by "
            f"their corners, with straight edges{told}"
        )
    return found


def listed(names: Sequence[str]) -> str:
    """Return the names there are, in words."""
    return f"the names there are: {', '.join(names)}" if names else "the mesh has no names"


def _regions(cells: np.ndarray, name: np.ndarray, where: str) -> dict[str, np.ndarray]:
    found = sorted(set(name) - {""})
    without = int((name == "").sum())
    if found and without:
        raise InputError(
            f"{where}: {without} of {len(cells)} cells are in no region, while others are; name "
            f"every part of the body; {listed(found)}"
        )
    return {region: np.flatnonzero(name == region) for region in found}


def _parted(
    cells: np.ndarray, rows: np.ndarray, name: np.ndarray, where: str
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return the named facets: those on the surface of the body, and those inside."""
    every = facets(cells).reshape(-1, cells.shape[1] - 1)
    number = keys(np.concatenate([every, rows]))
    theirs, count = np.unique(number[: len(every)], return_counts=True)
    mine = number[len(every) :]
    place = np.minimum(np.searchsorted(theirs, mine), len(theirs) - 1)
    beside = np.where(theirs[place] == mine, count[place], 0)
    faces: dict[str, np.ndarray] = {}
    cracks: dict[str, np.ndarray] = {}
    for side in sorted(set(name) - {""}):
        here = np.flatnonzero(name == side)
        kinds = set(beside[here].tolist())
        if 0 in kinds:
            raise InputError(_stray(where, side))
        if kinds == {1, 2}:
            raise InputError(
                f"{where}: '{side}' lies partly on the surface of the body and partly inside; name "
                f"a face or a crack, and not both at once"
            )
        (faces if kinds == {1} else cracks)[side] = rows[here]
    _do_not_overlap(mine, name, where)
    return faces, cracks


def _stray(where: str, name: str) -> str:
    return (
        f"{where}: '{name}' has facets that no cell has; embed it in the body before meshing, or "
        f"remove it"
    )


def _do_not_overlap(number: np.ndarray, name: np.ndarray, where: str) -> None:
    named = name != ""
    number, name = number[named], name[named]
    order = np.argsort(number, kind="stable")
    twice = np.flatnonzero(number[order][1:] == number[order][:-1])
    if len(twice):
        one, other = name[order[twice[0]]], name[order[twice[0] + 1]]
        raise InputError(
            f"{where}: '{one}' and '{other}' overlap; let each facet have one name, once; "
            f"{listed(sorted(set(name)))}"
        )


def _is_sound(mesh: Simplices, where: str) -> None:
    """Require that every cell is there once, has a size, and hangs together with the others."""
    if len(np.unique(keys(mesh.cells))) < len(mesh.cells):
        raise InputError(f"{where} has cells twice; save the mesh of each part once")
    corners = mesh.x[mesh.cells]
    content = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    if content.min() <= 1e-12 * content.max():
        raise InputError(f"{where} has cells without any extent; mesh the body again")
    parts = count_bodies(mesh)
    if parts > 1:
        raise InputError(
            f"{where} falls into {parts} parts that share no point; join them before meshing "
            f"(Gmsh: Coherence, or BooleanFragments), or leave out all but one"
        )

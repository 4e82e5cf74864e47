"""Reads meshes that other programs wrote, with meshio, and of Salome's by Gmsh."""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import redirect_stderr, redirect_stdout
from io import StringIO
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np

from staffa.errors import InputError
from staffa.geometry.assembled import Block, assembled
from staffa.geometry.simplices import Simplices
from staffa.geometry.splitting import bulge, sides

# What meshio calls the format of files that end so; each is one file, and names no other.
FORMATS = {
    ".inp": "abaqus",
    ".bdf": "nastran",
    ".fem": "nastran",
    ".nas": "nastran",
    ".mesh": "medit",
    ".vtk": "vtk",
    ".vtu": "vtu",
}
# meshio's kinds of cells without the number of nodes: dimension and corners.
SHAPES = {
    "line": (1, 2),
    "triangle": (2, 3),
    "quad": (2, 4),
    "tetra": (3, 4),
    "pyramid": (3, 5),
    "wedge": (3, 6),
    "hexahedron": (3, 8),
}
# Nodes of cells of second order.
SECOND = {(1, 3), (3, 6), (4, 8), (4, 9), (4, 10), (5, 13), (5, 14), (6, 15), (6, 18)} | {
    *((8, nodes) for nodes in (20, 24, 25, 26, 27)),
    (2, 3),
}
# Numbers of cells that stand for groups, as programs call them, in the order in which one counts.
GROUPS = (
    *("gmsh:physical", "medit:ref", "nastran:ref", "CellEntityIds", "MaterialIDs"),
    *("cell_tags", "material", "region", "group"),
)
ELEMENTS = re.compile(r"^\s*\*ELEMENT\b(.*)$", re.IGNORECASE | re.MULTILINE)
ELSET = re.compile(r"ELSET\s*=\s*([^,\s]+)", re.IGNORECASE)


def read_foreign(path: Path, unit: float, where: str) -> Simplices:
    """Return the triangles or tetrahedra of a file that meshio reads, see `read_msh`.

    The sets of cells give the names; a file without sets gives the numbers of the cells' groups.

    Parameters
    ----------
    path : the file.
    unit : length of the file's unit (m).
    where : key and value of the file, for messages.

    Raises
    ------
    InputError
        The file cannot be read, names other files, or is no mesh that a body can be made of.
    """
    import meshio  # takes a while to load, and few cases need it

    kind = FORMATS[path.suffix.lower()]
    if kind in ("abaqus", "nastran") and _includes(path):
        raise InputError(
            f"{where} includes another file, and a run keeps one; write the mesh as one file"
        )
    said = StringIO()
    try:
        with redirect_stdout(said), redirect_stderr(said):
            mesh = meshio.read(path, file_format=kind)
    except (Exception, SystemExit) as error:  # whatever a reader raises at a file that is none
        raise InputError(
            f"{where}: meshio cannot read it as {kind} ({_line(error, said)}); save it again, "
            f"or as a .msh file"
        ) from None
    if np.ndim(mesh.points) != 2 or not np.all(np.isfinite(mesh.points)):
        raise InputError(f"{where} has no points, or some that are not finite; save it again")
    points = np.zeros((len(mesh.points), 3))
    points[:, : mesh.points.shape[1]] = mesh.points
    names = _names(mesh, path, where)
    blocks = [b for c, n in zip(mesh.cells, names, strict=True) for b in _block(c, n, points)]
    if kind == "abaqus":
        blocks += _of_nodes(mesh.point_sets, blocks)
    return assembled(unit * points, blocks, where)


def _includes(path: Path) -> bool:
    """Return True if a line is an INCLUDE, in any spelling that meshio takes for one."""
    with path.open(errors="replace") as lines:
        return any(line.replace("*", "").strip().upper().startswith("INCLUDE") for line in lines)


def _line(error: BaseException, said: StringIO) -> str:
    """Return the first line of what a reader says, which may be nothing."""
    if isinstance(error, KeyError):
        return f"it has something that is not known, {error}"
    lines = f"{error}\n{said.getvalue()}".strip().splitlines()
    return lines[0].strip() if lines else type(error).__name__


def _block(cells: Any, name: np.ndarray, x: np.ndarray) -> Iterator[Block]:
    """Yield cells of one kind, if a body or a side has it. x: all points, in the file's unit."""
    shape = SHAPES.get(cells.type.rstrip("0123456789"))
    if shape is None or not len(cells.data):
        return
    (dim, corners), rows = shape, np.asarray(cells.data, dtype=np.int64)
    nodes = rows.shape[1]
    order = 1 if nodes == corners else 2 if (corners, nodes) in SECOND else 3
    off = bulge(x[rows], corners) if order == 2 else None
    yield Block(dim=dim, corners=rows[:, :corners], name=name, order=order, bulge=off)


def _of_nodes(sets: Mapping[str, Any], blocks: Sequence[Block]) -> Iterator[Block]:
    """Yield the surface facets whose corners are all in one set of nodes, under the set's name.

    A file with facets yields none. Sets of all nodes, and of edges and points, name no facets.
    """
    dim = max((block.dim for block in blocks), default=0)
    if dim < 2 or any(block.dim == dim - 1 for block in blocks):
        return
    every = [facet for block in blocks if block.dim == dim for facet in sides(block.corners, dim)]
    for width in sorted({rows.shape[1] for rows in every}):
        rows = np.concatenate([facet for facet in every if facet.shape[1] == width])
        _, first, count = np.unique(
            np.sort(rows, axis=1), axis=0, return_index=True, return_counts=True
        )
        rows = rows[first[count == 1]]
        for name, nodes in sets.items():
            mine = rows[np.isin(rows, nodes).all(axis=1)]
            if 0 < len(mine) < len(rows):
                yield Block(dim=dim - 1, corners=mine, name=np.full(len(mine), name, dtype=object))


def _names(mesh: Any, path: Path, where: str) -> list[np.ndarray]:
    """Return the name of each cell, block by block, empty without one."""
    found = [np.full(len(block.data), "", dtype=object) for block in mesh.cells]
    sets = _sets(mesh, path, where)
    for name, members in sets.items():
        for names, here in zip(found, members, strict=True):
            taken = sorted(set(names[here]) - {"", name})
            if taken:
                raise InputError(
                    f"{where}: the sets '{taken[0]}' and '{name}' overlap; let each cell be in one"
                )
            names[here] = name
    if not sets:
        for names, numbers in zip(found, _numbers(mesh), strict=True):
            names[numbers != 0] = numbers[numbers != 0].astype(str)
    return found


def _sets(mesh: Any, path: Path, where: str) -> dict[str, list[np.ndarray]]:
    """Return the sets of cells by name, their numbers in each block; of Abaqus *ELSET first."""
    found = {name: _aligned(mesh, name, of, where) for name, of in mesh.cell_sets.items()}
    if path.suffix.lower() == ".inp":
        heads = ELEMENTS.findall(path.read_text(errors="replace"))
        given = [ELSET.search(head) for head in heads]
        own = {name[1] for name in given if name}
        named = {name: of for name, of in found.items() if name not in own}
        if len(own) < len(heads):  # meshio then takes the sets for those of other blocks
            return _without_whole(mesh, named)
        found = _without_whole(mesh, named) | _rest(mesh, named, found, own)
    return found


def _rest(
    mesh: Any, named: dict[str, list[np.ndarray]], found: dict[str, list[np.ndarray]], own: set[str]
) -> dict[str, list[np.ndarray]]:
    """Return cells of the sets that stand with the elements themselves, in no other set."""
    kept = _without_whole(mesh, named).values()
    taken = [
        np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *(of[k] for of in kept)]))
        for k in range(len(mesh.cells))
    ]
    return {
        name: [np.setdiff1d(here, gone) for here, gone in zip(found[name], taken, strict=True)]
        for name in sorted(own & set(found))
    }


def _without_whole(mesh: Any, sets: dict[str, list[np.ndarray]]) -> dict[str, list[np.ndarray]]:
    """Return the sets but those that hold every cell, where there are others: Abaqus's Eall."""
    total = sum(len(block.data) for block in mesh.cells)
    kept = {name: of for name, of in sets.items() if sum(map(len, of)) < total}
    return kept if kept and len(mesh.cells) > 1 else sets


def _aligned(mesh: Any, name: str, of: Sequence[Any], where: str) -> list[np.ndarray]:
    """Return a set's cells block by block, as numbers in these."""
    arrays = [np.zeros(0, dtype=np.int64) if a is None else np.asarray(a) for a in of]
    if len(arrays) > len(mesh.cells) or any(a.dtype.kind not in "iuf" for a in arrays):
        raise InputError(
            f"{where}: the set '{name}' is made of other sets; write the numbers of its cells"
        )
    missing = len(mesh.cells) - len(arrays)
    arrays = [a.astype(np.int64) for a in chain(arrays, [np.zeros(0)] * missing)]
    if any(len(a) and a.max() >= len(b.data) for a, b in zip(arrays, mesh.cells, strict=True)):
        raise InputError(f"{where}: the set '{name}' holds cells that are not there; save it again")
    return arrays


def _numbers(mesh: Any) -> list[np.ndarray]:
    """Return the number of each cell's group, block by block, 0 without one."""
    whole = {name: [np.asarray(a).reshape(len(a), -1) for a in of] for name, of in _data(mesh)}
    whole = {n: of for n, of in whole.items() if all(a.shape[1] == 1 for a in of)}
    known = [name for name in GROUPS if name in whole]
    chosen = known[:1] or (list(whole) if len(whole) == 1 else [])
    if not chosen:
        return [np.zeros(len(block.data), dtype=np.int64) for block in mesh.cells]
    return [a[:, 0].astype(np.int64) for a in whole[chosen[0]]]


def _data(mesh: Any) -> Iterator[tuple[str, Any]]:
    """Yield numbers of cells that are whole."""
    for name, of in mesh.cell_data.items():
        if all(np.asarray(a).dtype.kind in "iu" for a in of):
            yield name, of

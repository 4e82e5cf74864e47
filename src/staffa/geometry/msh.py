"""Reads meshes with named parts: Gmsh's .msh files, or a model that Gmsh has open."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from staffa.errors import InputError
from staffa.geometry.gmsh_model import SIMPLEX, opened
from staffa.geometry.places import SAME
from staffa.geometry.simplices import Simplices, facets, keys, parts

BEGINNING = b"$MeshFormat"  # of every .msh file; Gmsh would run other files as scripts
ANNOUNCED = re.compile(rb'(\d+)\s+\d+\s+"(.*)"')
WAY_OUT = "give domain.size for a rectangle or a box"
KINDS = {0: "a point", 1: "a curve", 2: "a surface", 3: "a volume"}


def read_msh(path: Path, unit: float, where: str) -> Simplices:
    """The triangles or tetrahedra of a file with its names; unit: the length that it counts in (m).

    where: the key and its value, with which every sentence begins.

    Raises
    ------
    InputError
        Gmsh is not there; the file is missing or no mesh of triangles or tetrahedra; its names are
        missing, overlap, or name nothing that staffa knows.
    """
    try:
        with path.open("rb") as file:
            beginning = file.read(len(BEGINNING))
    except OSError as error:
        raise InputError(
            f"{where}: {path} cannot be read ({error.strerror}); name a .msh file, as seen from "
            f"the folder of the case file"
        ) from None
    if beginning != BEGINNING:
        raise InputError(f"{where} is no .msh file; save the mesh as one, with Gmsh or meshio")
    with opened(where, WAY_OUT) as gmsh:
        try:
            gmsh.merge(str(path))
        except Exception as error:  # Gmsh raises this very class
            raise InputError(f"{where}: Gmsh cannot read it ({error}); save it anew") from error
        held = {gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups()}
        for dim, name in _announced(path):
            _is_held(dim, name, held, where)
        return collected(gmsh, where, unit)


def _is_held(dim: int, name: str, held: set[str], where: str) -> None:
    """A name that a file announces was read with what it names."""
    if '"' in name:
        raise InputError(
            f"{where}: '{name}' has quotes in it, at which Gmsh ends a name; call it otherwise"
        )
    if name not in held and dim == 0:
        raise InputError(
            f"{where}: '{name}' names a point, where staffa knows names of regions, faces and "
            f"cracks only; remove it"
        )
    if name not in held:
        raise InputError(
            f"{where}: '{name}' names nothing that is in the file; remove it, or save the mesh "
            f"anew, in format 4.1 without Mesh.SaveAll"
        )


def _announced(path: Path) -> Iterator[tuple[int, str]]:
    """The dimensions and names that stand at the beginning of a file."""
    with path.open("rb") as file:
        for line in file:
            if line.startswith((b"$Entities", b"$Nodes")):
                return
            named = ANNOUNCED.fullmatch(line.strip())
            if named:
                yield int(named[1]), named[2].decode(errors="replace")


def collected(gmsh: Any, where: str, unit: float) -> Simplices:
    """The mesh and the physical names of the model that Gmsh has open; see `read_msh`."""
    dim = 3 if len(gmsh.model.mesh.getElements(3)[0]) else 2
    names = _names(gmsh, dim, where)
    corners, cell_name = _named(gmsh, dim, names, where)
    if not len(corners):
        named = " (Gmsh saves only what has a name: give the body one)" if names else ""
        raise InputError(
            f"{where} has no triangles and no tetrahedra; mesh the body, and save it{named}"
        )
    tags, x, _ = gmsh.model.mesh.getNodes()
    used, place = np.unique(corners, return_inverse=True)
    x = unit * x.reshape(-1, 3)[np.argsort(tags)][np.searchsorted(np.sort(tags), used)]
    if dim == 2 and np.ptp(x[:, 2]) > SAME * np.ptp(x, axis=0).max():
        raise InputError(f"{where} is a surface in space; give a volume, or a plane z = constant")
    cells = place.reshape(corners.shape).astype(np.int64)
    rows, row_name = _named(gmsh, dim - 1, names, where)
    inside = np.isin(rows, used).all(axis=1)
    for stray in sorted(set(row_name[~inside]) - {""}):
        raise InputError(_stray(where, stray))
    rows, row_name = np.searchsorted(used, rows[inside]), row_name[inside]
    faces, cracks = _parted(cells, rows, row_name, where)
    mesh = Simplices(
        x=x[:, :dim],
        cells=cells,
        regions=_regions(cells, cell_name, where),
        faces=faces,
        cracks=cracks,
    )
    _is_sound(mesh, where)
    return mesh


def _names(gmsh: Any, dim: int, where: str) -> dict[tuple[int, int], str]:
    """The name of each physical group, by its dimension and tag."""
    groups = gmsh.model.getPhysicalGroups()
    names = {(d, tag): gmsh.model.getPhysicalName(d, tag) for d, tag in groups}
    told = _listed(sorted({name for name in names.values() if name}))
    for (d, tag), name in names.items():
        if not name:
            raise InputError(
                f"{where}: physical group {tag}, {KINDS[d]}, has no name; name it, or remove it; "
                f"{told}"
            )
        if d < dim - 1:
            raise InputError(
                f"{where}: '{name}' names {KINDS[d]}, where staffa knows names of "
                f"{_kinds(dim)} only; remove it; {told}"
            )
    return names


def _kinds(dim: int) -> str:
    return "surfaces and curves" if dim == 2 else "volumes and surfaces"


def _listed(names: list[str]) -> str:
    return f"the names there are: {', '.join(names)}" if names else "the mesh has no names"


def _named(
    gmsh: Any, dim: int, names: Mapping[tuple[int, int], str], where: str
) -> tuple[np.ndarray, np.ndarray]:
    """Tags of the corners of each simplex of this dimension, and its name, empty without one."""
    rows, of_row = [np.zeros((0, dim + 1), dtype=np.int64)], [np.zeros(0, dtype=object)]
    for _, entity in gmsh.model.getEntities(dim):
        kinds, _, nodes = gmsh.model.mesh.getElements(dim, entity)
        if not len(kinds):
            continue
        if list(kinds) != [SIMPLEX[dim]]:
            wrong = [gmsh.model.mesh.getElementProperties(k)[0] for k in kinds if k != SIMPLEX[dim]]
            raise InputError(
                f"{where} has cells that are {wrong[0]}; staffa takes triangles and tetrahedra "
                f"with straight edges: mesh without recombining, with element order 1"
            )
        tags = gmsh.model.getPhysicalGroupsForEntity(dim, entity)
        mine = sorted({names[dim, tag] for tag in tags})
        if len(mine) > 1:
            raise InputError(
                f"{where}: '{mine[0]}' and '{mine[1]}' overlap, both name {KINDS[dim]} {entity}; "
                f"let each part have one name; {_listed(sorted(set(names.values())))}"
            )
        found = np.asarray(nodes[0], dtype=np.int64).reshape(-1, dim + 1)
        rows.append(found)
        of_row.append(np.full(len(found), mine[0] if mine else "", dtype=object))
    return np.concatenate(rows), np.concatenate(of_row)


def _regions(cells: np.ndarray, name: np.ndarray, where: str) -> dict[str, np.ndarray]:
    found = sorted(set(name) - {""})
    without = int((name == "").sum())
    if found and without:
        raise InputError(
            f"{where}: {without} of {len(cells)} cells are in no region, while others are; name "
            f"every part of the body; {_listed(found)}"
        )
    return {region: np.flatnonzero(name == region) for region in found}


def _parted(
    cells: np.ndarray, rows: np.ndarray, name: np.ndarray, where: str
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """The named facets: those on the surface of the body, and those inside."""
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
            f"{_listed(sorted(set(name)))}"
        )


def _is_sound(mesh: Simplices, where: str) -> None:
    """Every cell is there once, has a size, and hangs together with the others."""
    if len(np.unique(keys(mesh.cells))) < len(mesh.cells):
        raise InputError(f"{where} has cells twice; save the mesh of each part once")
    corners = mesh.x[mesh.cells]
    content = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1]))
    if content.min() <= 1e-12 * content.max():
        raise InputError(f"{where} has cells without any extent; mesh the body anew")
    pieces = parts(mesh)
    if pieces > 1:
        raise InputError(
            f"{where} falls into {pieces} pieces that share no point; join them before meshing "
            f"(Gmsh: Coherence, or BooleanFragments), or leave out all but one"
        )

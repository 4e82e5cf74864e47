"""Reads meshes with named parts by Gmsh: .msh files, those of Salome, or a model that is open."""

import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from staffa.backend.one_file import require_alone
from staffa.errors import InputError
from staffa.geometry.assembled import KINDS, Block, assembled, listed
from staffa.geometry.gmsh_model import open_gmsh
from staffa.geometry.simplices import Simplices
from staffa.geometry.splitting import bulge

BEGINNING = b"$MeshFormat"  # of every .msh file; Gmsh would run other files as scripts
ANNOUNCED = re.compile(rb'(\d+)\s+\d+\s+"(.*)"')
SALOME = (".med", ".unv")  # files of Salome and FreeCAD, which Gmsh reads too
WAY_OUT = "give domain.size for a rectangle or a box"


def read_msh(path: Path, unit: float, where: str) -> Simplices:
    """Return the triangles or tetrahedra of a file that Gmsh reads, with its names.

    Parameters
    ----------
    path : a .msh file, or one of SALOME.
    unit : length that it counts in (m).
    where : the key and its value, with which every sentence begins.

    Raises
    ------
    InputError
        Gmsh is not there; the file is missing or no mesh of a body; its names are missing, overlap,
        or name nothing that staffa knows.
    """
    try:
        with path.open("rb") as file:
            beginning = file.read(len(BEGINNING))
    except OSError as error:
        raise InputError(
            f"{where}: {path} cannot be read ({error.strerror}); name a .msh file, as seen from "
            f"the folder of the case file"
        ) from None
    of_gmsh = path.suffix.lower() not in SALOME
    if of_gmsh and beginning != BEGINNING:
        raise InputError(f"{where} is no .msh file; save the mesh as one, with Gmsh or meshio")
    if path.suffix.lower() == ".med":
        require_alone(path, where)
    with open_gmsh(where, WAY_OUT) as gmsh, TemporaryDirectory() as alone:
        # Gmsh runs an options file that lies beside the one it opens.
        link = Path(alone) / f"mesh{path.suffix}"
        link.symlink_to(path.absolute())
        try:
            gmsh.merge(str(link))
        except Exception as error:  # Gmsh raises this very class
            raise InputError(f"{where}: Gmsh cannot read it ({error}); save it again") from error
        held = {gmsh.model.getPhysicalName(*group) for group in gmsh.model.getPhysicalGroups()}
        for dim, name in _announced(path) if of_gmsh else ():
            _is_held(dim, name, held, where)
        return collected(gmsh, where, unit)


def _is_held(dim: int, name: str, held: set[str], where: str) -> None:
    """Require that a name that a file announces was read with its cells or facets."""
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
            f"again, in format 4.1 without Mesh.SaveAll"
        )


def _announced(path: Path) -> Iterator[tuple[int, str]]:
    """Yield the dimensions and names that stand at the beginning of a file."""
    with path.open("rb") as file:
        for line in file:
            if line.startswith((b"$Entities", b"$Nodes")):
                return
            named = ANNOUNCED.fullmatch(line.strip())
            if named:
                yield int(named[1]), named[2].decode(errors="replace")


def collected(gmsh: Any, where: str, unit: float) -> Simplices:
    """Return the mesh and the physical names of the model that Gmsh has open, see `read_msh`.

    Parameters
    ----------
    gmsh : the module, with the model open.
    where : key and value of the file, for messages.
    unit : length of the file's unit (m).
    """
    dim = 3 if len(gmsh.model.mesh.getElements(3)[0]) else 2
    names = _names(gmsh, dim, where)
    tags, x, _ = gmsh.model.mesh.getNodes()
    order = np.argsort(tags)
    tags, x = tags[order], x.reshape(-1, 3)[order]
    blocks = [block for d in (dim - 1, dim) for block in _blocks(gmsh, d, names, tags, x, where)]
    return assembled(unit * x, blocks, where)


def _names(gmsh: Any, dim: int, where: str) -> dict[tuple[int, int], str]:
    """Return the name of each physical group by dimension and tag; its number without a name."""
    groups = gmsh.model.getPhysicalGroups()
    names = {(d, tag): gmsh.model.getPhysicalName(d, tag).strip() for d, tag in groups}
    told = listed(sorted({name for name in names.values() if name}))
    for (d, _), name in names.items():
        if name and d < dim - 1:
            raise InputError(
                f"{where}: '{name}' names {KINDS[d]}, where staffa knows names of "
                f"{_kinds(dim)} only; remove it; {told}"
            )
    return {(d, tag): name or str(tag) for (d, tag), name in names.items()}


def _kinds(dim: int) -> str:
    return "surfaces and curves" if dim == 2 else "volumes and surfaces"


def _blocks(
    gmsh: Any,
    dim: int,
    names: Mapping[tuple[int, int], str],
    tags: np.ndarray,
    x: np.ndarray,
    where: str,
) -> Iterator[Block]:
    """Yield the cells of a dimension by kind. tags, x: of all nodes, by increasing tags."""
    for _, entity in gmsh.model.getEntities(dim):
        kinds, _, nodes = gmsh.model.mesh.getElements(dim, entity)
        groups = gmsh.model.getPhysicalGroupsForEntity(dim, entity) if len(kinds) else ()
        mine = sorted({names[dim, tag] for tag in groups})
        if len(mine) > 1:
            raise InputError(
                f"{where}: '{mine[0]}' and '{mine[1]}' overlap, both name {KINDS[dim]} {entity}; "
                f"let each part have one name; {listed(sorted(set(names.values())))}"
            )
        for kind, of_kind in zip(kinds, nodes, strict=True):
            _, _, order, width, _, corners = gmsh.model.mesh.getElementProperties(kind)
            rows = np.searchsorted(tags, np.asarray(of_kind, dtype=np.int64)).reshape(-1, width)
            yield Block(
                dim=dim,
                corners=rows[:, :corners],
                name=np.full(len(rows), mine[0] if mine else "", dtype=object),
                order=order,
                bulge=bulge(x[rows], corners) if order == 2 else None,
            )

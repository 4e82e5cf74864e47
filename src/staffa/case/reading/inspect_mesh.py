"""Which body a case means: a block, a shape, or a mesh, which is looked at here."""

from dataclasses import replace
from pathlib import Path
from typing import Any

from staffa.backend.guarded_reading import read_apart
from staffa.case.schema.case import Case
from staffa.case.schema.file_access import FileAccess
from staffa.case.schema.quantity_text import is_scaled, unit
from staffa.case.schema.shape_keys import Layers, PlateWithHole, Wellbore
from staffa.case.schema.toml_text import inline
from staffa.errors import InputError
from staffa.geometry.block import UNSTRUCTURED
from staffa.geometry.foreign import FORMATS
from staffa.geometry.hinges import hinges
from staffa.geometry.msh import SALOME
from staffa.geometry.simplices import Simplices, mesh_outline

# An edge that is asked for and one that is measured may differ so: they are means, and no mesh is
# exact. Gmsh makes even meshes whose mean edge is 0.93 (a disc of ten edges) to 1.0 of what it is
# asked for in 2-D, and more than that in 3-D.
NEARLY = 0.9
READ_MSH, READ_FOREIGN = "staffa.geometry.msh:read_msh", "staffa.geometry.foreign:read_foreign"
BODIES = ("size", "shape", "mesh")


def inspected(case: Case, place: FileAccess) -> Case:
    """Return the case with the outline of its body.

    Parameters
    ----------
    case : the case.
    place : rule for the place of its mesh.

    Raises
    ------
    InputError
        No body is given, or several, or one that cannot be; or its mesh is not as it has to be.
    """
    keys = case.domain
    given = [name for name in BODIES if getattr(keys, name) is not None]
    if not given:
        raise InputError(
            "domain.size is missing (extent along each axis); write it like size = [5.0, 1.0], or "
            "give a shape or a mesh in its place"
        )
    if len(given) > 1:
        raise InputError(f"domain.{given[0]} and domain.{given[1]} both give a body; leave one out")
    if keys.h is None and keys.mesh is None:
        raise InputError("domain.h is missing (cell edge); write it like h = 0.01")
    if keys.unit is not None and keys.mesh is None:
        raise InputError(
            f"domain.unit = {inline(keys.unit)} is for a mesh, and there is none; leave it out"
        )
    if keys.cells not in (None, UNSTRUCTURED) and keys.size is None:
        raise InputError(
            f'domain.cells = "{keys.cells}" is for domain.size; a {given[0]} has triangles or '
            f"tetrahedra that lie anywhere, so leave it out"
        )
    if keys.shape is not None:
        _is_possible(keys.shape)
    return case if keys.mesh is None else _with_mesh(case, place, keys.mesh)


def _with_mesh(case: Case, place: FileAccess, given: str) -> Case:
    keys = case.domain
    if keys.unit is None and not is_scaled(case):
        raise InputError(
            "domain.unit is missing: a mesh counts in numbers, and this case has units; write how "
            'long its 1 is, like unit = "1 mm"'
        )
    try:
        file = place.file(given)
    except InputError as error:
        raise InputError(f"domain.mesh = {inline(given)}: {error}") from None
    mesh = mesh_of(file, float(keys.unit or 1.0), given)
    found = replace(mesh_outline(mesh), hinges=tuple(map(tuple, hinges(mesh)[0].tolist())))
    if keys.h is not None:
        if keys.h * NEARLY > found.h:
            raise InputError(
                f"domain.h = {inline(keys.h)}: of a mesh it is the edge of its cells where cracks "
                f"run, at most the mean edge, {found.h:.3g}{unit(case, 'm')} (a tenth more is "
                f"taken as that); take a smaller one, or leave it out"
            )
        least = found.edges.finest if found.edges else 0.0
        if keys.h < NEARLY * least and keys.refining is None:
            raise InputError(
                f"domain.h = {inline(keys.h)}: the mesh has no such edges; they are "
                f"{found.h:.3g}{unit(case, 'm')} long in the mean, and {least:.3g} in its finest "
                f"cell; mesh the body again, leave domain.h out, or set domain.refine = true, "
                f"with which cells are split down to it"
            )
        found = replace(found, h=min(float(keys.h), found.h))
    return case.model_copy(update={"domain": keys.with_mesh(file, found)})


def mesh_of(file: Path, unit: float, given: str) -> Simplices:
    """Return the mesh of a file.

    Parameters
    ----------
    file : path of the file.
    unit : length of the file's unit (m).
    given : path of the file as the case writes it, for messages.
    """
    where, ends = f"domain.mesh = {inline(given)}", file.suffix.lower()
    if ends in FORMATS:
        return read_apart(Simplices, READ_FOREIGN, file, [unit, where], where=where)
    if ends not in (".msh", *SALOME):
        known = ", ".join(sorted((".msh", *SALOME, *FORMATS)))
        raise InputError(
            f"{where}: a mesh is one of {known}; convert it, with meshio's own command: meshio "
            f"convert {file.name} {file.stem}.vtu"
        )
    return read_apart(Simplices, READ_MSH, file, [unit, where], where=where)


def _is_possible(shape: Any) -> None:
    """Require that a shape has as many numbers as it needs, and that they are possible."""
    if isinstance(shape, Layers):
        _can_be_stacked(shape)
    if not isinstance(shape, PlateWithHole | Wellbore):
        return
    where, dim = f'domain.shape, kind = "{shape.kind}"', 3 if isinstance(shape, Wellbore) else 2
    if len(shape.size) != dim:
        raise InputError(f"{where}, size = {inline(shape.size)}: it needs {dim} numbers")
    center = shape.center or tuple(s / 2 for s in shape.size[:2])
    for c, s in zip(center, shape.size, strict=False):
        if not shape.radius < c < s - shape.radius:
            raise InputError(
                f"{where}: a hole of radius {inline(shape.radius)} around "
                f"{inline(center)} does not lie inside {inline(shape.size)}; take a smaller one, "
                f"or move it"
            )


def _can_be_stacked(shape: Layers) -> None:
    where = 'domain.shape, kind = "layers"'
    if len(shape.base) not in (1, 2):
        raise InputError(
            f"{where}, base = {inline(shape.base)}: it needs one number (2-D) or two (3-D)"
        )
    if not shape.layers:
        raise InputError(
            f'{where}: it has no layers; write them like layers = [{{ region = "shale", thickness '
            f"= 0.3 }}]"
        )

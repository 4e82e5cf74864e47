"""Meshes with names that tests write with Gmsh, as a user would."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

# Lower corner, size and height of the seam of the plate, in its own unit.
CORNER, SIZE, SEAM = (1.0, 2.0), (2.0, 1.0), 0.4


def written(path: Path, draw: Callable[[Any], None], *, h: float, version: float = 4.1) -> Path:
    """The mesh of what `draw` models and names, as a .msh file."""
    import gmsh

    gmsh.initialize(readConfigFiles=False, interruptible=False)
    try:
        gmsh.option.setNumber("General.Terminal", 0)
        gmsh.option.setNumber("Mesh.MeshSizeMin", h)
        gmsh.option.setNumber("Mesh.MeshSizeMax", h)
        gmsh.option.setNumber("Mesh.MshFileVersion", version)
        draw(gmsh)
        gmsh.model.mesh.generate(gmsh.model.getDimension())
        gmsh.write(str(path))
    finally:
        gmsh.finalize()
    return path


def plate(gmsh: Any, *, fault: tuple[float, float] | None = (0.5, 1.0)) -> None:
    """A plate of a seam (shale) and what lies on it (sand), with four faces: west, east, floor and
    the roof, and a crack (fault) that stands in its middle between two parts of its height."""
    occ, model = gmsh.model.occ, gmsh.model
    (x, y), (width, height) = CORNER, SIZE
    layers = [
        (2, occ.addRectangle(x, y, 0, width, SEAM)),
        (2, occ.addRectangle(x, y + SEAM, 0, width, height - SEAM)),
    ]
    lines = []
    if fault is not None:
        ends = [occ.addPoint(x + width / 2, y + part * height, 0) for part in fault]
        lines = [(1, occ.addLine(*ends))]
    _, pieces = occ.fragment(layers, lines)
    occ.synchronize()
    for name, piece in zip(("shale", "sand"), pieces, strict=False):
        model.addPhysicalGroup(2, [tag for _, tag in piece], name=name)
    if fault is not None:
        model.addPhysicalGroup(1, [tag for _, tag in pieces[2]], name="fault")
    for name, axis, at in (
        ("west", 0, x), ("east", 0, x + width), ("floor", 1, y), ("the roof", 1, y + height)
    ):  # fmt: skip
        model.addPhysicalGroup(1, _at(model, axis, at), name=name)


def _at(model: Any, axis: int, at: float) -> list[int]:
    """The curves that lie where one coordinate has a value."""
    boxes = {tag: model.getBoundingBox(1, tag) for _, tag in model.getEntities(1)}
    return [
        tag
        for tag, box in boxes.items()
        if max(abs(box[axis] - at), abs(box[axis + 3] - at)) < 1e-3
    ]


def square(gmsh: Any, size: float = 1.0, x: float = 0.0) -> int:
    """A square without any names."""
    tag = int(gmsh.model.occ.addRectangle(x, 0, 0, size, size))
    gmsh.model.occ.synchronize()
    return tag

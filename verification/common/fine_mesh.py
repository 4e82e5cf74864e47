"""A plate or a block, meshed by Gmsh, fine where its crack will run."""

from pathlib import Path

import gmsh


def make_mesh(path: Path, dim: int, sizes: dict[str, float], *, pulled: bool = False) -> None:
    """Half a plate, or a quarter of a block, fine where the crack will run; pulled: with names for
    the two ends of a block."""
    W, h, ell, reach = (sizes[name] for name in ("width", "h", "ell", "reach"))
    gmsh.initialize()
    gmsh.option.setNumber("General.Verbosity", 1)
    shape = gmsh.model.occ
    if dim == 2:
        shape.addRectangle(0, -W, 0, W, 2 * W)
    else:
        shape.addBox(0, 0, -W, W, W, 2 * W)
    shape.synchronize()
    names = {"left": (0, 0)} if dim == 2 else {"left": (0, 0), "front": (1, 0)}
    if pulled:
        names |= {"bottom": (2, -W), "top": (2, W)}
    for name, (axis, at) in names.items():
        on = [
            tag
            for _, tag in gmsh.model.getEntities(dim - 1)
            if max(abs(b - at) for b in gmsh.model.getBoundingBox(dim - 1, tag)[axis::3]) < 1e-6
        ]
        gmsh.model.addPhysicalGroup(dim - 1, on, name=name)
    gmsh.model.addPhysicalGroup(dim, [1], name="rock")
    field = gmsh.model.mesh.field
    field.add("Box", 1)
    low = {"XMin": -1, "YMin": -1, "ZMin": -1, "XMax": reach, "YMax": reach, "ZMax": 1}
    across = "Y" if dim == 2 else "Z"
    low |= {f"{across}Min": -3 * ell, f"{across}Max": 3 * ell}
    for name, value in (low | {"VIn": h, "VOut": W / 5, "Thickness": W}).items():
        field.setNumber(1, name, value)
    field.setAsBackgroundMesh(1)
    gmsh.option.setNumber("Mesh.MeshSizeExtendFromBoundary", 0)
    gmsh.option.setNumber("Mesh.Algorithm", 5)
    gmsh.model.mesh.generate(dim)
    gmsh.write(str(path))
    gmsh.finalize()

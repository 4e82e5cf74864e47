"""Meshes of other kinds, orders and formats: the same triangles and tetrahedra."""

from pathlib import Path
from typing import Any

import h5py
import meshio
import numpy as np
import pytest

from staffa.case.check.preview import preview
from staffa.case.reading.inspect_mesh import mesh_of
from staffa.case.reading.read import parse_case
from staffa.errors import InputError
from staffa.geometry.simplices import Simplices, facets, keys
from staffa.geometry.simplices import mesh_outline as found_outline
from support import meshes
from support.bodies import needs_gmsh

CASE = """
[domain]
mesh = "%s"
[damage]
ell = 1.0
[temperature]
profile = "none"
[supports]
left = "rollers"
right = { x = 0.02 }
[time]
t = [1.0]
"""
# Of nschloe/meshio issue 169 ("Meshio doesn't recognize physical groups"), as it is given there.
SQUARES = """$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
5
1 1 "lower"
1 2 "right"
1 3 "upper"
1 4 "left"
2 5 "domain"
$EndPhysicalNames
$Nodes
9
1 0 0 0
2 1 0 0
3 1 1 0
4 0 1 0
5 0.499999999998694 0 0
6 1 0.499999999998694 0
7 0.5000000000020591 1 0
8 0 0.5000000000020591 0
9 0.5000000000003766 0.5000000000003766 0
$EndNodes
$Elements
12
1 1 2 1 1 1 5
2 1 2 1 1 5 2
3 1 2 2 2 2 6
4 1 2 2 2 6 3
5 1 2 3 3 3 7
6 1 2 3 3 7 4
7 1 2 4 4 4 8
8 1 2 4 4 8 1
9 3 2 5 1 1 5 9 8
10 3 2 5 1 8 9 7 4
11 3 2 5 1 5 2 6 9
12 3 2 5 1 9 6 3 7
$EndElements
"""
NAMES = SQUARES[SQUARES.index("$PhysicalNames") : SQUARES.index("$Nodes")]


def content(x: np.ndarray, rows: np.ndarray) -> float:
    """Length, area or volume of simplices."""
    edges = x[rows][:, 1:] - x[rows][:, :1]
    gram = edges @ edges.transpose(0, 2, 1)
    return float(np.sqrt(np.linalg.det(gram)).sum()) / {1: 1, 2: 2, 3: 6}[gram.shape[1]]


def sizes(mesh: Simplices) -> dict[str, float]:
    """Names of all faces and regions."""
    found = {name: content(mesh.x, rows) for name, rows in mesh.faces.items()}
    return found | {n: content(mesh.x, mesh.cells[c]) for n, c in mesh.regions.items()}


def read(path: Path) -> Simplices:
    return mesh_of(path, 1.0, path.name)


def test_quadrilaterals_with_names_are_four_triangles_each(tmp_path: Path) -> None:
    """The file of meshio's issue 169: https://github.com/nschloe/meshio/issues/169."""
    pytest.importorskip("gmsh")
    (tmp_path / "test2D.msh").write_text(SQUARES)
    mesh = read(tmp_path / "test2D.msh")
    assert len(mesh.cells) == 16 and len(mesh.x) == 9 + 4
    sides = dict.fromkeys(("lower", "right", "upper", "left"), 1.0)
    assert sizes(mesh) == pytest.approx(sides | {"domain": 1.0})
    case = parse_case(CASE % "test2D.msh", folder=tmp_path)
    assert any("its 4 quadrilaterals are read as four" in note for note in preview(case).notes)


def test_groups_without_names_go_by_their_numbers(tmp_path: Path) -> None:
    """Lines and surfaces with numbers alone, as in meshio's issue 265 and as Salome's scripts give
    them: https://github.com/nschloe/meshio/issues/265 and
    https://github.com/kinnala/scikit-fem/pull/1190."""
    pytest.importorskip("gmsh")
    (tmp_path / "a.msh").write_text(SQUARES.replace(NAMES, ""))
    mesh = read(tmp_path / "a.msh")
    assert sizes(mesh) == pytest.approx(dict.fromkeys("12345", 1.0))
    text = (CASE % "a.msh").replace("left =", "4 =").replace("right =", "2 =")
    case = parse_case(text, folder=tmp_path)
    assert case.outline.sides == {"1": "bottom", "2": "right", "3": "top", "4": "left"}
    assert case.supports.on("4") == "rollers" and case.supports.on("2").x == 0.02
    with pytest.raises(InputError, match=r"supports.6: the mesh has no such face; it has 1, 2, 3"):
        parse_case(text.replace("4 =", "6 ="), folder=tmp_path)


def test_parts_that_a_mesh_only_numbers_need_not_be_named(tmp_path: Path) -> None:
    """Two materials, and the line between them, none of which the case is about."""
    pytest.importorskip("gmsh")
    numbered = SQUARES.replace(NAMES, "").replace("12 3 2 5 1 9 6 3 7", "12 3 2 6 2 9 6 3 7")
    numbered = numbered.replace("Elements\n12\n", "Elements\n13\n", 1)
    numbered = numbered.replace("$EndElements", "13 1 2 7 7 9 6\n$EndElements")
    (tmp_path / "a.msh").write_text(numbered)
    text = (CASE % "a.msh").replace("left =", "4 =").replace("right =", "2 =")
    case = parse_case(text, folder=tmp_path)
    assert case.outline.regions == ("5", "6") and case.outline.cracks == ("7",)
    assert parse_case(text + "[regions.6]\nE = 2.0\n", folder=tmp_path).regions["6"].E == 2.0


def quarter(gmsh: Any) -> None:
    """A quarter of a disc of second order, with a name for its arc: of
    https://discourse.julialang.org/t/order-for-finite-elements-when-using-gridap-and-gmsh/125094."""
    geo = gmsh.model.geo
    points = [geo.addPoint(*x, 0) for x in ((0, 0), (0, 1), (1, 0))]
    left, arc = geo.addLine(points[0], points[1]), geo.addCircleArc(points[1], points[0], points[2])
    bottom = geo.addLine(points[2], points[0])
    tag = geo.addPlaneSurface([geo.addCurveLoop([left, arc, bottom])])
    geo.synchronize()
    gmsh.model.addPhysicalGroup(2, [tag], name="disc")
    gmsh.model.addPhysicalGroup(1, [arc], name="arc1")
    gmsh.option.setNumber("Mesh.ElementOrder", 2)


@needs_gmsh
@pytest.mark.parametrize("version", [2.2, 4.1])
def test_cells_of_second_order_are_read_by_their_corners(tmp_path: Path, version: float) -> None:
    h = 0.2
    mesh = read(meshes.written(tmp_path / "a.msh", quarter, h=h, version=version))
    arc = mesh.faces["arc1"]
    chord = np.pi / 2 / len(arc)
    assert content(mesh.x, arc) == pytest.approx(len(arc) * 2 * np.sin(chord / 2))
    assert np.linalg.norm(mesh.x[arc], axis=2) == pytest.approx(1.0)
    (note,) = mesh.notes
    moved = float(note.split("they move ")[1].split()[0])
    assert moved == pytest.approx(1 - np.cos(chord / 2), rel=0.05), note
    assert "of order 2 and read by their corners, with straight edges" in note


def brick(gmsh: Any) -> None:
    """A box of hexahedra below and prisms above, with four faces and an order of two."""
    geo = gmsh.model.geo
    points = [geo.addPoint(x, y, 0) for x, y in ((0, 0), (2, 0), (2, 1), (0, 1))]
    lines = [geo.addLine(points[i], points[(i + 1) % 4]) for i in range(4)]
    floor = geo.addPlaneSurface([geo.addCurveLoop(lines)])
    geo.mesh.setTransfiniteSurface(floor)
    geo.mesh.setRecombine(2, floor)
    lower = geo.extrude([(2, floor)], 0, 0, 0.5, numElements=[2], recombine=True)
    upper = geo.extrude([(2, floor)], 0, 0, -0.5, numElements=[3], recombine=True)
    geo.synchronize()
    gmsh.model.addPhysicalGroup(3, [lower[1][1], upper[1][1]], name="rock")
    gmsh.model.addPhysicalGroup(2, [lower[0][1]], name="top")
    gmsh.model.addPhysicalGroup(2, [upper[0][1]], name="bottom")
    gmsh.model.addPhysicalGroup(2, [lower[5][1], upper[5][1]], name="side")


def conforms(mesh: Simplices) -> None:
    """Every facet is between two cells or on the surface, whose area is that of the body."""
    every = facets(mesh.cells).reshape(-1, mesh.dim)
    _, first, count = np.unique(keys(every), return_index=True, return_counts=True)
    assert count.max() == 2
    assert content(mesh.x, every[first[count == 1]]) == pytest.approx(10.0), "a gap"


@needs_gmsh
@pytest.mark.parametrize("order", [1, 2])
def test_hexahedra_are_tetrahedra_that_fit_together(tmp_path: Path, order: int) -> None:
    def draw(gmsh: Any) -> None:
        brick(gmsh)
        gmsh.option.setNumber("Mesh.ElementOrder", order)

    mesh = read(meshes.written(tmp_path / "a.msh", draw, h=0.3))
    assert sizes(mesh) == pytest.approx({"rock": 2.0, "top": 2.0, "bottom": 2.0, "side": 1.0})
    conforms(mesh)
    assert len(mesh.cells) % 5 == 0 and "hexahedra are read as tetrahedra" in mesh.notes[0]
    assert len(mesh.notes) == order


@pytest.mark.parametrize("kind", ["wedge", "pyramid"])
def test_prisms_and_pyramids_are_tetrahedra_that_fit_together(tmp_path: Path, kind: str) -> None:
    """A box of 2 x 1 x 1 of two cubes, each cut into prisms or into pyramids about its middle."""
    x = np.array([[i, j, k] for i in range(3) for j in range(2) for k in range(2)], dtype=float)
    corners = np.array([[0, 4, 6, 2, 1, 5, 7, 3], [4, 8, 10, 6, 5, 9, 11, 7]])
    if kind == "wedge":
        cells = np.concatenate([corners[:, [0, 1, 2, 4, 5, 6]], corners[:, [0, 2, 3, 4, 6, 7]]])
    else:
        x = np.concatenate([x, x[corners].mean(axis=1)])
        sides = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
        cells = np.array([[*c[list(s)], 12 + k] for k, c in enumerate(corners) for s in sides])
    meshio.write(tmp_path / "a.vtu", meshio.Mesh(x, [(kind, cells)]))
    mesh = read(tmp_path / "a.vtu")
    assert content(mesh.x, mesh.cells) == pytest.approx(2.0)
    conforms(mesh)


def test_a_cell_that_is_folded_is_refused(tmp_path: Path) -> None:
    x = np.array([[0, 0, 0], [1, 0, 0], [0.1, 0.1, 0], [0, 1, 0]], dtype=float)
    meshio.write(tmp_path / "a.vtu", meshio.Mesh(x, [("quad", [[0, 1, 2, 3]])]))
    with pytest.raises(InputError, match=r"1 of its 1 cells .* folded or not convex"):
        read(tmp_path / "a.vtu")


@needs_gmsh
@pytest.mark.parametrize("ends", [".inp", ".med", ".unv", ".mesh", ".vtk"])
def test_a_mesh_in_another_format_has_the_same_parts(tmp_path: Path, ends: str) -> None:
    """The plate with a fault: with names where the format has them, else with numbers."""
    path = meshes.written(tmp_path / f"a{ends}", meshes.plate, h=0.2)
    mesh = read(path)
    known = [0.5, 0.8, 1.0, 1.0, 1.2, 2.0, 2.0]  # fault, shale, west, east, sand, floor, the roof
    found = sizes(mesh) | {name: content(mesh.x, rows) for name, rows in mesh.cracks.items()}
    if ends in (".mesh", ".vtk"):  # their numbers are those of curves, of which a side has two
        assert sorted((found["1"], found["2"])) == pytest.approx([0.8, 1.2])
        assert [content(mesh.x, rows) for rows in mesh.cracks.values()] == [pytest.approx(0.5)]
        return
    assert sorted(found.values()) == pytest.approx(known), found
    named = {name.replace("_", " "): size for name, size in found.items()}
    assert named["the roof"] == pytest.approx(2.0) and named["fault"] == pytest.approx(0.5)


def test_a_mesh_that_names_another_file_is_refused(tmp_path: Path) -> None:
    for line in ("\n*INCLUDE", "\r*INCLUDE", "\n*INC*LUDE", "\n*ınclude"):
        (tmp_path / "a.inp").write_text(f"*NODE\n1, 0, 0, 0{line}, INPUT=/etc/passwd\n")
        with pytest.raises(InputError, match="includes another file, and a run keeps one"):
            read(tmp_path / "a.inp")
    with h5py.File(tmp_path / "a.med", "w") as file:
        file["ENS_MAA"] = h5py.ExternalLink("/tmp/other.med", "/ENS_MAA")
    with pytest.raises(InputError, match=r"shows what is in another file, /tmp/other.med"):
        read(tmp_path / "a.med")
    with pytest.raises(InputError, match=r"a mesh is one of \.bdf, .*\.vtu; convert it.* meshio"):
        read(tmp_path / "a.xdmf")


def test_a_file_that_is_no_mesh_is_refused_in_one_sentence(tmp_path: Path) -> None:
    for ends in (".inp", ".vtu", ".vtk", ".mesh", ".bdf"):
        (tmp_path / f"a{ends}").write_text("no mesh\n")
        with pytest.raises(InputError, match=f'domain.mesh = "a{ends}"') as error:
            read(tmp_path / f"a{ends}")
        assert "\n" not in str(error.value), str(error.value)


def test_sets_of_abaqus_name_cells_once_and_eall_names_nothing(tmp_path: Path) -> None:
    head = "*NODE\n1, 0, 0, 0\n2, 1, 0, 0\n3, 1, 1, 0\n4, 0, 1, 0\n"
    cells = "*ELEMENT, TYPE=CPS3, ELSET=Surface1\n1, 1, 2, 3\n2, 1, 3, 4\n"
    side = "*ELEMENT, TYPE=T3D2, ELSET=Line1\n3, 1, 2\n4, 3, 4\n"
    sets = "*ELSET, ELSET=Eall\n1, 2, 3, 4\n*ELSET, ELSET=clay\n1\n*ELSET, ELSET=sand\n2\n"
    (tmp_path / "a.inp").write_text(head + cells + side + sets + "*ELSET, ELSET=floor\n3\n")
    mesh = read(tmp_path / "a.inp")
    assert sizes(mesh) == pytest.approx({"clay": 0.5, "sand": 0.5, "floor": 1.0, "Line1": 1.0})
    assert found_outline(mesh).sides["floor"] == "bottom"
    (tmp_path / "a.inp").write_text(head + cells + sets + "*ELSET, ELSET=both\n1, 2\n")
    with pytest.raises(InputError, match=r"the sets '\w+' and '\w+' overlap"):
        read(tmp_path / "a.inp")


def test_sets_of_nodes_name_faces_where_a_file_has_none(tmp_path: Path) -> None:
    """As FreeCAD and CalculiX write them, with one of all nodes, of an edge, and of a corner."""
    points = [(x, y, z) for x in (0, 1) for y in (0, 2) for z in (0, 3)]
    nodes = "".join(f"{k}, {x}, {y}, {z}\n" for k, (x, y, z) in enumerate(points, start=1))
    text = f"*NODE\n{nodes}*ELEMENT, TYPE=C3D8, ELSET=Evolumes\n1, 1, 5, 7, 3, 2, 6, 8, 4\n"
    text += "*NSET, NSET=Nall\n1, 2, 3, 4, 5, 6, 7, 8\n*NSET, NSET=left\n1, 2, 3, 4\n"
    text += "*NSET, NSET=top\n2, 4, 6, 8\n*NSET, NSET=edge\n1, 2\n*NSET, NSET=pin\n1\n"
    (tmp_path / "a.inp").write_text(text)
    mesh = read(tmp_path / "a.inp")
    assert sizes(mesh) == pytest.approx({"left": 6.0, "top": 2.0, "Evolumes": 6.0})
    assert found_outline(mesh).sides == {"left": "left", "top": "top"}

"""Parts of a mesh that share points only: they are found, and the place is told."""

from pathlib import Path

import numpy as np
import pytest

from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case
from staffa.geometry.hinges import hinges
from staffa.geometry.simplices import Simplices
from support.bodies import needs_gmsh


def mesh(x, cells) -> Simplices:
    """Cells without any names."""
    return Simplices(x=np.array(x, float), cells=np.array(cells), regions={}, faces={}, cracks={})


SQUARE = [(0, 0), (1, 0), (1, 1), (0, 1)]
# Two triangles that meet in the middle alone: the bow tie of ShapeWorks' issue 2047
# (github.com/SCIInstitute/ShapeWorks).
BOW_TIE = mesh([(0, 0), (0, 2), (1, 1), (2, 0), (2, 2)], [(0, 1, 2), (2, 3, 4)])
# Two tetrahedra with an edge in common, as voxels leave them behind: issue 359 of automesh
# (github.com/autotwin/automesh).
EDGE = mesh(
    [(0, 0, 0), (0, 0, 1), (1, 0, 0), (1, 1, 0), (-1, 0, 0), (-1, -1, 0)],
    [(0, 1, 2, 3), (0, 1, 4, 5)],
)


def test_parts_that_share_a_facet_have_no_hinge() -> None:
    points, number = hinges(mesh(SQUARE, [(0, 1, 2), (0, 2, 3)]))
    assert (len(points), number) == (0, 1)


@pytest.mark.parametrize(
    ("found", "at"), [(BOW_TIE, [(1, 1)]), (EDGE, [(0, 0, 0), (0, 0, 1)])], ids=["2-D", "3-D"]
)
def test_a_hinge_is_where_two_bodies_touch(found: Simplices, at: list) -> None:
    points, number = hinges(found)
    assert number == 2
    assert points.tolist() == np.array(at, float).tolist()


def test_three_bodies_have_the_hinges_of_each_two() -> None:
    """A chain of three triangles."""
    chain = mesh(
        [(0, 0), (0, 1), (1, 0), (2, 1), (2, 0), (3, 0), (3, 1)],
        [(0, 1, 2), (2, 3, 4), (4, 5, 6)],
    )
    points, number = hinges(chain)
    assert number == 3 and points.tolist() == [[1, 0], [2, 0]]


CASE = """
[domain]
mesh = "two.msh"
[material]
rho = 1.0
[damage]
ell = 0.3
[forces]
gravity = [0.0, -1e-3]
[temperature]
profile = "none"
[supports]
left = "clamped"
[time]
t = [1.0]
"""


def two_squares(path: Path, *, apart: float) -> Path:
    """Two squares corner to corner, or overlapping by an edge, with a left face."""
    import gmsh

    from support.meshes import written

    def draw(gmsh) -> None:
        occ, model = gmsh.model.occ, gmsh.model
        squares = [(2, occ.addRectangle(0, 0, 0, 1, 1)), (2, occ.addRectangle(1, apart, 0, 1, 1))]
        occ.fragment(squares[:1], squares[1:])
        occ.synchronize()
        model.addPhysicalGroup(2, [tag for _, tag in model.getEntities(2)], name="rock")
        left = [tag for _, tag in model.getEntities(1) if model.getBoundingBox(1, tag)[3] < 1e-6]
        model.addPhysicalGroup(1, left, name="left")

    assert gmsh
    return written(path, draw, h=0.1)


@needs_gmsh
@pytest.mark.parametrize(("apart", "hinged"), [(1.0, True), (0.5, False)])
def test_check_tells_of_a_hinge_and_where_it_is(tmp_path: Path, apart: float, hinged: bool) -> None:
    (tmp_path / "my.toml").write_text(CASE)
    two_squares(tmp_path / "two.msh", apart=apart)
    from staffa.case.reading.read import read_case

    said = [text for text in preview(read_case(tmp_path / "my.toml")).warnings if "hinge" in text]
    assert bool(said) == hinged, said
    if hinged:
        assert "at (1, 1): a hinge" in said[0]


def test_a_block_has_none() -> None:
    case = parse_case(CASE.replace('mesh = "two.msh"', "size = [1.0, 1.0]\nh = 0.1"))
    assert not [text for text in preview(case).warnings if "hinge" in text]

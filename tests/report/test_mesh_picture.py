"""The picture of a mesh that follows the cracks: what a section cuts out, and what it shows."""

from dataclasses import replace

import numpy as np
import pytest
from matplotlib.image import imread

from report.test_report import BOX, drawn_mesh, drawn_run, rewritten
from staffa.io.vtkhdf import VtkMesh
from staffa.plot.mesh_picture import plane, section
from staffa.records.step import RefinedMesh
from staffa.report.drawing import draw


def tetrahedra() -> VtkMesh:
    """A unit cube of 27 smaller ones, each cut into six tetrahedra around a diagonal."""
    cubes = drawn_mesh((1.0, 1.0, 1.0), 3)
    ways = ([0, 1, 2, 6], [0, 2, 3, 6], [0, 3, 7, 6], [0, 7, 4, 6], [0, 4, 5, 6], [0, 5, 1, 6])
    cells = np.concatenate([cubes.cells[:, way] for way in ways])
    return VtkMesh(points=cubes.points, cells=cells, type=10)


def area(polygon: np.ndarray) -> float:
    """Area of a flat polygon, shape (n, 3)."""
    fan = np.cross(polygon[1:-1] - polygon[0], polygon[2:] - polygon[0])
    return float(np.linalg.norm(fan.sum(axis=0)) / 2)


@pytest.mark.parametrize("axis", [0, 1, 2])
def test_a_section_has_the_area_of_the_body_and_the_damage_at_its_corners(axis):
    grid = tetrahedra()
    alpha = grid.points @ np.array([0.2, 0.3, 0.4])
    polygons, damage = section(grid, alpha, axis, 0.45)
    assert sum(map(area, polygons)) == pytest.approx(1.0)
    assert {len(polygon) for polygon in polygons} <= {3, 4}
    for polygon, values in zip(polygons, damage, strict=True):
        assert polygon[:, axis] == pytest.approx(0.45)
        assert values == pytest.approx(polygon @ np.array([0.2, 0.3, 0.4]))


def test_a_section_of_a_solid_contains_the_depth(tmp_path):
    found = {}
    for face in ("bottom", "left", "front"):
        found[face] = plane(drawn_run(tmp_path / face, BOX, n=2, face=face).manifest)
    assert found == {"bottom": (0, 2), "left": (1, 0), "front": (0, 1)}


@pytest.mark.slow
@pytest.mark.parametrize("size", [(2.5, 1.0), BOX], ids=["slab", "block"])
def test_only_a_run_whose_mesh_follows_the_cracks_has_the_picture(size, tmp_path, monkeypatch):
    monkeypatch.setattr("staffa.plot.volume.RENDERER", "staffa.no_such_module")
    run = drawn_run(tmp_path / "run", size, n=8)
    assert "mesh.png" not in [path.name for path in draw(run, movie=False).pictures]
    steps = [
        replace(step, mesh=RefinedMesh(cells=100 + 50 * step.index, vertices=90))
        for step in run.steps
    ]
    drawn = draw(rewritten(run, steps), movie=False)
    picture = next(path for path in drawn.pictures if path.name == "mesh.png")
    assert imread(picture)[..., :3].std() > 0.02, "it is blank"
    text = drawn.page.read_text(encoding="utf-8")
    where = "in a section " if len(size) == 3 else ""
    caption = f"The cells {where}at the last time whose fields are kept, over the damage"
    assert text.count(caption) == 2, "as its caption, and for those who do not see it"

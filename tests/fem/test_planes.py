"""Cells are measured on planes of a mesh, the same ones on any number of ranks."""

from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
import pytest
from scipy.spatial import cKDTree

from run.test_run import CASES as READY
from run.test_run import launch
from staffa.geometry.shapes import Round, meshed
from staffa.io.run_directory import open_run
from staffa.loads.closed_form import Face
from staffa.measure.column_planes import Planes
from staffa.model.domain import Domain, block, body
from staffa.model.fields import State, linear_spaces, vertices, zero_state
from staffa.records.status import Status
from staffa.records.step import CellSection, Energies, Measures, Step
from support.bodies import needs_gmsh

SIZE, H, ELL = (1.0, 0.8, 0.3), 0.04, 0.06
FACES = {
    "bottom": Face(axis=2, position=0.0, inward=1),
    "top": Face(axis=2, position=0.3, inward=-1),
}
POINTS = np.random.default_rng(2).uniform(0.1, 0.9, (40, 2)) * SIZE[:2]
CELLS = ["hexahedron", "tetrahedron"]


def seeds(number: int) -> np.ndarray:
    """This number of points that lie apart."""
    found = POINTS[:1]
    while len(found) < number:
        away = cKDTree(found).query(POINTS)[0]
        found = np.concatenate([found, POINTS[away.argmax()][None]])
    return found


FEW, MANY = seeds(5), seeds(9)


def to_borders(x: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Distance to the borders of the points' Voronoi cells."""
    near, number = cKDTree(points).query(x, k=len(points))
    way = np.linalg.norm(points[number[:, 1:]] - points[number[:, :1]], axis=2)
    return ((near[:, 1:] ** 2 - near[:, :1] ** 2) / (2 * way)).min(axis=1)


def drawn(domain: Domain, face: Face) -> State:
    """Many cells above half of the depth, a few below."""
    state = zero_state(spaces := linear_spaces(domain))
    x = vertices(spaces.alpha)
    away = [to_borders(x[:, :2], points) for points in (MANY, FEW)]
    distance = np.where(face.depth(x.T) < 0.15, *away)
    state.alpha.x.array[:] = np.clip(1 - np.maximum(distance - H / 2, 0) / (2 * ELL), 0, 1) ** 2
    return state


def seen(cells: str, face: Face, depths=(0.05, 0.25)) -> tuple[CellSection, ...]:
    domain = block(MPI.COMM_WORLD, size=SIZE, h=H, cells=cells)
    return Planes(domain, face, depths, ell=ELL, threshold=0.8)(drawn(domain, face))


def expected(points: np.ndarray) -> np.ndarray:
    """The areas of the cells of points within the block."""
    fine = np.stack(np.meshgrid(*(np.linspace(0, s, 400) for s in SIZE[:2])), axis=2)
    number = cKDTree(points).query(fine.reshape(-1, 2))[1]
    return np.sort(np.bincount(number) / number.size * SIZE[0] * SIZE[1])


@pytest.mark.parametrize("face", FACES)
@pytest.mark.parametrize("cells", CELLS)
def test_drawn_columns_are_found_at_each_depth(cells: str, face: str) -> None:
    for section, points in zip(seen(cells, FACES[face]), (MANY, FEW), strict=True):
        areas = np.sort(section.areas)
        assert len(areas) == len(points)
        assert areas.sum() == pytest.approx(SIZE[0] * SIZE[1], rel=1e-9)
        assert areas == pytest.approx(expected(points), rel=0.1), "to a pixel all around"
        assert section.junctions["Y"] + section.junctions["T"] >= 2 and sum(section.ends) > 0


@needs_gmsh
def test_a_cylinder_is_seen_on_its_disc() -> None:
    shape = Round(radius=0.5, height=0.2)
    domain = body(MPI.COMM_WORLD, lambda: meshed(shape, 0.06, "domain.shape"))
    planes = Planes(domain, FACES["bottom"], (0.1,), ell=0.09, threshold=0.8)
    state = zero_state(spaces := linear_spaces(domain))
    x = vertices(spaces.alpha)[:, 0]
    away = np.maximum(np.abs(x) - 0.06, 0)
    state.alpha.x.array[:] = np.clip(1 - away / 0.18, 0, 1) ** 2
    (section,) = planes(state)
    assert section.number == 2 and section.sides == (1, 1) and min(section.ends) > 0
    assert sum(section.areas) == pytest.approx(np.pi / 4, rel=0.02), "of a polygon in a circle"


def words(cells: str) -> list[str]:
    """The parts of two planes that must be the same, in words, then their areas."""
    found = seen(cells, FACES["bottom"])
    counts = [n for s in found for n in (s.number, *s.sides, *s.ends, *s.junctions.values())]
    return [" ".join(map(str, row)) for row in (counts, (area for s in found for area in s.areas))]


def test_cells_are_kept_with_the_step_and_old_steps_have_none() -> None:
    section = CellSection(
        depth=0.1, pixel=(0.02, 0.02), areas=(0.1, 0.2), perimeters=(1.0, 1.0), sides=(1, 1),
        ends=(1, 2), junctions={"T": 1, "Y": 0, "X": 0}, cracked=0.2,
    )  # fmt: skip
    measures = Measures(
        sections=(), tips=(), front=0.0, length_surface=0.0, length_geometry=0.0, cells=(section,)
    )
    step = Step(
        index=1, time=1.0, tau=None, energies=Energies(elastic=1.0, surface=0.0), sweeps=1,
        status=Status.CONVERGED, reason="", measures=measures,
    )  # fmt: skip
    record = step.to_record()
    assert Step.from_record(record) == step
    del record["measures"]["cells"]
    assert Step.from_record(record).measures.cells == ()


@needs_gmsh
@pytest.mark.long
def test_a_cylinder_goes_from_its_case_to_its_pictures(tmp_path: Path) -> None:
    coarse = ("--set", "domain.h=0.25", "--set", "damage.ell=0.3", "--set", "time.tau=[0.6]")
    settings = [*coarse, "--set", "output.at=[0.6]", "--out", tmp_path / "run"]
    done = launch(1, "run", READY / "cylinder.toml", *settings)
    assert done.returncode == 0, done.stderr
    run = open_run(tmp_path / "run")
    (step,) = run.steps
    assert [section.depth for section in step.measures.cells] == [0.2, 0.4, 0.6]
    disc = np.pi * 1.4**2  # of pixels whose middles are in it, and of facets within its round
    assert all(sum(s.areas) == pytest.approx(disc, rel=0.05) for s in step.measures.cells)
    there = {path.name for path in (run.path / "pictures").iterdir()}
    assert {"cracks.png", "sections.png"} <= there, done.stdout

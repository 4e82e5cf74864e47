"""Pictures of columns: the cells of planes, their sizes by depth, and cracks in perspective."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from matplotlib.colors import to_rgb
from PIL import Image

from report.test_report import drawn_manifest, drawn_mesh, drawn_run, drawn_step
from staffa.errors import InputError
from staffa.io.run_directory import Journal, Run, create, fields_name, open_run
from staffa.io.vtkhdf import write_vtkhdf
from staffa.measure.patterns import Estimate, pattern
from staffa.plot import movie, volume
from staffa.plot.cell_planes import (
    AT_THE_END,
    CRACK,
    NEIGHBORS,
    ColumnPlane,
    ReferenceCurve,
    painted,
    sections_figure,
    size_figure,
)
from staffa.plot.frames import read_frames
from staffa.plot.rendering import CRACKS, ROCK
from staffa.records.step import CellSection
from staffa.report.drawing import draw
from staffa.results import sections
from support.pages import without_scripts

SIZE, ELL, N = (1.0, 1.0, 0.5), 0.04, 24  # N cells of the mesh along the first axis
SHALLOW = 0.2  # where the cracks across y end; those across x go on
DEPTHS = (0.1, 0.4)


def brick_bond(points: np.ndarray) -> np.ndarray:
    """The damage of two cracks across x, all through, and of two across y that end."""
    to_x, to_y = (np.abs(points[:, k, None] - [1 / 3, 2 / 3]).min(axis=1) for k in (0, 1))
    to_y = np.hypot(to_y, np.maximum(points[:, 2] - SHALLOW, 0.0))
    return np.clip(1 - np.minimum(to_x, to_y) / (2 * ELL), 0, 1) ** 2


def columns_run(path: Path, *, round_body: bool = False, steps: int = 1) -> Run:
    """A run of a body that cracks divide in nine columns, farther down in three."""
    grid = drawn_mesh(SIZE, N)
    if round_body:
        middles = grid.points[grid.cells].mean(axis=1)
        grid = replace(grid, cells=grid.cells[np.hypot(*(middles[:, :2] - 0.5).T) < 0.5])
    create(path, "", drawn_manifest(SIZE, ell=ELL, scales={"ell0": 0.01}))
    for index in range(steps):
        alpha = brick_bond(grid.points) * (index + 1 == steps)  # uncracked before
        fields = {"alpha": alpha, "T": 0 * alpha, "u": np.zeros((len(alpha), 3))}
        write_vtkhdf(path / fields_name(index), grid, fields)
        step = drawn_step(index, SIZE, fields_name(index))
        assert step.measures is not None
        found = tuple(one_section(depth) for depth in DEPTHS)
        Journal(path).append(replace(step, measures=replace(step.measures, cells=found, front=0.5)))
    return open_run(path)


def one_section(depth: float) -> CellSection:
    """Nine equal square cells, one of them inside."""
    return CellSection(
        depth=depth, pixel=(0.01, 0.01), areas=(1 / 9,) * 9, perimeters=(1.0,) * 9, sides=(4,) * 9,
        ends=(0,) + (1,) * 4 + (2,) * 4, junctions={"T": 0, "Y": 0, "X": 4}, cracked=0.1,
    )  # fmt: skip


def planes_of(run: Run) -> list[ColumnPlane]:
    (frame,), _ = read_frames(run)
    return sections.planes_of(run.manifest, frame)


def test_planes_are_cut_where_the_run_looked_for_cells(tmp_path):
    upper, lower = planes_of(columns_run(tmp_path / "run"))
    assert (upper.depth, lower.depth) == DEPTHS
    assert (upper.cells.number, lower.cells.number) == (9, 3)
    inside = upper.cells.ends == 0
    assert upper.cells.sides[inside].tolist() == [4] and not (lower.cells.ends == 0).any()
    assert upper.cells.areas == pytest.approx(np.full(9, 1 / 9), rel=0.05), "a pixel is 0.0125"


def test_planes_are_cut_at_as_many_depths_as_are_given(tmp_path):
    run = columns_run(tmp_path / "run")
    (frame,), _ = read_frames(run)
    depths = [DEPTHS[0] + 0.01 * k for k in range(2 * sections.MOST)]
    found = sections.planes_of(run.manifest, frame, depths)
    assert [plane.depth for plane in found] == depths


def test_planes_are_even_down_to_the_deepest_crack_where_no_depths_were_asked_for(tmp_path):
    run = columns_run(tmp_path / "run")
    (step,) = run.steps
    assert step.measures is not None
    bare = replace(step, measures=replace(step.measures, cells=()))
    found = sections.depths_of(run.manifest, bare)
    assert found == pytest.approx([0.5 / 12 * k for k in (1, 3, 5, 7, 9, 11)])
    assert sections.depths_of(replace(run.manifest, face=None), bare) == []


def test_a_cell_has_the_color_of_the_number_of_its_neighbors(tmp_path):
    upper, _ = planes_of(columns_run(tmp_path / "run"))
    colors = painted(upper)
    n, m = colors.shape[0] // 2, colors.shape[0] // 6
    assert colors[n, n] == pytest.approx(to_rgb(NEIGHBORS[4]))
    assert colors[m, n] == pytest.approx(to_rgb(AT_THE_END))
    wall = colors[2 * m - 2 : 2 * m + 3, n].sum(axis=1).min()
    assert wall < sum(CRACK) + 0.5 < colors[n, n].sum(), "a crack is dark"


def test_what_is_outside_of_a_round_body_is_white(tmp_path):
    upper, _ = planes_of(columns_run(tmp_path / "run", round_body=True))
    colors = painted(upper)
    assert np.isnan(upper.damage[0, 0]) and (colors[0, 0] == 1).all()
    assert np.isfinite(upper.damage).mean() == pytest.approx(np.pi / 4, rel=0.03)


def test_sections_have_a_panel_each_of_equal_size_and_a_legend_of_all_classes(tmp_path):
    run = columns_run(tmp_path / "run")
    figure = sections_figure(run.manifest, run.steps[0], planes_of(run))
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == ["depth 0.1: 9 cells, 1 inside", "depth 0.4: 3 cells, 0 inside"]
    assert {axes.images[0].get_array().shape for axes in figure.axes} == {(80, 80, 3)}
    (legend,) = figure.legends
    said = [text.get_text() for text in legend.get_texts()]
    assert said == ["3 or fewer", "4", "5", "6", "7", "8 or more", "cut by an end of the body"]


def test_sizes_are_drawn_with_their_errors_beside_theory():
    one = pattern([one_section(0.1)])
    known = Estimate(value=0.3, error=0.05)
    found = {
        0.1: replace(one, interior=9, diameter=known, spacing=known),
        0.4: replace(
            one, diameter=Estimate(value=None, error=None), spacing=Estimate(value=0.5, error=None)
        ),
    }
    curve = ReferenceCurve(name="theory", depths=np.array([0.0, 0.4]), lengths=np.array([0.1, 0.8]))
    (axes,) = size_figure(drawn_manifest(SIZE), found, [curve]).axes
    assert axes.lines[0].get_ydata().tolist() == [0.1, 0.8]
    points = [bars.lines[0].get_xydata().tolist() for bars in axes.containers]
    assert points == [[[0.1, 0.3]], [[0.1, 0.3], [0.4, 0.5]]]
    ends = axes.containers[0].lines[2][0].get_segments()[0][:, 1]
    assert ends == pytest.approx([0.25, 0.35])
    assert axes.get_ylim()[1] > 0.8, "the theory ends above the points"
    assert [text.get_text() for text in axes.texts] == ["9"]


def test_theory_takes_the_ell0_of_the_case():
    manifest = drawn_manifest(SIZE, scales={"ell0": 0.01})
    once, twice = sections.doubling(manifest, 0.178)
    assert once.lengths[-1] == pytest.approx(0.32), "the table has 32 at 17.8 ell0"
    assert twice.lengths[-1] == pytest.approx(0.64)
    assert sections.doubling(replace(manifest, scales={}), 0.2) == []


@pytest.mark.slow
def test_the_rock_is_cut_away_and_the_cracks_in_there_are_left_standing(tmp_path):
    cracked = columns_run(tmp_path / "cracked", steps=2)
    files = [cracked.path / fields_name(index) for index in (0, 1)]
    rock, cracks = volume.rendered(cracked.manifest, files, 0.5, (ROCK, CRACKS), pixels=160)
    for row in (rock, cracks):
        assert row.ndim == 4 and len(row) == 2, "the views of one look are alike"
    stone, green = (np.stack([kind(view) for view in rock]) for kind in (is_stone, is_green))
    assert not green[0].any() and green[1].mean() > 0.01, "cracks stand where the rock is cut"
    assert 0.2 < stone[0].mean() < 0.7
    lower_right = np.s_[-stone.shape[1] // 4 :, stone.shape[2] // 2 :]
    assert stone[0][lower_right].mean() < 0.1, "the near quarter is not there"
    alone = [is_green(view) for view in cracks]
    assert not alone[0].any()
    assert alone[1].mean() > 2 * green[1].mean(), "alone, those of all quarters are seen"


def is_stone(image: np.ndarray) -> np.ndarray:
    """Light and warm."""
    red, _, blue = (image[..., k].astype(int) for k in range(3))
    return (blue > 100) & (red - blue > 3)


def is_green(image: np.ndarray) -> np.ndarray:
    """In the middle of the colors of depth."""
    red, green, blue = (image[..., k].astype(int) for k in range(3))
    return (green > 1.3 * red) & (green > blue)


@pytest.mark.slow
def test_a_run_in_three_dimensions_is_drawn_with_its_cells_and_growing(tmp_path, monkeypatch):
    monkeypatch.setattr(volume, "PIXELS", 300)
    monkeypatch.setattr(movie, "PIXELS", 150)
    told = []
    run = columns_run(tmp_path / "run", steps=3)
    drawn = draw(run, told=lambda done, of: told.append((done, of)))
    names = [path.name for path in drawn.pictures]
    expected = ["cracks", "sections", "spacing", "network", "energies", "lengths"]
    assert names == [*(f"{name}.png" for name in expected), "growing.gif"], drawn.skipped
    assert told == [(k, 6) for k in range(1, 7)], "three steps in two views"
    with Image.open(drawn.pictures[-1]) as found:
        assert found.n_frames == 3
        assert found.width == pytest.approx(movie.DPI * 7)
    page = without_scripts(drawn.page.read_text(encoding="utf-8"))
    assert page.count("data:image/png;base64,") == 6 and page.count("data:image/gif;base64,") == 1


def test_a_movie_of_a_body_in_two_dimensions_is_made_if_asked_for(tmp_path, monkeypatch):
    monkeypatch.setattr("staffa.plot.style.DPI", 40)
    monkeypatch.setattr(movie, "DPI", 40)
    monkeypatch.setattr("staffa.report.drawing.MOST", 4)
    run = drawn_run(tmp_path / "run")
    assert "growing.gif" not in [path.name for path in draw(run).pictures]
    (path,) = [path for path in draw(run, movie=True).pictures if path.suffix == ".gif"]
    with Image.open(path) as found:
        assert found.n_frames == 4
    monkeypatch.setattr(movie, "LARGEST", path.stat().st_size - 1)
    draw(run, movie=True)
    with Image.open(path) as found:
        assert found.n_frames == 2, "too large a file loses every other frame"
    assert not list(run.path.rglob("*.staffa-part"))


def test_an_ensemble_has_no_movie(tmp_path, monkeypatch):
    from staffa.cli import commands

    monkeypatch.setattr("staffa.io.ensemble_directory.is_ensemble", lambda directory: True)
    with pytest.raises(InputError, match="one of its members"):
        commands.report(tmp_path, movie=True)

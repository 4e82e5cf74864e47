"""Files of a run hold the computed fields, at the right vertices, at every step."""

import json
from dataclasses import replace
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
import pytest
import pyvista

from report.test_report import SLAB, drawn_manifest, drawn_step
from staffa.errors import InputError, StaffaError
from staffa.io.field_output import FieldWriter
from staffa.io.run_directory import (
    FORMAT,
    MANIFEST,
    STEPS,
    Journal,
    create,
    open_run,
    write_series,
)
from staffa.io.vtkhdf import read_vtkhdf
from staffa.model.domain import block
from staffa.model.fields import at_vertices, linear_spaces, owned, vertices, zero_state
from staffa.records.status import Status

BLOCKS = {
    "quadrilateral": (0.6, 0.4),
    "triangle": (0.6, 0.4),
    "hexahedron": (0.6, 0.4, 0.2),
    "tetrahedron": (0.6, 0.4, 0.2),
}


@pytest.fixture(scope="module", params=BLOCKS)
def written(request, tmp_path_factory) -> tuple[Path, tuple[float, ...]]:
    """A file of a state whose every value tells where it belongs, and the size of its body."""
    cells = request.param
    size = BLOCKS[cells]
    dim = len(size)
    domain = block(MPI.COMM_WORLD, size=size, h=0.1, cells=cells)
    spaces = linear_spaces(domain)
    state = zero_state(spaces)
    x = vertices(spaces.alpha)
    state.u.x.array[:] = (x * [1.0, 2.0, 3.0])[:, :dim].ravel()
    state.alpha.x.array[:] = x[:, 0] / size[0]
    state.T.x.array[:] = -5 * x[:, 1] + 7 * x[:, 0]
    path = tmp_path_factory.mktemp(cells) / "step.vtkhdf"
    writer = FieldWriter(MPI.COMM_WORLD, spaces)
    u = np.pad(at_vertices(state.u, spaces), ((0, 0), (0, 3 - len(size))))
    writer.write(path, {"u": u, "alpha": owned(state.alpha), "T": owned(state.T)})
    assert len(owned(state.alpha)) == len(x), "one rank owns all"
    return path, size


def check_fields(points: np.ndarray, fields, size: tuple[float, ...]) -> None:
    x, y, z = points.T
    expected = {
        "u": np.column_stack([x, 2 * y, 3 * z]),
        "alpha": x / size[0],
        "T": -5 * y + 7 * x,
    }
    assert set(fields.keys()) == set(expected)
    for name, values in expected.items():
        gap = np.abs(np.asarray(fields[name]) - values).max()
        assert gap < 1e-14, f"{name} is off by {gap} at the vertices it is written for"


def test_every_value_is_written_for_its_own_vertex(written) -> None:
    path, size = written
    grid, fields = read_vtkhdf(path)
    assert grid.points.shape[1] == 3 and fields["u"].shape == (len(grid.points), 3)
    check_fields(grid.points, fields, size)


def test_pyvista_reads_the_same_values_and_the_true_size_of_every_cell(written) -> None:
    path, size = written
    mesh = pyvista.read(path)
    mesh = mesh[0] if isinstance(mesh, pyvista.MultiBlock) else mesh
    check_fields(np.asarray(mesh.points), mesh.point_data, size)
    name = "Area" if len(size) == 2 else "Volume"
    sizes = np.abs(mesh.compute_cell_sizes()[name])
    assert sizes.sum() == pytest.approx(np.prod(size), rel=1e-9), f"{sizes.sum()}: cells overlap"
    one = np.prod(size) / mesh.n_cells  # all cells of these blocks are of one size
    assert sizes == pytest.approx(np.full(mesh.n_cells, one), rel=1e-9), "vertices out of order"


def test_a_file_is_there_whole_or_not_at_all(written) -> None:
    path, _ = written
    assert [p.name for p in path.parent.iterdir()] == [path.name], "nothing is left beside it"


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A run directory with five steps, the last one with a file of fields."""
    create(tmp_path / "run", "title = 'drawn'\n", drawn_manifest(SLAB))
    for index in range(5):
        Journal(tmp_path / "run").append(
            drawn_step(index, SLAB, "fields/a" if index == 4 else None)
        )
    return tmp_path / "run"


def test_every_step_that_was_written_is_read_back_as_it_was(run: Path) -> None:
    found = open_run(run)
    expected = tuple(drawn_step(i, SLAB, "fields/a" if i == 4 else None) for i in range(5))
    assert found.steps == expected, f"{len(found.steps)} steps of 5"
    assert found.case == "title = 'drawn'\n" and found.manifest == drawn_manifest(SLAB)
    assert not found.finished, "five of twenty-five"


def test_a_run_is_finished_when_its_last_step_is_there_and_converged(run: Path) -> None:
    manifest = drawn_manifest(SLAB)
    for index in range(5, len(manifest.times)):
        found = open_run(run)
        assert not found.finished and len(found.steps) == index and found.unreached is None
        last = drawn_step(index, SLAB, None)
        Journal(run).append(replace(last, status=Status.NOT_CONVERGED) if index == 24 else last)
    found = open_run(run)
    assert not found.finished and len(found.steps) == 24, "its last step did not converge"
    assert found.unreached == replace(last, status=Status.NOT_CONVERGED)
    assert found.audited == (*found.steps, found.unreached) == found.computed
    lines = (run / STEPS).read_text().splitlines()
    (run / STEPS).write_text("\n".join([*lines[:-1], json.dumps(last.to_record())]) + "\n")
    assert open_run(run).finished


@pytest.mark.parametrize("kept", [1, 20, -1])
def test_only_a_last_line_that_was_cut_short_is_dropped(run: Path, kept: int) -> None:
    text = (run / STEPS).read_text()
    *whole, last = text.splitlines(keepends=True)
    (run / STEPS).write_text("".join(whole) + last[:kept])
    found = open_run(run).steps
    assert [step.index for step in found] == [0, 1, 2, 3], f"{len(found)} steps"


def test_a_run_without_a_step_yet_has_none(run: Path) -> None:
    (run / STEPS).write_text("")
    assert open_run(run).steps == ()
    (run / STEPS).unlink()
    assert open_run(run).steps == ()


@pytest.mark.parametrize("line", [1, 3, 5])
@pytest.mark.parametrize("damage", ['{"index": 1', "{}", "[]", "no JSON", '{"a": 1}'])
def test_a_damaged_line_is_an_error_that_names_it(run: Path, line: int, damage: str) -> None:
    """The fifth too: it ends, so that nothing cut it short."""
    lines = (run / STEPS).read_text().splitlines()
    lines[line - 1] = damage
    (run / STEPS).write_text("\n".join(lines) + "\n")
    with pytest.raises(StaffaError, match=f"steps.jsonl, line {line} is damaged"):
        open_run(run)


def test_a_format_from_the_future_is_refused_with_the_way_out(run: Path) -> None:
    record = json.loads((run / MANIFEST).read_text())
    (run / MANIFEST).write_text(json.dumps(record | {"format": FORMAT + 1, "version": "9.1"}))
    with pytest.raises(InputError, match=rf"format {FORMAT + 1}.*reads {FORMAT}.*wrote it, 9.1"):
        open_run(run)


def test_a_damaged_manifest_is_an_error_that_names_it(run: Path) -> None:
    (run / MANIFEST).write_text((run / MANIFEST).read_text()[:50])
    with pytest.raises(StaffaError, match=r"manifest\.json is damaged"):
        open_run(run)


def test_a_folder_without_a_manifest_is_no_run(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"is no run directory: it has no manifest\.json"):
        open_run(tmp_path)


def test_the_animation_names_every_file_with_its_time(run: Path) -> None:
    write_series(run, [("fields/step-0001.vtkhdf", 0.5), ("fields/step-0004.vtkhdf", 2.0)])
    index = json.loads((run / "fields" / "fields.vtkhdf.series").read_text())
    assert index["files"] == [
        {"name": "step-0001.vtkhdf", "time": 0.5},
        {"name": "step-0004.vtkhdf", "time": 2.0},
    ]

"""Fields of a reservoir's cells on disk: read back, shown by VTK, cut back with their steps."""

import json
from pathlib import Path

import numpy as np
import pytest

from staffa.io.reservoir_fields import cell_mesh, read_reservoir, write_reservoir
from staffa.io.run_directory import create, cut_back, fields_name, write_series
from staffa.io.vtkhdf import write_vtkhdf
from staffa.reservoir.grid import Grid
from support.circulating import manifest, step

X, Y, Z = np.array([0.0, 1.0, 3.0, 6.0]), np.array([-1.0, 0.0, 5.0]), np.array([0.0, 2.0, 3.0])


@pytest.mark.parametrize("edges", [(X, Y), (X, Y, Z)], ids=["2-D", "3-D"])
def test_cells_are_read_back_each_with_its_values(tmp_path: Path, edges) -> None:
    (tmp_path / "fields").mkdir()
    grid = Grid(edges=(X, Y, edges[2] if len(edges) == 3 else np.array([0.0, 1.0])), dim=len(edges))
    T, p, k = (scale * grid.centers @ [1.0, 10.0, 100.0] for scale in (1.0, 2.0, 3.0))
    name = write_reservoir(tmp_path, 7, edges, T=T, p=p, k=k)
    assert name == "fields/reservoir-0007.vtkhdf"
    found = read_reservoir(tmp_path, fields_name(7))
    assert (found.T == T).all() and (found.p == p).all() and (found.k == k).all()
    middles = found.grid.points[found.grid.cells].mean(axis=1)
    assert middles[:, : len(edges)] == pytest.approx(grid.centers[:, : len(edges)])


@pytest.mark.parametrize(("edges", "size"), [((X, Y), 36.0), ((X, Y, Z), 108.0)])
def test_vtk_reads_the_cells_with_their_size_and_values(tmp_path: Path, edges, size) -> None:
    pyvista = pytest.importorskip("pyvista")
    (tmp_path / "fields").mkdir()
    n = int(np.prod([len(axis) - 1 for axis in edges]))
    values = np.arange(n, dtype=float)
    name = write_reservoir(tmp_path, 0, edges, T=values, p=values, k=values)
    mesh = pyvista.read(tmp_path / name)
    measured = mesh.compute_cell_sizes()["Area" if len(edges) == 2 else "Volume"]
    assert measured.sum() == pytest.approx(size) and measured.min() > 0
    assert set(mesh.cell_data) == {"T", "p", "k"} and list(mesh.cell_data["T"]) == list(values)


def test_a_file_of_other_fields_or_none_is_refused(tmp_path: Path) -> None:
    (tmp_path / "fields").mkdir()
    with pytest.raises(ValueError, match="No such file"):
        read_reservoir(tmp_path, fields_name(1))
    n = np.zeros(6)
    path = tmp_path / "fields" / "reservoir-0001.vtkhdf"
    write_vtkhdf(path, cell_mesh((X, Y)), {}, {"T": n, "p": n})
    with pytest.raises(KeyError, match="k"):
        read_reservoir(tmp_path, fields_name(1))
    write_vtkhdf(path, cell_mesh((X, Y)), {}, {"T": np.zeros((6, 2)), "p": n, "k": n})
    with pytest.raises(ValueError, match="one value in each cell"):
        read_reservoir(tmp_path, fields_name(1))


def names(folder: Path, series: str) -> list[str]:
    index = json.loads((folder / "fields" / series).read_text())
    return [file["name"] for file in index["files"]]


def test_files_of_the_reservoir_have_an_index_and_go_with_their_steps(tmp_path: Path) -> None:
    create(tmp_path, "", manifest([1.0, 2.0, 3.0]))
    values = np.zeros(6)
    steps = [step(n, n + 1.0, None, fields=fields_name(n)) for n in range(3)]
    for n in range(3):
        (tmp_path / fields_name(n)).touch()
        write_reservoir(tmp_path, n, (X, Y), T=values, p=values, k=values)
    write_series(tmp_path, [(fields_name(n), n + 1.0) for n in range(3)])
    assert names(tmp_path, "reservoir.vtkhdf.series") == [
        f"reservoir-000{n}.vtkhdf" for n in range(3)
    ]
    cut_back(tmp_path, [], steps[:1])
    left = sorted(file.name for file in (tmp_path / "fields").glob("*.vtkhdf"))
    assert left == ["reservoir-0000.vtkhdf", "step-0000.vtkhdf"]
    assert names(tmp_path, "reservoir.vtkhdf.series") == ["reservoir-0000.vtkhdf"]
    assert names(tmp_path, "fields.vtkhdf.series") == ["step-0000.vtkhdf"]
    cut_back(tmp_path, [], [])
    assert not (tmp_path / "fields" / "reservoir.vtkhdf.series").exists()


def test_a_run_without_a_reservoir_has_one_index(tmp_path: Path) -> None:
    create(tmp_path, "", manifest([1.0], reservoir=None))
    write_series(tmp_path, [(fields_name(0), 1.0)])
    assert [file.name for file in (tmp_path / "fields").iterdir()] == ["fields.vtkhdf.series"]

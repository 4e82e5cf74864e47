"""Temperature and pressure of another simulator, from files: their values in space and time."""

import pickle
from pathlib import Path

import numpy as np
import pytest
import pyvista

import staffa
from fem.test_own import refusal, slab
from staffa.errors import InputError, LoadError
from staffa.io.run_directory import open_run
from staffa.properties.field_series import FieldSeries, read_series
from staffa.properties.mesh_field import Counting, read_field
from staffa.runs.run import Watcher
from support.restarting import After, assert_same, stopped

# Temperatures that are linear in space, so that any interpolation between points is exact.
TIMES = (0.0, 10.0, 40.0)
X = np.array([[0.1, 0.55, 0.93, 0.4], [0.2, 0.11, 0.4, 0.03], [0.0, 0.0, 0.0, 0.0]])


def T(x, k: int):
    return 300.0 - 10 * k * (1 + x[1] - 0.5 * x[0])


def p(x, k: int):
    return 1e6 * (k + x[0])


def grid(h: float = 0.1) -> pyvista.ImageData:
    """A plate of 1 by 0.5."""
    return pyvista.ImageData(
        dimensions=(round(1 / h) + 1, round(0.5 / h) + 1, 1), spacing=(h, h, 1)
    )


def vtu(folder: Path, k: int, h: float = 0.1) -> Path:
    mesh = grid(h).cast_to_unstructured_grid()
    mesh.point_data["temperature"] = T(mesh.points.T, k)
    mesh.point_data["pressure"] = p(mesh.points.T, k)
    mesh.save(folder / f"flow-{k}.vtu")
    return folder / f"flow-{k}.vtu"


def vtkhdf(folder: Path, k: int) -> Path:
    from staffa.io.vtkhdf import VtkMesh, write_vtkhdf

    mesh = grid().cast_to_unstructured_grid()
    cells = np.array(mesh.cells).reshape(-1, 5)[:, 1:]
    points = np.array(mesh.points, dtype=float)
    path = folder / f"flow-{k}.vtkhdf"
    fields = {"temperature": T(points.T, k), "pressure": p(points.T, k)}
    kind = int(np.unique(mesh.celltypes)[0])
    write_vtkhdf(path, VtkMesh(points=points, cells=cells, type=kind), fields, {})
    return path


def csv(folder: Path, k: int, head: str = "x,y,temperature,pressure") -> Path:
    points = np.array(grid().points, dtype=float).T
    rows = np.column_stack([points[0], points[1], T(points, k), p(points, k)])
    np.savetxt(folder / f"flow-{k}.csv", rows, delimiter=",", header=head, comments="")
    return folder / f"flow-{k}.csv"


def series(folder: Path, write=vtu, **more) -> FieldSeries:
    files = [write(folder, k) for k in range(3)]
    return read_series(files, TIMES, T="temperature", p="pressure", **more)


@pytest.mark.parametrize("write", [vtu, vtkhdf, csv])
def test_values_are_those_of_the_files_and_linear_in_time(write, tmp_path: Path) -> None:
    known = series(tmp_path, write)
    for k, time in enumerate(TIMES):
        assert known.absolute(X, time) == pytest.approx(T(X, k), rel=1e-6)
        assert known.temperature(X, time) == pytest.approx(T(X, k) - 300, abs=1e-4)
        assert known.pressure(X, time) == pytest.approx(p(X, k), rel=1e-6)
    between = 0.75 * T(X, 1) + 0.25 * T(X, 2)
    assert known.absolute(X, 17.5) == pytest.approx(between, rel=1e-6)
    assert known.pressure(X, 5.0) == pytest.approx((p(X, 0) + p(X, 1)) / 2, rel=1e-6)
    assert known.absolute(X[:, :0], 5.0).shape == (0,), "a rank may hold no point"


def test_it_is_sent_to_other_ranks_as_it_is(tmp_path: Path) -> None:
    known = series(tmp_path)
    sent = pickle.loads(pickle.dumps(known))
    assert np.array_equal(sent.temperature(X, 17.5), known.temperature(X, 17.5))
    assert sent == known and sent.identity == known.identity
    assert sent.paths == tuple(tmp_path / f"flow-{k}.vtu" for k in range(3))
    assert known.T[0].points is known.T[2].points, "one mesh is kept once"


def test_meshes_of_the_times_may_differ(tmp_path: Path) -> None:
    files = [vtu(tmp_path, 0, 0.1), vtu(tmp_path, 1, 0.05)]
    known = read_series(files, (0.0, 1.0), T="temperature")
    assert known.pressure is None
    assert known.absolute(X, 0.5) == pytest.approx((T(X, 0) + T(X, 1)) / 2, rel=1e-6)


def test_the_change_counts_from_the_first_time_or_from_what_is_given(tmp_path: Path) -> None:
    free = series(tmp_path, reference=lambda x: np.full(x.shape[1], 310.0))
    assert free.temperature(X, 0.0) == pytest.approx(-10.0, abs=1e-4)
    celsius = Counting(zero=273.15, one=274.15)
    warm = read_series([vtu(tmp_path, 0)], (0.0,), T="temperature", T_counts=celsius)
    assert warm.absolute(X, 0.0) == pytest.approx(573.15, rel=1e-6)
    assert warm.temperature(X, 0.0) == pytest.approx(0.0)


@pytest.mark.parametrize("time", [-1.0, 40.1])
def test_times_beyond_the_files_are_refused(time: float, tmp_path: Path) -> None:
    known = series(tmp_path)
    with pytest.raises(LoadError, match=r"no temperature is known at t = .*from 0 s to 40 s; keep"):
        known.temperature(X, time)
    with pytest.raises(LoadError, match="no pressure is known"):
        known.pressure(X, time)


def test_points_beyond_a_mesh_are_refused_unless_they_are_near(tmp_path: Path) -> None:
    known, x = series(tmp_path), np.array([[0.5, 1.05], [0.2, 0.2], [0.0, 0.0]])
    assert list(known.reaches(x)) == [True, False]
    said = refusal(lambda: known.temperature(x, 10.0))
    assert "flow-" in said and "does not reach (1.05, 0.2, 0)" in said and "(1, 0.5, 0)" in said
    near = known.reaching(0.1)
    assert near.reaches(x).all()
    assert near.absolute(x, 10.0)[1] == pytest.approx(290 - 10 * (0.2 - 0.5), rel=1e-6)


def bad(folder: Path, text: str) -> Path:
    (folder / "bad.csv").write_text(text)
    return folder / "bad.csv"


SQUARE = "x,y,temperature\n0,0,300\n1,0,300\n0,1,300\n1,1,300\n"
BAD = {
    "no header": (SQUARE.replace("x,y,temperature\n", ""), "is no table of points"),
    "no x": (SQUARE.replace("x,y", "r,y"), "has no columns x and y"),
    "a text": (SQUARE.replace("1,1,300", "1,1,hot"), "is no table of points"),
    "a short line": (SQUARE.replace("1,1,300", "1,1"), "is no table of points"),
    "empty": ("", "is no table of points"),
    "a name twice": (SQUARE.replace("temperature", "x"), "is no table of points"),
    "a line": (SQUARE.replace("0,1,", "2,0,").replace("1,1,", "3,0,"), "lie on a line"),
    "no place": (SQUARE.replace("1,1,300", "nan,1,300"), "a coordinate is not finite"),
    "no field": (SQUARE.replace("temperature", "T"), "has no field 'temperature'; it has T."),
    "no number": (SQUARE.replace("1,1,300", "1,1,nan"), "is not finite everywhere"),
    "too cold": (SQUARE.replace("1,1,300", "1,1,-3"), "below absolute zero"),
}


@pytest.mark.parametrize("fault", BAD)
def test_bad_tables_are_refused_by_their_name(fault: str, tmp_path: Path) -> None:
    text, rule = BAD[fault]
    with pytest.raises(InputError) as caught:
        read_series([bad(tmp_path, text)], (0.0,), T="temperature")
    assert rule in str(caught.value) and "bad.csv" in str(caught.value), caught.value


def test_times_and_files_that_do_not_fit_are_refused(tmp_path: Path) -> None:
    file = vtu(tmp_path, 0)
    for files, t, rule in (
        ([], (), "0 numbers"),
        ([file], (0.0, 1.0), "as many of each"),
        ([file, file], (1.0, 0.0), "increasing order"),
        ([file, file], (0.0, np.nan), "not finite"),
        ([tmp_path / "flow.pvd"], (0.0,), "is none of .vtu"),
        ([tmp_path / "none.vtu"], (0.0,), "there is no file"),
    ):
        with pytest.raises(InputError, match=rule):
            read_series(files, t, T="temperature")


def test_a_table_of_paraview_is_read_in_three_dimensions(tmp_path: Path) -> None:
    axis = np.linspace(0, 1, 4)
    x = np.array(np.meshgrid(axis, 2 * axis, 3 * axis)).reshape(3, -1)
    head = '"T","Points:0","Points:1","Points:2"'
    rows = np.column_stack([x[0] + x[1] - x[2], *x])
    np.savetxt(tmp_path / "3d.csv", rows, delimiter=",", header=head, comments="")
    known = read_field(tmp_path / "3d.csv", "T")
    inside = np.random.default_rng(1).uniform(0.02, 0.98, (3, 40)) * [[1], [2], [3]]
    assert known(inside) == pytest.approx(inside[0] + inside[1] - inside[2], abs=1e-6)


def test_a_run_is_driven_by_files_and_goes_on_with_the_same_alone(tmp_path: Path) -> None:
    """The plate of the files, cooled as they say, in place of the case's cooling."""
    files = [csv(tmp_path, k) for k in range(3)]
    known = read_series(files, (0.0, 0.02, 0.2), T="temperature")
    staffa.run(slab(), tmp_path / "whole", temperature=known)

    def cut() -> None:
        staffa.run(slab(), tmp_path / "cut", temperature=known, watcher=Watcher(stop=After(3)))

    stopped(cut)
    other = read_series(files[:2], (0.0, 0.2), T="temperature")
    assert "fields of 2 times" in refusal(
        lambda: staffa.resume(tmp_path / "cut", temperature=other)
    )
    staffa.resume(tmp_path / "cut", temperature=known)
    assert_same(open_run(tmp_path / "cut"), open_run(tmp_path / "whole"))
    assert open_run(tmp_path / "whole").steps[-1].energies.elastic > 0


WELL = """
[domain]
size = ["80 m", "80 m"]
h = "1 m"
[material]
E = "40 GPa"
Gc = "100 J/m^2"
expansion = "8e-6 1/K"
k = "2.5 W/(m K)"
rho = "2700 kg/m^3"
c = "850 J/(kg K)"
[damage]
ell = "3 m"
[temperature]
profile = "reservoir"
[reservoir]
simulator = "fields"
fields = { t = ["0 s", "1 d"], files = ["a.vtu", "b.vtu"], T = "temperature" }
[supports]
left = "rollers"
bottom = "rollers"
[time]
t = ["1 d"]
"""


def test_a_hole_in_the_mesh_of_a_file_is_refused_before_the_run(tmp_path: Path) -> None:
    """That of a well, between the places at which a case is looked at as it is read."""
    whole = pyvista.ImageData(dimensions=(161, 161, 1), spacing=(0.5, 0.5, 1.0))
    whole.point_data["temperature"] = np.full(whole.n_points, 400.0)
    off = np.abs(whole.cell_centers().points[:, :2] - 42.0).max(axis=1)
    for name, least in (("a.vtu", 0.0), ("b.vtu", 1.5)):
        whole.extract_cells(np.flatnonzero(off >= least)).save(tmp_path / name)
    (tmp_path / "my.toml").write_text(WELL)
    case = staffa.read_case(tmp_path / "my.toml")
    said = refusal(lambda: staffa.problem(case))
    assert "reservoir.fields: the mesh of a file does not reach every vertex" in said

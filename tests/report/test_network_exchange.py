"""Networks for other programs: GeoJSON by RFC 7946 in 2-D, planar polygons in 3-D."""

import csv
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import pyvista

from report.test_report import drawn_manifest, drawn_step
from staffa.io.run_directory import Run
from staffa.measure.network import Network, polylines
from staffa.measure.planar_polygons import planar_polygons
from staffa.results.network_exchange import write_outline, write_polygons, write_traces
from support.paths import DOCS

# A fork of three branches, and a crack apart from it: points, segments, openings (m).
POINTS = [(0.5, 0.0), (0.5, 0.3), (0.3, 0.6), (0.7, 0.6), (1.2, 0.0), (1.2, 0.2), (1.2, 0.4)]
SEGMENTS = [(0, 1), (1, 2), (1, 3), (4, 5), (5, 6)]
OPENINGS = [4e-4, 2e-4, 0.0, 0.0, 3e-4, 2e-4, 0.0]


def plane_network(**more: Any) -> Network:
    return Network(
        points=np.column_stack([np.array(POINTS), np.zeros(len(POINTS))]),
        elements=np.array(SEGMENTS),
        damage=np.ones(len(POINTS)),
        opening=np.array(OPENINGS),
        uncertainty=np.full(len(POINTS), 1e-5),
        **more,
    )


def drawn_run(path: Path, size: tuple[float, ...]) -> Run:
    return Run(path=path, case="", manifest=drawn_manifest(size), steps=())


def positions(coordinates: Any) -> list[list[float]]:
    if isinstance(coordinates[0], float):
        return [coordinates]
    return [position for inner in coordinates for position in positions(inner)]


def geojson(file: Path) -> dict[str, Any]:
    """Read a file, and require what RFC 7946 does of collections, features, lines and polygons."""
    found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
    assert found["type"] == "FeatureCollection" and isinstance(found["features"], list)
    reserved = {"coordinates", "geometries", "geometry", "properties"}
    assert not reserved & set(found), "section 7.1: no member of another kind"
    for feature in found["features"]:
        assert feature["type"] == "Feature" and isinstance(feature["properties"], dict)
        geometry = feature["geometry"]
        assert all(len(position) == 2 for position in positions(geometry["coordinates"]))
        if geometry["type"] == "LineString":
            assert len(geometry["coordinates"]) >= 2
            continue
        assert geometry["type"] == "Polygon"
        for number, ring in enumerate(geometry["coordinates"]):
            assert len(ring) >= 4 and ring[0] == ring[-1]
            x, y = np.array(ring).T
            area = np.sum(x[:-1] * y[1:] - x[1:] * y[:-1]) / 2
            assert (area > 0) == (number == 0), "counterclockwise outside, clockwise in holes"
    return found


def test_each_branch_is_a_line_with_its_length_and_opening(tmp_path: Path) -> None:
    size, cracks = (2.0, 1.0), plane_network()
    step = drawn_step(4, size, None)
    found = geojson(write_traces(tmp_path / "x.geojson", drawn_run(tmp_path, size), step, cracks))
    lines = [feature["properties"] for feature in found["features"]]
    assert len(lines) == len(polylines(cracks)) == 4
    assert sum(line["length"] for line in lines) == pytest.approx(cracks.size)
    volume = sum(line["length"] * line["opening"] for line in lines)
    assert volume == pytest.approx(cracks.volume)
    assert {(line["step"], line["time"]) for line in lines} == {(4, step.time)}
    assert sorted(line["crack"] for line in lines) == [0, 0, 0, 1]
    for feature in found["features"]:
        way = np.array(feature["geometry"]["coordinates"])
        length = np.linalg.norm(np.diff(way, axis=0), axis=1).sum()
        assert length == pytest.approx(feature["properties"]["length"])
    assert "neither longitude and latitude" in found["coordinate_system"] and found["crs"] is None


def test_an_unknown_opening_is_null_and_a_ring_counts_by_its_area(tmp_path: Path) -> None:
    unknown = Network(
        points=plane_network().points,
        elements=np.array(SEGMENTS),
        damage=np.ones(len(POINTS)),
        opening=np.full(len(POINTS), np.nan),
        uncertainty=np.full(len(POINTS), np.nan),
        axial=True,
    )
    size = (2.0, 1.0)
    file = write_traces(
        tmp_path / "x.geojson", drawn_run(tmp_path, size), drawn_step(1, size, None), unknown
    )
    lines = [feature["properties"] for feature in geojson(file)["features"]]
    assert all(line["opening"] is None for line in lines)
    assert sum(line["area"] for line in lines) == pytest.approx(unknown.size)


def sides(*rings: list[tuple[float, float]]) -> np.ndarray:
    """Sides of rings, each in two parts, in any order and direction."""
    found = []
    for ring in rings:
        for a, b in zip(np.array(ring), np.roll(ring, -1, axis=0), strict=True):
            found += [[a, (a + b) / 2], [b, (a + b) / 2]]
    return np.random.default_rng(1).permutation(np.array(found))


def test_the_body_is_a_polygon_with_its_holes(tmp_path: Path) -> None:
    outer = [(0.0, 0.0), (2.0, 0.0), (2.0, 1.0), (0.0, 1.0)]
    hole = [(0.5, 0.5), (0.7, 0.5), (0.6, 0.8)]
    run = drawn_run(tmp_path, (2.0, 1.0))
    found = geojson(write_outline(tmp_path / "body.geojson", run, sides(hole, outer)))
    (body,) = found["features"]
    first, second = body["geometry"]["coordinates"]
    assert sorted(map(tuple, first[:-1])) == sorted(outer)
    assert sorted(map(tuple, second[:-1])) == sorted(hole)


def sheet(n: int, bend: float) -> Network:
    """A sheet of 2 x 1 that turns by an angle (degrees) at 1.2, with an opening of 2 mm."""
    x, y = np.meshgrid(np.linspace(0, 2, 2 * n + 1), np.linspace(0, 1, n + 1), indexing="ij")
    i = np.arange(x.size).reshape(x.shape)
    a, b, c, d = (k.ravel() for k in (i[:-1, :-1], i[1:, :-1], i[1:, 1:], i[:-1, 1:]))
    beyond = np.maximum(x.ravel() - 1.2, 0)
    angle = np.radians(bend)
    points = np.column_stack(
        [np.minimum(x.ravel(), 1.2) + np.cos(angle) * beyond, y.ravel(), np.sin(angle) * beyond]
    )
    elements = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    count = len(points)
    return Network(
        points=points,
        elements=elements,
        damage=np.ones(count),
        opening=np.full(count, 2e-3),
        uncertainty=np.full(count, 1e-4),
    )


@pytest.mark.parametrize("bend", [50.0, 90.0])
def test_a_bent_crack_becomes_two_polygons(bend: float) -> None:
    one, other = planar_polygons(sheet(10, bend), least=1e-3)
    for polygon, area, angle in ((one, 1.2, 0.0), (other, 0.8, bend)):
        assert polygon.area == pytest.approx(area) == polygon.polygon_area
        normal = [-np.sin(np.radians(angle)), 0.0, np.cos(np.radians(angle))]
        assert abs(polygon.normal @ normal) == pytest.approx(1.0)
        assert polygon.normal[np.argmax(np.abs(polygon.normal))] > 0
        assert len(polygon.corners) == 4 and polygon.flatness == pytest.approx(0.0, abs=1e-9)
        assert (polygon.aperture, polygon.uncertainty) == pytest.approx((2e-3, 1e-4))
        away = (polygon.corners - polygon.center) @ polygon.normal
        assert away == pytest.approx(np.zeros(4), abs=1e-9), "a corner outside of the plane"


def test_a_curved_crack_is_less_flat_and_keeps_its_area() -> None:
    """A spherical cap of radius 1 with half an angle of 20 degrees stays one part."""
    flat = sheet(40, 0.0)
    places = (flat.points[:, :2] - [1.0, 0.5]) * [0.3, 0.6]
    cap = Network(
        points=np.column_stack([places, np.sqrt(1 - (places**2).sum(axis=1))]),
        elements=flat.elements,
        damage=flat.damage,
        opening=flat.opening,
        uncertainty=flat.uncertainty,
    )
    (polygon,) = planar_polygons(cap, least=1e-3)
    assert polygon.area == pytest.approx(cap.size)
    assert polygon.polygon_area == pytest.approx(0.36, rel=0.03)
    height = cap.points[cap.elements].mean(axis=1)[:, 2]
    spread = np.sqrt(np.average((height - np.average(height, weights=cap.sizes)) ** 2,
                                weights=cap.sizes))  # fmt: skip
    assert polygon.flatness == pytest.approx(spread, rel=0.02)


def test_the_files_of_polygons_have_the_same_polygons(tmp_path: Path) -> None:
    size, cracks = (2.0, 1.0, 1.0), sheet(10, 90.0)
    run = drawn_run(tmp_path, size)
    vtp, table, corners = write_polygons(tmp_path, run, drawn_step(2, size, None), cracks)
    shapes = pyvista.read(vtp)
    assert shapes.n_cells == 2
    assert shapes.compute_cell_sizes()["Area"] == pytest.approx(np.array([1.2, 0.8]))
    assert np.asarray(shapes["aperture"]) == pytest.approx(2e-3)
    with table.open() as file:
        rows = list(csv.DictReader(file))
    assert [float(row["area"]) for row in rows] == pytest.approx([1.2, 0.8])
    lines = [line for line in corners.read_text().splitlines() if not line.startswith("#")]
    box, *polygons = ([float(number) for number in line.split(",")] for line in lines)
    assert box == [0.0, 0.0, 0.0, *size]
    assert [len(polygon) // 3 for polygon in polygons] == [int(row["corners"]) for row in rows]
    for polygon, cell in zip(polygons, shapes.cell, strict=True):
        assert np.reshape(polygon, (-1, 3)) == pytest.approx(np.asarray(cell.points), abs=1e-6)


def test_the_file_for_dfnworks_has_the_polygons_about_the_middle(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its documentation: "nPolygons: 13", then "5 {x1, y1, z1} {x2, y2, z2} ..." a line."""
    size, folder = (2.0, 1.0, 1.0), tmp_path / "runs" / "my" / "network"
    folder.mkdir(parents=True)
    run = drawn_run(tmp_path / "run", size)
    *_, corners = write_polygons(folder, run, drawn_step(4, size, None), sheet(10, 90.0))
    page = (DOCS / "how-to" / "networks.md").read_text(encoding="utf-8")
    (script,) = re.findall(r"```python\n(import csv.*?)```", page, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    exec(script, {})
    head, *lines = (folder / "polygons.dat").read_text().splitlines()
    known = [line for line in corners.read_text().splitlines() if not line.startswith("#")][1:]
    assert head == f"nPolygons: {len(known)}"
    for line, row in zip(lines, known, strict=True):
        count, rest = line.split(" ", 1)
        places = [list(map(float, one.split(","))) for one in re.findall(r"{(.*?)}", rest)]
        assert len(places) == int(count)
        expected = np.reshape(list(map(float, row.split(","))), (-1, 3)) - np.array(size) / 2
        assert np.array(places) == pytest.approx(expected)


def test_no_crack_gives_files_without_a_polygon(tmp_path: Path) -> None:
    size, none = (2.0, 1.0, 1.0), np.zeros(0)
    empty = Network(points=np.zeros((0, 3)), elements=np.zeros((0, 3), dtype=int), damage=none,
                    opening=none, uncertainty=none)  # fmt: skip
    vtp, table, corners = write_polygons(
        tmp_path, drawn_run(tmp_path, size), drawn_step(2, size, None), empty
    )
    assert pyvista.read(vtp).n_cells == 0
    assert len(table.read_text().splitlines()) == 1
    assert len(corners.read_text().splitlines()) == 2

"""Crack networks for programs of fractures: GeoJSON of traces in 2-D, polygons in 3-D."""

import json
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from staffa.io.network_files import write_vtp
from staffa.io.own_files import write_aside
from staffa.io.run_directory import Run
from staffa.measure.network import Network, polylines
from staffa.measure.planar_polygons import Polygon, planar_polygons
from staffa.records.step import Step
from staffa.results.tables import Column, Table

LOCAL = "local: x and y of the case; neither longitude and latitude nor of any map"
LOCAL_AXIAL = "local: radius r from the axis and height y of the case, in the meridian plane"
LEAST = 1.0  # parts of cracks smaller than this times ell^2 make no polygon


def write_traces(path: Path, run: Run, step: Step, cracks: Network) -> Path:
    """Write the branches of a 2-D network as lines of GeoJSON (RFC 7946), and return the file.

    Parameters
    ----------
    path : the file.
    run : run of the network.
    step : record of its step.
    cracks : the network.
    """
    return _write_geojson(path, run, list(_traces(step, cracks)))


def write_outline(path: Path, run: Run, outline: np.ndarray) -> Path:
    """Write the area of a 2-D body, on which its traces lie, as a polygon of GeoJSON.

    Parameters
    ----------
    path : the file.
    run : run of the body.
    outline : sides of the body (m), shape (k, 2, 2).
    """
    rings = sorted(_rings(outline), key=lambda ring: -abs(_signed_area(ring)))
    turned = [
        ring if (_signed_area(ring) > 0) == (k == 0) else ring[::-1] for k, ring in enumerate(rings)
    ]
    coordinates = [[*ring.tolist(), ring[0].tolist()] for ring in turned]
    return _write_geojson(path, run, [_feature("Polygon", coordinates, {"name": "body"})])


def _write_geojson(path: Path, run: Run, features: list[dict[str, Any]]) -> Path:
    scaled, axial = run.manifest.scaled, run.manifest.axial
    units = {} if scaled else {"length": "m", "opening": "m", "uncertainty": "m", "time": "s"}
    if axial and not scaled:
        units = {**units, "area": "m^2"}
    content = {
        "type": "FeatureCollection",
        "name": path.stem,
        "coordinate_system": LOCAL_AXIAL if axial else LOCAL,
        "units": units or "scaled: lengths over L",
        "crs": None,  # of GeoJSON before RFC 7946, which GIS read: no system is known
        "features": features,
    }
    write_aside(path, json.dumps(content, indent=1) + "\n")
    return path


def _traces(step: Step, cracks: Network) -> Iterator[dict[str, Any]]:
    """Yield a line for each branch, in the order of `polylines`."""
    opening, unknown = (
        cracks.sizes * values[cracks.elements].mean(axis=1)
        for values in (cracks.opening, cracks.uncertainty)
    )
    for branch, line in enumerate(polylines(cracks)):
        members = cracks.branches == branch
        size = float(cracks.sizes[members].sum())
        yield _feature(
            "LineString",
            cracks.points[line, :2].tolist(),
            {
                "step": step.index,
                "time": step.time,
                "tau": step.tau,
                "crack": int(cracks.cracks[members][0]),
                "branch": branch,
                "area" if cracks.axial else "length": size,
                "opening": _known(opening[members].sum(), size),
                "uncertainty": _known(unknown[members].sum(), size),
            },
        )


def _known(volume: float, size: float) -> float | None:
    """Return a mean; None where there is none."""
    mean = float(volume) / size if size else np.nan
    return mean if np.isfinite(mean) else None


def _feature(kind: str, coordinates: list[Any], properties: dict[str, Any]) -> dict[str, Any]:
    return {
        "type": "Feature",
        "geometry": {"type": kind, "coordinates": coordinates},
        "properties": properties,
    }


def _rings(outline: np.ndarray) -> list[np.ndarray]:
    """Return the closed lines of a set of sides (k, 2, 2), without corners on straight lines."""
    points, sides = np.unique(outline.reshape(-1, 2), axis=0, return_inverse=True)
    sides = sides.reshape(-1, 2)
    network = Network(
        points=np.column_stack([points, np.zeros(len(points))]),
        elements=sides,
        damage=np.zeros(len(points)),
    )
    return [_cornered(points[line[:-1]]) for line in polylines(network) if line[0] == line[-1]]


def _cornered(ring: np.ndarray) -> np.ndarray:
    before, after = ring - np.roll(ring, 1, axis=0), np.roll(ring, -1, axis=0) - ring
    turn = np.abs(before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0])
    bent = turn > 1e-9 * np.linalg.norm(before, axis=1) * np.linalg.norm(after, axis=1)
    return np.asarray(ring[bent])


def _signed_area(ring: np.ndarray) -> float:
    """Return the area within a ring (n, 2), positive if it goes counterclockwise."""
    x, y = ring.T
    return float((x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)


def write_polygons(folder: Path, run: Run, step: Step, cracks: Network) -> list[Path]:
    """Write planar polygons of a 3-D network in three forms, and return the files.

    `polygons-NNNN.vtp` and `.csv` have them with their properties; `polygon-corners-NNNN.csv` has
    a line of coordinates (m) each, below one of the box around the body, as PorePy reads.

    Parameters
    ----------
    folder : folder of the files.
    run : run of the network.
    step : record of its step.
    cracks : the network.
    """
    found = planar_polygons(cracks, least=LEAST * run.manifest.ell**2)
    shapes, table = folder / f"polygons-{step.index:04d}.vtp", _table(run, found).csv()
    corners = folder / f"polygon-corners-{step.index:04d}.csv"
    numbers = np.cumsum([0, *(len(polygon.corners) for polygon in found)])
    names = ("area", "aperture", "uncertainty", "flatness")
    on_cells = {name: np.array([getattr(polygon, name) for polygon in found]) for name in names}
    if found:
        on_cells["crack"] = np.array([polygon.crack for polygon in found])
        on_cells["normal"] = np.array([polygon.normal for polygon in found])
    write_vtp(
        shapes,
        np.concatenate([np.zeros((0, 3)), *(polygon.corners for polygon in found)]),
        [np.arange(a, b) for a, b in pairwise(numbers.tolist())],
        surface=True,
        at_points={},
        on_cells=on_cells,
    )
    write_aside(shapes.with_suffix(".csv"), table)
    write_aside(corners, _corner_lines(run, found))
    return [shapes, shapes.with_suffix(".csv"), corners]


def _corner_lines(run: Run, found: list[Polygon]) -> str:
    unit = "scaled lengths" if run.manifest.scaled else "m"
    upper = np.add(run.manifest.lower or (0.0, 0.0, 0.0), run.manifest.size)
    box = [*(run.manifest.lower or (0.0, 0.0, 0.0)), *upper.tolist()]
    lines = [f"# box around the body, then the corners of each polygon: x, y, z and so on ({unit})"]
    lines += [
        ",".join(map(repr, row)) for row in (box, *(p.corners.ravel().tolist() for p in found))
    ]
    return "\n".join(lines) + "\n"


def _table(run: Run, found: list[Polygon]) -> Table:
    """Return the polygons as a table, a row each, in the order of the other files."""
    shown = run.manifest.shown
    columns = (
        Column(name="crack"),
        *(Column(name=axis, unit=shown.length) for axis in "xyz"),
        *(Column(name=f"n{axis}") for axis in "xyz"),
        Column(name="area", unit=shown.crack),
        Column(name="polygon_area", unit=shown.crack),
        Column(name="flatness", unit=shown.length),
        Column(name="aperture", unit=shown.opening),
        Column(name="uncertainty", unit=shown.opening),
        Column(name="corners"),
    )
    rows = tuple(
        (
            p.crack, *p.center.tolist(), *p.normal.tolist(), p.area, p.polygon_area, p.flatness,
            p.aperture, p.uncertainty, len(p.corners),
        )
        for p in found
    )  # fmt: skip
    return Table(columns=columns, rows=rows)

"""Cracks of a 3-D body as a surface that a reader can turn."""

from html import escape

import numpy as np
from matplotlib.colors import to_hex

from staffa.measure.network import Network
from staffa.plot.cracks import extent
from staffa.plot.labels import moment
from staffa.plot.network_openings import COLORS, UNKNOWN, mean_opening
from staffa.records.manifest import Manifest
from staffa.records.step import Step
from staffa.report.charts import Chart, rounded

FINEST = 90  # boxes along the longest edge of the body, in each of which vertices become one
SHADES = 9  # of the color scale


def turnable(manifest: Manifest, step: Step, cracks: Network) -> Chart:
    """Return the cracks as a surface of some thousand triangles in the colors of their opening.

    Parameters
    ----------
    manifest : description of the run.
    step : the step.
    cracks : its crack network, of triangles.
    """
    of, unit = manifest.shown.length, manifest.shown.opening
    points, triangles, values = simplified(
        of.of(cracks.points), cracks.elements, mean_opening(manifest, cracks),
        edge=of.of(max(manifest.size)) / FINEST,
    )  # fmt: skip
    x, y, z = (rounded(line) for line in points.T)
    i, j, k = triangles.T.tolist()
    ends = extent(manifest)
    return {
        "data": [
            {
                "type": "mesh3d", "x": x, "y": y, "z": z, "i": i, "j": j, "k": k,
                "flatshading": True, "lighting": {"ambient": 0.75, "diffuse": 0.4},
                **_colors(values, unit.label("opening")), **_hover(manifest),
            },
            _edges(ends),
        ],
        "layout": {
            "title": {"text": escape(moment(manifest, step), quote=False)},
            "scene": {
                "aspectmode": "data", "camera": {"eye": {"x": 1.5, "y": 1.7, "z": 1.2}},
                **{
                    f"{name}axis": {
                        "title": {"text": escape(of.label(name), quote=False)}, "range": list(end),
                    }
                    for name, end in zip("xyz", ends, strict=True)
                },
            },
        },
    }  # fmt: skip


def simplified(
    points: np.ndarray, triangles: np.ndarray, values: np.ndarray, *, edge: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return a surface whose vertices within each box of a grid are one, at their mean.

    Parameters
    ----------
    points : vertices, shape (n, 3).
    triangles : indices of vertices, shape (m, 3).
    values : value of each triangle, shape (m,).
    edge : edge of the boxes.

    Returns
    -------
    tuple of ndarray
        Vertices, triangles of three different ones, and their values; each triangle once.
    """
    boxes = np.floor((points - points.min(axis=0)) / edge).astype(np.int64)
    _, box, counts = np.unique(boxes, axis=0, return_inverse=True, return_counts=True)
    box = box.ravel()
    means = np.column_stack([np.bincount(box, line) / counts for line in points.T])
    found = box[triangles]
    _, first = np.unique(np.sort(found, axis=1), axis=0, return_index=True)
    a, b, c = found[first].T
    kept = first[(a != b) & (b != c) & (a != c)]
    return means, found[kept], values[kept]


def _colors(values: np.ndarray, label: str) -> Chart:
    """Return the colors of triangles by their opening, gray where no opening is known.

    Parameters
    ----------
    values : openings as shown, shape (m,).
    label : label of the color scale.
    """
    if np.isnan(values).all():
        return {"color": to_hex(UNKNOWN), "showscale": False}
    shades = np.linspace(0, 1, SHADES)
    return {
        "intensity": rounded(np.nan_to_num(values)), "intensitymode": "cell",
        "cmin": 0.0, "cmax": float(np.nanmax(values)) or 1.0,
        "colorscale": [
            [float(s), to_hex(c)] for s, c in zip(shades, COLORS(shades), strict=True)
        ],
        "colorbar": {
            "title": {"text": escape(label, quote=False), "side": "right"},
            "orientation": "h", "y": -0.02, "yanchor": "top", "thickness": 14, "len": 0.8,
        },
    }  # fmt: skip


def _hover(manifest: Manifest) -> Chart:
    unit = escape(manifest.shown.length.behind, quote=False)
    lines = (f"{name} = %{{{name}:.3~g}}{unit}" for name in "xyz")
    return {"hovertemplate": "<br>".join(lines) + "<extra></extra>"}


def _edges(ends: list[tuple[float, float]]) -> Chart:
    """Return the edges of the box around a body as one line with gaps."""
    corners = np.array([[p, q, r] for p in ends[0] for q in ends[1] for r in ends[2]])
    pairs = [
        (one, other)
        for one in range(8)
        for other in range(one)
        if (corners[one] != corners[other]).sum() == 1
    ]
    gap = np.full((1, 3), np.nan)
    lines = np.concatenate([part for a, b in pairs for part in (corners[[a, b]], gap)])
    x, y, z = (rounded(line) for line in lines.T)
    return {
        "type": "scatter3d", "mode": "lines", "x": x, "y": y, "z": z, "hoverinfo": "skip",
        "line": {"color": "#8a8a8a", "width": 3}, "showlegend": False,
    }  # fmt: skip

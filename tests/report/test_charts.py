"""Curves of pictures as data of a page: the same numbers, names and units."""

import json

import numpy as np
import pytest
from matplotlib.figure import Figure

from report.test_report import BOX, SLAB, TAUS, drawn_manifest, drawn_run, drawn_step
from staffa.measure.network import Network
from staffa.plot.cracks import cracks_figure
from staffa.plot.curves import energies_figure, lengths_figure
from staffa.plot.frames import read_frames
from staffa.plot.style import BLACK
from staffa.report.charts import charts
from staffa.report.turnable import FINEST, simplified, turnable


def test_a_chart_has_the_numbers_the_names_and_the_units_of_its_picture() -> None:
    manifest = drawn_manifest(SLAB, scaled=False)
    steps = [drawn_step(index, SLAB, None) for index in range(len(TAUS))]
    (chart,) = charts(energies_figure(manifest, steps))
    total = chart["data"][0]
    unit = manifest.shown.energy
    assert [trace["name"] for trace in chart["data"]] == ["total", "elastic", "surface"]
    assert total["y"] == pytest.approx([unit.of(s.energies.total) for s in steps], rel=1e-5)
    assert total["x"] == pytest.approx([manifest.shown.time.of(s.time) for s in steps], rel=1e-5)
    assert total["line"]["color"] == BLACK
    assert total["hovertemplate"].endswith(f" {unit.name}")
    layout = chart["layout"]
    assert layout["yaxis"]["title"]["text"] == f"energy ({unit.name})"
    assert layout["xaxis"]["title"]["text"] == f"time ({manifest.shown.time.name})"
    assert layout["unit"] == f" {manifest.shown.time.name}"
    assert layout["yaxis"]["range"][0] == 0.0


def test_each_panel_of_a_picture_is_a_chart_with_the_axis_below_and_its_legend() -> None:
    manifest = drawn_manifest(SLAB)
    steps = [drawn_step(index, SLAB, None) for index in range(len(TAUS))]
    lengths, depths, counts = charts(lengths_figure(manifest, steps))
    below = {one["layout"]["xaxis"]["title"]["text"] for one in (lengths, depths, counts)}
    assert below == {"τ = 2 √(κ t) / L"}
    assert counts["layout"]["legend"]["title"]["text"] == "at depth (scaled)"
    assert {trace["line"]["shape"] for trace in counts["data"]} == {"hv"}
    assert None in depths["data"][0]["y"], "a crack that is not there yet"
    assert sum(trace["showlegend"] for trace in depths["data"]) == 3 < len(depths["data"])
    json.dumps([lengths, depths, counts], allow_nan=False)


def test_errors_bands_marks_and_names_are_those_of_the_picture() -> None:
    figure = Figure()
    axes = figure.subplots()
    axes.errorbar([1, 2], [3, 4], [0.5, 0.25], label="<b>mean</b>", capsize=3, marker="o")
    axes.fill_between([1, 2], [2, 3], [4, 5], label="band", alpha=0.3)
    axes.axvline(1.5)
    axes.annotate("1 %", (1.5, 0.1), xycoords=("data", "axes fraction"))
    axes.set(xlabel="time (h)", ylabel="spacing (mm)", yscale="log", ylim=(1, 100))
    (chart,) = charts(figure)
    band, mean = chart["data"]
    assert band["fill"] == "toself" and band["hoverinfo"] == "skip"
    assert mean["error_y"]["array"] == [0.5, 0.25]
    assert mean["name"] == "&lt;b&gt;mean&lt;/b&gt;"
    assert mean["hovertemplate"] == "%{y:.4~g} mm ± %{customdata:.2~g}"
    (line,), (note,) = chart["layout"]["shapes"], chart["layout"]["annotations"]
    assert (line["x0"], line["x1"], line["yref"]) == (1.5, 1.5, "y domain")
    assert (note["text"], note["x"], note["xref"], note["yref"]) == ("1 %", 1.5, "x", "y domain")
    assert chart["layout"]["yaxis"]["type"] == "log"
    assert chart["layout"]["yaxis"]["range"] == [0.0, 2.0]


def test_an_axis_of_texts_keeps_them_and_a_line_with_errors_its_own_name() -> None:
    figure = Figure()
    axes = figure.subplots()
    bars = axes.errorbar([0, 1], [3, 4], [0.5, 0.25], linestyle="none", marker="o")
    bars.lines[0].set_label("law")
    axes.set_xticks([0, 1], ["AT1", "<AT2>"])
    axes.annotate("outside", (0.5, 0.5), xycoords="figure fraction")
    figure.legend(title="over the law")
    (chart,) = charts(figure)
    (trace,), layout = chart["data"], chart["layout"]
    assert (trace["name"], trace["mode"]) == ("law", "markers")
    assert layout["xaxis"]["ticktext"] == ["AT1", "&lt;AT2&gt;"]
    assert layout["xaxis"]["tickvals"] == [0.0, 1.0]
    assert layout["legend"]["title"]["text"] == "over the law" and layout["annotations"] == []


def test_a_picture_of_fields_has_no_chart(tmp_path) -> None:
    run = drawn_run(tmp_path)
    frames, _ = read_frames(run)
    assert charts(cracks_figure(run.manifest, frames[:1])) == ()


def wall(n: int) -> Network:
    """A plane across the box at x = 0.5 of 2 n² triangles."""
    y, z = (a.ravel() for a in np.meshgrid(*[np.linspace(0, 1, n + 1)] * 2, indexing="ij"))
    corner = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    a, b, c, d = corner, corner + n + 1, corner + n + 2, corner + 1
    elements = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    return Network(
        points=np.column_stack([np.full_like(y, 0.5), y, z]), elements=elements,
        damage=np.ones(len(y)), opening=1e-3 * y, uncertainty=np.zeros(len(y)),
    )  # fmt: skip


def test_cracks_to_turn_are_few_triangles_of_the_same_area() -> None:
    cracks = wall(4 * FINEST)
    (mesh, edges) = turnable(drawn_manifest(BOX), drawn_step(24, BOX, None), cracks)["data"]
    assert len(cracks.elements) > 10 * len(mesh["i"]) > 0
    points = np.column_stack([mesh[name] for name in "xyz"])
    triangles = np.column_stack([mesh[name] for name in "ijk"])
    corners = points[triangles]
    sides = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    assert np.linalg.norm(sides, axis=1).sum() / 2 == pytest.approx(1.0, rel=0.03)
    middle = corners[..., 1].mean(axis=1)
    assert np.array(mesh["intensity"]) == pytest.approx(1e-3 * middle, abs=2e-5)
    assert edges["x"].count(None) == 12, "edges of the box"


def test_a_surface_that_is_coarse_already_is_left_as_it_is() -> None:
    cracks = wall(8)
    values = np.arange(len(cracks.elements), dtype=float)
    points, triangles, kept = simplified(cracks.points, cracks.elements, values, edge=1e-3)
    assert len(points) == len(cracks.points) and sorted(kept) == sorted(values)
    assert {tuple(sorted(map(tuple, points[t]))) for t in triangles} == {
        tuple(sorted(map(tuple, cracks.points[t]))) for t in cracks.elements
    }

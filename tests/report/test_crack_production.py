"""Production with cracks and without: rows, frames, numbers, pictures and page of one mechanism."""

import re
from dataclasses import replace
from functools import partial
from math import isnan
from pathlib import Path

import numpy as np
import pytest

from report.test_report import assert_shows_something
from staffa.io.production_rows import paired_production, production
from staffa.io.run_directory import open_run
from staffa.io.well_rows import WITHOUT
from staffa.plot.cell_openings import OPENINGS, crack_openings
from staffa.plot.exchange_curves import exchange_figure
from staffa.plot.frames import read_frames
from staffa.plot.production_curves import production_figure
from staffa.plot.reservoir_cells import reservoir_figure, reservoir_moments
from staffa.plot.style import write_picture
from staffa.report.drawing import draw
from staffa.results.production_table import production_numbers, production_numbers_table
from support.circulating import CRACKS, FAR, HOT, boxed_run, shadowed_run
from support.crack_networks import NETWORK, distances, network_run

FALLS, WITHOUT_CRACKS = [0.0, 3.5, 14.0], [0.0, 7.0, 28.0]


@pytest.fixture
def run(tmp_path: Path):
    return shadowed_run(tmp_path / "run", FALLS, WITHOUT_CRACKS, dp=(3e5, 5e5))


def test_the_numbers_without_cracks_are_those_of_a_run_that_has_none(run, tmp_path: Path) -> None:
    """A row has of its shadow the bits that the row of such a run has of itself."""
    alone = shadowed_run(tmp_path / "alone", WITHOUT_CRACKS, WITHOUT_CRACKS, dp=(5e5, 5e5))
    frame, other = run.production_frame(), alone.production_frame()
    for name in WITHOUT:
        bare = other[name.removesuffix("_without")]
        np.testing.assert_array_equal(frame[name], bare, err_msg=name)
    assert frame["crack_area"].tolist() == [CRACKS.area] * 6
    assert frame["crack_volume"].tolist() == [CRACKS.volume] * 6
    assert frame["T"].iloc[-1] == HOT - 14 and frame["T_without"].iloc[-1] == HOT - 28


def test_the_frame_of_the_steps_has_both(run) -> None:
    frame = run.to_frame()
    assert frame["production_T"].tolist() == [HOT - fall for fall in FALLS]
    assert frame["production_T_without"].tolist() == [HOT - fall for fall in WITHOUT_CRACKS]
    assert frame["production_pressure_without"].tolist() == [FAR + 5e5] * 3
    assert frame["heat_circulation_cracks_area"].tolist() == [CRACKS.area] * 3


def test_a_step_without_a_shadow_leaves_its_columns_empty(run) -> None:
    first = replace(run.steps[0], heat=replace(run.steps[0].heat, shadow=None))
    part = replace(run, steps=(first, *run.steps[1:]))
    frame = part.production_frame()
    assert isnan(frame["T_without"].iloc[0]) and frame["T_without"].iloc[-1] == HOT - 28
    assert len(paired_production(run.manifest.reservoir, part.steps)) == 2


def test_each_number_of_the_production_stands_twice_with_its_difference(run) -> None:
    """14 of 140 K are a tenth: with cracks at the last step, without after a third of it."""
    table = production_numbers_table(run)
    assert table.header == ("number", "with cracks", "without", "difference")
    lines = {line[0].split(":")[0]: line[1:] for line in table.lines}
    assert lines["production temperature"] == ("186 °C", "172 °C", "+14 K")
    assert lines["thermal breakthrough"] == ("14 d", "12 d", "+2 d")
    assert lines["drawdown of 10 %"] == ("not by the end", "23.33 d", "-")
    assert lines["10 K less"] == ("26.19 d", "21.43 d", "+4.76 d")
    assert lines["peak pressure"][:2] == ("20.3 MPa", "20.5 MPa")
    assert lines["pressure difference"] == ("300 kPa", "500 kPa", "-200 kPa (-40 %)")
    assert lines["impedance"] == ("15 MPa·s/kg", "25 MPa·s/kg", "-10 MPa·s/kg (-40 %)")
    assert lines["crack area"] == ("240 m²", "-", "-")
    assert lines["widest crack"][0] == "1.2 mm"
    energy = {one.name: one for one in production_numbers(run)}["energy"]
    rate = 4200 * 0.02 * 10 * 86400.0
    assert energy.value - energy.without == pytest.approx(rate * (35 - 17.5), rel=1e-9)


def test_the_shadow_is_dashed_below_the_lines_of_the_run(run) -> None:
    facts, steps = run.manifest.reservoir, run.steps
    found, without = production(facts, steps), production(facts, steps, cracks=False)
    figure = production_figure(run.manifest, found, without)
    for axes, values in zip(figure.axes, ([200.0, 193.0, 172.0], None, [20.5] * 3), strict=True):
        dashed = [line for line in axes.get_lines() if line.is_dashed() and len(line.get_xdata())]
        assert dashed, axes.get_ylabel()
        if values:
            drawn = [np.array(line.get_ydata()) for line in dashed]
            alike = [len(y) == len(values) and np.allclose(y, values) for y in drawn]
            assert any(alike), (axes.get_ylabel(), drawn, values)
    assert not any(
        line.is_dashed() for line in production_figure(run.manifest, found).axes[1].get_lines()
    )


def test_injectivity_area_and_cracks_are_drawn_against_time(run, tmp_path: Path) -> None:
    """0.02 kg/s at 0.3 and 0.5 MPa above the rock's pressure."""
    facts, steps = run.manifest.reservoir, run.steps
    found, without = production(facts, steps), production(facts, steps, cracks=False)
    figure = exchange_figure(run.manifest, found, without)
    labels = [axes.get_ylabel() for axes in figure.axes]
    assert labels == [
        "injectivity (kg/s/MPa)", "exchange area (m²)", "crack area (m²)", "crack volume (L)",
    ]  # fmt: skip
    solid, dashed = figure.axes[0].get_lines()[:2]
    assert solid.get_ydata() == pytest.approx([0.02 / 0.3] * 3)
    assert dashed.get_ydata() == pytest.approx([0.02 / 0.5] * 3)
    assert figure.axes[3].get_lines()[0].get_ydata() == pytest.approx([80.0] * 3)
    none = [replace(one, now=replace(one.now, cracks=None)) for one in found]
    assert len(exchange_figure(run.manifest, none).axes) == 2
    path = tmp_path / "exchange.png"
    write_picture(path, partial(exchange_figure, run.manifest, found, without))
    assert_shows_something(path)


def test_an_injectivity_that_grows_by_decades_has_a_logarithmic_axis_of_plain_numbers(
    tmp_path: Path,
) -> None:
    run = shadowed_run(tmp_path, FALLS, WITHOUT_CRACKS, dp=(5e3, 5e5))
    facts, steps = run.manifest.reservoir, run.steps
    found, without = production(facts, steps), production(facts, steps, cracks=False)
    figure = exchange_figure(run.manifest, found, without)
    assert [axes.get_yscale() for axes in figure.axes] == ["log", "linear", "linear", "linear"]
    write_picture(tmp_path / "exchange.png", lambda: figure)
    texts = [text.get_text() for text in figure.axes[0].get_yticklabels()]
    assert any(texts) and not any("$" in text for text in texts), texts


def test_cracks_have_the_color_of_the_opening_of_the_cells_around_them(tmp_path: Path) -> None:
    """From the lower bound, 0.02 mm, to the widest, 1.2 mm; damage is drawn and nothing else."""
    run = network_run(tmp_path)
    facts = run.manifest.reservoir
    moments, reasons = reservoir_moments(run, read_frames(run)[0])
    assert len(moments) == 4 and not reasons
    figure = reservoir_figure(run.manifest, facts, moments)
    panels, bars = figure.axes[:4], figure.axes[4:]
    assert [bar.get_xlabel() for bar in bars] == ["T (°C)", "opening of cracks (mm)"]
    for axes, (frame, found) in zip(panels, moments, strict=True):
        (cracks,) = [c for c in axes.collections if c.get_cmap() is OPENINGS]
        colors = np.asarray(cracks.get_array())
        assert colors.min() == pytest.approx(0.02, rel=1e-6)
        assert colors.max() == pytest.approx(1.2, rel=0.02)
        middles = np.array([path.vertices[:3].mean(axis=0) for path in cracks.get_paths()])
        mean = [[w for *_, w in NETWORK][k] for k in distances(middles).argmin(axis=0)]
        near = np.abs(np.log(colors / (1e3 * np.array(mean)))) < 0.5
        assert near.mean() > 0.7, f"{near.mean():.0%}: the others are beside a junction"
        cracked = (frame.alpha > run.manifest.threshold).sum()
        assert cracked < len(colors) < 4 * cracked + 100 and (found.A > 0).any()


def test_the_scale_of_openings_begins_at_the_lower_bound_and_has_two_decades_at_most(
    tmp_path: Path,
) -> None:
    run = network_run(tmp_path)
    facts = run.manifest.reservoir
    found = [of for _, of in reservoir_moments(run, read_frames(run)[0])[0]]
    scale = crack_openings(facts, found)
    assert scale.vmax == pytest.approx(1.2) and scale.vmin == pytest.approx(0.02)
    lower = replace(facts, cracks=replace(facts.cracks, smallest=1e-9))
    assert crack_openings(lower, found).vmin == pytest.approx(0.012)
    assert crack_openings(facts, [replace(of, w=0 * of.w) for of in found]) is None
    assert crack_openings(facts, [replace(of, w=None, A=None) for of in found]) is None


def test_a_section_of_a_3d_body_has_the_openings_of_its_cells(tmp_path: Path) -> None:
    """They fall with depth from 1 mm exp(-1/2) in the first cells, 1 m deep, by e each 2 m."""
    run = boxed_run(tmp_path, cracks=True)
    moments, _ = reservoir_moments(run, read_frames(run)[0])
    figure = reservoir_figure(run.manifest, run.manifest.reservoir, moments)
    (cracks,) = [c for c in figure.axes[0].collections if c.get_cmap() is OPENINGS]
    colors = np.ma.compressed(cracks.get_array())
    known = np.exp(-np.array([1, 3, 5, 7]) / 2)
    assert colors.max() == pytest.approx(known[0])
    assert {round(float(v), 6) for v in colors} <= {round(float(v), 6) for v in (*known, 0.02)}


def test_the_page_has_the_paragraph_then_the_table_then_the_pictures(tmp_path: Path) -> None:
    run = network_run(tmp_path)
    drawn = draw(run)
    assert {"production", "exchange", "reservoir"} <= {path.stem for path in drawn.pictures}
    page = (tmp_path / "report.html").read_text()
    section = page.split("<h2>Production</h2>")[1].split("<h2>")[0]
    told = "<p>Cracks made the produced water colder", "<th>with cracks</th>", "<img"
    places = [section.index(text) for text in told]
    assert places == sorted(places) and section.count("<img") == 3
    captions = re.findall("<figcaption>(.*?)</figcaption>", section, re.DOTALL)
    of_each = "Dashed: the same water", "Below: area and volume", "in the color of their opening"
    assert [text in caption for text, caption in zip(of_each, captions, strict=True)] == [True] * 3
    assert "flow in cracks" in page  # the warnings
    assert open_run(tmp_path).production_frame()["crack_volume"].iloc[-1] == 9.0

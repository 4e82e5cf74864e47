"""Production of runs that are written by hand: columns, numbers, pictures and page."""

import csv
from dataclasses import replace
from functools import partial
from io import StringIO
from math import inf, isnan, nan
from pathlib import Path

import numpy as np
import pytest
from scipy.special import erfcinv

import staffa
from report.test_report import assert_shows_something
from staffa.display_units import Unit
from staffa.io.production_rows import exchange_area, first_time, production
from staffa.io.run_directory import Journal, create, open_run
from staffa.io.well_rows import WellRow, well_rows
from staffa.plot.frames import read_frames
from staffa.plot.production_curves import closed_form_temperature
from staffa.plot.reservoir_cells import reservoir_figure, reservoir_moments, section_axis
from staffa.plot.style import write_picture
from staffa.records.circulation import Circulation, WellAccount
from staffa.records.reservoir_facts import FractureFlow, WellFacts
from staffa.records.status import Status
from staffa.report.charts import charts
from staffa.report.chosen_figures import curve_figures
from staffa.report.drawing import draw
from staffa.results.production_table import (
    production_numbers,
    production_numbers_table,
    production_table,
)
from staffa.results.summary import summary
from support.circulating import (
    COLD,
    DAY,
    FAR,
    FLOW,
    HOT,
    LENGTH,
    account,
    boxed_run,
    facts,
    fracture_run,
    manifest,
    step,
)

# Two steps of 1e5 s and 2e5 s of 4200 J/(kg K) water: 1000 kg in and 980 out, then 2000 and 1980;
# heat counts from 0 °C, as a simulator may choose.
FIRST = Circulation(
    duration=1e5,
    wells={
        "in": WellAccount(mass=1000.0, heat=4200 * 1000 * 60.0, T=COLD, pressure=20.5e6),
        "out": WellAccount(mass=-980.0, heat=-4200 * 980 * 200.0, T=HOT, pressure=FAR),
    },
    mass_stored=20.0,
    heat_stored=-5.7e8,
)
SECOND = Circulation(
    duration=2e5,
    wells={
        "in": WellAccount(mass=2000.0, heat=4200 * 2000 * 60.0, T=COLD, pressure=20.25e6),
        "out": WellAccount(mass=-1980.0, heat=-4200 * 1980 * 186.0, T=HOT - 14, pressure=FAR),
    },
    mass_stored=20.0,
    heat_stored=-1.04e9,
)
STEPS = (step(1, 1e5, FIRST), step(2, 3e5, SECOND))


def rows() -> dict[tuple[int, str], WellRow]:
    return {(row.step, row.well): row for row in well_rows(facts(), STEPS)}


def test_a_row_for_each_step_and_well_has_rate_temperature_and_pressure() -> None:
    found = rows()
    assert list(found) == [(1, "in"), (1, "out"), (2, "in"), (2, "out")]
    assert [row.time for row in found.values()] == [1e5, 1e5, 3e5, 3e5]
    assert [row.rate for row in found.values()] == [0.01, -0.0098, 0.01, -0.0099]
    assert [row.T for row in found.values()] == [COLD, HOT, COLD, HOT - 14]
    assert [row.pressure for row in found.values()] == [20.5e6, FAR, 20.25e6, FAR]


def test_power_and_heat_are_above_those_of_the_injected_water() -> None:
    """8.232e8 - 2.52e8 J come in 1e5 s, then 15.46776e8 - 5.04e8 J in 2e5 s; 1e9 J are there."""
    one, two = rows()[1, "out"], rows()[2, "in"]
    assert one.power == pytest.approx(5712.0) and one.heat == pytest.approx(5.712e8)
    assert two.power == pytest.approx(5213.88) and two.heat == pytest.approx(16.13976e8)
    assert (one.recovered, two.recovered) == pytest.approx((0.5712, 1.613976))


def test_drawdown_and_pressure_ratios_are_those_of_their_wells_alone() -> None:
    found = rows()
    assert found[1, "out"].drawdown == 0 and found[2, "out"].drawdown == pytest.approx(0.1)
    assert found[1, "out"].impedance == pytest.approx(0.5e6 / 0.0098)
    assert found[2, "out"].impedance == pytest.approx(0.25e6 / 0.0099)
    assert found[1, "in"].injectivity == pytest.approx(2e-8)
    assert found[2, "in"].injectivity == pytest.approx(4e-8)
    empty = [found[2, "in"].drawdown, found[2, "in"].impedance, found[2, "in"].area]
    assert all(map(isnan, [*empty, found[2, "out"].injectivity]))


def test_lost_water_and_balance_count_since_the_start() -> None:
    """Wells bring -5.712e8 and -16.13976e8 J; -5.7e8 and -16.1e8 J are stored."""
    found = rows()
    assert (found[1, "in"].lost, found[2, "in"].lost) == pytest.approx((20.0, 40.0))
    assert found[1, "out"].balance == pytest.approx(-0.012e8 / -5.7e8)
    assert found[2, "out"].balance == pytest.approx(-0.03976e8 / -16.1e8)


def test_the_area_of_a_drawdown_of_a_tenth_is_the_one_by_hand() -> None:
    """erfcinv(.1) = 1.163087; sqrt(2.5/2.3e6 * 3e5) = .571040 m."""
    assert isnan(rows()[1, "out"].area)
    assert rows()[2, "out"].area == pytest.approx(
        1.163087 * 4200 * 0.0099 * 0.571040 / 2.5, rel=1e-5
    )
    assert float(erfcinv(0.1)) == pytest.approx(1.163087, rel=1e-6)


def test_the_area_of_fenton_hills_drawdown_is_that_of_the_docs() -> None:
    """Segment 2: from 175 to 85 °C in 75 days; injection at 25 °C and 7.5 l/s are assumed."""
    granite = facts(conductivity=2.9, rho_c=2.7e6, water_c=4200.0)
    area = exchange_area(granite, (175 - 85) / (175 - 25), 7.5, 75 * DAY)
    assert area == pytest.approx(10_626, rel=1e-4)


@pytest.mark.parametrize("halved", [False, True])
def test_the_area_of_a_single_fractures_water_is_that_of_its_wall(tmp_path: Path, halved) -> None:
    """60 m in a layer of 1 m, at each time after the breakthrough; also of half a fracture."""
    run = fracture_run(tmp_path, 40)
    steps = run.steps
    if halved:
        half = [
            replace(s.heat.circulation, wells={
                name: replace(w, mass=w.mass / 2, heat=w.heat / 2)
                for name, w in s.heat.circulation.wells.items()
            })
            for s in steps
        ]  # fmt: skip
        steps = [step(s.index, s.time, water) for s, water in zip(steps, half, strict=True)]
    found = [row for row in well_rows(facts(halved=halved), steps) if row.well == "out"]
    known = np.array([row.area for row in found if row.drawdown >= 0.01])
    assert len(known) > 30 and all(isnan(row.area) for row in found if row.drawdown < 0.01)
    assert known == pytest.approx(LENGTH * 1.0, rel=1e-9)


def test_numbers_without_a_meaning_are_no_numbers() -> None:
    """No water flows, no well is known, nothing is injected, rock is as cold as the water."""
    still = replace(
        FIRST, wells={n: replace(w, mass=0.0, heat=0.0) for n, w in FIRST.wells.items()}
    )
    for row in well_rows(facts(), [step(1, 1e5, replace(still, heat_stored=0.0))]):
        ratios = (row.drawdown, row.impedance, row.injectivity, row.area, row.balance)
        assert all(map(isnan, ratios)) and row.power == row.heat == row.lost == 0
    for odd in (
        facts(wells={}),
        facts(T_injected=None, heat_in_place=None),
        facts(wells={"out": WellFacts(at=(0.0, 0.0, 0.0), T_rock=COLD, p_rock=FAR)}),
    ):
        found = [row for row in well_rows(odd, STEPS) if row.well == "out"]
        assert [row.power for row in found] == pytest.approx([5712.0, 5213.88])
        assert all(isnan(row.drawdown) and isnan(row.area) for row in found)
    assert all(isnan(row.recovered) for row in well_rows(facts(heat_in_place=0.0), STEPS))
    warmer = replace(SECOND, wells=SECOND.wells | {"out": replace(SECOND.wells["out"], T=HOT + 1)})
    assert all(isnan(row.area) for row in well_rows(facts(), [step(1, 2e5, warmer)]))
    back = replace(FIRST, wells=FIRST.wells | {"in": replace(FIRST.wells["in"], pressure=19e6)})
    assert all(isnan(row.injectivity) for row in well_rows(facts(), [step(1, 1e5, back)]))


def test_several_producers_are_mixed_by_their_mass() -> None:
    """Three parts at 200 °C and one at 160 °C are 190 °C, a drawdown of 10/140."""
    wells = {
        "in": FIRST.wells["in"],
        "a": WellAccount(mass=-750.0, heat=0.0, T=HOT, pressure=FAR),
        "b": WellAccount(mass=-250.0, heat=0.0, T=HOT - 40, pressure=19e6),
    }
    known = facts().wells
    of = facts(wells={"in": known["in"], "a": known["out"], "b": known["out"]})
    (found,) = production(of, [step(1, 1e5, replace(FIRST, wells=wells))])
    assert pytest.approx(HOT - 10) == found.T and found.fall == pytest.approx(10)
    assert found.drawdown == pytest.approx(10 / 140) and found.pressure == 20.5e6


def test_times_are_linear_between_steps_and_infinite_if_not_reached() -> None:
    """Drawdown 0 at 1e5 s and .1 at 3e5 s: .01 at 1.2e5 s, 10 K of 14 K at 2.4286e5 s."""
    found = production(facts(), STEPS)
    drawdown = [one.drawdown for one in found]
    assert first_time(found, drawdown, 0.01) == pytest.approx(1.2e5)
    assert first_time(found, drawdown, 0.05) == pytest.approx(2e5)
    assert first_time(found, [one.fall for one in found], 10.0) == pytest.approx(
        1e5 + 2e5 * 10 / 14
    )
    assert first_time(found, drawdown, 0.2) == inf and first_time([], [], 0.1) == inf
    assert first_time(found, [0.02, 0.03], 0.01) == pytest.approx(0.5e5)  # 0 before the first step
    assert first_time(found, [nan, 0.1], 0.05) == pytest.approx(1.5e5)


def written(path: Path, steps=STEPS, **changes: object) -> staffa.io.run_directory.Run:
    create(path, "", manifest([1e5, 3e5], **changes))
    for one in steps:
        Journal(path).append(one)
    return open_run(path)


def test_the_table_names_its_si_units_and_leaves_empty_what_is_not_known(tmp_path: Path) -> None:
    run = written(tmp_path)
    read = list(csv.DictReader(StringIO(production_table(run).csv())))
    assert list(read[0]) == [
        "step", "time_s", "well", "rate_kg_per_s", "T_K", "pressure_Pa", "power_W", "heat_J",
        "drawdown", "recovered", "impedance_Pa_s_per_kg", "injectivity_kg_per_s_per_Pa", "area_m2",
        "lost_kg", "balance", "T_without_K", "pressure_without_Pa", "power_without_W",
        "heat_without_J", "drawdown_without", "impedance_without_Pa_s_per_kg",
        "injectivity_without_kg_per_s_per_Pa", "area_without_m2", "crack_area_m2",
        "crack_volume_m3",
    ]  # fmt: skip
    assert {read[3][f"{name}"] for name in read[0] if "_without" in name or "crack" in name} == {""}
    assert (read[0]["well"], read[0]["T_K"], read[0]["drawdown"]) == ("in", "333.15", "")
    assert (
        float(read[3]["drawdown"]) == pytest.approx(0.1)
        and read[3]["injectivity_kg_per_s_per_Pa"] == ""
    )


def test_the_table_is_a_frame_and_the_scalars_are_in_that_of_the_steps(tmp_path: Path) -> None:
    run = written(tmp_path)
    frame = staffa.open_run(tmp_path).production_frame()
    assert list(frame.columns) == list(WellRow._fields) and len(frame) == 4
    assert frame["power"].iloc[3] == pytest.approx(5213.88) and isnan(frame["area"].iloc[0])
    steps = run.to_frame()
    assert steps["production_T"].tolist() == [HOT, HOT - 14]
    assert steps["production_heat"].tolist() == pytest.approx([5.712e8, 16.13976e8])


def test_a_run_without_water_has_no_production(tmp_path: Path) -> None:
    for name, changes, steps in (
        ("old", {"reservoir": None}, [step(1, 1e5, None)]),
        ("empty", {}, []),
        ("still", {}, [step(1, 1e5, None)]),
    ):
        run = written(tmp_path / name, steps, **changes)
        assert production_table(run).rows == () and production_numbers(run) == []
        assert list(run.production_frame().columns) == list(WellRow._fields)
        assert not any(column.startswith("production_") for column in run.to_frame())
        draw(run)
        assert not (tmp_path / name / "production.csv").exists()
        assert "<h2>Production</h2>" not in (tmp_path / name / "report.html").read_text()


def test_the_curves_of_one_step_are_marked_where_the_next_was_not_reached(tmp_path: Path) -> None:
    left = replace(STEPS[1], status=Status.FAILED, reason="a solver failed")
    run = written(tmp_path, (STEPS[0], left))
    curves, missing = curve_figures(run)
    assert missing == ["curves: they need two steps"]
    (shown, *_) = charts(curves["production"]())
    assert [note["text"] for note in shown["layout"]["annotations"]] == ["step 2 not reached"]


def test_numbers_of_the_whole_run_are_in_its_units(tmp_path: Path) -> None:
    celsius = Unit(name="°C", zero=273.15)
    units = {
        "temperature": celsius,
        "time": Unit(name="d", size=DAY),
        "stress": Unit(name="MPa", size=1e6),
    }
    run = written(tmp_path, units=units)
    text = {one.name: one.text for one in production_numbers(run)}
    assert text["thermal breakthrough"] == f"{1.2e5 / DAY:.4g} d"
    assert text["drawdown of 10 %"] == "not by the end"
    assert text["production temperature"] == "186 °C" and text["peak pressure"] == "20.5 MPa"
    assert text["energy"] == "1.614 GJ" and text["power"] == "5.214 kW"
    assert text["lost water"] == "40 kg" and text["recovered"] == "1.614"
    lines = {fact.name: fact.text for fact in summary(run)}
    assert lines["reservoir"] == "tried 1.0, 540 cells, wells 'in', 'out'"
    assert lines["production"].startswith(
        "186 °C at the end, 5.214 kW over the last step, 1.614 GJ since the start; thermal"
    )


def test_a_breakthrough_within_the_first_step_is_noted(tmp_path: Path) -> None:
    """That of this fracture comes after some 10 days: within a first step of 100 d, not of 10 d."""
    for every, noted in ((10 * DAY, False), (100 * DAY, True)):
        run = fracture_run(tmp_path / f"{every:g}", 5, every=every)
        notes = production_numbers_table(run).notes
        assert any("The first step ends at" in note for note in notes) is noted, (every, notes)


def test_closed_forms_are_a_single_fracture_and_parallel_ones_where_they_feel_each_other() -> None:
    """Values of references.csv of the reservoir's design: q = 2e-5 m2/s, 60 m, spacing 10 m."""
    at = np.array([20.0, 40.0, 60.0, 100.0, 160.0]) * DAY
    near = facts(flow=FractureFlow(q=FLOW, length=LENGTH, half_spacing=5.0))
    T = closed_form_temperature(near, at)
    assert (
        pytest.approx(
            np.array([190.84732, 173.03666, 159.69856, 141.24699, 121.11752]) + 273.15, abs=0.01
        )
        == T
    )
    alone = closed_form_temperature(facts(), at)
    far = facts(flow=FractureFlow(q=FLOW, length=LENGTH, half_spacing=500.0))
    assert closed_form_temperature(far, at) == pytest.approx(alone)
    assert alone is not None and alone[0] == pytest.approx(T[0], abs=0.3)
    assert closed_form_temperature(facts(flow=None), at) is None


NAMES = {"in": "<b>in</b> $x^2$", "out": "_out $\\frac{"}


def renamed(run_path: Path, **changes: object) -> staffa.io.run_directory.Run:
    """The run of two steps, its wells with names that HTML and mathtext would take for theirs."""
    known = facts().wells
    steps = [
        step(s.index, s.time, replace(water, wells={NAMES[n]: w for n, w in water.wells.items()}))
        for s in STEPS
        if s.heat and (water := s.heat.circulation)
    ]
    of = facts(wells={NAMES[name]: well for name, well in known.items()})
    return written(run_path, steps, reservoir=of, **changes)


def test_the_page_has_a_section_with_pictures_table_and_sentences(tmp_path: Path) -> None:
    run = fracture_run(tmp_path)
    drawn = draw(run)
    assert {"production", "exchange", "reservoir"} <= {path.stem for path in drawn.pictures}
    for name in ("production", "exchange", "reservoir"):
        assert_shows_something(tmp_path / "pictures" / f"{name}.png")
    assert tmp_path / "production.csv" in drawn.tables
    page = (tmp_path / "report.html").read_text()
    section = page.split("<h2>Production</h2>")[1].split("<h2>")[0]
    assert (
        section.count("<img") == 3 and "Dotted line: a fracture in rock without cracks" in section
    )
    assert "thermal breakthrough: first time at which the drawdown is above 1 %" in section
    assert page.split("<h2>Pictures</h2>")[1].count("The temperature of the reservoir") == 0


def test_names_of_wells_are_text_in_page_and_pictures(tmp_path: Path) -> None:
    run = renamed(tmp_path)
    drawn = draw(run)
    assert {"production"} <= {path.stem for path in drawn.pictures}
    page = (tmp_path / "report.html").read_text()
    assert "<b>in</b>" not in page and "&lt;b&gt;in&lt;/b&gt;" in page
    assert "<b>in</b> $x^2$" in (tmp_path / "production.csv").read_text()


def test_one_step_is_drawn_as_dots_and_has_its_numbers(tmp_path: Path) -> None:
    run = written(tmp_path, STEPS[:1])
    assert len(production_table(run).rows) == 2
    drawn = draw(run)
    assert (tmp_path / "production.csv").exists()
    assert "curves: they need two steps" in drawn.skipped
    assert "production" in {path.stem for path in drawn.pictures}


def test_a_lost_or_foreign_file_of_the_reservoir_is_named(tmp_path: Path) -> None:
    run = fracture_run(tmp_path)
    (tmp_path / "fields" / "reservoir-0003.vtkhdf").unlink()
    other = replace(run.manifest, reservoir=facts(edges=((0.0, 1.0), (0.0, 1.0), (0.0, 1.0))))
    drawn = draw(run)
    lost = "fields/reservoir-0003.vtkhdf is left out: it is not there"
    assert lost in drawn.skipped
    assert "reservoir" in {path.stem for path in drawn.pictures}
    drawn = draw(replace(run, manifest=other))
    assert any("its cells are not those of manifest.json" in reason for reason in drawn.skipped)
    assert "reservoir" not in {path.stem for path in drawn.pictures}


def test_water_that_comes_at_the_rocks_temperature_has_no_breakthrough(tmp_path: Path) -> None:
    waters = [account(1e5, HOT), account(2e5, HOT)]
    run = written(tmp_path, [step(1, 1e5, waters[0]), step(2, 3e5, waters[1])])
    text = {one.name: one.text for one in production_numbers(run)}
    assert text["thermal breakthrough"] == text["10 K less"] == "not by the end"
    assert text["exchange area"] == "-" and float(text["balance"]) == pytest.approx(0, abs=1e-12)
    draw(run)


def test_a_3d_reservoir_is_drawn_in_the_section_through_its_wells(tmp_path: Path) -> None:
    """Wells at y = 15 m: cracks of the body are drawn in that section, names of wells as text."""
    run = boxed_run(tmp_path)
    known = run.manifest.reservoir
    assert known is not None and section_axis(known) == 1
    frames, _ = read_frames(run)
    moments, reasons = reservoir_moments(run, frames)
    assert len(moments) == 1 and not reasons
    figure = reservoir_figure(run.manifest, known, moments)
    axes = figure.axes[0]
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x (m)", "z (m)")
    cells, cracks = axes.collections[:2]
    assert cells.get_array().size == 40 * 20 and cells.get_array().min() < HOT - 100
    drawn = cracks.get_array().compressed()
    assert drawn.size > 0 and drawn.all()
    assert {text.get_text() for text in axes.texts} == {"in $a$", "out"}
    path = tmp_path / "reservoir.png"
    write_picture(path, partial(reservoir_figure, run.manifest, known, moments))
    assert_shows_something(path)

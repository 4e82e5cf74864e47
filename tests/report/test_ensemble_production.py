"""Production of ensembles that are written by hand: means and errors, table, picture and page."""

import csv
from math import sqrt
from pathlib import Path

import pytest

from report.test_report import assert_shows_something
from staffa.io.ensemble_directory import Ensemble, is_of_ensemble, read_ensemble
from staffa.io.own_files import write_aside
from staffa.io.run_directory import CASE
from staffa.measure.averages import mean_over_time
from staffa.report.drawing import draw_ensemble
from staffa.results.ensemble_means import sheets, write_results
from staffa.results.members_production import production_means
from support.circulating import DAY, HOT, fracture_run, shadowed_run

# Fall of the production temperature (K) with cracks, by seed, and its length of a step (d); without
# cracks it is twice that of seed 0.
FALLS = {
    0: ([0.0, 1.0, 4.0, 8.0, 14.0, 20.0], 10),
    1: ([0.0, 2.0, 6.0, 12.0, 20.0, 26.0], 10),
    2: ([2.0, 10.0, 20.0], 20),
}
WITHOUT = {10: [0.0, 2.0, 8.0, 16.0, 28.0, 40.0], 20: [2.0, 16.0, 40.0]}


def ensemble(folder: Path) -> Ensemble:
    for seed, (falls, every) in FALLS.items():
        run = shadowed_run(folder / f"seed-{seed}", falls, WITHOUT[every], every=every * DAY)
        write_aside(run.path / CASE, f'title = "drawn"\n[toughness]\nseed = {seed}\n')
    return read_ensemble(folder)


def rows(found: Ensemble) -> list[dict[str, float]]:
    read = csv.DictReader(production_means(found).csv().splitlines())
    return [{name: float(cell) for name, cell in row.items()} for row in read]


def test_curves_are_linear_between_steps_and_end_where_a_member_does() -> None:
    found = mean_over_time([((1.0, 3.0), (0, 2)), ((2.0, 4.0), (5, 1))], linear=True)
    assert found.at.tolist() == [2.0, 3.0]
    assert found.values.tolist() == [[1.0, 2.0], [5.0, 3.0]]


def test_means_and_errors_are_those_by_hand_at_the_times_of_all_members(tmp_path: Path) -> None:
    """At 30 d the member of long steps is halfway between its falls of 2 and 10 K."""
    found = rows(ensemble(tmp_path))
    assert [row["time_s"] / DAY for row in found] == pytest.approx([20, 30, 40, 50, 60])
    third = found[1]
    assert third["members"] == 3
    assert third["T_K"] == pytest.approx(HOT - (4 + 6 + 6) / 3)
    assert third["T_error_K"] == pytest.approx(sqrt((16 + 4 + 4) / 9 / 2 / 3))
    assert third["T_change_K"] == pytest.approx((4 + 2 + 3) / 3)
    assert third["T_change_error_K"] == pytest.approx(sqrt(2 / 2 / 3))
    assert third["T_without_K"] == pytest.approx(HOT - (8 + 8 + 9) / 3)


def test_the_energy_of_the_means_is_that_of_the_members(tmp_path: Path) -> None:
    last = rows(ensemble(tmp_path))[-1]
    rate_c = 0.02 * 4200
    with_cracks, without = (
        [rate_c * every * DAY * sum(140 - fall for fall in falls) for falls, every in of]
        for of in (FALLS.values(), [(WITHOUT[every], every) for _, every in FALLS.values()])
    )
    gained = [one - other for one, other in zip(with_cracks, without, strict=True)]
    assert last["heat_J"] == pytest.approx(sum(with_cracks) / 3)
    assert last["heat_change_J"] == pytest.approx(sum(gained) / 3)
    assert last["power_W"] == pytest.approx(rate_c * (140 - (20 + 26 + 20) / 3))
    assert last["heat_change_error_J"] > 0


def test_each_member_and_the_mean_are_on_the_sheet(tmp_path: Path) -> None:
    """20, 14 and 20 K at the end; errors of temperatures have no zero of their scale."""
    found = ensemble(tmp_path)
    (sheet,) = [sheet for sheet in sheets(found) if sheet.title == "Production"]
    lines = [dict(zip(sheet.header, line, strict=True)) for line in sheet.lines + sheet.total_lines]
    changes = [line["change of T at the end (K)"] for line in lines]
    assert changes == ["20", "14", "20", "18", "2", "3"]
    ends = [line["production temperature at the end (°C)"] for line in lines]
    assert ends == ["180", "174", "180", "178", "2", "3"]
    assert lines[0]["change of energy (%)"] == f"{100 * 47 / (840 - 94):.4g}"
    write_results(found)
    columns = (tmp_path / "ensemble.csv").read_text().splitlines()[0].split(",")
    assert {"breakthrough_d", "T_degC", "T_change_K", "energy_change_percent"} <= set(columns)


def test_the_page_has_curves_sheet_and_caption(tmp_path: Path) -> None:
    drawn = draw_ensemble(ensemble(tmp_path))
    (picture,) = [path for path in drawn.pictures if path.stem == "production-of-all"]
    assert_shows_something(picture)
    assert tmp_path / "production_means.csv" in drawn.tables
    assert is_of_ensemble(tmp_path / "production_means.csv")
    page = drawn.page.read_text()
    section = page.split("<h2>Production</h2>")[1].split("<h2>")[0]
    assert section.count("<img") == 1 and "Below: with cracks less without." in section


def test_members_without_a_shadow_have_means_without_changes(tmp_path: Path) -> None:
    for seed in (0, 1):
        run = fracture_run(tmp_path / f"seed-{seed}")
        write_aside(run.path / CASE, f'title = "drawn"\n[toughness]\nseed = {seed}\n')
    found = read_ensemble(tmp_path)
    assert set(rows(found)[0]) == {
        "time_s", "members", "T_K", "T_error_K", "power_W", "power_error_W", "heat_J",
        "heat_error_J",
    }  # fmt: skip
    (sheet,) = [sheet for sheet in sheets(found) if sheet.title == "Production"]
    assert not any("change of" in name for name in sheet.header)

"""Production of two runs side by side."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from report.test_report import assert_shows_something
from staffa.compare.figures import pair_figures
from staffa.compare.open_pair import read_pair
from staffa.compare.pair import Pair
from staffa.compare.side_by_side import common_times, results
from staffa.display_units import Unit
from staffa.io.run_directory import Journal, create
from staffa.records.manifest import Manifest
from staffa.report.drawing import draw_pair
from support.circulating import DAY, FAR, HOT, account, facts, manifest, shadowed_run, step

CASE = """title = "A wall"
[domain]
size = ["60 m", "30 m"]
h = "1 m"
[material]
E = "50 GPa"
Gc = "50 J/m^2"
expansion = "8e-6 1/K"
kappa = "1 mm^2/s"
[damage]
ell = "2 m"
[temperature]
dT = "140 K"
[time]
t = ["10 d", "40 d"]
"""
UNITS = {
    "length": Unit(name="m"), "time": Unit(name="d", size=DAY),
    "stress": Unit(name="MPa", size=1e6),
    "temperature": Unit(name="°C", zero=273.15),
}  # fmt: skip
TIMES = [10 * DAY * n for n in (1, 2, 3, 4)]


def circulated(path: Path, fall: float, **changes: object) -> Manifest:
    """A run of four steps, whose water gets colder by `fall` (K) in each but the first."""
    of = manifest(TIMES, units=UNITS, **changes)
    create(path, CASE, of)
    for n, time in enumerate(TIMES):
        water = account(10 * DAY, HOT - n * fall, p_in=FAR + (4 - n) * 1e5 + 1e4 * fall)
        Journal(path).append(step(n, time, water if of.reservoir else None))
    return of


@pytest.fixture
def pair(tmp_path: Path) -> Pair:
    circulated(tmp_path / "a", 6.0)
    circulated(tmp_path / "b", 3.0)
    return read_pair(tmp_path / "a", tmp_path / "b")


def rows(pair: Pair) -> dict[str, tuple[object, ...]]:
    return {str(row[0]): row[1:] for row in results(pair).rows}


def test_the_last_temperature_breakthrough_energy_and_peak_are_side_by_side(pair: Pair) -> None:
    """200 °C less 18 and 9 K; 1 % of 140 K are 1.4 K, at 10 d + 10 d 1.4/6 and 1.4/3."""
    found = rows(pair)
    assert found["production temperature (°C)"] == ("182", "191", "+9 K")
    assert found["thermal breakthrough (d)"][:2] == ("12.33", "14.67")
    assert found["10 K less (d)"] == ("26.67", "-", "-")
    assert found["peak pressure (MPa)"][:2] == ("20.46", "20.43")
    energies = [4200 * 0.02 * 10 * DAY * (4 * 140 - 6 * fall) / 1e9 for fall in (6.0, 3.0)]
    told = found["produced energy (GJ)"]
    assert [float(str(cell)) for cell in told[:2]] == pytest.approx(energies, rel=1e-3)
    assert found["produced power (kW)"][0] == "10.25"


def test_common_times_have_both_temperatures(pair: Pair) -> None:
    found = common_times(pair)
    column = [c.name for c in found.columns].index("production temperature (°C)")
    assert [row[column] for row in found.rows] == [
        "200 / 200",
        "194 / 197",
        "188 / 194",
        "182 / 191",
    ]


def test_curves_of_both_are_drawn_and_on_the_page(pair: Pair, tmp_path: Path) -> None:
    drawn = draw_pair(pair, tmp_path / "out")
    assert "production-of-both" in {picture.stem for picture in drawn.pictures}
    assert_shows_something(tmp_path / "out" / "pictures" / "production-of-both.png")
    assert "production temperature (°C)" in drawn.page.read_text()
    figure = pair_figures(pair)[0]["production-of-both"]()
    (one, other) = figure.axes[0].get_lines()
    assert list(one.get_ydata()) == pytest.approx([200.0, 194.0, 188.0, 182.0])
    assert list(other.get_xdata()) == pytest.approx([10.0, 20.0, 30.0, 40.0])
    assert figure.axes[0].get_ylim()[0] > 100  # temperatures do not start at 0


def test_a_run_without_water_leaves_its_cells_empty(tmp_path: Path) -> None:
    circulated(tmp_path / "a", 6.0)
    circulated(tmp_path / "b", 6.0, reservoir=None)
    for names in (("a", "b"), ("b", "a")):
        pair = read_pair(*(tmp_path / name for name in names))
        found = rows(pair)
        cells = ("182", "-", "-") if names[0] == "a" else ("-", "182", "-")
        assert found["production temperature (°C)"] == cells
        assert "production-of-both" not in pair_figures(pair)[0]


def test_runs_without_water_have_no_word_on_it(tmp_path: Path) -> None:
    for name in ("a", "b"):
        circulated(tmp_path / name, 6.0, reservoir=None)
    pair = read_pair(tmp_path / "a", tmp_path / "b")
    assert not any("pressure" in name or "production" in name for name in rows(pair))
    assert "production-of-both" not in pair_figures(pair)[0]
    assert np.isnan(pair.first.readings["production temperature"]).all()


def test_pressures_and_temperatures_of_bodies_of_two_sizes_are_compared(tmp_path: Path) -> None:
    circulated(tmp_path / "a", 6.0)
    circulated(tmp_path / "b", 3.0, size=(50.0, 30.0), reservoir=facts())
    pair = read_pair(tmp_path / "a", tmp_path / "b")
    found = rows(pair)
    assert found["production temperature (°C)"][2] == "+9 K"
    assert found["produced energy (GJ)"][2] == "-" and not pair.alike
    assert replace(pair, mixed=False).dim == 2


def test_runs_with_cracks_and_without_are_compared_by_all_four(tmp_path: Path) -> None:
    """Falls of 0, 7 and 28 K without cracks: 14 K, a tenth, at a third of the last 10 days."""
    for name, falls in (("a", [0.0, 3.5, 14.0]), ("b", [0.0, 7.0, 35.0])):
        shadowed_run(tmp_path / name, falls, [0.0, 7.0, 28.0], dp=(3e5, 5e5))
        (tmp_path / name / "case.toml").write_text(CASE)
    pair = read_pair(tmp_path / "a", tmp_path / "b")
    found = rows(pair)
    assert found["production temperature (°C)"] == ("186", "165", "-21 K")
    assert found["production temperature without cracks (°C)"] == ("172", "172", "0")
    assert found["drawdown of 10 % (d)"] == ("-", "22.5", "-")
    assert found["drawdown of 10 % without cracks (d)"] == ("23.33", "23.33", "0")
    assert found["peak pressure (MPa)"][:2] == ("20.3", "20.3")
    assert found["peak pressure without cracks (MPa)"][:2] == ("20.5", "20.5")
    assert found["exchange area without cracks (m²)"][2] == "0"

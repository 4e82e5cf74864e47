"""The crack network is a function of the fields: of no order of points and cells."""

import csv
from pathlib import Path

import numpy as np
import pytest

from fem.test_opening import LONG, cooled, seen
from run.test_run import launch
from staffa.io.run_directory import read_run
from staffa.io.vtkhdf import read_vtkhdf
from staffa.measure.statistics import tips
from staffa.measure.tracing import network
from support.bodies import needs_gmsh

MIXED = """
title = "Unstructured, layered, random, squeezed, heated"
[domain]
size = ["1 m", "0.5 m"]
h = "12.5 mm"
cells = "unstructured"
[material]
E = "65 GPa"
nu = 0.3
Gc = "61.5 J/m^2"
expansion = "6e-6 1/K"
k = "3.05 W/(m K)"
rho = "2750 kg/m^3"
c = "790 J/(kg K)"
[damage]
ell = "37.5 mm"
[regions.seam]
lower = ["0 m", "0.15 m"]
upper = ["1 m", "0.22 m"]
Gc = "40 J/m^2"
[toughness]
amplitude = 0.1
correlation_length = "80 mm"
[temperature]
profile = "heat"
face = "bottom"
[heat]
initial = "200 °C"
bottom = { T = "60 °C" }
[forces]
prestress = { xx = "-5 MPa" }
[supports]
left = "rollers"
right = "rollers"
top = "rollers"
[time]
t = { start = "5 min", stop = "45 min", steps = 2 }
[output]
at = ["45 min"]
[measures]
depths = ["50 mm", "100 mm"]
"""


@needs_gmsh
@pytest.mark.slow
@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.long)])
def test_measures_are_the_same_on_any_number_of_ranks(ranks: int, tmp_path: Path) -> None:
    """Tips, counts, network, openings: of unstructured, layered, random, squeezed, heated rock."""
    (tmp_path / "case.toml").write_text(MIXED)
    runs = []
    for n in (1, ranks):
        done = launch(n, "run", tmp_path / "case.toml", "--quiet", "--out", tmp_path / f"on{n}")
        assert done.returncode == 0, done.stderr
        runs.append(read_run(tmp_path / f"on{n}"))
    for one, many in zip(runs[0].steps, runs[1].steps, strict=True):
        assert many.energies.total == pytest.approx(one.energies.total, rel=1e-9)
        for a, b in zip(one.measures.tips, many.measures.tips, strict=True):
            assert b.position == pytest.approx(a.position, abs=1e-9)
        for c, d in zip(one.measures.sections, many.measures.sections, strict=True):
            assert d.positions == pytest.approx(c.positions, abs=1e-9)
        assert many.measures.volume == pytest.approx(one.measures.volume, rel=1e-6)
    assert runs[0].steps[-1].measures.tips
    rows = []
    for run in runs:
        with (run.path / "network.csv").open() as file:
            rows.append([{k: float(v) for k, v in row.items()} for row in csv.DictReader(file)])
    for one, many in zip(*rows, strict=True):
        assert many == pytest.approx(one, rel=1e-6)


@pytest.mark.parametrize("cells", ["quadrilateral", "triangle"])
def test_a_network_is_the_same_in_any_order(cells: str, tmp_path: Path) -> None:
    """To the last bit, openings to round-off, for points and cells in random orders."""
    ell = LONG / 10
    first = seen(cooled(ell, "plane stress", cells=cells), tmp_path / "fields.vtkhdf")
    grid, values = read_vtkhdf(first.fields)
    strains = np.stack([values["opening_strain"], values["intact_strain"]], axis=1)
    for seed in (1, 2):
        random = np.random.default_rng(seed)
        points, members = random.permutation(len(grid.points)), random.permutation(len(grid.cells))
        number = np.argsort(points)
        again = network(
            grid.points[points], number[grid.cells][members], alpha=values["alpha"][points],
            strains=strains[members], dim=2, h=ell / 4, ell=ell, crack=0.8, tip=0.25,
        )  # fmt: skip
        assert np.array_equal(again.elements, first.network.elements)
        assert np.array_equal(again.points, first.network.points)
        assert again.opening == pytest.approx(first.network.opening, rel=1e-9, abs=1e-12)
        assert again.uncertainty == pytest.approx(first.network.uncertainty, rel=1e-6, abs=1e-9)


def test_tips_do_not_hang_on_round_off() -> None:
    """Depths equal but for rounding; one just as deep as the prominence asks for counts."""
    x, depth = np.array([0.1, 0.2, 0.3, 0.3]), np.array([0.3, 0.3, 0.3, 0.0])
    edges = np.array([[0, 1], [1, 2], [2, 3]])
    found = set()
    for sign in (-1, 0, 1):
        off = depth + sign * np.array([1e-17, -2e-17, 4e-17, 0.0])
        tip = tips(np.stack([x, off], axis=1), off, edges, prominence=0.1)
        found.add(tuple(t.position[0] for t in tip))
        off = depth + sign * np.array([0.0, 0.0, 0.0, 1e-17])
        assert len(tips(np.stack([x, off], axis=1), off, edges, prominence=0.3)) == 1
        assert tips(np.stack([x, off], axis=1), off, edges, prominence=0.301) == ()
    assert len(found) == 1

"""The crack network is the same on several ranks."""

import csv
from pathlib import Path

import pytest

from staffa.io.run_directory import open_run
from support.bodies import needs_gmsh
from support.ranks import staffa_on

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
@pytest.mark.parametrize("ranks", [2, pytest.param(3, marks=pytest.mark.long)])
def test_measures_are_the_same_on_any_number_of_ranks(ranks: int, tmp_path: Path) -> None:
    """Tips, counts, network, openings: of unstructured, layered, random, squeezed, heated rock."""
    (tmp_path / "case.toml").write_text(MIXED)
    runs = []
    for n in (1, ranks):
        staffa_on(n, "run", tmp_path / "case.toml", "--quiet", "--out", tmp_path / f"on{n}")
        runs.append(open_run(tmp_path / f"on{n}"))
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

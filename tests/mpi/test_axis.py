"""Bodies of revolution on several ranks."""

from math import pi
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from staffa.io.run_directory import open_run
from staffa.results.crack_network import networks
from staffa.results.summary import summary
from support.bodies import RANKS
from support.ranks import staffa_on

CASE = """
title = "penny"
[domain]
size = ["4 m", "4.1 m"]
h = "0.1 m"
symmetry = "axis"
[material]
E = "2 GPa"
nu = 0.3
Gc = "80 J/m^2"
[damage]
ell = "0.3 m"
split = "none"
[temperature]
profile = "none"
[forces]
crack_pressure = { t = ["0 s", "2 s"], value = ["0 MPa", "0.2 MPa"] }
[[cracks]]
start = ["0 m", "2.05 m"]
end = ["1 m", "2.05 m"]
[solver]
backtracking = true
stability = "report"
[time]
t = ["1 s", "1.5 s", "2 s"]
"""


@pytest.mark.parametrize("ranks", RANKS)
def test_on_several_ranks_a_run_gives_the_serial_numbers(tmp_path: Path, ranks: int) -> None:
    """A penny crack with backtracking and exact second order; its network has the area and volume
    that the energies tell, in units of a whole body."""
    (tmp_path / "penny.toml").write_text(CASE)
    found = []
    for number in (1, ranks):
        out = tmp_path / f"{number}"
        staffa_on(number, "run", tmp_path / "penny.toml", "--out", out, "--quiet")
        found.append(open_run(out))
    totals = [[step.energies.total for step in each.steps] for each in found]
    assert totals[1] == pytest.approx(totals[0], rel=1e-9)
    serial, step = found[0], found[0].steps[-1]
    assert not step.audit.violations and step.hoop == 0.0
    (drawn,), _ = networks(serial)
    measures, shown = step.measures, serial.manifest.shown
    # The network ends where the crack, of radius 1 m, was given; its energy counts damage beyond.
    assert np.sqrt(drawn.network.size / pi) == pytest.approx(1.0, abs=0.04)
    assert measures.length_surface > pi
    assert drawn.network.volume == pytest.approx(measures.fluid.volume, rel=0.01)
    assert measures.volume == pytest.approx(measures.fluid.volume, rel=0.06)
    assert (shown.crack.name, shown.energy.name[-1]) == ("m²", "J")
    told = {fact.name for fact in summary(serial)}
    assert "crack area" in told and "radial cracks" not in told

"""Values of every step on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from support.ranks import printed_on

ON_RANKS = """
from staffa.backend.stack import MPI
from support.bodies import body, rock
from staffa.model.initial_cracks import FlatCrack
from staffa.evolution.march import Observers, march
from staffa.evolution.system import build
from staffa.measure.crack import Gauge, crack_volume
from staffa.measure.probes import Probes
from staffa.model.supports import SideSupport
from report.test_series import LINE, SPOT
crack = FlatCrack(center=(0.5, 0.0, 0.0), normal=(1.0, 0.0, 0.0), radius=0.25)
pull = SideSupport(side="right", components={0: lambda x, t: 1.0 * t, 1: lambda x, t: 0.0})
problem = body((1.0, 0.6), 0.05, material=rock(cracks=(crack,)), sides=(
    SideSupport(side="left", components={0: lambda x, t: 0.0, 1: lambda x, t: 0.0}), pull))
system = build(problem)
looks = Probes(problem.domain, [LINE, SPOT])
(step,) = march(problem, system, Observers(probe=lambda: looks(system.state)))
gauge = Gauge(face=None, depths=(), threshold=0.8, prominence=0.1, h=0.05, toughness_factor=1.0)
volume = crack_volume(problem.domain, system.state, system.energy, gauge)
if MPI.COMM_WORLD.rank == 0:
    for values in (*step.reactions.values(), *step.probed, [volume]):
        print(*values)
system.destroy()
"""


@pytest.mark.long
def test_readings_are_the_same_on_any_ranks() -> None:
    alone, *others = [
        np.array([float(w) for line in printed_on(n, ON_RANKS) for w in line]) for n in (1, 2, 3)
    ]
    assert len(alone) == 2 * 2 + 4 * 4 + 1 and np.abs(alone).max() > 0.1
    for found in others:
        assert found == pytest.approx(alone, abs=1e-7), "to the tolerance of the minimization"

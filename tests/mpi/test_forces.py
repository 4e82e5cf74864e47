"""A fluid of given volume on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from support.ranks import printed_on

ON_RANKS = """
from dataclasses import replace

from staffa.backend.stack import MPI
from fem.test_forces import *
held, step = last(cracked(Forces(crack_volume=lambda t: 0.1 * t), "no-tension", times=(0.5, 1.0)))
pressure = float(held.energy.external.pressure.value)
if MPI.COMM_WORLD.rank == 0:
    print(repr(pressure), repr(step.energies.elastic), repr(step.energies.surface))
"""


def test_ranks_agree() -> None:
    """A fluid of given volume in rock without tension, on 1, 2 and 3 ranks."""
    alone, *others = (np.array(printed_on(n, ON_RANKS)[0], dtype=float) for n in (1, 2, 3))
    for found in others:
        assert found == pytest.approx(alone, rel=1e-6)

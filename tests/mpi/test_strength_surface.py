"""Rock with a strength surface on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from support.ranks import printed_on

ON_RANKS = """
from staffa.backend.stack import MPI
from fem.test_strength_surface import *
steps = [*run(loaded("biaxial", 0.1, (0.9, 1.02, 1.04))), *run(loaded("pressed", 0.1, (0.9, 1.02)))]
if MPI.COMM_WORLD.rank == 0:
    print(*(repr(e) for s in steps for e in (s.energies.elastic, s.energies.surface)))
"""


def test_ranks_agree() -> None:
    """Damage by two tensions and by pressure, on 1, 2 and 3 ranks."""
    alone, *others = (np.array(printed_on(n, ON_RANKS)[0], dtype=float) for n in (1, 2, 3))
    assert alone[3] > 1e-6
    assert alone[-1] > 1e-3
    for found in others:
        assert found == pytest.approx(alone, rel=1e-6, abs=1e-10)

"""Objects of a script are known again on other ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from support.bodies import RANKS
from support.ranks import printed_on

ON_RANKS = """
import sys
from staffa.backend.stack import MPI
from fem.test_own import Cold, load, slab
import numpy as np
import staffa
from staffa.setup.user_objects import tried_load
domain = staffa.problem(slab(), temperature=Cold(1.0)).domain
waves = load(lambda x, t: np.sin(3 * x[0]) * x[1] * t)
found = tried_load(waves, domain, (0.1, 0.7))
if MPI.COMM_WORLD.rank == 0:
    print(*found)
bad = load(lambda x, t: np.where(x[0] > 0.95, np.nan, 0.0))
try:
    tried_load(bad, domain, (0.1,))
except staffa.errors.InputError as error:
    if MPI.COMM_WORLD.rank == 0:
        print(error)
"""


@pytest.mark.parametrize("ranks", RANKS)
def test_a_load_is_known_again_on_other_ranks(ranks: int) -> None:
    one, many = printed_on(1, ON_RANKS), printed_on(ranks, ON_RANKS)
    assert many[0] == one[0] and len(one[0]) == 12
    assert all("not finite at t = 0.1" in " ".join(lines[1]) for lines in (one, many))

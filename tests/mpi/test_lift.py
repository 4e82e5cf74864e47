"""The state of a mesh on a finer one, on several ranks."""

import pytest

from fem.test_lift import QUADRATIC
from support.bodies import RANKS
from support.ranks import printed_on

ERRORS = """
from staffa.backend.stack import MPI
from fem.test_lift import errors_of_lift
print(*errors_of_lift(*{settings!r}))
"""


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
@pytest.mark.parametrize("settings", [(), (QUADRATIC,)], ids=["linear", "quadratic"])
def test_a_state_passes_to_a_finer_mesh_on_any_ranks(ranks: int, settings: tuple[str, ...]) -> None:
    printed = printed_on(ranks, ERRORS.format(settings=settings))
    assert len(printed) == ranks
    assert max(float(error) for line in printed for error in line) < 1e-12

"""Quantities of a script on several ranks."""

from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from run.test_step_quantities import BOTH, SHORT
from staffa.runs.run import run
from support.bodies import RANKS
from support.ranks import printed_on
from support.restarting import small

ON_RANKS = """
from pathlib import Path
from staffa.backend.stack import MPI
import staffa
from support.restarting import small
from staffa.errors import InputError
from run.test_step_quantities import BOTH, SHORT, constant
comm = MPI.COMM_WORLD
steps = staffa.run(small(*SHORT), Path({folder!r}) / "run", quantities=BOTH)
if comm.rank == 0:
    for step in steps:
        print(*step.quantities["damaged_area"], *step.quantities["extremes"])
for value in (comm.rank, [1.0] * (1 + comm.rank), "much" if comm.rank else 1.0):
    try:
        staffa.run(small(*SHORT), Path({folder!r}) / "no", quantities=[constant(value)])
    except InputError as error:
        said = comm.gather(str(error))
        if comm.rank == 0:
            print(len(set(said)), str(error).replace(" ", "_"))
"""


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_quantities_are_the_same_on_any_ranks(ranks: int, tmp_path: Path) -> None:
    """And one that is not is refused on all of them, in the same sentence."""
    alone = run(small(*SHORT), tmp_path / "alone", quantities=BOTH)
    *numbers, one, two, three = printed_on(ranks, ON_RANKS.format(folder=str(tmp_path)))
    expected = [[*step.quantities["damaged_area"], *step.quantities["extremes"]] for step in alone]
    assert np.array(numbers, dtype=float) == pytest.approx(np.array(expected), rel=1e-4)
    assert one[0] == two[0] == three[0] == "1"
    assert "gives_0_on_rank_0_and_1_on_rank_1" in one[1] and "add_up_over_the_ranks" in one[1]
    assert "gives_1_on_rank_0_and_1,_1_on_rank_1" in two[1]
    assert "give_a_number" in three[1]
    assert not (tmp_path / "no").exists()

"""Unstructured cells on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_unstructured import cooled, energies
from staffa.model.domain import cell_count
from support.bodies import RANKS, needs_gmsh
from support.ranks import printed_on

pytestmark = needs_gmsh

ON_RANKS = """
from fem.test_unstructured import cooled
from staffa.model.domain import cell_count
from staffa.evolution.march import march
from staffa.evolution.system import build
case = cooled("unstructured")
system = build(case)
for step in march(case, system):
    if case.domain.comm.rank == 0:
        print(case.domain.identity, cell_count(case.domain), step.energies.total)
"""


@pytest.mark.parametrize("ranks", RANKS)
def test_any_number_of_ranks_has_the_same_mesh_and_the_same_energies(ranks: int) -> None:
    case, found = cooled("unstructured"), printed_on(ranks, ON_RANKS)
    assert {(identity, int(count)) for identity, count, _ in found} == {
        (case.domain.identity, cell_count(case.domain))
    }
    assert [float(energy) for *_, energy in found] == pytest.approx(energies(case), rel=1e-6)


ONE_FAILS = """
import sys
from staffa.backend.stack import MPI
if MPI.COMM_WORLD.rank == 0:
    sys.modules["gmsh"] = None
from staffa.model.domain import block
from staffa.errors import InputError
try:
    block(MPI.COMM_WORLD, size=(1.0, 1.0), h=0.1, cells="unstructured")
except InputError as error:
    said = MPI.COMM_WORLD.gather("install" in str(error))
    if MPI.COMM_WORLD.rank == 0:
        print(*said)
"""


def test_an_error_of_gmsh_is_raised_on_every_rank() -> None:
    assert printed_on(3, ONE_FAILS) == [["True"] * 3]

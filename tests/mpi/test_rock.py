"""Rock that varies is the same rock on several ranks."""

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from fem.test_rock import PLATE, SLAB, _write_field, energies
from support.bodies import RANKS
from support.ranks import printed_on

ON_RANKS = """
from pathlib import Path
from staffa.backend.stack import MPI
import numpy as np
from staffa.setup.build import problem
from staffa.case.reading.read import read_case
from staffa.model.domain import middles
from staffa.backend.parallel import on_root

def table(case, comm):
    built = problem(case, comm=comm)
    mesh = built.domain.mesh
    own = np.arange(mesh.topology.index_map(2).size_local)
    x, material, cap = middles(mesh)[:, own], built.material, built.regions["cap"]
    inside = np.isin(own, built.domain.cells("cap")).astype(float)
    rows = [*x[:2], material.E(x), material.nu(x), material.toughness(x), cap.E(x), inside]
    parts = comm.gather(np.array(rows))
    whole = np.hstack(parts) if comm.rank == 0 else np.zeros((2, 0))
    return whole[:, np.lexsort(whole[:2].round(9))]

case = on_root(MPI.COMM_WORLD, lambda: read_case(Path(r"{path}")))
all_ranks = table(case, MPI.COMM_WORLD)
if MPI.COMM_WORLD.rank == 0:
    one = table(case, MPI.COMM_SELF)
    least, difference = np.ptp(one[2:6], axis=1).min(), np.abs(all_ranks - one).max()
    print(one.shape[1], one[-1].sum(), least, difference)
"""

VARIED = """
[material]
E = { file = "E.vtu", name = "E" }
nu = { formula = "0.1 + 0.1*x" }
Gc = { mean = 2.0, variation = 0.3, distribution = "weibull", length = [0.5, 0.2], angle = 20 }
[regions.cap]
lower = [0.0, 0.5]
upper = [2.0, 1.0]
E = { mean = 3.0, variation = 0.1, distribution = "normal", length = 0.3, seed = 7 }
[toughness]
amplitude = 0.2
seed = 3
"""


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_the_rock_is_the_same_on_many_ranks_as_on_one(tmp_path, ranks: int) -> None:
    (tmp_path / "my.toml").write_text(PLATE + VARIED)
    _write_field(tmp_path / "E.vtu")
    ((cells, inside, least, difference),) = printed_on(
        ranks, ON_RANKS.replace("{path}", str(tmp_path / "my.toml"))
    )
    assert (int(cells), float(inside)) == (32, 16) and float(least) > 0.05
    assert float(difference) <= 1e-12, f"{difference} on {ranks} ranks"


LAYERED = (
    "material={E={mean=1.0, variation=0.2, length=[0.5,0.2], angle=20}, nu=0.3}",
    "regions.shale={lower=[0,0.25], upper=[1,0.5], E=1.0, nu=0.2, E_axis=0.5, nu_axis=0.1, "
    "G_axis=0.3, axis=[0.3,1], expansion=[1,2], Gc=[3,1]}",
)

CRACKED_ON_RANKS = f"""
from staffa.backend.stack import MPI
from support.bodies import run
from staffa.setup.build import problem
from staffa.case.reading.read import parse_case
for step in run(problem(parse_case({SLAB!r}, {LAYERED!r}))):
    if MPI.COMM_WORLD.rank == 0:
        print(step.energies.elastic, step.energies.surface)
"""


@pytest.mark.long
def test_layered_rock_with_bedding_cracks_alike_on_two_ranks() -> None:
    one = energies(*LAYERED)
    two = np.array(printed_on(2, CRACKED_ON_RANKS), dtype=float)
    # each is a minimum to the residual that a step ends at, 1e-3 of the scale of damage forces
    assert two == pytest.approx(one, rel=1e-5), f"{two} on two ranks, {one} on one"
    assert one[-1, 1] > 0.1, "it cracks"

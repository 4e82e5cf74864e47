"""Fields in files, on several ranks."""

from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_given_files import HEATED, grid, warm
from staffa.case.reading.read import read_case
from staffa.runs.run import run
from support.bodies import RANKS
from support.ranks import printed_on

MANY = """
from pathlib import Path
from staffa.backend.stack import MPI
from staffa.case.reading.read import read_case
from staffa.runs.run import run
from staffa.backend.parallel import on_root
comm = MPI.COMM_WORLD
case = on_root(comm, lambda: read_case(Path({path!r})))
steps = run(case, Path({out!r}), comm=comm)
if comm.rank == 0:
    print(*(repr(s.energies.elastic) for s in steps))
"""


@pytest.mark.parametrize("ranks", RANKS)
def test_many_ranks_take_the_same_from_files(tmp_path: Path, ranks: int) -> None:
    """A supplied temperature and moved sides, each on another mesh, as after a restart onto
    another mesh: https://github.com/su2code/SU2/pull/1277."""
    grid(tmp_path / "T0.vtu", (-0.5, -0.5), (3, 2), 7, T=warm)
    grid(tmp_path / "u.vtu", (0, 0), (2, 1), 5, ux=lambda x: 0.1 * x[:, 0])
    text = (
        HEATED + '[supports]\nright = { x = { file = "u.vtu", name = "ux" } }\nleft = "rollers"\n'
    )
    (tmp_path / "my.toml").write_text(text)
    alone = [s.energies.elastic for s in run(read_case(tmp_path / "my.toml"), tmp_path / "one")]
    code = MANY.format(path=str(tmp_path / "my.toml"), out=str(tmp_path / "many"))
    (line,) = printed_on(ranks, code)
    assert [float(word) for word in line] == pytest.approx(alone, rel=1e-9)

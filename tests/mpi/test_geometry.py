"""Meshes with names, and shapes, on several ranks."""

from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from fem.test_geometry import (
    PULLED,
    fields_of,
    folder,  # noqa: F401
)
from run.test_run import launch
from staffa.case.reading.read import read_case
from staffa.setup.build import problem
from support.bodies import RANKS, needs_gmsh
from support.ranks import printed_on

TOLD = """
import sys
from pathlib import Path
from staffa.backend.stack import MPI
from dolfinx import fem
import numpy as np, ufl
from fem.test_geometry import PULLED, fields_of
from staffa.setup.build import problem
from staffa.case.reading.read import read_case
from staffa.backend.parallel import on_root
comm = MPI.COMM_WORLD
for path in {paths!r}:
    case = on_root(comm, lambda: read_case(Path(path)))
    numbers = fields_of(problem(case, comm=comm))
    if comm.rank == 0:
        print(*(repr(n) for n in numbers))
"""

# In space, a region that comes twice.
STACKED = """
[domain]
h = 0.15
[domain.shape]
kind = "layers"
base = [0.6, 0.5]
layers = [
    { region = "shale", thickness = 0.3 },
    { region = "sand", thickness = 0.15 },
    { region = "shale", thickness = 0.15 },
]
[regions.shale]
[regions.sand]
[damage]
ell = 0.4
[temperature]
profile = "none"
[supports]
bottom = "clamped"
top = { z = 0.01 }
[solver]
displacement = "direct"
[time]
t = [1.0]
"""


@needs_gmsh
@pytest.mark.parametrize("ranks", RANKS)
def test_any_number_of_ranks_finds_the_same_parts_and_energies(folder, ranks: int) -> None:
    paths = [str(folder / name) for name in ("my.toml", "stacked.toml")]
    for path, text in zip(paths, (PULLED, STACKED), strict=True):
        Path(path).write_text(text)
    alone = [fields_of(problem(read_case(Path(path)))) for path in paths]
    together = printed_on(ranks, TOLD.format(paths=paths))
    for one, line in zip(alone, together, strict=True):
        assert [float(word) for word in line] == pytest.approx(one, rel=1e-9, abs=1e-12)
    assert alone[0][:6] == pytest.approx([1.2, 0.8, 1.0, 2.0, 2.0, 1.0])
    assert alone[1][:8] == pytest.approx([0.045, 0.135, 0.36, 0.3, 0.36, 0.3, 0.3, 0.3])


@needs_gmsh
def test_two_ranks_refuse_a_wrong_name_once_and_write_nothing(folder: Path) -> None:
    (folder / "my.toml").write_text(PULLED.replace("west =", "wets ="))
    done = launch(2, "run", folder / "my.toml", "--out", folder / "run")
    assert done.returncode == 2, done.stderr
    assert done.stderr.count("supports.wets: the mesh has no such face") == 1, done.stderr
    assert "Did you mean 'west'?" in done.stderr and "Traceback" not in done.stderr
    assert not (folder / "run").exists()

"""The cohesive law on several ranks: the energies and cracks of one rank."""

from pathlib import Path

import pytest

from staffa.io.run_directory import Run, open_run
from support.bodies import RANKS
from support.ranks import staffa_on

CASE = """
[domain]
size = [1.0, 0.5]
h = 0.025
[material]
nu = 0.2
[damage]
law = "cohesive"
strength = 4.0
ell = 0.05
[toughness]
amplitude = 0.1
seed = 2
[temperature]
profile = "half-space"
face = "bottom"
severity = 15.0
[supports]
left = "rollers"
right = "rollers"
[time]
tau = [0.1, 0.2, 0.3]
[solver]
backtracking = true
"""


@pytest.fixture(scope="module")
def case_file(tmp_path_factory) -> Path:
    """Returns the file of the case."""
    file = tmp_path_factory.mktemp("cohesive") / "case.toml"
    file.write_text(CASE)
    return file


@pytest.fixture(scope="module")
def alone(case_file: Path) -> Run:
    """Returns the run on one rank."""
    return ran(case_file, 1)


def ran(case_file: Path, ranks: int) -> Run:
    directory = case_file.parent / str(ranks)
    staffa_on(ranks, "run", case_file, "--out", directory, "--quiet")
    return open_run(directory)


@pytest.mark.slow
@pytest.mark.parametrize("ranks", RANKS)
def test_a_cohesive_slab_is_the_same_on_any_ranks(case_file: Path, alone: Run, ranks: int) -> None:
    found = ran(case_file, ranks)
    for one, other in zip(alone.steps, found.steps, strict=True):
        assert one.status == other.status == "converged"
        assert one.audit.violations == other.audit.violations == ()
        assert other.energies.total == pytest.approx(one.energies.total, rel=1e-6)
        assert len(one.measures.tips) == len(other.measures.tips)
    assert alone.steps[-1].energies.surface > 0.5
    assert len(alone.steps[-1].measures.tips) > 1

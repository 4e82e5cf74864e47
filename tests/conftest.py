"""Marks by folder: what lies in tests/mpi starts mpiexec. Compiling, and the simulator's Python."""

import os
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

import support.compiling  # noqa: F401
from staffa.errors import InputError
from staffa.reservoir.interpreter import simulator_python

TESTS = Path(__file__).parent
MPI = TESTS / "mpi"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark each test by its folder; refuse the mark `mpi` elsewhere."""
    for item in items:
        if item.path.is_relative_to(MPI):
            item.add_marker("mpi")
        elif item.get_closest_marker("mpi"):
            raise pytest.UsageError(f"{item.nodeid} is marked mpi: such tests lie in tests/mpi")


@pytest.fixture(autouse=True)
def systems_are_destroyed() -> Iterator[None]:
    """Destroy the systems that a test leaves behind; tests that load no DOLFINx build none."""
    if "staffa.evolution.system" not in sys.modules:
        yield
        return
    from support.systems import destroyed_when_left

    with destroyed_when_left():
        yield


@pytest.fixture(scope="session")
def darts_python() -> Path:
    """The Python that has open-DARTS.

    A test that asks for it is skipped if there is none; with STAFFA_REQUIRE_DARTS=1 it fails.
    """
    try:
        return simulator_python()
    except InputError as error:
        if os.environ.get("STAFFA_REQUIRE_DARTS") == "1":
            pytest.fail(f"STAFFA_REQUIRE_DARTS is 1. {error}")
        pytest.skip(str(error))

"""Marks by folder: what lies in tests/mpi starts mpiexec. Forms are compiled with less ado."""

from pathlib import Path

import pytest

import support.compiling  # noqa: F401

TESTS = Path(__file__).parent
MPI = TESTS / "mpi"


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark each test by its folder; refuse the mark `mpi` elsewhere."""
    for item in items:
        if item.path.is_relative_to(MPI):
            item.add_marker("mpi")
        elif item.get_closest_marker("mpi"):
            raise pytest.UsageError(f"{item.nodeid} is marked mpi: such tests lie in tests/mpi")

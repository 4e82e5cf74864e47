"""Sweeps and iterations of small cases are those on record."""

from staffa.backend.stack import MPI  # noqa: F401

import pytest

from bench.common.cases import COUNTED
from bench.history import counts


@pytest.mark.parametrize("name", COUNTED)
@pytest.mark.parametrize("meshes", counts.MESHES)
def test_counts_are_the_last_on_record(name: str, meshes: str) -> None:
    expected = counts.last()["counts"][f"{name}, {meshes}"]
    found = counts.counts(COUNTED[name], meshes)
    assert found["sweeps"] > 1
    assert found == {
        key: pytest.approx(number, rel=counts.ALLOWED) for key, number in expected.items()
    }, "where that is meant: python -m bench.history.counts"

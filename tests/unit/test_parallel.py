"""Reductions on one rank: what is not a number is not lost, and errors keep their words."""

from collections.abc import Callable

from staffa.backend.stack import MPI

import numpy as np
import pytest

from staffa.backend.parallel import (
    any_over_ranks,
    best_candidate,
    gather,
    max_over_ranks,
    on_root,
    sum_over_ranks,
)
from staffa.errors import InputError

COMMS = [MPI.COMM_SELF, MPI.COMM_WORLD]
NAN = float("nan")


@pytest.mark.parametrize("comm", COMMS, ids=["self", "world"])
@pytest.mark.parametrize(
    "values", [NAN, [NAN], [NAN, 1.0], [1.0, NAN], [1.0, NAN, 2.0], [np.inf, NAN]], ids=str
)
def test_nan_anywhere_gives_nan(comm: MPI.Comm, values: float | list[float]) -> None:
    found = max_over_ranks(comm, np.array(values))
    assert np.isnan(found), f"{found} from {values}"


class BesideOne:
    """A communicator of two ranks, as seen from one of them; the other one holds 1.0.

    MPI leaves open what the maximum of a number and NaN is; here, as with many, NaN is lost.
    """

    def allreduce(self, value: float, op: MPI.Op) -> float:
        """Reduce with the other rank's part."""
        return max(1.0, value) if op == MPI.MAX else value


@pytest.mark.parametrize(
    ("values", "expected"), [([], 1.0), ([0.5], 1.0), ([2.0], 2.0), ([2.0, NAN], NAN), (NAN, NAN)]
)
def test_a_ranks_nan_is_not_lost_beside_anothers_number(
    values: float | list[float], expected: float
) -> None:
    found = max_over_ranks(BesideOne(), np.array(values))  # type: ignore[arg-type]
    assert found == pytest.approx(expected, nan_ok=True), f"{found} from {values} beside 1.0"


@pytest.mark.parametrize("comm", COMMS, ids=["self", "world"])
@pytest.mark.parametrize(
    ("values", "expected"),
    [(3.0, 3.0), ([-2.0, -1.0], -1.0), ([1.0, np.inf], np.inf), ([], -np.inf)],
    ids=str,
)
def test_the_largest_entry_is_found_and_of_none_it_is_minus_infinity(
    comm: MPI.Comm, values: float | list[float], expected: float
) -> None:
    found = max_over_ranks(comm, np.array(values))
    assert found == expected and type(found) is float, f"{found!r} from {values}"


def test_one_rank_sums_and_gathers_its_own_part() -> None:
    comm, part = MPI.COMM_SELF, np.array([1.0, 2.0])
    assert sum_over_ranks(comm, 2.5) == 2.5
    assert np.array_equal(sum_over_ranks(comm, part), part)
    parts = gather(comm, part)
    assert parts is not None and len(parts) == 1 and np.array_equal(parts[0], part)
    assert (any_over_ranks(comm, True), any_over_ranks(comm, False)) == (True, False)


def test_a_rank_without_a_candidate_proposes_none() -> None:
    assert best_candidate(MPI.COMM_SELF, None) is None
    assert best_candidate(MPI.COMM_SELF, (1.0, 2.0)) == (1.0, 2.0)


def test_what_rank_zero_returns_is_the_result() -> None:
    assert on_root(MPI.COMM_WORLD, lambda: {"a": 1}) == {"a": 1}


def raising(error: Exception) -> Callable[[], None]:
    """An action that fails."""

    def action() -> None:
        raise error

    return action


@pytest.mark.parametrize(
    "error", [InputError("no such key"), ValueError("ill"), FileNotFoundError(2, "gone", "a.toml")]
)
def test_an_error_of_rank_zero_is_raised_as_it_is(error: Exception) -> None:
    with pytest.raises(type(error)) as caught:
        on_root(MPI.COMM_WORLD, raising(error))
    assert str(caught.value) == str(error)


class LockedError(Exception):
    """An error that holds what cannot be sent to another rank."""

    def __init__(self, words: str) -> None:
        super().__init__(words)
        self.key = lambda: None


class TwoWordsError(Exception):
    """An error that is sent, but cannot be made again from its words alone."""

    def __init__(self, one: str, two: str) -> None:
        super().__init__(f"{one} and {two}")


@pytest.mark.parametrize(
    ("error", "words"),
    [
        (LockedError("it holds a key"), "LockedError: it holds a key"),
        (TwoWordsError("a", "b"), "TwoWordsError: a and b"),
    ],
    ids=["cannot be sent", "cannot be received"],
)
def test_an_error_that_cannot_travel_keeps_its_words(error: Exception, words: str) -> None:
    with pytest.raises(RuntimeError) as caught:
        on_root(MPI.COMM_WORLD, raising(error))
    assert str(caught.value) == words

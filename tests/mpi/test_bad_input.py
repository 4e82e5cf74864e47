"""Bad input under mpiexec: one sentence, once."""

from case.test_bad_input import (
    files_in,
    place,  # noqa: F401
    staffa,
)


def test_two_ranks_say_it_once_and_leave_no_trace(place):
    before = files_in(place)
    done = staffa(place, "run", "my.toml", "--out", "runs/a", "--set", "domain.h=-1", ranks=2)
    assert done.returncode == 2, f"exit code {done.returncode}: {done.stderr}"
    assert done.stderr.count("domain.h = -1: it must be larger than zero") == 1, done.stderr
    assert "Traceback" not in done.stderr and files_in(place) == before

"""A small run that cracks, and ways to cut it short: what the tests of restarts share."""

import os
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

from staffa.case.reading.read import parse_case
from staffa.case.schema.case import Case
from staffa.errors import StoppedError
from staffa.io.run_directory import Run, open_run
from staffa.runs.resume import resume
from staffa.runs.run import Watcher, run
from support.paths import BIN

SMALL = """
[domain]
size = [1.0, 0.4]
h = 0.05
[damage]
ell = 0.1
[toughness]
amplitude = 0.1
seed = 3
[temperature]
profile = "slab"
severity = 8.0
[supports]
left = "rollers"
right = "rollers"
[time]
tau = { start = 0.1, stop = 0.6, steps = 6 }
[output]
at = [0.3]
[solver]
guess = "none"
"""


def small(*settings: str) -> Case:
    """The case, with settings put over it."""
    return parse_case(SMALL, settings)


class After:
    """Asks to stop at the look of this number: there is one before each step and one a sweep."""

    def __init__(self, looks: int) -> None:
        self.left = looks

    def __call__(self) -> str | None:
        """Why to stop, or None."""
        self.left -= 1
        return "enough was seen" if self.left < 0 else None


def stopped(call: Callable[[], object]) -> str:
    """The sentence with which it stops."""
    try:
        call()
    except StoppedError as error:
        return str(error)
    raise AssertionError("it came to its end")


def cut_run(case: Case, directory: Path, looks: int) -> str:
    """Run until this number of looks, and give what it says then."""
    return stopped(lambda: run(case, directory, watcher=Watcher(stop=After(looks))))


def finish(directory: Path, looks: int, most: int = 20) -> int:
    """Resume, stopping again and again after this number of looks, to the end; how many times."""
    for times in range(1, most):
        try:
            resume(directory, watcher=Watcher(stop=After(looks)))
        except StoppedError:
            continue
        return times
    raise AssertionError(f"{most} times were not enough")


def launch(
    *arguments: str | Path, ranks: int = 1, timeout: float = 300
) -> subprocess.CompletedProcess:
    """Python or staffa in a separate process, to its end."""
    process = started(*arguments, ranks=ranks)
    try:
        out, err = process.communicate(timeout=timeout)
    except subprocess.TimeoutExpired:
        process.terminate()  # mpiexec then ends its ranks, which would go on waiting
        process.communicate()
        raise
    return subprocess.CompletedProcess(process.args, process.returncode, out, err)


def started(*arguments: str | Path, ranks: int = 1) -> subprocess.Popen:
    """The same, not waited for."""
    command = [str(BIN / arguments[0]), *map(str, arguments[1:])]
    if ranks > 1:
        command = [str(BIN / "mpiexec"), "-n", str(ranks), *command]
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    return subprocess.Popen(
        command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=environment
    )


def assert_same(found: Run, expected: Run, rel: float = 0.0) -> None:
    """Every step once, and all of them as they are without a cut."""
    assert found.finished and [s.index for s in found.steps] == list(range(len(expected.steps)))
    assert_steps(found.steps, expected.steps, rel)
    assert [s.index for s in found.superseded] == [s.index for s in expected.superseded]
    assert [s.time for s in found.rejected] == [s.time for s in expected.rejected]
    fields = {s.fields for s in found.steps if s.fields}
    assert {f"fields/{p.name}" for p in (found.path / "fields").glob("*.vtkhdf")} == fields
    assert not list(found.path.rglob("*.staffa-part"))


def assert_steps(found: Sequence, expected: Sequence, rel: float) -> None:
    """Energies to `rel`; at 0 everything else is the same to the last bit too, but the seconds."""
    for here, there in zip(found, expected, strict=True):
        a, b = here.energies.total, there.energies.total
        assert abs(a - b) <= rel * abs(b), f"step {here.index}: energy {a!r} against {b!r}"
        if not rel:
            same = ("time", "energies", "sweeps", "audit", "measures", "heat", "returned", "mesh")
            for name in same:
                one, other = getattr(here, name), getattr(there, name)
                assert one == other, f"step {here.index}: {name} {one} against {other}"


def whole_run(case: Case, directory: Path) -> Run:
    """The run without a cut."""
    run(case, directory)
    return open_run(directory)

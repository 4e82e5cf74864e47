"""Runs that are killed, stopped, or whose disk fails them, for real: each goes on as it was."""

import os
import random
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from matplotlib.figure import Figure

from staffa.backend.lock import Lock
from staffa.cli.stopping import Stopping
from staffa.errors import StaffaError, StoppedError
from staffa.io.network_files import write_vtp
from staffa.io.run_directory import STEPS, Run, open_run
from staffa.plot.style import write_picture
from staffa.runs.resume import resume
from staffa.runs.run import Watcher, run
from support.restarting import SMALL, assert_same, assert_steps, launch, small, started, whole_run

# Energies after a kill: on one rank the same to the last bit, far more than 1e-8 asks for.
EXACT = 0.0
MANY = "time.tau={start=0.03,stop=0.6,steps=20}"


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    """A folder with the case."""
    folder = tmp_path_factory.mktemp("killed")
    (folder / "my.toml").write_text(SMALL)
    return folder


@pytest.fixture(scope="module")
def expected(place: Path) -> Run:
    """The run of many steps without a cut."""
    return whole_run(small(MANY), place / "whole")


def begin(place: Path, directory: Path, *more: str, ranks: int = 1) -> subprocess.Popen:
    """The run of many steps in a separate process."""
    arguments = ("run", place / "my.toml", "--set", MANY, "--out", directory, "--quiet", *more)
    return started("staffa", *arguments, ranks=ranks)


def lines(directory: Path) -> int:
    """Number of steps on record."""
    file = directory / STEPS
    return file.read_bytes().count(b"\n") if file.exists() else 0


def wait_for(condition, process: subprocess.Popen, seconds: float = 240) -> bool:
    """True if the condition is met before the process ends."""
    until = time.monotonic() + seconds
    while time.monotonic() < until:
        if condition():
            return True
        if process.poll() is not None:
            return False
        time.sleep(0.0005)
    raise AssertionError("nothing happened")


def makes_a_step(process: subprocess.Popen, directory: Path) -> bool:
    """True if one more step is recorded before the process ends."""
    before = lines(directory)
    return wait_for(lambda: lines(directory) > before, process)


def kill_and_resume(place: Path, directory: Path, kills: int, seed: int) -> int:
    """Kill a run so often by SIGKILL, every second time while it writes; how often it was alive."""
    draw, killed = random.Random(seed), 0
    process = begin(place, directory)
    for number in range(kills):
        alive = makes_a_step(process, directory)
        if number % 2:
            alive = alive and wait_for(lambda: any(directory.rglob("*.staffa-part")), process)
        else:
            time.sleep(draw.uniform(0, 0.5))
        process.kill()
        process.communicate()
        killed += alive and process.returncode == -signal.SIGKILL
        process = started("staffa", "resume", directory, "--quiet")
    _, said = process.communicate(timeout=300)
    assert process.returncode == 0, said
    return killed


@pytest.mark.slow
def test_a_run_that_is_killed_goes_on_as_if_nothing_had_happened(place, expected) -> None:
    killed = kill_and_resume(place, place / "few", kills=3, seed=1)
    assert killed >= 2, f"it was alive at {killed} of 3 kills"
    assert_same(open_run(place / "few"), expected, EXACT)


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_fifty_kills_lose_nothing(place, expected) -> None:
    """In runs of 20 steps each, started again until there were 50 kills."""
    killed = number = 0
    while killed < 50:
        directory = place / f"many-{number}"
        killed += kill_and_resume(place, directory, kills=15, seed=number)
        assert_same(open_run(directory), expected, EXACT)
        number += 1
        assert number < 20, f"{killed} kills in {number} runs"


@pytest.mark.slow
def test_a_signal_stops_a_run_which_says_how_to_go_on(place, expected) -> None:
    """SIGTERM, then SIGINT; then a wall time that is over at once; then nothing."""
    directory = place / "asked"
    process = begin(place, directory)
    for number in (signal.SIGTERM, signal.SIGINT):
        assert makes_a_step(process, directory)
        process.send_signal(number)
        out, said = process.communicate(timeout=120)
        last = lines(directory) - 1
        assert (process.returncode, out) == (3, ""), said
        assert said == (
            f"staffa: stopped, since {number.name} asked for it: step {last} is finished; "
            f"`staffa resume {directory}` goes on\n"
        )
        process = started("staffa", "resume", directory, "--quiet")
    process.kill()
    process.communicate()
    over = launch("staffa", "resume", directory, "--quiet", "--wall-time", "0.1 s")
    assert over.returncode == 3 and over.stderr.count("\n") == 1, over.stderr
    assert "its wall time is nearly over" in over.stderr
    resume(directory)
    assert_same(open_run(directory), expected, EXACT)


def test_only_one_process_writes_to_a_run_and_a_dead_one_is_known(tmp_path: Path) -> None:
    code = (
        "import sys, time\n"
        "from pathlib import Path\n"
        "from staffa.backend.lock import Lock\n"
        f"lock = Lock(Path({str(tmp_path)!r})); lock.take(); print(flush=True); time.sleep(100)"
    )
    holder = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE)
    assert holder.stdout.readline() == b"\n"
    with pytest.raises(StaffaError, match=f"written to by process {holder.pid} on ") as refused:
        Lock(tmp_path).take()
    assert refused.value.exit_code == 2
    holder.kill()
    holder.communicate()
    lock = Lock(tmp_path)
    assert f"process {holder.pid} on " in (lock.take() or "")
    lock.release()
    assert lock.take() is None
    lock.release()


@pytest.mark.slow
def test_a_second_run_in_the_same_directory_is_refused(tmp_path: Path) -> None:
    """While the first computes, which then ends as if nothing had been asked."""
    refusals = []

    def meddle(step) -> None:
        if step.index == 0:
            done = launch("staffa", "resume", tmp_path / "run")
            refusals.append((done.returncode, done.stdout, done.stderr))

    case = small("time.tau=[0.1,0.2]", "output.at=[]")
    run(case, tmp_path / "run", watcher=Watcher(stepped=meddle))
    ((code, out, said),) = refusals
    assert (code, out) == (2, "") and said.count("\n") == 1, said
    assert f"is being written to by process {os.getpid()} on " in said
    assert open_run(tmp_path / "run").finished


@pytest.fixture
def disk(tmp_path: Path):
    """A small separate disk, in memory."""
    folder = tmp_path / "disk"
    folder.mkdir()
    mount = ["mount", "-t", "tmpfs", "-o", "size=150k", "tmpfs", str(folder)]
    if shutil.which("mount") is None or subprocess.run(mount, capture_output=True).returncode:
        pytest.skip("no file system can be mounted here")
    yield folder
    subprocess.run(["umount", str(folder)], check=True)


def remount(disk: Path, option: str) -> None:
    subprocess.run(["mount", "-o", f"remount,{option}", str(disk)], check=True)


@pytest.mark.slow
def test_a_full_disk_and_one_that_cannot_be_written_to_lose_nothing(disk: Path, tmp_path) -> None:
    """It fills up at whatever is written then; then it is larger, but read-only at first."""
    case = small("output.steps=all")
    expected = whole_run(case, tmp_path / "whole")
    with pytest.raises(StoppedError, match="cannot be written to") as full:
        run(case, disk / "run")
    assert full.value.exit_code == 3 and f"`staffa resume {disk / 'run'}`" in str(full.value)
    cut = open_run(disk / "run")
    assert_steps(cut.steps, expected.steps[: len(cut.steps)], EXACT)
    remount(disk, "size=10m,ro")
    with pytest.raises(StaffaError, match=r"cannot be written to \(Read-only") as refused:
        resume(disk / "run")
    assert refused.value.exit_code == 2
    remount(disk, "rw")
    resume(disk / "run")
    assert_same(open_run(disk / "run"), expected, EXACT)


def test_a_network_and_a_picture_on_a_full_disk_are_errors_and_leave_nothing(disk: Path) -> None:
    x = np.random.default_rng(0).random((20_000, 3))
    lines = [np.arange(20_000)]
    with pytest.raises(OSError, match="No space left"):
        write_vtp(disk / "a.vtp", x, lines, surface=False, at_points={}, on_cells={})

    def noise() -> Figure:
        figure = Figure(figsize=(4, 4))
        figure.figimage(x[:, :1].reshape(100, 200))
        return figure

    (disk / "full").write_bytes(bytes(140 * 1024))
    with pytest.raises(OSError, match="No space left"):
        write_picture(disk / "a.png", noise)
    assert [path.name for path in disk.iterdir()] == ["full"]


def test_where_nothing_can_be_started_nothing_is_left_to_go_on_with(disk: Path) -> None:
    """The disk is full before the run has started: the same command does once there is room."""
    (disk / "full").write_bytes(bytes(143 * 1024))
    case = small("time.tau=[0.1]", "output.at=[]")
    with pytest.raises(StaffaError, match="no run was started") as full:
        run(case, disk / "run")
    assert full.value.exit_code == 1
    (disk / "full").unlink()
    remount(disk, "size=10m")
    assert run(case, disk / "run")


def test_a_directory_that_is_removed_ends_the_run_in_a_sentence(tmp_path: Path) -> None:
    def remove(step) -> None:
        shutil.rmtree(tmp_path / "run")

    with pytest.raises(StaffaError, match="it is gone") as gone:
        run(small(), tmp_path / "run", watcher=Watcher(stepped=remove))
    assert gone.value.exit_code == 1


def test_a_wall_time_ends_before_the_next_look_would_be_too_late(monkeypatch) -> None:
    """Two looks that lie 10 s apart, of 100 s: the last one that leaves time is at 70 s."""
    now = 0.0
    monkeypatch.setattr("staffa.cli.stopping.perf_counter", lambda: now)
    stopping, reasons = Stopping(100.0), []
    while not reasons:
        now += 10.0
        reasons += [reason for reason in (stopping.reason(),) if reason]
    assert now == 80.0 and reasons == ["its wall time is nearly over"]
    assert Stopping(None).reason() is None


def test_a_second_signal_ends_at_once_but_not_its_echo() -> None:
    """A launcher and a terminal may both pass one on."""
    code = (
        "import os, signal, time\n"
        "from staffa.cli import stopping\n"
        "stopping.ONCE = 0.2\n"
        "stop = stopping.Stopping()\n"
        "with stop.heeded():\n"
        "    os.kill(os.getpid(), signal.SIGINT); os.kill(os.getpid(), signal.SIGINT)\n"
        "    print(stop.reason(), flush=True)\n"
        "    time.sleep(0.3)\n"
        "    os.kill(os.getpid(), signal.SIGINT)\n"
        "    print('not at once')\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60)
    assert done.stdout == "SIGINT asked for it\n" and done.returncode == -signal.SIGINT, done


def test_what_breaks_as_a_signal_comes_is_an_interruption() -> None:
    """The compiler gets it too; on more ranks others may wait for the one that it broke for."""
    for ranks, kind in ((1, KeyboardInterrupt), (2, RuntimeError)):
        with pytest.raises(kind), Stopping().heeded(ranks):
            os.kill(os.getpid(), signal.SIGINT)
            raise RuntimeError("the compiler was interrupted")


STEADY = ["time.tau={start=0.0002,stop=0.4,steps=2000}", "output.steps=all", "output.at=[]"]


def resident() -> float:
    """Memory of this process (MB)."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * os.sysconf("SC_PAGE_SIZE") / 1e6


@pytest.mark.long
@pytest.mark.timeout(3600)
def test_memory_stays_flat_over_two_thousand_steps(tmp_path: Path) -> None:
    """With all fields and checkpoints kept; what a record of a step takes is a few kB."""
    size: dict[int, float] = {}
    settings = [*STEADY, "domain.h=0.2", "damage.ell=0.2", "temperature.severity=1.0"]
    watcher = Watcher(stepped=lambda step: size.update({step.index: resident()}))
    steps = run(small(*settings), tmp_path / "run", watcher=watcher)
    assert len(steps) == 2000
    grown = size[1999] - size[200]
    assert grown < 20.0, f"{size[200]:.1f} MB after 200 steps, {size[1999]:.1f} MB after 2000"

"""One lock serves run directories and the cache of compiled forms."""

import fcntl
import os
import subprocess
import sys
from errno import ENOLCK
from pathlib import Path

import pytest

from staffa.backend.lock import LOCK, Lock
from staffa.errors import InputError
from support.paths import ROOT

SOURCE = ROOT / "src" / "staffa"


def test_one_module_locks_files() -> None:
    """But for `doctor`, which tries whether this file system has locks."""
    users = {path.name for path in SOURCE.rglob("*.py") if "import fcntl" in path.read_text()}
    assert users == {"lock.py", "checks.py"}


def test_a_second_writer_is_told_who_the_first_is(tmp_path: Path) -> None:
    first, second = Lock(tmp_path), Lock(tmp_path)
    assert first.take() is None
    with pytest.raises(InputError, match=f"is being written to by process {os.getpid()} on "):
        second.take()
    assert (tmp_path / LOCK).read_text().startswith("process "), "the first is still named"
    first.release()
    assert (tmp_path / LOCK).read_text() == ""
    assert second.take() is None
    second.release()
    second.release()


def test_many_share_a_lock_that_one_alone_then_waits_for(tmp_path: Path) -> None:
    with Lock(tmp_path).held(shared=True) as one, Lock(tmp_path).held(shared=True) as other:
        assert one and other
        with Lock(tmp_path).held(wait=False) as alone:
            assert not alone
    with Lock(tmp_path).held(wait=False) as alone:
        assert alone
        with Lock(tmp_path).held(shared=True, wait=False) as one:
            assert not one


def test_a_lock_goes_with_the_process_that_was_killed(tmp_path: Path) -> None:
    code = (
        "import os, signal, pathlib\n"
        "from staffa.backend.lock import Lock\n"
        f"lock = Lock(pathlib.Path({str(tmp_path)!r})); lock.take()\n"
        "os.kill(os.getpid(), signal.SIGKILL)"
    )
    assert subprocess.run([sys.executable, "-c", code]).returncode == -9
    lock = Lock(tmp_path)
    said = lock.take() or ""
    assert said.startswith("process ") and f"was cut while it wrote to {tmp_path}" in said
    lock.release()


def test_a_lock_is_not_handed_on_to_a_program_that_is_started(tmp_path: Path) -> None:
    """A compiler that hangs would otherwise hold it."""
    with Lock(tmp_path).held() as alone:
        program = subprocess.Popen(["sleep", "60"], close_fds=False)
    try:
        assert alone
        with Lock(tmp_path).held(wait=False) as again:
            assert again
    finally:
        program.kill()
        program.wait()


def test_a_link_in_the_place_of_the_lock_is_not_followed(tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    mine.write_text("canary")
    (tmp_path / LOCK).symlink_to(mine)
    with pytest.raises(InputError, match="cannot be written to"):
        Lock(tmp_path).take()
    with Lock(tmp_path).held() as had:
        assert not had
    assert mine.read_text() == "canary"


def test_a_folder_that_cannot_be_written_to_is_named(tmp_path: Path) -> None:
    gone = tmp_path / "gone"
    with pytest.raises(InputError, match=r"gone cannot be written to \(.*\); see to that first"):
        Lock(gone).take()
    with Lock(gone).held() as had:
        assert not had


def test_a_file_system_without_locks_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def flock(file: int, kind: int) -> None:
        raise OSError(ENOLCK, "No locks available")

    monkeypatch.setattr(fcntl, "flock", flock)
    lock = Lock(tmp_path)
    assert "file system without locks: run nothing else in it" in (lock.take() or "")
    lock.release()
    with Lock(tmp_path).held() as had:
        assert not had

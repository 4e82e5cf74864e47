"""tools/reservoir.sh finds a Python for the simulator, installs once, or says what is missing."""

import os
import shutil
import subprocess
from pathlib import Path

import pytest

from support.paths import ROOT

TOOLS = ["sh", "dirname", "uname", "ls", "cat", "find", "rmdir", "rm", "mkdir", "touch", "tail"]
# Answers like a Python: says where it is, makes an environment, installs.
PYTHON = """#!/bin/sh
case "$*" in
    *"-m venv"*) mkdir -p .reservoir/bin; cp "$0" .reservoir/bin/python ;;
    *"-m pip"*) echo "$*" >>installed; exit {code} ;;
    *import*) echo {here} ;;
esac
"""


@pytest.fixture
def copy(tmp_path: Path) -> Path:
    """A copy of the script in an empty folder, with few programs in PATH and no Python."""
    (tmp_path / "tools").mkdir()
    (tmp_path / "bin").mkdir()
    shutil.copy(ROOT / "tools" / "reservoir.sh", tmp_path / "tools")
    shutil.copy(ROOT / "constraints-reservoir.txt", tmp_path)
    for tool in [*TOOLS, "cp"]:
        (tmp_path / "bin" / tool).symlink_to(str(shutil.which(tool)))
    return tmp_path


def run(folder: Path, **more: str) -> subprocess.CompletedProcess[str]:
    """Run the script."""
    environment = {"PATH": str(folder / "bin"), "HOME": str(folder), **more}
    return subprocess.run(
        ["tools/reservoir.sh"], cwd=folder, env=environment, capture_output=True, text=True
    )


def python(folder: Path, name: str, code: int = 0) -> Path:
    """Make a program that answers like a Python."""
    path = folder / "bin" / name
    path.write_text(PYTHON.format(code=code, here=path))
    path.chmod(0o755)
    return path


def test_without_a_python_it_refuses_in_a_sentence_and_makes_nothing(copy: Path) -> None:
    new = copy / "bin" / "python3"
    new.write_text("#!/bin/sh\nexit 1\n")  # as of Python 3.14, which the probe refuses
    new.chmod(0o755)
    done = run(copy)
    assert done.returncode == 2 and done.stdout == ""
    assert done.stderr.startswith("reservoir: no Python 3.11, 3.12 or 3.13 that can make")
    assert done.stderr.count("\n") == 1 and not (copy / ".reservoir").exists()


def test_it_installs_the_pins_once_and_again_when_they_change(copy: Path) -> None:
    python(copy, "python3.12")
    done = run(copy)
    assert done.returncode == 0 and "making .reservoir with" in done.stdout, done
    (told,) = (copy / "installed").read_text().splitlines()
    assert "--no-deps" in told and "constraints-reservoir.txt" in told
    assert run(copy).stdout == ""
    assert len((copy / "installed").read_text().splitlines()) == 1
    pins = copy / "constraints-reservoir.txt"
    later = (copy / ".reservoir" / ".ready").stat().st_mtime + 10
    os.utime(pins, (later, later))
    assert "making .reservoir" in run(copy).stdout


def test_a_named_python_goes_first_and_a_failed_install_is_told(copy: Path) -> None:
    python(copy, "python3.12")
    named = python(copy, "mine", code=1)
    done = run(copy, PYTHON=str(named))
    assert done.returncode == 2 and f"with {named}" in done.stdout
    assert "the installation failed" in done.stderr
    assert not (copy / ".reservoir" / ".ready").exists()


def test_a_folder_that_is_not_its_own_is_left_alone(copy: Path) -> None:
    python(copy, "python3.12")
    (copy / ".reservoir").mkdir()
    (copy / ".reservoir" / "notes.txt").touch()
    done = run(copy)
    assert done.returncode == 2 and "was not made by this script" in done.stderr
    assert (copy / ".reservoir" / "notes.txt").exists()


def test_the_pins_are_exact_and_name_the_simulator() -> None:
    lines = (ROOT / "constraints-reservoir.txt").read_text().split("\n")
    pins = [line for line in lines if line and not line.startswith("#")]
    assert all(pin.count("==") == 1 and " " not in pin and "@" not in pin for pin in pins), pins
    assert "open-darts==2.0.0" in pins

"""`staffa doctor` says in a sentence what is wrong with an installation that is really broken."""

import os
import subprocess
import time
from pathlib import Path

import pytest

from staffa.backend.child_process import output_of
from staffa.doctor import OK, UNTRIED, WRONG, checks
from staffa.errors import StaffaError
from support.paths import BIN


def doctor(folder: Path, **environment: str) -> tuple[int, dict[str, tuple[str, str]]]:
    """Exit code of the command; name -> verdict and sentence."""
    done = subprocess.run(
        [BIN / "staffa", "doctor"],
        cwd=folder,
        env=os.environ | {"OMP_NUM_THREADS": "1"} | environment,
        capture_output=True,
        text=True,
        timeout=400,
    )
    assert done.stderr == "", done.stderr
    lines = [
        line.split(maxsplit=2) for line in done.stdout.replace("two ranks", "ranks").splitlines()
    ]
    return done.returncode, {name: (verdict, said) for verdict, name, said in lines}


@pytest.mark.slow
def test_each_thing_that_is_wrong_has_its_sentence(tmp_path: Path) -> None:
    """Nothing in PATH, a cache that is no folder, and threads that were not thought of."""
    for name in ("bin", "here"):
        (tmp_path / name).mkdir()
    (tmp_path / "file").touch()
    environment = {"PATH": str(tmp_path / "bin"), "XDG_CACHE_HOME": str(tmp_path / "file")}
    environment |= {"CC": "", "OMP_NUM_THREADS": "4"}
    code, found = doctor(tmp_path / "here", **environment)
    assert code == 1
    wrong = {name: said for name, (verdict, said) in found.items() if verdict == WRONG}
    assert wrong.keys() == {"compiler", "headers", "cache", "mpiexec"}, found
    assert wrong["compiler"].startswith("there is no C compiler 'gcc'"), wrong
    assert f"cannot be kept in {tmp_path}/file/staffa" in wrong["cache"]
    assert "name another folder with XDG_CACHE_HOME" in wrong["cache"]
    assert wrong["mpiexec"].startswith("there is no mpiexec in PATH"), wrong
    assert found["ranks"] == (UNTRIED, "not tried; see to what is wrong above first")
    assert "OMP_NUM_THREADS is 4: threads" in found["threads"][1]
    assert found["libraries"][0] == OK and not list((tmp_path / "here").iterdir())


def sentence(look) -> str:
    with pytest.raises(StaffaError) as error:
        look()
    return str(error.value)


@pytest.mark.parametrize(
    ("command", "why"),
    [
        ("nocompiler", "there is no C compiler 'nocompiler'"),
        ("false", "'false' compiles nothing: false failed; install one"),
        ("true", "'true' compiles nothing: a.out cannot be started (No such file"),
        ("cc -nonsense", "'cc -nonsense' compiles nothing: "),
    ],
)
def test_a_compiler_that_compiles_nothing_is_known(command: str, why: str, monkeypatch) -> None:
    monkeypatch.setenv("CC", command)
    said = sentence(checks.compiler)
    assert why in said and "CC=" in said, said


def test_headers_of_another_python_are_known(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr(checks.sysconfig, "get_path", lambda name: str(tmp_path))
    assert "there is no Python.h in" in sentence(checks.headers)
    (tmp_path / "Python.h").write_text('#define PY_VERSION "2.7.18"\n')
    assert "is of Python 2.7.18" in sentence(checks.headers)
    (tmp_path / "Python.h").write_text("not C\n")
    assert "cannot be used: " in sentence(checks.headers)


LAUNCHERS = {
    'shift 2; "$@"; "$@"': "starts ranks that do not see one another",  # another MPI's
    "exit 7": "starts no two ranks (mpiexec failed)",
    "kill -SEGV $$": "starts no two ranks (mpiexec was ended by SIGSEGV)",
}


@pytest.mark.parametrize("script", LAUNCHERS)
def test_a_launcher_of_another_mpi_is_known(script: str, tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "mpiexec").write_text(f"#!/bin/bash\n{script}\n")
    (tmp_path / "mpiexec").chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path), prepend=os.pathsep)
    assert LAUNCHERS[script] in sentence(checks.mpiexec)


def test_a_stack_that_does_not_load_is_known(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "dolfinx.py").write_text("raise ImportError('libpetsc.so.3: no such file')\n")
    monkeypatch.syspath_prepend(tmp_path)
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    said = sentence(checks.libraries)
    assert "(ImportError: libpetsc.so.3: no such file)" in said and "install DOLFINx again" in said


def test_a_folder_that_is_gone_is_known(tmp_path: Path, monkeypatch) -> None:
    (tmp_path / "gone").mkdir()
    monkeypatch.chdir(tmp_path / "gone")
    (tmp_path / "gone").rmdir()
    assert "work in another one" in sentence(checks.folder)


def test_what_crashes_or_hangs_does_so_in_another_process() -> None:
    """Its own children end with it."""
    crash = "import os, signal; os.kill(os.getpid(), signal.SIGSEGV)"
    assert "was ended by SIGSEGV" in sentence(lambda: checks.in_python(crash))
    assert sentence(lambda: checks.in_python("raise ValueError('so')")) == "ValueError: so"
    began = time.monotonic()
    said = sentence(lambda: output_of(["sh", "-c", "sleep 50 & sleep 60"], seconds=0.5))
    assert said == "sh did not end within 0.5 s" and time.monotonic() - began < 30

"""What compiles forms: a C compiler, Python's headers, and a folder that keeps them."""

import os
import shlex
import shutil
import sysconfig
import tempfile
from pathlib import Path

from staffa.doctor.child import python, spoken
from staffa.errors import StaffaError

GET_ONE = "install one (apt install gcc, dnf install gcc), or name yours like CC=/usr/bin/gcc"
HELLO = '#include <stdio.h>\nint main(void) { puts("hello"); return 0; }\n'
VERSION = "#include <Python.h>\n" + HELLO.replace('"hello"', "PY_VERSION")
CACHE = "from staffa.backend.jit import CACHE, cache_folder\nprint(CACHE)\nprint(cache_folder())"


def compiler() -> str:
    """The C compiler that compiles forms: CC, or the one that built Python."""
    command = _command()
    found = shutil.which(command[0])
    if found is None:
        raise StaffaError(f"there is no C compiler '{command[0]}', and forms need one; {GET_ONE}")
    try:
        _compiled_and_run(HELLO)
    except StaffaError as error:
        raise StaffaError(f"'{shlex.join(command)}' compiles nothing: {error}; {GET_ONE}") from None
    return found


def headers() -> str:
    """Python.h, of the Python that runs."""
    folder = sysconfig.get_path("include")
    version = sysconfig.get_python_version()
    if not (Path(folder) / "Python.h").is_file():
        raise StaffaError(
            f"there is no Python.h in {folder}, and forms need it; install the headers of Python "
            f"{version} (apt install python{version}-dev, dnf install python{version}-devel)"
        )
    try:
        told = _compiled_and_run(VERSION, f"-I{folder}").strip()
    except StaffaError as error:
        raise StaffaError(f"Python.h in {folder} cannot be used: {error}") from None
    if not told.startswith(version):
        raise StaffaError(f"Python.h in {folder} is of Python {told}, and this is {version}")
    return f"{folder}, of Python {told}"


def cache() -> str:
    """The folder of compiled forms: it can be written to, and how much is in it."""
    wanted, folder = map(Path, python(CACHE).strip().splitlines())
    if folder != wanted:
        raise StaffaError(
            f"compiled forms cannot be kept in {wanted}, which is not this user's alone to write "
            f"to, but in {folder} as long as that is there; name another folder with XDG_CACHE_HOME"
        )
    size = sum(file.stat().st_size for file in folder.iterdir() if file.is_file())
    return f"{folder}, {size / 1e6:.0f} MB of compiled forms"


def _command() -> list[str]:
    """As cffi finds it, by which forms are compiled."""
    given = os.environ.get("CC") or sysconfig.get_config_var("CC")
    return shlex.split(given or "") or ["cc"]


def _compiled_and_run(source: str, *flags: str) -> str:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "a.c").write_text(source)
        spoken([*_command(), *flags, "a.c", "-o", "a.out"], seconds=60, folder=folder)
        return spoken([folder / "a.out"], seconds=10)

"""The checks of an installation: each tells what it found, or raises what is wrong."""

import fcntl
import json
import os
import platform
import shlex
import shutil
import sys
import sysconfig
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from functools import cache as cached
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from typing import Any

from staffa.backend import isolation
from staffa.backend.child_process import output_of
from staffa.case.reading import ready_cases
from staffa.errors import StaffaError
from staffa.io.run_directory import open_run
from staffa.reservoir.interpreter import answers, simulator_python

HELLO = '#include <stdio.h>\nint main(void) { puts("hello"); return 0; }\n'
VERSION = "#include <Python.h>\n" + HELLO.replace('"hello"', "PY_VERSION")
STACK = """
import json
from staffa.backend.stack import MPI, PETSc, SLEPc
import dolfinx, mpi4py, petsc4py, slepc4py, ufl
found = {m.__name__: m.__version__ for m in (dolfinx, petsc4py, slepc4py, mpi4py)}
found["MPI"] = " ".join(MPI.Get_library_version().splitlines()[0].split())
sharing = [name for name in ("ptscotch", "parmetis", "kahip") if getattr(dolfinx, f"has_{name}")]
print(json.dumps([found, PETSc.Sys.hasExternalPackage("mumps"), sharing]))
"""
CACHE = "from staffa.backend.jit import CACHE, cache_folder\nprint(CACHE)\nprint(cache_folder())"
# One rank alone speaks: the launcher may mix what two say.
SIZE = """
from staffa.backend.stack import MPI
if MPI.COMM_WORLD.rank == 0:
    print(MPI.COMM_WORLD.size)
"""
GMSH = """
import gmsh
gmsh.initialize(readConfigFiles=False, interruptible=False)
print(gmsh.__version__)
"""
PICTURE = """
import pyvista
plotter = pyvista.Plotter(off_screen=True, window_size=(64, 64))
plotter.add_mesh(pyvista.Sphere())
print(plotter.screenshot(None, return_img=True).std() > 0)
"""
STAFFA = "from staffa.cli import main; main()"
SMALL = ("domain.h=0.05", "time.t=[0.1,0.9]", "output.at=[]", "solver.guess=none")
LITTLE = 1e9  # bytes; the fields and pictures of one run of the size of the slab take some 10 MB
GET_ONE = "install one (apt install gcc, dnf install gcc), or name yours like CC=/usr/bin/gcc"
FROM_WHERE = "install DOLFINx again, as docs/how-to/cluster.md says"


def require_sound(sound: object, sentence: str) -> None:
    """Raise a sentence unless what it is about is sound."""
    if not sound:
        raise StaffaError(sentence)


@contextmanager
def told_as(sentence: str) -> Iterator[None]:
    """Raise what goes wrong within as a sentence, in which {} is the reason."""
    try:
        yield
    except (StaffaError, OSError) as error:
        why = error.strerror if isinstance(error, OSError) else error
        raise StaffaError(sentence.replace("{}", str(why))) from None


def in_python(code: str, launcher: Sequence[str] = ()) -> str:
    """Return what this Python prints in another process, or in several."""
    command = [*launcher, *isolation.isolated_python(code)]
    return output_of(command, seconds=60, folder=Path(isolation.NOWHERE)).strip()


def python() -> str:
    """This Python; an older one than staffa needs cannot read this line."""
    return f"{platform.python_version()}, {sys.executable}"


def compiler() -> str:
    """The C compiler that compiles forms: CC, or the one that built Python."""
    command = _compiler()
    found = shutil.which(command[0])
    require_sound(found, f"there is no C compiler '{command[0]}', and forms need one; {GET_ONE}")
    with told_as(f"'{shlex.join(command)}' compiles nothing: {{}}; {GET_ONE}"):
        _compiled_and_run(HELLO)
    return str(found)


def headers() -> str:
    """Python.h, of the Python that runs."""
    folder, version = sysconfig.get_path("include"), sysconfig.get_python_version()
    require_sound(
        (Path(folder) / "Python.h").is_file(),
        f"there is no Python.h in {folder}, and forms need it; install the headers of Python "
        f"{version} (apt install python{version}-dev, dnf install python{version}-devel)",
    )
    with told_as(f"Python.h in {folder} cannot be used: {{}}"):
        told = _compiled_and_run(VERSION, f"-I{folder}").strip()
    wrong = f"Python.h in {folder} is of Python {told}, and this is {version}"
    require_sound(told.startswith(version), wrong)
    return f"{folder}, of Python {told}"


def _compiler() -> list[str]:
    """Return the command as cffi finds it, by which forms are compiled."""
    given = os.environ.get("CC") or sysconfig.get_config_var("CC")
    return shlex.split(given or "") or ["cc"]


def _compiled_and_run(source: str, *flags: str) -> str:
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "a.c").write_text(source)
        output_of([*_compiler(), *flags, "a.c", "-o", "a.out"], seconds=60, folder=folder)
        return output_of([folder / "a.out"], seconds=10)


@cached
def _stack() -> Any:
    """Return versions, whether MUMPS is there, and partitioners."""
    with told_as(f"the finite-element stack does not load ({{}}); {FROM_WHERE}"):
        return json.loads(in_python(STACK))


def libraries() -> str:
    """DOLFINx, PETSc, SLEPc and MPI, which load together."""
    return ", ".join(f"{name} {version}" for name, version in _stack()[0].items())


def petsc() -> str:
    """The direct solver of PETSc."""
    require_sound(_stack()[1], f"PETSc was built without MUMPS, the direct solver; {FROM_WHERE}")
    return "with MUMPS"


def partitioner() -> str:
    """A library by which DOLFINx shares a mesh out."""
    require_sound(_stack()[2], f"DOLFINx was built without a partitioner of meshes; {FROM_WHERE}")
    return ", ".join(_stack()[2])


def cache() -> str:
    """The folder of compiled forms: it can be written to, and how much is in it."""
    wanted, folder = map(Path, in_python(CACHE).splitlines())
    require_sound(
        folder == wanted,
        f"compiled forms cannot be kept in {wanted}, which is not this user's alone to write to, "
        f"but in {folder} as long as that is there; name another folder with XDG_CACHE_HOME",
    )
    size = sum(file.stat().st_size for file in folder.iterdir() if file.is_file())
    return f"{folder}, {size / 1e6:.0f} MB of compiled forms"


def mpiexec() -> str:
    """The launcher, which starts ranks that see one another."""
    found, beside = shutil.which("mpiexec"), Path(sys.executable).parent
    way_out = f"put {beside} in it" if (beside / "mpiexec").exists() else "install that of your MPI"
    require_sound(found, f"there is no mpiexec in PATH, which starts several ranks; {way_out}")
    with told_as(f"{found} starts no two ranks ({{}}); {FROM_WHERE}"):
        size = in_python(SIZE, launcher=[str(found), "-n", "2"])
    require_sound(
        size == "2",
        f"{found} starts ranks that do not see one another: it belongs to another MPI than "
        f"mpi4py; use the mpiexec that came with that",
    )
    return str(found)


def folder() -> str:
    """This folder, under which runs go by default: a file can be made in it."""
    with told_as("this folder cannot be written to ({}); work in another one"):
        here = Path.cwd()
        with TemporaryFile(dir=here) as file:
            file.write(b"1")
    return f"{here} can be written to"


def disk() -> str:
    """Room on the disk of this folder."""
    free = shutil.disk_usage(Path.cwd()).free
    require_sound(
        free >= LITTLE, f"only {free / 1e9:.2g} GB are free here; make room, or give --out"
    )
    return f"{free / 1e9:.3g} GB free"


def locks() -> str:
    """Locks, by which one process alone writes to a run directory."""
    way_out = "let one process alone write to a run directory"
    with told_as(f"no file can be locked here ({{}}): {way_out}"), TemporaryFile(dir=".") as file:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    return "files can be locked"


def threads() -> str:
    """One thread a rank."""
    given = os.environ.get("OMP_NUM_THREADS")
    require_sound(
        given == "1",
        f"OMP_NUM_THREADS is {given or 'not set'}: threads of linear algebra compete with the "
        f"ranks for the same cores; export OMP_NUM_THREADS=1",
    )
    return f"one a rank, of {os.cpu_count()} cores"


def gmsh() -> str:
    """Gmsh, for unstructured cells, shapes and meshes."""
    way_out = "`pip install gmsh`, and libGLU, libXft, libXcursor and libXinerama for it"
    lacking = "so no unstructured cells, shapes and meshes"
    with told_as(f"Gmsh does not load ({{}}), {lacking}; {way_out}"):
        return in_python(GMSH)


def pictures() -> str:
    """VTK, which draws 3-D bodies without a screen."""
    with told_as("nothing can be drawn in 3-D ({}); install libGL or Mesa"):
        drawn = in_python(PICTURE)
    require_sound(drawn == "True", "what is drawn in 3-D stays empty; install libGL or Mesa")
    return "3-D bodies can be drawn"


def two_ranks() -> str:
    """A small run on two ranks; the first one compiles its forms."""
    with TemporaryDirectory() as name:
        case, directory = Path(name) / "bar.toml", Path(name) / "run"
        case.write_text(ready_cases.text("bar"), encoding="utf-8")
        settings = [word for setting in SMALL for word in ("--set", setting)]
        launch = [str(shutil.which("mpiexec")), "-n", "2", *isolation.isolated_python(STAFFA)]
        command: list[str | Path] = [*launch, "run", case, "--out", directory, "--quiet", *settings]
        output_of(command, seconds=300, folder=Path(name))
        run = open_run(directory)
    said = [sentence for step in run.steps if step.audit for sentence in step.audit.violations]
    require_sound(
        run.finished and run.steps[-1].energies.surface > 0 and not said,
        f"a small run on two ranks ended wrongly ({said[0] if said else 'nothing broke'}); "
        f"{FROM_WHERE}",
    )
    return f"the ready case bar, {run.manifest.unknowns:,} unknowns, breaks as it should"


def reservoir() -> str:
    """Let the reservoir simulator take a step on five cells: only [reservoir] with darts needs
    it."""
    with told_as('cases with reservoir.simulator = "darts" cannot run here: {}'):
        python = simulator_python()
        return f"{answers(python)} in {python} answers"

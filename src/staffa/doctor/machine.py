"""What the machine gives: Python, a folder for runs, threads, and what draws and meshes."""

import fcntl
import os
import platform
import shutil
import sys
import tempfile
from pathlib import Path

from staffa.doctor.child import python as in_python
from staffa.errors import StaffaError

LITTLE = 1e9  # bytes; the fields and pictures of one run of the size of the slab take some 10 MB
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


def python() -> str:
    """This Python; an older one than staffa needs cannot read this line."""
    return f"{platform.python_version()}, {sys.executable}"


def folder() -> str:
    """A file can be made in this folder, under which runs go by default."""
    try:
        here = Path.cwd()
        with tempfile.TemporaryFile(dir=here) as file:
            file.write(b"1")
    except OSError as error:
        raise StaffaError(
            f"this folder cannot be written to ({error.strerror}); work in another one"
        ) from None
    return f"{here} can be written to"


def disk() -> str:
    """Room on the disk of this folder."""
    free = shutil.disk_usage(Path.cwd()).free
    if free < LITTLE:
        raise StaffaError(f"only {free / 1e9:.2g} GB are free here; make room, or give --out")
    return f"{free / 1e9:.3g} GB free"


def locks() -> str:
    """Locks, by which one process alone writes to a run directory."""
    try:
        with tempfile.TemporaryFile(dir=Path.cwd()) as file:
            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError as error:
        raise StaffaError(
            f"no file can be locked here ({error.strerror}): let one process alone write to a run "
            f"directory"
        ) from None
    return "files can be locked"


def threads() -> str:
    """One thread a rank."""
    given = os.environ.get("OMP_NUM_THREADS")
    if given != "1":
        raise StaffaError(
            f"OMP_NUM_THREADS is {given or 'not set'}: threads of linear algebra compete with the "
            f"ranks for the same cores; export OMP_NUM_THREADS=1"
        )
    return f"one a rank, of {os.cpu_count()} cores"


def gmsh() -> str:
    """Gmsh, for unstructured cells, shapes and meshes."""
    try:
        return in_python(GMSH).strip()
    except StaffaError as error:
        raise StaffaError(
            f"Gmsh does not load ({error}), so no unstructured cells, shapes and meshes; `pip "
            f"install gmsh`, and libGLU, libXft, libXcursor and libXinerama for it"
        ) from None


def pictures() -> str:
    """VTK draws without a screen, for pictures of 3-D bodies."""
    try:
        drawn = in_python(PICTURE).strip() == "True"
    except StaffaError as error:
        raise StaffaError(f"nothing can be drawn in 3-D ({error}); install libGL or Mesa") from None
    if not drawn:
        raise StaffaError("what is drawn in 3-D stays empty; install libGL or Mesa")
    return "3-D bodies can be drawn"

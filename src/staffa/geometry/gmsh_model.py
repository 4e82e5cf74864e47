"""Start of Gmsh with a separate model, or with an error in one sentence, and meshing by it."""

import signal
from collections.abc import Iterator
from contextlib import contextmanager
from threading import current_thread, main_thread
from typing import Any

from staffa.backend.isolation import elsewhere
from staffa.errors import InputError

# Gmsh's plain Delaunay refinement, in 2-D and on the faces of a box. How well its edges spread over
# the directions theta, as |mean exp(i k theta)| over all 20,000 of 2 x 1 with h = 0.02 (0 without
# any order), and over those in each square of 6 h:
#     algorithm             k = 4   k = 6   k = 6, in 6 h   mean quality   mean edge
#     5, Delaunay           0.01    0.02    0.18            0.95           0.95 h
#     1, MeshAdapt          0.02    0.13    0.27            0.96           0.98 h
#     6, Frontal-Delaunay   0.00    0.94    0.94            1.00           1.00 h
#     9, packing            0.16    0.20    0.49            0.92           1.10 h
# Frontal-Delaunay makes one crystal along the sides; four triangles to a square have 0.33, k = 4.
PLANE, SOLID = 5, 1
# Asked for edges of this times h, Gmsh makes them h long in the mean, within 5 %.
ASKED = {2: 1.0, 3: 0.8}
SIMPLEX = {1: 1, 2: 2, 3: 4}  # Gmsh's numbers of lines, triangles and tetrahedra
OPTIONS = {
    "General.Terminal": 0,
    # One thread and one seed: the same body gives the same mesh every time.
    "General.NumThreads": 1,
    "Mesh.RandomSeed": 1,
}


def missing(what: str, way_out: str) -> str:
    """Return the message for a missing Gmsh, with the way out."""
    return (
        f"{what} needs Gmsh, which is not installed; install it with pip install gmsh, or {way_out}"
    )


@contextmanager
def open_gmsh(what: str, way_out: str) -> Iterator[Any]:
    """Open Gmsh with a separate model and separate options; a caller's open Gmsh stays open.

    Parameters
    ----------
    what : the key that needs Gmsh, for the message.
    way_out : advice for a user without Gmsh.

    Raises
    ------
    InputError
        Gmsh is not installed, or cannot be loaded.
    """
    try:
        import gmsh  # only where it is asked for: the extra `mesh` brings it

        mine = not gmsh.isInitialized()
        if mine:
            with elsewhere():  # the PETSc inside of Gmsh reads `.petscrc`
                gmsh.initialize(readConfigFiles=False, interruptible=False)
            _take_back_signals()
    except ImportError as error:
        raise InputError(missing(what, way_out)) from error
    except (OSError, AttributeError) as error:  # its library, or one that this needs, is missing
        raise InputError(
            f"{what} needs Gmsh, which cannot be loaded ({error}); install what that names, or "
            f"{way_out}"
        ) from error
    try:
        gmsh.model.add("staffa")
        for name, value in OPTIONS.items():
            gmsh.option.setNumber(name, value)
        yield gmsh
    finally:
        gmsh.finalize() if mine else gmsh.model.remove()


def _take_back_signals() -> None:
    """Take back SIGTERM and others from Gmsh, so that the process can be stopped in order."""
    if current_thread() is main_thread():
        for number in (signal.SIGTERM, signal.SIGINT):
            signal.signal(number, signal.getsignal(number) or signal.SIG_DFL)


def generate(gmsh: Any, dim: int) -> None:
    """Mesh what is modelled with lengths counted in h."""
    gmsh.option.setNumber("Mesh.Algorithm", PLANE)
    gmsh.option.setNumber("Mesh.Algorithm3D", SOLID)
    gmsh.option.setNumber("Mesh.ElementOrder", 1)
    for end in ("Min", "Max"):
        gmsh.option.setNumber(f"Mesh.MeshSize{end}", ASKED[dim])
    gmsh.model.mesh.generate(dim)

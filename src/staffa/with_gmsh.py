"""How Gmsh is opened: with a model of its own, and an error in one sentence if it is not there."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from staffa.errors import InputError

SIMPLEX = {1: 1, 2: 2, 3: 4}  # Gmsh's numbers of lines, triangles and tetrahedra
OPTIONS = {
    "General.Terminal": 0,
    # One thread and one seed: the same body gives the same mesh every time.
    "General.NumThreads": 1,
    "Mesh.RandomSeed": 1,
}


def missing(what: str, way_out: str) -> str:
    """That something needs Gmsh, and what to do."""
    return (
        f"{what} needs Gmsh, which is not installed; install it with pip install gmsh, or {way_out}"
    )


@contextmanager
def opened(what: str, way_out: str) -> Iterator[Any]:
    """Gmsh with a model and options of its own; a Gmsh that the caller has open stays open.

    what: the key that needs it; way_out: what to do without it.

    Raises
    ------
    InputError
        Gmsh is not installed, or cannot be loaded.
    """
    try:
        import gmsh  # only where it is asked for: the extra `mesh` brings it

        mine = not gmsh.isInitialized()
        if mine:
            gmsh.initialize(readConfigFiles=False, interruptible=False)
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

"""Loading of MPI and PETSc in the one order that is safe with every build of DOLFINx.

The binary wheel must see its bootstrap module before any compiled part, and `mpi4py.MPI` before
PETSc; a DOLFINx from conda-forge, Spack or Debian has no such module and needs none. Every module
that touches the finite-element stack imports this one first. PETSc reads no `.petscrc` and no
`petscrc`, neither in the current folder nor at home: its options come from the environment. Signals
are left to Python: PETSc would end a run with an error where a pipe is closed. All is
loaded elsewhere: in the current folder MPI reads `ucx.conf` and petsc4py `petsc.cfg`, which name
libraries to load and files to write.
"""

import os
from importlib.util import find_spec
from itertools import pairwise

from staffa.backend.isolation import elsewhere
from staffa.errors import InputError

with elsewhere():
    if find_spec("dolfinx_solver") is not None:
        import dolfinx_solver  # noqa: F401
    import petsc4py
    from mpi4py import MPI
    from petsc4py.lib import ImportPETSc

    LOADED = ImportPETSc()

OWN = ("skip_petscrc", "no_signal_handler")


def _start() -> None:
    """Start PETSc with the options of the environment.

    Raises
    ------
    InputError
        It cannot start with them.
    """
    words = os.environ.get("PETSC_OPTIONS", "").split()
    for word, file in pairwise(words):
        if word.startswith("-options_file") and not os.access(file, os.R_OK):
            raise InputError(f"PETSC_OPTIONS: {word} {file} is no file that can be read; fix it")
    try:
        # Here, since a file among the options is named as seen from the user's folder.
        petsc4py.init(["staffa", *(f"-{name}" for name in OWN)], arch=LOADED.__arch__)
    except Exception as error:  # of a class that is there once PETSc has started
        raise InputError(
            f"PETSc does not start with PETSC_OPTIONS = {' '.join(words)} ({error}); fix them"
        ) from None


_start()

with elsewhere():
    from petsc4py import PETSc
    from slepc4py import SLEPc

__all__ = ["MPI", "OWN", "PETSc", "SLEPc"]

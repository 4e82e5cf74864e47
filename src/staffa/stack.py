"""Loads MPI and PETSc in the one order that is safe with every build of DOLFINx.

The binary wheel must see its bootstrap module before any compiled part, and `mpi4py.MPI` before
PETSc; a DOLFINx from conda-forge, Spack or Debian has no such module and needs none. Every module
that touches the finite-element stack imports this one first.
"""

from importlib.util import find_spec

if find_spec("dolfinx_solver") is not None:
    import dolfinx_solver  # noqa: F401
from mpi4py import MPI
from petsc4py import PETSc
from slepc4py import SLEPc

__all__ = ["MPI", "PETSc", "SLEPc"]

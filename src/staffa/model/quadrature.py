"""Quadrature rules of the energy over cells."""

from staffa.backend.stack import MPI  # noqa: F401

import basix
import numpy as np
import ufl
from dolfinx import mesh as dmesh

from staffa.model import axis
from staffa.model.domain import Domain

# Exact for the stiffness of damaged linear simplices, and of undamaged quadratic ones; the 2 x 2
# (x 2) Gauss rule of quadrilaterals.
DEGREE = 2
# One point in the middle of a cell.
ONE_POINT = 1


def in_the_middle(domain: Domain) -> axis.Measure:
    """Return the measure with one quadrature point at the center of each cell.

    It is defined over cells with a number, which all cells have: in one kernel with another rule
    FFCx 0.11 sums a matrix wrongly (compare github.com/FEniCS/ffcx, issue 394).
    """
    own = np.arange(domain.mesh.topology.index_map(domain.dim).size_local, dtype=np.int32)
    rule = {"quadrature_degree": ONE_POINT}
    plain = ufl.Measure("dx", domain.mesh, subdomain_data=[(1, own)], metadata=rule)
    return axis.around(domain, plain(1))


def cell_middle(mesh: dmesh.Mesh) -> np.ndarray:
    """Return the middle of the reference cell, shape (1, dim)."""
    middle: np.ndarray = basix.geometry(mesh.basix_cell()).mean(axis=0)[None, :]
    return middle

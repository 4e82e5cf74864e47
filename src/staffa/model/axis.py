"""Bodies of revolution: integrals over the ring of each point of the meridian plane (r, z)."""

from dataclasses import dataclass
from math import pi

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import ufl
from dolfinx import fem

from staffa.geometry.outline import on_axis
from staffa.model.domain import Domain
from staffa.model.fields import Spaces, vertices

# The factor r raises the polynomial degree of the integrand.
RAISED = 1


@dataclass(frozen=True, kw_only=True)
class Around:
    """Measure with the factor 2 pi r, used as UFL's measures are.

    Attributes
    ----------
    plain : measure of the meridian plane.
    r : distance from the axis (m).
    """

    plain: ufl.Measure
    r: ufl.core.expr.Expr

    def __call__(self, subdomain: int | None = None, *, degree: int | None = None) -> "Around":
        """Return the measure over a numbered part, or with a quadrature of a degree.

        Parameters
        ----------
        subdomain : number of the part; None for all.
        degree : degree that the quadrature integrates exactly, without the factor r.
        """
        raised = None if degree is None else degree + RAISED
        return Around(plain=self.plain(subdomain, degree=raised), r=self.r)

    def __rmul__(self, integrand: ufl.core.expr.Expr) -> ufl.Form:
        """Return the integral of an expression over the whole body."""
        return (2 * pi * self.r * integrand) * self.plain


type Measure = ufl.Measure | Around


def volume(domain: Domain, degree: int | None = None) -> Measure:
    """Return dx of a body: per thickness in 2-D, over whole rings of a body of revolution.

    Parameters
    ----------
    domain : the body.
    degree : polynomials up to this degree are integrated exactly; None: as UFL estimates it.
    """
    raised = RAISED if domain.axial else 0
    metadata = None if degree is None else {"quadrature_degree": degree + raised}
    return around(domain, ufl.Measure("dx", domain.mesh, metadata=metadata))


def surface(domain: Domain, tags: object = None) -> Measure:
    """Return ds of a body, as `volume` is its dx; `tags` numbers its boundaries."""
    return around(domain, ufl.Measure("ds", domain.mesh, subdomain_data=tags))


def around(domain: Domain, plain: ufl.Measure) -> Measure:
    """Return the measure of the body from one of the mesh."""
    if not domain.axial:
        return plain
    return Around(plain=plain, r=ufl.SpatialCoordinate(domain.mesh)[0])


def hoop_strain(u: fem.Function) -> ufl.core.expr.Expr:
    """Return u_r/r, the strain around the axis."""
    return u[0] / ufl.SpatialCoordinate(u.function_space.mesh)[0]


def divergence(domain: Domain, u: fem.Function) -> ufl.core.expr.Expr:
    """Return the change of volume of a displacement; of area in 2-D."""
    return ufl.div(u) + hoop_strain(u) if domain.axial else ufl.div(u)


def held_by_axis(domain: Domain, spaces: Spaces) -> np.ndarray:
    """Return the entries of u along r of nodes on the axis: local, owned, shape (n,)."""
    if not domain.axial:
        return np.zeros(0, dtype=np.int32)
    owned = spaces.nodes.dofmap.index_map.size_local
    r = vertices(spaces.nodes)[:owned, 0]
    return (domain.dim * np.flatnonzero(on_axis(r, domain.size))).astype(np.int32)

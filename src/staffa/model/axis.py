"""Bodies of revolution: integrals over the whole ring of each point of the section (r, z)."""

from dataclasses import dataclass
from math import pi

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import ufl
from dolfinx import fem

from staffa.geometry.outline import on_axis
from staffa.model.domain import Domain
from staffa.model.fields import Spaces, vertices

# The factor r raises the degree of what is integrated.
RAISED = 1


@dataclass(frozen=True, kw_only=True)
class Around:
    """A measure that multiplies what it integrates with 2 pi r. Used as UFL's measures are.

    plain: the measure of the section. r: the distance from the axis (m).
    """

    plain: ufl.Measure
    r: ufl.core.expr.Expr

    def __call__(self, subdomain: int | None = None, *, degree: int | None = None) -> "Around":
        """The same over a part with this number, or with a quadrature exact to this degree without
        the factor r."""
        raised = None if degree is None else degree + RAISED
        return Around(plain=self.plain(subdomain, degree=raised), r=self.r)

    def __rmul__(self, integrand: ufl.core.expr.Expr) -> ufl.Form:
        """The integral of an expression over the whole body."""
        return (2 * pi * self.r * integrand) * self.plain


type Measure = ufl.Measure | Around


def volume(domain: Domain, degree: int | None = None) -> Measure:
    """dx of a body: per thickness in 2-D, over whole rings of a body of revolution.

    Parameters
    ----------
    domain : the body.
    degree : polynomials up to this degree are integrated exactly; None: as UFL estimates it.
    """
    raised = RAISED if domain.axial else 0
    metadata = None if degree is None else {"quadrature_degree": degree + raised}
    return around(domain, ufl.Measure("dx", domain.mesh, metadata=metadata))


def surface(domain: Domain, tags: object = None) -> Measure:
    """ds of a body, as `volume` is its dx; tags: the numbers of its sides."""
    return around(domain, ufl.Measure("ds", domain.mesh, subdomain_data=tags))


def around(domain: Domain, plain: ufl.Measure) -> Measure:
    """A measure of the section as one of the body."""
    if not domain.axial:
        return plain
    return Around(plain=plain, r=ufl.SpatialCoordinate(domain.mesh)[0])


def hoop_strain(u: fem.Function) -> ufl.core.expr.Expr:
    """u_r/r, the strain around the axis."""
    return u[0] / ufl.SpatialCoordinate(u.function_space.mesh)[0]


def divergence(domain: Domain, u: fem.Function) -> ufl.core.expr.Expr:
    """Change of volume of a displacement; of area in 2-D."""
    return ufl.div(u) + hoop_strain(u) if domain.axial else ufl.div(u)


def held_by_axis(domain: Domain, spaces: Spaces) -> np.ndarray:
    """Entries of the displacement along r of nodes on the axis: local, owned, shape (n,)."""
    if not domain.axial:
        return np.zeros(0, dtype=np.int32)
    owned = spaces.nodes.dofmap.index_map.size_local
    r = vertices(spaces.nodes)[:owned, 0]
    return (domain.dim * np.flatnonzero(on_axis(r, domain.size))).astype(np.int32)

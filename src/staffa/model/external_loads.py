"""External loads as a part of the energy: minus their work."""

from dataclasses import dataclass

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import ufl
from dolfinx import fem
from dolfinx import mesh as dmesh

from staffa.loads.forces import Forces, InSpaceAndTime
from staffa.model import axis
from staffa.model.domain import Domain
from staffa.model.fields import Spaces, vertices
from staffa.model.strain import Coefficient


@dataclass(frozen=True, kw_only=True)
class Varying:
    """Load in space and time.

    Attributes
    ----------
    field : its values at the current time.
    value : function of position and time (s).
    """

    field: fem.Function
    value: InSpaceAndTime


class External:
    """Loads of a body at the time of the last call of `at`. Collective.

    Attributes
    ----------
    forces : the loads of the problem.
    time : current time (s).
    pressure : pressure of the fluid in cracks (Pa). If their volume is given, the pressure is found
        with the displacement, and stored here.
    pore_pressure : pressure of the fluid in pores (Pa); None without.
    """

    def __init__(
        self, domain: Domain, spaces: Spaces, forces: Forces, density: Coefficient
    ) -> None:
        """Create the fields of the loads.

        Parameters
        ----------
        domain : the mesh.
        spaces : the function spaces.
        forces : the loads of the problem.
        density : mass density (kg/m^3), for the weight.
        """
        self.forces, self.time = forces, 0.0
        self.pressure = fem.Constant(domain.mesh, 0.0)
        self._biot = fem.Constant(domain.mesh, float(forces.biot))
        self._domain, self._spaces, self._density = domain, spaces, density
        self._x = vertices(spaces.alpha).T
        self._varying: list[Varying] = []
        vectors = spaces.u
        if spaces.quadratic:  # tractions are linear along an edge, even if u is quadratic
            vectors = fem.functionspace(domain.mesh, ("Lagrange", 1, (domain.dim,)))
        self._on_sides = [
            (number, self._vary(t.force, vectors), self._vary(t.pressure, spaces.alpha))
            for number, t in enumerate(forces.sides)
        ]
        self.pore_pressure = self._at_corners(forces)
        self.at(0.0)

    def _vary(self, value: InSpaceAndTime | None, space: fem.FunctionSpace) -> fem.Function | None:
        if value is None:
            return None
        self._varying.append(Varying(field=fem.Function(space), value=value))
        return self._varying[-1].field

    def _at_corners(self, forces: Forces) -> fem.Function | None:
        if forces.pore_pressure is None:
            return None
        space = fem.functionspace(self._domain.mesh, ("Discontinuous Lagrange", 1))
        field = fem.Function(space, name="pore pressure")
        field.interpolate(forces.pore_pressure)
        return field

    @property
    def fields(self) -> list[fem.Function]:
        """Loads that are functions of space, at the current time."""
        varying = [load.field for load in self._varying]
        return varying if self.pore_pressure is None else [*varying, self.pore_pressure]

    @property
    def controlled(self) -> bool:
        """True if the volume in cracks is given, and their pressure is found."""
        return self.forces.crack_volume is not None

    @property
    def volume(self) -> float:
        """Given volume in cracks at the current time (m^3; m^2 in 2-D)."""
        return 0.0 if self.forces.crack_volume is None else self.forces.crack_volume(self.time)

    def at(self, t: float) -> None:
        """Apply the loads of a time (s)."""
        self.time = t
        for load in self._varying:
            values = load.value(self._x, t)
            load.field.x.array[:] = values.T.ravel() if values.ndim == 2 else values
        if self.forces.crack_pressure is not None:
            self.pressure.value = self.forces.crack_pressure(t)

    def is_finite(self) -> bool:
        """Return True if all loads on this rank are finite at the current time."""
        fields = all(np.all(np.isfinite(load.field.x.array)) for load in self._varying)
        return bool(fields and np.isfinite(self.pressure.value) and np.isfinite(self.volume))

    def kept(self) -> np.ndarray:
        """Return the current time and pressure, for `put_back`."""
        return np.array([self.time, float(self.pressure.value)])

    def put_back(self, kept: np.ndarray) -> None:
        """Restore loads and pressure."""
        self.at(float(kept[0]))
        self.pressure.value = kept[1]

    def between(self, start: np.ndarray, end: np.ndarray, share: float) -> None:
        """Apply the loads of a point on the linear path between two times.

        Parameters
        ----------
        start : time and pressure at the start of the path, from `kept`.
        end : time and pressure at its end, from `kept`.
        share : part of the path, from 0 to 1.
        """
        self.put_back(start)
        before = [load.field.x.array.copy() for load in self._varying]
        self.put_back(end)
        for load, values in zip(self._varying, before, strict=True):
            load.field.x.array[:] = (1 - share) * values + share * load.field.x.array
        self.pressure.value = (1 - share) * start[1] + share * end[1]

    def potential(
        self, u: fem.Function, alpha: fem.Function, swelling: ufl.core.expr.Expr, dx: axis.Measure
    ) -> ufl.Form | None:
        """Return minus the work of all loads, that of the pores included; None without any.

        Parameters
        ----------
        u : displacement (m).
        alpha : damage.
        swelling : free change of volume, see `crack_volume_density`.
        dx : measure of the body.
        """
        terms = list(self._terms(u, dx))
        if self.forces.in_cracks:
            terms.append(
                -self.in_excess() * crack_volume_density(self._domain, u, alpha, swelling) * dx
            )
        return sum(terms[1:], terms[0]) if terms else None

    def in_excess(self) -> ufl.core.expr.Expr:
        """Return the pressure of the fluid in cracks, less the part that the pores carry there."""
        if self.pore_pressure is None:
            return self.pressure
        return self.pressure - self._biot * self.pore_pressure

    def _terms(self, u: fem.Function, dx: axis.Measure) -> list[ufl.Form]:
        mesh, forces, terms = self._domain.mesh, self.forces, []
        if forces.gravity is not None:
            weight = self._density * fem.Constant(mesh, np.array(forces.gravity))
            terms.append(-ufl.dot(weight, u) * dx)
        if self.pore_pressure is not None:
            terms.append(-self._biot * self.pore_pressure * axis.divergence(self._domain, u) * dx)
        ds, n = _sides(self._domain, forces), ufl.FacetNormal(mesh)
        for number, force, pressure in self._on_sides:
            if force is not None:
                terms.append(-ufl.dot(force, u) * ds(number))
            if pressure is not None:
                terms.append(pressure * ufl.dot(n, u) * ds(number))
        return terms


def crack_volume_density(
    domain: Domain, u: fem.Function, alpha: fem.Function, swelling: ufl.core.expr.Expr
) -> ufl.core.expr.Expr:
    """Return alpha (div u - swelling), whose integral is the volume of open cracks.

    Integrated by parts this is -u . grad alpha (Bourdin, Chukwudozie and Yoshioka 2012) with the
    mouths of cracks on the surface, where a fluid also presses on the body: without them it would
    push the body away. The thermal shrinkage of rock (`swelling`, negative) is no crack.

    Parameters
    ----------
    domain : the mesh.
    u : displacement (m).
    alpha : damage.
    swelling : free change of volume.
    """
    return alpha * (axis.divergence(domain, u) - swelling)


def _sides(domain: Domain, forces: Forces) -> axis.Measure:
    """Return one measure for all loaded boundaries, in their numbering."""
    facets = [domain.facets(t.side) for t in forces.sides]
    if not facets:
        return axis.surface(domain)
    numbers = np.repeat(np.arange(len(facets), dtype=np.int32), [len(f) for f in facets])
    places = np.concatenate(facets)
    order = np.argsort(places, kind="stable")
    tags = dmesh.meshtags(domain.mesh, domain.dim - 1, places[order], numbers[order])
    return axis.surface(domain, tags)

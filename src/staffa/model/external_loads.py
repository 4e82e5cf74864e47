"""External loads as part of the energy: minus their work."""

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
    """A load in space and time, and the field that holds it at the time at hand."""

    field: fem.Function
    value: InSpaceAndTime


class External:
    """The loads of a body at the time that `at` was told last. Collective.

    pressure: of the fluid in cracks (Pa); where their volume is given it is found with the
    displacement, and kept here.
    """

    def __init__(
        self, domain: Domain, spaces: Spaces, forces: Forces, density: Coefficient
    ) -> None:
        self.forces, self.time = forces, 0.0
        self.pressure = fem.Constant(domain.mesh, 0.0)
        self._biot = fem.Constant(domain.mesh, float(forces.biot))
        self._domain, self._spaces, self._density = domain, spaces, density
        self._x = vertices(spaces.alpha).T
        self._varying: list[Varying] = []
        vectors = spaces.u
        if spaces.quadratic:  # what presses is linear along an edge, whatever moves there
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
        """The loads that are functions of space, at the current time."""
        varying = [load.field for load in self._varying]
        return varying if self.pore_pressure is None else [*varying, self.pore_pressure]

    @property
    def controlled(self) -> bool:
        """Whether the volume in cracks is given, and their pressure found."""
        return self.forces.crack_volume is not None

    @property
    def volume(self) -> float:
        """The volume in cracks that is given at the time at hand."""
        return 0.0 if self.forces.crack_volume is None else self.forces.crack_volume(self.time)

    def at(self, t: float) -> None:
        """Put on the loads of a time (s)."""
        self.time = t
        for load in self._varying:
            values = load.value(self._x, t)
            load.field.x.array[:] = values.T.ravel() if values.ndim == 2 else values
        if self.forces.crack_pressure is not None:
            self.pressure.value = self.forces.crack_pressure(t)

    def is_finite(self) -> bool:
        """Whether all loads on this rank are, at the time at hand."""
        fields = all(np.all(np.isfinite(load.field.x.array)) for load in self._varying)
        return bool(fields and np.isfinite(self.pressure.value) and np.isfinite(self.volume))

    def kept(self) -> np.ndarray:
        """The time and the pressure at hand, for `put_back`."""
        return np.array([self.time, float(self.pressure.value)])

    def put_back(self, kept: np.ndarray) -> None:
        """Loads and pressure as they were."""
        self.at(float(kept[0]))
        self.pressure.value = kept[1]

    def between(self, start: np.ndarray, end: np.ndarray, share: float) -> None:
        """Put on the loads that are a share of the straight way from those `kept` at one time to
        those at another."""
        self.put_back(start)
        before = [load.field.x.array.copy() for load in self._varying]
        self.put_back(end)
        for load, values in zip(self._varying, before, strict=True):
            load.field.x.array[:] = (1 - share) * values + share * load.field.x.array
        self.pressure.value = (1 - share) * start[1] + share * end[1]

    def potential(
        self, u: fem.Function, alpha: fem.Function, swelling: ufl.core.expr.Expr, dx: axis.Measure
    ) -> ufl.Form | None:
        """Minus the work of all loads, the pores' included; None without any.

        swelling: the change of volume that costs nothing, see `crack_volume`.
        """
        terms = list(self._terms(u, dx))
        if self.forces.in_cracks:
            terms.append(
                -self.in_excess() * crack_volume_density(self._domain, u, alpha, swelling) * dx
            )
        return sum(terms[1:], terms[0]) if terms else None

    def in_excess(self) -> ufl.core.expr.Expr:
        """Pressure of the fluid in cracks, less what the pores carry, which acts there too."""
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
    """alpha (div u - swelling), whose integral is the volume that cracks hold open.

    By parts this is -u . grad alpha (Bourdin, Chukwudozie and Yoshioka 2012) with the mouths of
    cracks on the surface, where a fluid presses on the body as well: without them it would push the
    body along. What rock shrinks by in the cold (`swelling`, negative) is no crack.
    """
    return alpha * (axis.divergence(domain, u) - swelling)


def _sides(domain: Domain, forces: Forces) -> axis.Measure:
    """One measure for all loaded sides, numbered as they are."""
    facets = [domain.facets(t.side) for t in forces.sides]
    if not facets:
        return axis.surface(domain)
    numbers = np.repeat(np.arange(len(facets), dtype=np.int32), [len(f) for f in facets])
    places = np.concatenate(facets)
    order = np.argsort(places, kind="stable")
    tags = dmesh.meshtags(domain.mesh, domain.dim - 1, places[order], numbers[order])
    return axis.surface(domain, tags)

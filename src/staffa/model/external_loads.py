"""External loads as a part of the energy: minus their work."""

from collections.abc import Sequence
from dataclasses import dataclass
from dataclasses import field as dataclass_field

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

# Times whose values are kept: the ends of a step.
ENDS = 2


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
    # Values at the times asked for last: the work of a step asks for its two ends again and again.
    _known: dict[float, np.ndarray] = dataclass_field(default_factory=dict, repr=False)

    def at(self, x: np.ndarray, t: float) -> None:
        """Set the field to the values of a time.

        Parameters
        ----------
        x : vertices (m), shape (3, n), at which a continuous field has its values.
        t : time (s).
        """
        if t not in self._known:
            self._evaluate(x, t)
            self._known[t] = self.field.x.array.copy()
            while len(self._known) > ENDS:
                self._known.pop(next(iter(self._known)))
        self.field.x.array[:] = self._known[t]

    def _evaluate(self, x: np.ndarray, t: float) -> None:
        if self.field.function_space.ufl_element().discontinuous:
            self.field.interpolate(lambda points: self.value(points, t))
            return
        values = self.value(x, t)
        self.field.x.array[:] = values.T.ravel() if values.ndim == 2 else values


class External:
    """Loads of a body at the time of the last call of `at`. Collective.

    Attributes
    ----------
    forces : the loads of the problem.
    time : current time (s).
    pressure : pressure of the fluid in cracks (Pa). If their volume is given, the pressure is found
        with the displacement, and stored here.
    pore_pressure : pressure of the fluid in pores that acts (Pa), in forms; None without.
    p_at_rest : pressure (Pa) of the fluid that comes with the temperature, before the first step.
    """

    def __init__(
        self,
        domain: Domain,
        spaces: Spaces,
        forces: Forces,
        density: Coefficient,
        p: fem.Function | None = None,
    ) -> None:
        """Create the fields of the loads.

        Parameters
        ----------
        domain : the mesh.
        spaces : the function spaces.
        forces : the loads of the problem.
        density : mass density (kg/m^3), for the weight.
        p : pressure (Pa) of the fluid that comes with the temperature, as it is before the first
            step; needed where `Forces.fluid` is True.
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
        self.p_at_rest = fem.Function(spaces.alpha, name="p at rest")
        self._acting = self._pressure_of_fluid(p)
        self.pore_pressure = self._in_pores()
        self._in_cracks = self._acting
        if self._acting is None:
            self._in_cracks = self._vary(forces.crack_field, spaces.alpha)
        self.at(0.0)

    def _vary(self, value: InSpaceAndTime | None, space: fem.FunctionSpace) -> fem.Function | None:
        if value is None:
            return None
        self._varying.append(Varying(field=fem.Function(space), value=value))
        return self._varying[-1].field

    def _pressure_of_fluid(self, p: fem.Function | None) -> ufl.core.expr.Expr | None:
        if not self.forces.fluid:
            return None
        assert p is not None
        self.p_at_rest.x.array[:] = p.x.array
        return p - self.p_at_rest if self.forces.balanced else p

    def _in_pores(self) -> ufl.core.expr.Expr | None:
        if self._acting is not None:
            return self._acting
        space = fem.functionspace(self._domain.mesh, ("Discontinuous Lagrange", 1))
        return self._vary(self.forces.pore_pressure, space)

    @property
    def at_rest(self) -> ufl.core.expr.Expr | None:
        """Part of the prestress that pores carry before the first step, of the fluid (Pa)."""
        whole = self._acting is not None and not self.forces.balanced
        return self._biot * self.p_at_rest if whole else None

    @property
    def fields(self) -> list[fem.Function]:
        """Loads that are functions of space, at the current time."""
        return [load.field for load in self._varying]

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
            load.at(self._x, t)
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
            return self.in_cracks
        return self.in_cracks - self._biot * self.pore_pressure

    @property
    def in_cracks(self) -> ufl.core.expr.Expr:
        """Pressure of the fluid in cracks that acts (Pa), in forms."""
        return self.pressure if self._in_cracks is None else self._in_cracks

    def _terms(self, u: fem.Function, dx: axis.Measure) -> list[ufl.Form]:
        mesh, forces, terms = self._domain.mesh, self.forces, []
        if forces.gravity is not None:
            weight = self._density * fem.Constant(mesh, np.array(forces.gravity))
            terms.append(-ufl.dot(weight, u) * dx)
        if self.pore_pressure is not None:
            terms.append(-self._biot * self.pore_pressure * axis.divergence(self._domain, u) * dx)
        n = ufl.FacetNormal(mesh)
        ds = _sides(self._domain, [t.side for t in forces.sides])
        wet = _sides(self._domain, forces.fluid_sides)
        for number in range(len(forces.fluid_sides)):
            terms.append(self._acting * ufl.dot(n, u) * wet(number))
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


def _sides(domain: Domain, names: Sequence[str]) -> axis.Measure:
    """Return one measure for some boundaries, numbered in their order."""
    facets = [domain.facets(name) for name in names]
    if not facets:
        return axis.surface(domain)
    numbers = np.repeat(np.arange(len(facets), dtype=np.int32), [len(f) for f in facets])
    places = np.concatenate(facets)
    order = np.argsort(places, kind="stable")
    tags = dmesh.meshtags(domain.mesh, domain.dim - 1, places[order], numbers[order])
    return axis.surface(domain, tags)

"""Fluid in the cracks of a body: its volume and its pressure, from the forms of the energy."""

from functools import cached_property, partial

from staffa.backend.stack import PETSc

import ufl
from dolfinx import fem

from staffa.backend import jit
from staffa.model.derivatives import EnergyDerivatives
from staffa.model.external_loads import External
from staffa.model.fields import State


class CrackFluid(EnergyDerivatives):
    """Volume and pressure of the fluid in cracks; `Energy` defines the forms. Collective.

    Attributes
    ----------
    state : the fields.
    external : the external loads.
    """

    state: State
    external: External
    _in_cracks: tuple[ufl.Form, ufl.core.expr.Expr, fem.Function, ufl.Argument]
    _dx: ufl.Measure

    def pressure_in_cracks(self) -> float:
        """Return the fluid's mean pressure over damaged rock (Pa), weighted with the damage."""
        damage, pressed = map(self._integral, self._pressed)
        return pressed / damage if damage else 0.0

    def crack_volume(self) -> float:
        """Return the crack volume, see `external_loads.crack_volume_density`; in 2-D an area."""
        return self._integral(self._cracks_open["volume"])

    def crack_swelling(self) -> float:
        """Return the crack volume's derivative in u times u, less the crack volume."""
        return self._integral(self._cracks_open["swelling"])

    def widening(self, out: PETSc.Vec) -> None:
        """Write the derivative of the crack volume in u: the force of unit pressure in cracks."""
        self._vector(self._cracks_open["widening"], self._sums_u, out)

    @cached_property
    def _pressed(self) -> tuple[fem.Form, fem.Form]:
        """Forms of the damage, and of the fluid's pressure in it, compiled at their first use."""
        alpha = self.state.alpha
        damage, pressed = alpha * self._dx, self.external.in_cracks * alpha * self._dx
        return jit.form(damage, self.comm), jit.form(pressed, self.comm)

    @cached_property
    def _cracks_open(self) -> dict[str, fem.Form]:
        """Forms of the crack volume, compiled at their first use."""
        volume, cold, u, v = self._in_cracks
        form = partial(jit.form, comm=self.comm)
        return {
            "volume": form(volume),
            "swelling": form(cold),
            "widening": form(ufl.derivative(volume, u, v)),
        }

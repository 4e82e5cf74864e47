"""The stress that cooling has to overcome along the face, and the drop that it takes."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import scipy

from staffa.case.rules.initial_stress import equivalent, initial_normal_stresses
from staffa.case.scales.case_scales import Numbers, least_factor
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import at_least
from staffa.physics.damage import has_threshold, strength
from staffa.physics.material import PLANE_STRESS

SAMPLES = 25  # times at which what acts on the faces is looked at
AS_GOOD_AS_NEVER = 1e3  # strengths that cooling would have to overcome: nobody looks further


@dataclass(frozen=True, kw_only=True)
class Squeeze:
    """The stress of a cooled face where it is squeezed least.

    Attributes
    ----------
    along : stress along the face before cooling (Pa).
    stress : stress before cooling that decides (Pa): along the face or, in plane strain, across the
        plane.
    beyond : True if `stress` is that across the plane.
    thermal : stress that the largest drop of the face adds to either (Pa).
    starts : net tension, in the direction of `stress`, at which damage starts (Pa).
    needed : drop of the face that gives `starts` (K).
    share : stress that drives damage at the largest drop, over the one that starts damage.
    across : stress across the plane of a 2-D body without cooling, once cracks have relieved the
        stress along the face (Pa).
    """

    along: float
    stress: float
    beyond: bool
    thermal: float
    starts: float
    needed: float
    share: float
    across: float

    @property
    def net(self) -> float:
        """Return the tension that decides at the largest drop, if nothing breaks (Pa)."""
        return self.stress + self.thermal

    def needs(self, case: Case) -> str:
        """Return the drop that starts damage, as the end of a sentence."""
        return f"; it takes a drop of {at_least(case, self.needed, 'K', digits=4)}"


def squeeze(case: Case, derived: Numbers, drop: float) -> Squeeze | None:
    """Return the squeeze of a cooled face at its weakest place and time.

    Parameters
    ----------
    case : the case.
    derived : scales of the case.
    drop : largest temperature drop of the face (K).

    Returns
    -------
    None where uniform rock does not give the initial stress (see `initial_normal_stresses`), where
    the face is not flat, or the law has no threshold.
    """
    if derived.face is None or not has_threshold(derived.law) or case.forces is None:
        return None
    x = case.outline.places.on(case.temperature.face)
    stresses = [
        initial_normal_stresses(case, x, t) for t in np.linspace(0.0, derived.times[-1], SAMPLES)
    ]
    found = [stress for stress in stresses if stress is not None]
    if len(found) < len(stresses):
        return None
    rest = np.unique(np.hstack(found), axis=1)
    sides, pulled = lateral(case, derived.face.axis), pulled_axes(case, derived.face.axis)
    m, ell = derived.rock, float(case.damage.ell)
    a_kelvin = thermal_stress(derived, 1.0)
    bears = strength(derived.law, E=m.E, Gc=m.Gc * least_factor(case), ell=ell)

    def share(T: float) -> np.ndarray:
        stress = rest.copy()
        stress[pulled] += a_kelvin * T
        return equivalent(case, stress) / bears

    needed = _first(lambda T: float(share(T).max()) - 1, bears / a_kelvin)
    weakest = int(share(needed).argmax())
    k = max(sides, key=lambda axis: rest[axis, weakest])
    decides = max(pulled, key=lambda axis: rest[axis, weakest])  # of equal ones that along the face
    return Squeeze(
        along=float(rest[k, weakest]),
        stress=float(rest[decides, weakest]),
        beyond=decides not in sides,
        thermal=a_kelvin * drop,
        starts=float(rest[decides, weakest]) + a_kelvin * needed,
        needed=needed,
        share=float(share(drop).max()),
        across=float((rest[2] - m.nu * rest[k]).max()) if case.dim == 2 else 0.0,
    )


def lateral(case: Case, across: int) -> list[int]:
    """Return the axes of the body along a face, whose normal is the axis across."""
    return [axis for axis in range(case.dim) if axis != across]


def pulled_axes(case: Case, across: int) -> list[int]:
    """Return the axes along which a cooled face pulls: in plane strain across the plane too."""
    third = case.dim == 2 and not case.plane_stress
    return [*lateral(case, across), *([2] if third else [])]


def thermal_stress(derived: Numbers, drop: float) -> float:
    """Return the stress along a face that is colder by a drop (K) than the rock around it (Pa)."""
    m = derived.rock
    free = 1.0 if derived.state == PLANE_STRESS else 1 - m.nu
    return m.E * m.expansion * drop / free


def _first(excess: Callable[[float], float], step: float) -> float:
    """Return the drop (K) at which an excess that grows becomes zero, looked for from a step on."""
    if excess(0.0) >= 0:
        return 0.0
    high = step
    while excess(high) < 0:
        high *= 2
        if high > AS_GOOD_AS_NEVER * step:
            return high
    return float(scipy.optimize.brentq(excess, 0.0, high, xtol=1e-9 * step))

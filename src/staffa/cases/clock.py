"""How fast heat diffuses in a case, and its times in seconds (or scaled).

What a scaled case leaves out is 1. Of a rock that varies these are the averages in [material].
"""

import numpy as np

from staffa.cases.kinds import ONE
from staffa.cases.model import Case
from staffa.cases.pieces import conductivity, pieces
from staffa.grid import face_axis
from staffa.physics.scales import time_of_tau


def conductivities(case: Case) -> tuple[float, ...]:
    """Conductivity along each axis, of a case with profile "heat" (W/(m K))."""
    return tuple(np.diag(conductivity(pieces(case)[0])).tolist())


def heat_capacity(case: Case) -> float:
    """rho c, of a case with profile "heat" (J/(m^3 K))."""
    body = pieces(case)[0]
    return body.average(body.keys.rho or ONE) * body.average(body.keys.c or ONE)


def diffusivity(case: Case, side: str | None = None) -> float:
    """kappa (m^2/s) across a side, by default the one from which depths are measured."""
    if case.heat is None:
        return float(case.material.kappa or ONE)
    axis = face_axis(side or case.temperature.face, case.dim)
    return conductivities(case)[axis] / heat_capacity(case)


def depth(case: Case) -> float:
    """L, the extent of the body below the cooled face; its height without cooling (m)."""
    cooled = case.temperature.profile != "none"
    axis = face_axis(case.temperature.face, case.dim) if cooled else case.dim - 1
    return float(case.domain.size[axis])


def times_in(case: Case, given: np.ndarray) -> list[float]:
    """Times (s), from tau or t as the case counts them."""
    if case.time.tau is None:
        return [float(t) for t in given]
    scale = {"kappa": diffusivity(case), "L": depth(case)}
    return [time_of_tau(float(tau), **scale) for tau in given]

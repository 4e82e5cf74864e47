"""Diffusion of heat in a case, and its times in seconds (or scaled).

Keys that a scaled case leaves out are 1. Rock that varies counts by its averages in [material].
"""

import numpy as np

from staffa.case.schema.case import Case
from staffa.case.schema.field_types import ONE
from staffa.case.values import subdomains
from staffa.physics.scales import time_of_tau


def conductivities(case: Case) -> tuple[float, ...]:
    """Return the conductivity along each axis (W/(m K)), of a case that conducts."""
    return tuple(np.diag(subdomains.conductivity(subdomains.subdomains_of(case)[0])).tolist())


def conductivity_across(case: Case, face: str) -> float:
    """Return the conductivity across a face; the mean one if the face is not flat (W/(m K))."""
    along = conductivities(case)
    axis = case.outline.axis(face) if face in case.outline.faces else None
    return sum(along) / len(along) if axis is None else along[axis]


def heat_capacity(case: Case) -> float:
    """Return rho c, of a case that conducts (J/(m^3 K))."""
    body = subdomains.subdomains_of(case)[0]
    return body.average(body.keys.rho or ONE) * body.average(body.keys.c or ONE)


def diffusivity(case: Case, side: str | None = None) -> float:
    """Return kappa (m^2/s) across a side, by default the one from which depths are measured."""
    if not case.conducts:
        return float(case.material.kappa or ONE)
    return conductivity_across(case, side or case.temperature.face) / heat_capacity(case)


def depth(case: Case) -> float:
    """Return L, the extent of the body below the cooled face (m).

    If that face is none of its flat sides, L is the least extent; without a face the height.
    """
    size, face = case.outline.size, case.temperature.face
    if not case.temperature.has_face:
        return size[-1]
    axis = case.outline.axis(face)
    return min(size) if axis is None or case.outline.sides[face] is None else size[axis]


def times_in(case: Case, given: np.ndarray) -> list[float]:
    """Return times (s), from tau or t as the case counts them."""
    if case.time.tau is None:
        return [float(t) for t in given]
    scale = {"kappa": diffusivity(case), "L": depth(case)}
    return [time_of_tau(float(tau), **scale) for tau in given]

"""The elastic energy of a cooled body that does not damage, against closed forms, to 0.5 %."""

from itertools import pairwise

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.special import erfc

from staffa.evolution.march import march
from staffa.evolution.system import build
from staffa.model.supports import GeneralizedPlaneStrain, rollers
from support.bodies import UNSTRUCTURED, Unbreakable, body, quench, rock

NU, DT, TAU = 0.3, 2.0, 0.4
TIME = TAU**2 / 4


def strain(y: float) -> float:
    """Free thermal strain at depth y below the face, in a slab of height 1."""
    return -DT * erfc(y / TAU)


def modes(section: str) -> list:
    """Mean strains that the section leaves free, as functions of y."""
    stretch, bend = (lambda y: 1.0), (lambda y: y - 0.5)
    return {"fixed": [], "stretch": [stretch], "free": [stretch, bend]}[section]


def energy_per_length(state: str, section: str) -> float:
    """Minimum over the free mean strains of int W(e_xx - p, p) dy, with sigma_yy = 0.

    W = 1/2 E (e - p)^2 in plane stress; 1/2 E/(1 - nu^2) (a^2 + b^2 + 2 nu a b), a = e - p and b =
    -p, in plane strain.
    """
    plane = state == "plane strain"
    E = 1 / (1 - NU**2) if plane else 1.0
    nu = NU if plane else 0.0
    coupling = 1 + nu  # the force of a strain p is -E (1 + nu) p

    def integral(f) -> float:
        return quad(f, 0, 1, epsabs=1e-12)[0]

    free = modes(section)
    matrix = np.array([[integral(lambda y, f=f, g=g: f(y) * g(y)) for f in free] for g in free])
    right = np.array([coupling * integral(lambda y, f=f: f(y) * strain(y)) for f in free])
    blocked = (2 + 2 * nu) / 2 if plane else 0.5
    energy = E * blocked * integral(lambda y: strain(y) ** 2)
    if free:
        energy -= E / 2 * float(right @ np.linalg.solve(matrix, right))
    return energy


def elastic_energy(state: str, width: float, h: float, section: str | None, cells: str) -> float:
    material = rock(law=Unbreakable(), state=state, nu=NU, ell=0.1)
    fields = {"load": quench(DT), "times": (TIME,), "material": material, "cells": cells}
    if section is None:
        problem = body((width, 1.0), h, anchor="top", **fields)
    else:
        held = ["left", "right"] if section == "fixed" else ["left"]
        free = {
            "fixed": None,
            "stretch": GeneralizedPlaneStrain(bending=False),
            "free": GeneralizedPlaneStrain(bending=True),
        }
        domain = body((width, 1.0), h, **fields).domain
        sides = tuple(rollers(domain, side) for side in held)
        problem = body((width, 1.0), h, sides=sides, section=free[section], anchor="top", **fields)
    system = build(problem)
    (step,) = march(problem, system)
    system.destroy()
    assert step.energies.surface < 1e-12
    return step.energies.elastic


@pytest.mark.parametrize("section", ["fixed", "stretch", "free"])
@pytest.mark.parametrize("state", ["plane stress", "plane strain"])
@pytest.mark.parametrize("cells", ["quadrilateral", "triangle", UNSTRUCTURED])
def test_cell_of_a_long_slab(state: str, section: str, cells: str) -> None:
    width = 0.05
    found = elastic_energy(state, width, 0.01, section, cells) / width
    exact = energy_per_length(state, section)
    assert found == pytest.approx(exact, rel=0.005), f"{found:.5f} against {exact:.5f}"


def test_a_section_that_is_freer_stores_less() -> None:
    energies = [energy_per_length("plane stress", s) for s in ("fixed", "stretch", "free")]
    assert all(a > 1.2 * b for a, b in pairwise(energies)), f"too alike to test: {energies}"


@pytest.mark.slow
@pytest.mark.parametrize(
    "state", ["plane stress", pytest.param("plane strain", marks=pytest.mark.long)]
)
def test_slab_with_free_ends(state: str) -> None:
    """The ends relax, the same in both widths: the difference is five lengths of the middle."""
    h = 0.0125
    wide, narrow = (elastic_energy(state, w, h, None, "quadrilateral") for w in (10.0, 5.0))
    exact = 5 * energy_per_length(state, "free")
    assert wide - narrow == pytest.approx(exact, rel=0.005)
    assert narrow < 0.98 * exact, "free ends relax by several percent"


def test_box_with_blocked_sides() -> None:
    """Both lateral strains blocked: the energy density is E p^2/(1 - nu)."""
    material = rock(law=Unbreakable(), state="solid", nu=NU, ell=0.1)
    from staffa.loads.closed_form import Face, HalfSpace

    load = HalfSpace(dT=DT, kappa=1.0, face=Face(axis=2, position=0.0, inward=1))
    size, fields = (0.1, 0.1, 1.0), {"load": load, "times": (TIME,), "material": material}
    domain = body(size, 0.02, **fields).domain
    sides = tuple(rollers(domain, side) for side in ("left", "right", "front", "back"))
    problem = body(size, 0.02, sides=sides, anchor="top", displacement="iterative", **fields)
    system = build(problem)
    (step,) = march(problem, system)
    exact = 0.01 / (1 - NU) * quad(lambda y: strain(y) ** 2, 0, 1)[0]
    assert step.energies.elastic == pytest.approx(exact, rel=0.005)
    system.destroy()

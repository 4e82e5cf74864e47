"""Closed-form temperatures satisfy the heat equation, initial and boundary conditions."""

import numpy as np
import pytest

from staffa.loads.closed_form import PROFILES, Convective, CooledFace, Face, HalfSpace, Slab

KAPPA, DT, L, H = 0.7, 3.0, 1.3, 4.0
BOTTOM = Face(axis=1, position=0.0, inward=1)
LOADS = {
    "half-space": HalfSpace(dT=DT, kappa=KAPPA, face=BOTTOM),
    "slab": Slab(dT=DT, kappa=KAPPA, face=BOTTOM, L=L),
    "convective": Convective(dT=DT, kappa=KAPPA, face=BOTTOM, h=H),
}
# sqrt(kappa t)/L from 0.05 to 0.9: the slab's early and late forms are both met.
TIMES = [0.05**2 * L**2 / KAPPA, 0.3**2 * L**2 / KAPPA, 0.44**2 * L**2 / KAPPA, 0.8 * L**2 / KAPPA]


COOLED = CooledFace(dT=DT, kappa=KAPPA, face=BOTTOM, L=L, biot=H * L)


def at(y: np.ndarray) -> np.ndarray:
    return np.array([np.full_like(y, 0.4), y, np.zeros_like(y)])


def derivative(f, x: float, step: float) -> np.ndarray:
    """Fourth-order central difference."""
    return (f(x - 2 * step) - 8 * f(x - step) + 8 * f(x + step) - f(x + 2 * step)) / (12 * step)


@pytest.mark.parametrize("name", LOADS)
def test_a_case_names_the_load(name: str) -> None:
    assert PROFILES[name](COOLED) == LOADS[name]


@pytest.mark.parametrize("name", PROFILES)
def test_a_profile_is_a_function_of_place_and_time_that_only_cools(name: str) -> None:
    """One finite number a point, the same when asked again; no change before cooling begins."""
    load, x = PROFILES[name](COOLED), at(np.linspace(0.01, 1.0, 30) * L)
    for t in TIMES:
        found = load.temperature(x, t)
        assert found.shape == (30,) and np.isfinite(found).all()
        assert found.max() <= 0
    assert np.array_equal(load.temperature(x, TIMES[0]), load.temperature(x, TIMES[0]))
    assert np.all(load.temperature(x, 0.0) == 0)


@pytest.mark.parametrize("name", LOADS)
@pytest.mark.parametrize("t", TIMES)
def test_heat_equation_holds(name: str, t: float) -> None:
    load, y = LOADS[name], np.linspace(0.05, 0.95, 19) * L
    dt, dy = 1e-3 * t, 1e-3 * np.sqrt(KAPPA * t)
    rate = derivative(lambda s: load.temperature(at(y), s), t, dt)

    def slope(shift: float) -> np.ndarray:
        return derivative(lambda s: load.temperature(at(y + s), t), shift, dy)

    curvature = derivative(slope, 0.0, dy)
    scale = DT / t  # both sides are of this order near the front
    error = np.abs(rate - KAPPA * curvature).max() / scale
    assert error < 1e-7, f"dT/dt and kappa d2T/dy2 differ by {error:.1e} of dT/t"


@pytest.mark.parametrize("name", LOADS)
def test_initial_temperature_is_zero(name: str) -> None:
    y = np.linspace(0.1, 1.0, 10) * L
    assert np.all(LOADS[name].temperature(at(y), 0.0) == 0)
    soon = LOADS[name].temperature(at(y), 1e-6 * L**2 / KAPPA)
    assert np.abs(soon).max() < 1e-12 * DT


@pytest.mark.parametrize("name", ["half-space", "slab"])
@pytest.mark.parametrize("t", TIMES)
def test_face_is_at_the_drop(name: str, t: float) -> None:
    surface = LOADS[name].temperature(at(np.zeros(1)), t)[0]
    assert surface == pytest.approx(-DT, rel=1e-12)


@pytest.mark.parametrize("t", TIMES)
def test_opposite_boundary_of_the_slab_is_insulated(t: float) -> None:
    slab = LOADS["slab"]
    flux = derivative(lambda s: slab.temperature(at(np.array([L + s])), t), 0.0, 1e-4 * L)[0]
    assert abs(flux) < 1e-9 * DT / L


@pytest.mark.parametrize("t", TIMES)
def test_convective_flux_is_the_film_times_the_difference(t: float) -> None:
    load = LOADS["convective"]
    step = 1e-3 * np.sqrt(KAPPA * t)
    near = load.temperature(at(np.array([0, 1, 2, 3, 4]) * step), t)
    slope = (-25 * near[0] + 48 * near[1] - 36 * near[2] + 16 * near[3] - 3 * near[4]) / (12 * step)
    film = H * (near[0] + DT)
    assert slope == pytest.approx(film, rel=1e-7)


def test_early_and_late_forms_of_the_slab_agree() -> None:
    slab, y = Slab(dT=DT, kappa=KAPPA, face=BOTTOM, L=L), np.linspace(0, L, 30)
    t = 0.2 * L**2 / KAPPA
    early, late = slab._images(y, t), slab._series(y, 0.2)
    assert np.abs(early - late).max() < 1e-13


def test_strong_film_is_a_drop_of_the_face() -> None:
    strong = Convective(dT=DT, kappa=KAPPA, face=BOTTOM, h=1e8)
    y, t = np.linspace(0, L, 20), TIMES[1]
    difference = strong.temperature(at(y), t) - LOADS["half-space"].temperature(at(y), t)
    assert np.abs(difference).max() < 1e-6 * DT


@pytest.mark.parametrize("axis", [0, 1, 2])
@pytest.mark.parametrize("inward", [1, -1])
def test_any_face_cools_the_same(axis: int, inward: int) -> None:
    """The temperature is a function of the depth below the face alone."""
    position = 2.0
    face = Face(axis=axis, position=position, inward=inward)
    depth = np.linspace(0, 1, 7)
    x = np.zeros((3, 7))
    x[axis] = position + inward * depth
    turned = HalfSpace(dT=DT, kappa=KAPPA, face=face).temperature(x, TIMES[1])
    upright = LOADS["half-space"].temperature(at(depth), TIMES[1])
    assert turned == pytest.approx(upright, rel=1e-14)

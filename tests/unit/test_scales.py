"""The strengths, drops and lengths that are known by hand."""

from math import inf, isclose, sqrt

import numpy as np
import pytest

from staffa.physics import doubling, scales
from staffa.physics.damage import AT1, AT2, effective_gc_factor, strength
from staffa.physics.material import PLANE_STRAIN, PLANE_STRESS, SOLID, energy_density, lame

# Alumina: Bourdin, Marigo, Maurini, Sicsic, Phys. Rev. Lett. 112, 014301 (2014).
ROCK = {"E": 340e9, "nu": 0.22, "Gc": 42.47, "expansion": 8e-6}
ELL = 46e-6
EXACT = 1e-12  # round-off; the strength's search over alpha is exact to 1e-9
FOUND = 1e-6  # AT2 peaks between two of the alphas that are tried
BODIES = (PLANE_STRESS, PLANE_STRAIN, SOLID)


def drop_of(law=None, *, state: str = PLANE_STRESS, ell: float = ELL, **changes) -> float:
    found = scales.critical_drop(law or AT1(), **{**ROCK, **changes}, ell=ell, state=state)
    assert found is not None
    return found


@pytest.mark.parametrize(("E", "Gc", "ell"), [(1, 1, 0.03), (100, 1, 0.1), (340e9, 42.47, 46e-6)])
def test_strengths_of_both_laws(E, Gc, ell):
    at1, at2 = (strength(law, E=E, Gc=Gc, ell=ell) for law in (AT1(), AT2()))
    assert isclose(at1, sqrt(3 * Gc * E / (8 * ell)), rel_tol=FOUND), f"AT1 {at1}"
    assert isclose(at2, 3 / 16 * sqrt(3 * E * Gc / ell), rel_tol=FOUND), f"AT2 {at2}"


def test_strength_of_the_bar_and_of_alumina():
    bar = strength(AT1(), E=100, Gc=1, ell=0.1)
    assert round(bar, 3) == 19.365, f"{bar}, by hand 19.365"
    alumina = strength(AT1(), E=340e9, Gc=42.47, ell=ELL)
    assert isclose(alumina, 342e6, rel_tol=0.005), f"{alumina:.4g} Pa, measured 342 MPa"


def test_critical_drop_in_plane_stress_is_that_of_a_blocked_bar():
    by_hand = sqrt(3 * ROCK["Gc"] / (8 * ROCK["E"] * ELL)) / ROCK["expansion"]
    assert isclose(drop_of(), by_hand, rel_tol=EXACT), f"{drop_of()}, by hand {by_hand}"


@pytest.mark.parametrize("nu", [-0.3, 0.0, 0.22, 0.49])
@pytest.mark.parametrize("state", [PLANE_STRAIN, SOLID])
def test_critical_drop_with_both_lateral_strains_blocked(nu, state):
    found = drop_of(state=state, nu=nu)
    rest = 3 * ROCK["Gc"] * (1 - nu) / (16 * ROCK["E"] * ELL)
    by_hand = sqrt(rest) / ROCK["expansion"]
    assert isclose(found, by_hand, rel_tol=EXACT), f"{found}, by hand {by_hand}"


@pytest.mark.parametrize("nu", [0.0, 0.22, 0.4])
@pytest.mark.parametrize("state", BODIES)
def test_at_the_critical_drop_the_energy_density_is_at_the_threshold(nu, state):
    """AT1 starts where psi = Gc/(4 c_w ell) w'(0)/-a'(0) = 3 Gc/(16 ell), in any stress state."""
    blocked = 1 if state == PLANE_STRESS else 2  # lateral strains; the rest is free of stress
    strain = np.full(blocked, ROCK["expansion"] * drop_of(state=state, nu=nu))
    lambda_, mu = lame(ROCK["E"], nu, state)
    across = -lambda_ * strain.sum() / (lambda_ + 2 * mu)  # along the depth, free of stress
    elastic = np.append(strain, across)
    psi = energy_density(elastic.sum(), elastic @ elastic, lambda_, mu)
    threshold = 3 * ROCK["Gc"] / (16 * ELL)
    assert isclose(psi, threshold, rel_tol=FOUND), f"psi {psi}, threshold {threshold}"


def test_at2_has_no_threshold():
    assert scales.critical_drop(AT2(), **ROCK, ell=ELL, state=PLANE_STRESS) is None


@pytest.mark.parametrize("dT", [100.0, 380.0, 1000.0])
def test_drop_over_critical_drop_follows_from_ell_over_ell0_in_plane_stress(dT):
    ell0 = scales.ell0(**ROCK, dT=dT, state=PLANE_STRESS)
    m = dT / drop_of()
    assert isclose(m, sqrt(8 * ELL / (3 * ell0)), rel_tol=FOUND), f"m = {m}"


def test_ell0_of_alumina_and_of_both_lateral_strains_blocked():
    dT, nu = 380.0, ROCK["nu"]
    stress = ROCK["Gc"] / (ROCK["E"] * (ROCK["expansion"] * dT) ** 2)
    found = scales.ell0(**ROCK, dT=dT, state=PLANE_STRESS)
    assert isclose(found, stress, rel_tol=EXACT) and round(found * 1e6, 1) == 13.5
    for state in (PLANE_STRAIN, SOLID):
        blocked = scales.ell0(**ROCK, dT=dT, state=state)
        by_hand = stress * (1 - nu) / (1 + nu)
        assert isclose(blocked, by_hand, rel_tol=EXACT), f"{blocked}, by hand {by_hand}"


def test_ell0_without_a_drop_is_infinite():
    assert scales.ell0(**ROCK, dT=0.0, state=PLANE_STRESS) == inf


def test_severity_and_drop_are_each_other_s_inverse():
    body = {"expansion": 8e-6, "E": 340e9, "L": 4.9e-3, "Gc": 42.47}
    severity = scales.severity(dT=380.0, **body)
    assert isclose(scales.dT_of_severity(severity=severity, **body), 380.0, rel_tol=EXACT)
    assert isclose(severity**2, body["L"] / scales.ell0(**ROCK, dT=380.0, state=PLANE_STRESS))


def test_tau_and_time_are_each_other_s_inverse():
    t = scales.time_of_tau(0.3, kappa=8.85e-6, L=4.9e-3)
    assert isclose(scales.tau_of_time(t, kappa=8.85e-6, L=4.9e-3), 0.3, rel_tol=EXACT)
    assert isclose(scales.diffusion_length(8.85e-6, t), 0.3 * 4.9e-3 / 2, rel_tol=EXACT)


def test_first_guess_at_the_effective_gc():
    at1, at2 = (effective_gc_factor(law, h=0.01, ell=0.03) for law in (AT1(), AT2()))
    assert isclose(at1, 1 + 3 / 8 / 3) and isclose(at2, 1 + 1 / 2 / 3), f"{at1}, {at2}"


def test_arrays_double_where_the_table_says_and_nothing_is_told_beyond_it():
    ell0 = 2.0**-6  # without round-off: at the ends of the table that would be beyond it
    for p, a in zip(doubling.SPACING, doubling.LENGTH, strict=True):
        assert doubling.spacing_at(a * ell0, ell0) == pytest.approx(p * ell0)
    between = doubling.spacing_at(np.array([0.0, 1.9, 25.0, 3050.0]) * ell0, ell0) / ell0
    assert np.isnan(between[[0, 1, 3]]).all() and 32 < between[2] < 64


@pytest.mark.parametrize("state", BODIES)
def test_unit_of_doubling_is_that_of_the_stress_released_over_the_modulus(state):
    """G of cracks that release the stress sigma goes with sigma^2/E'."""
    E, nu, Gc, strain = ROCK["E"], ROCK["nu"], ROCK["Gc"], ROCK["expansion"] * 100
    blocked = state != PLANE_STRESS
    sigma = E * strain / (1 - nu) if blocked else E * strain
    modulus = E / (1 - nu**2) if blocked else E
    found = scales.ell0(**ROCK, dT=100, state=state)
    assert found == pytest.approx(Gc * modulus / sigma**2)
    if blocked:
        assert found == pytest.approx(Gc * (1 - nu) / (E * (1 + nu) * strain**2))

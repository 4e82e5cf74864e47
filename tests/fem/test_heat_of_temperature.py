"""The heat equation with conductivity, capacity and films that depend on temperature."""

from dataclasses import replace

from staffa.backend.stack import MPI

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import erfc

from staffa.heat.thermal_body import (
    Conduction,
    Conductor,
    Dirichlet,
    FluidFilledCrack,
    Neumann,
    OfSurface,
    Robin,
)
from staffa.physics.temperature import ARRAYS, LinearTable, Written
from support.heated import Heated, tensor


def even(T: float):
    """A temperature (K) that is the same everywhere."""
    return lambda x: np.full(x.shape[1], T)


def at(T: float):
    """A prescribed temperature (K) at all times."""
    return lambda x, t: T


RISING = LinearTable(T=(0.0, 1.0), value=(1.0, 3.0))  # 1 + 2 T
PLAIN = Conduction(k=tensor(1.0, 1.0), rho_c=1.0, initial=even(0.0))


def kirchhoff(T: np.ndarray) -> np.ndarray:
    """Integral of 1 + 2 T."""
    return T + T**2


def inverse(theta: np.ndarray) -> np.ndarray:
    """Temperature with this integral."""
    return (np.sqrt(1 + 4 * theta) - 1) / 2


def test_a_steady_slab_is_exact_at_the_vertices_by_kirchhoffs_transform() -> None:
    sides = (Dirichlet(side="left", T=at(0.0)), Dirichlet(side="right", T=at(1.0)))
    body = Heated((1.0, 0.2), 0.1, replace(PLAIN, k_law=RISING, sides=sides))
    body.to(100.0)
    expected = inverse(kirchhoff(1.0) * body.x[0])
    assert np.abs(body.T - expected).max() < 1e-9


def test_a_half_space_cools_as_kirchhoffs_transform_says() -> None:
    """If k and c change alike, the transformed temperature obeys the linear equation."""
    errors = []
    for h in (0.04, 0.02):
        conduction = replace(
            PLAIN,
            initial=even(1.0),
            k_law=RISING,
            c_law=RISING,
            sides=(Dirichlet(side="left", T=at(0.0)),),
            tolerance=1e-6,
        )
        body = Heated((2.0, 2 * h), h, conduction)
        heat = body.to(0.05)
        theta = kirchhoff(1.0) * (1 - erfc(body.x[0] / (2 * np.sqrt(0.05))))
        errors.append(np.abs(body.T + 1.0 - inverse(theta)).max())
        assert heat.imbalance < 1e-8
    assert errors[1] < 2e-3
    order = np.log2(errors[0] / errors[1])
    assert 1.5 < order < 2.5, f"error {errors}, order {order:.2f}"


def test_a_manufactured_solution_converges_at_second_order() -> None:
    """T = 1 + sin(pi x)/2 exp(-t), with k = 1 + 2 T and c = 2 - T/2, by its own source."""

    def exact(x: np.ndarray, t: float) -> np.ndarray:
        return 1 + 0.5 * np.sin(np.pi * x[0]) * np.exp(-t)

    def source(x: np.ndarray, t: float) -> np.ndarray:
        wave = 0.5 * np.exp(-t)
        T, slope = exact(x, t), wave * np.pi * np.cos(np.pi * x[0])
        bend, rate = -(np.pi**2) * (T - 1), -(T - 1)
        return (2 - T / 2) * rate - (1 + 2 * T) * bend - 2 * slope**2

    errors = []
    for h in (0.1, 0.05, 0.025):
        conduction = replace(
            PLAIN,
            initial=lambda x: exact(x, 0.0),
            k_law=LinearTable(T=(0.0, 3.0), value=(1.0, 7.0)),
            c_law=LinearTable(T=(0.0, 3.0), value=(2.0, 0.5)),
            sides=(Dirichlet(side="left", T=at(1.0)), Dirichlet(side="right", T=at(1.0))),
            source=source,
            tolerance=1e-6,
        )
        body = Heated((1.0, 2 * h), h, conduction, cells="triangle")
        heat = body.to(0.5)
        errors.append(np.abs(body.T + exact(body.x, 0.0) - exact(body.x, 0.5)).max())
        assert heat.imbalance < 1e-8
    orders = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all((orders > 1.8) & (orders < 2.2)), f"errors {errors}, orders {orders}"


def test_laws_that_change_nothing_give_the_linear_equation() -> None:
    one = LinearTable(T=(0.0, 1.0), value=(1.0, 1.0))
    sides = (
        Robin(side="left", h=at(3.0), T=at(-1.0)),
        Neumann(side="right", q=at(0.5)),
        Dirichlet(side="top", T=at(0.2)),
    )
    plain = replace(PLAIN, sides=sides, tolerance=1e-5)
    linear, lawful = (Heated((1.0, 0.5), 0.1, c) for c in (plain, replace(plain, c_law=one)))
    for time in (0.01, 0.3):
        expected, found = linear.to(time), lawful.to(time)
        assert np.abs(lawful.T - linear.T).max() < 1e-9
        assert found.entered == pytest.approx(expected.entered, rel=1e-8)
        assert found.substeps == expected.substeps


def test_a_thin_body_takes_up_latent_heat() -> None:
    """A peak of the capacity, as melting has: the temperature is that of the heat that entered."""
    peak = LinearTable(T=(0.9, 1.0, 1.1), value=(1.0, 20.0, 1.0))
    conduction = replace(
        PLAIN, k=tensor(1e5, 1e5), c_law=peak, sides=(Neumann(side="left", q=at(1.0)),)
    )
    body = Heated((1.0, 1.0), 0.5, conduction)
    for entered in (0.5, 1.5, 3.0, 4.0):
        heat = body.to(entered)
        held = peak.integral(0.0, body.T, body.x)
        assert np.abs(held - entered).max() < 2e-3 * entered
        assert heat.imbalance < 1e-8


def test_radiation_as_a_film_of_temperature_follows_the_fourth_power() -> None:
    """h = (T^2 + B^2)(T + B) is radiation to a wall at B; a thin body, against an ODE solver."""
    wall = 0.3
    film = Robin(
        side="left", h=OfSurface(at=lambda x, t, T: (T**2 + wall**2) * (T + wall)), T=at(wall)
    )
    body = Heated(
        (1.0, 1.0), 0.5,
        replace(PLAIN, k=tensor(1e4, 1e4), initial=even(1.0), sides=(film,), tolerance=1e-6),
    )  # fmt: skip
    heat = body.to(2.0)
    known = solve_ivp(lambda t, T: wall**4 - T**4, (0.0, 2.0), [1.0], rtol=1e-10, atol=1e-12)
    assert np.abs(body.T + 1.0 - known.y[0, -1]).max() < 2e-4
    assert heat.imbalance < 1e-8


# Film boiling, transition and nucleate boiling, convection: the shape of public data of quenched
# steel probes in water (Energies 15, 4258, 2022): small, a peak of 30 times that, small again.
BOILING = LinearTable(T=(0.1, 0.15, 0.2, 0.35, 0.6, 1.0), value=(0.5, 3.0, 9.0, 0.6, 0.3, 0.4))


def boiled(cracks: FluidFilledCrack | None = None) -> Conduction:
    """A hot body in a boiling bath, whose film has a peak."""
    h = OfSurface(at=lambda x, t, T: np.interp(T, BOILING.T, BOILING.value) * 10)
    return replace(
        PLAIN,
        initial=even(1.0),
        k_law=LinearTable(T=(0.0, 1.0), value=(1.0, 0.5)),
        sides=(Robin(side="left", h=h, T=at(0.0)),),
        cracks=cracks,
    )


def test_a_boiling_curve_is_followed_through_its_peak() -> None:
    coarse, fine = (
        Heated((1.0, 0.1), 0.05, replace(boiled(), tolerance=tolerance))
        for tolerance in (1e-4, 1e-6)
    )
    for time in (0.01, 0.1, 0.3, 1.0):
        heats = [body.to(time) for body in (coarse, fine)]
        assert all(heat.imbalance < 1e-8 for heat in heats)
        assert np.abs(coarse.T - fine.T).max() < 3e-3
    assert coarse.T.max() < -0.5, "the body has gone through the peak"
    assert heats[0].substeps < 500


def test_an_even_body_stays_as_it_is() -> None:
    body = Heated((1.0, 1.0), 0.25, replace(PLAIN, initial=even(293.15), k_law=RISING))
    heat = body.to(10.0)
    assert np.all(body.T == 0.0) and heat.stored == 0.0


def test_regions_have_laws_of_their_own() -> None:
    """Two thin halves that nothing couples but their own capacity: flux into both."""
    law = LinearTable(T=(0.0, 1.0), value=(1.0, 5.0))
    other = Conductor(k=tensor(1.0, 1.0), rho_c=2.0, c_law=law)
    conduction = replace(PLAIN, regions={"r": other}, source=at(1.0))
    body = Heated((1.0, 1.0), 0.25, conduction, parts={"r": lambda x: x[0] > 0.5})
    heat = body.to(0.2)
    assert heat.entered["source"] == pytest.approx(0.2, rel=1e-9)
    assert heat.imbalance < 1e-8
    left, right = (body.T[np.isclose(body.x[0], x)] for x in (0.0, 1.0))
    assert left.min() > right.max(), "the half that holds more heat a kelvin stays colder"


@pytest.mark.parametrize("start, end", [(0.0, 2.0), (1.7, -0.4), (0.3, 0.3)])
def test_integrals_of_tables_and_formulas_agree(start: float, end: float) -> None:
    table = LinearTable(T=(-1.0, 3.0), value=(0.5, 4.5))
    text = Written(text="T", reference=0.0, value=lambda T, x, functions: 1.5 + T)
    scaled = 1.5 * text.integral(start, end, None)
    assert table.integral(start, end, None) == pytest.approx(scaled, rel=1e-12, abs=1e-14)
    panels = np.linspace(start, end, 2001)
    by_parts = np.trapezoid([table.at(T, None) for T in panels], panels)
    assert table.integral(start, end, None) == pytest.approx(by_parts, rel=1e-9, abs=1e-14)


def test_a_table_is_constant_beyond_its_ends() -> None:
    table = LinearTable(T=(1.0, 2.0, 4.0), value=(1.0, 3.0, 2.0))
    T = np.array([-5.0, 1.0, 1.5, 2.0, 3.0, 4.0, 90.0])
    assert table.at(T, None) == pytest.approx([1.0, 1.0, 2.0, 3.0, 2.5, 2.0, 2.0], abs=1e-13)
    assert ARRAYS.numbers(T) is T


def march_boiled() -> list[tuple[float, float, float]]:
    """Heat stored, that through the film, and its imbalance, at three times."""
    body = Heated((1.0, 0.2), 0.1, boiled(), comm=MPI.COMM_WORLD)
    heats = [body.to(time) for time in (0.05, 0.3, 1.0)]
    return [(heat.stored, heat.entered["left"], heat.imbalance) for heat in heats]

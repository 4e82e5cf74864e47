"""The heat equation against closed forms and made-up solutions, its balance, and its purity."""

from staffa.backend.stack import MPI

import numpy as np
import pytest
from scipy.special import erfcx

from staffa.errors import InputError, LoadError
from staffa.heat.thermal_body import (
    Conduction,
    Dirichlet,
    FluidFilledCrack,
    Insulating,
    Neumann,
    Robin,
)
from staffa.loads.closed_form import Convective, Face, HalfSpace, Slab
from support.bodies import UNSTRUCTURED, rates
from support.heated import Heated, broken_layer, still, tensor, turned

BOTTOM = Face(axis=1, position=0.0, inward=1)
K, RHO_C, DT = 3.0, 2.0, 54.0
KAPPA = K / RHO_C
FILM = 40.0  # W/(m^2 K)


def cold(x, t):
    """300 K less the drop."""
    return 300.0 - DT


def hot(x):
    """300 K at every point."""
    return np.full(x.shape[1], 300.0)


CLOSED = {
    "half-space": (HalfSpace(dT=DT, kappa=KAPPA, face=BOTTOM), Dirichlet(side="bottom", T=cold)),
    "slab": (Slab(dT=DT, kappa=KAPPA, face=BOTTOM, L=1.0), Dirichlet(side="bottom", T=cold)),
    "convective": (
        Convective(dT=DT, kappa=KAPPA, face=BOTTOM, h=FILM / K),
        Robin(side="bottom", h=lambda x, t: FILM, T=cold),
    ),
}


def worst_error(name: str, cells: str, *, since: float = 0.06) -> float:
    """Over the drop, against a closed form, from sqrt(kappa t) = 3 h to where the far side is felt;
    the slab until it is cold. since: another sqrt(kappa t) to begin with; h is .02."""
    form, side = CLOSED[name]
    conduction = Conduction(k=tensor(K, K), rho_c=RHO_C, initial=hot, sides=(side,))
    body, worst = Heated((0.15, 1.0), 0.02, conduction, cells=cells), 0.0
    late = [0.5, 1.5] if name == "slab" else []
    for length in [0.01, 0.02, 0.04, 0.06, 0.09, 0.12, 0.18, 0.22, *late]:
        time = length**2 / KAPPA
        assert body.to(time).imbalance < 1e-8
        if length >= since:
            error = np.abs(body.T - form.temperature(body.x, time)).max() / DT
            worst = max(worst, float(error))
    return worst


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("cells", ["quadrilateral", "triangle", UNSTRUCTURED])
def test_closed_forms_are_reproduced_to_half_a_percent_of_the_drop(name: str, cells: str) -> None:
    assert worst_error(name, cells) < 0.005


def warming(size: tuple[float, ...], cells: str, *ratios: float) -> float:
    """Over the drop, how much warmer than at the start, or colder than its bath, a quenched corner
    gets, from a diffusion length of a hundredth of a cell on, in steps that double it.

    ratios: of the conductivities along the axes, all 1 if not given.
    """
    conduction = Conduction(
        k=tensor(*(K * ratio for ratio in ratios or (1.0,) * len(size))),
        rho_c=RHO_C,
        initial=hot,
        sides=(Dirichlet(side="bottom", T=cold), Dirichlet(side="left", T=cold)),
    )
    body, worst = Heated(size, 0.01, conduction, cells=cells), 0.0
    for length in 0.01 * 2.0 ** np.arange(-7, 4):
        body.to(length**2 / KAPPA)
        worst = max(worst, body.T.max() / DT, -body.T.min() / DT - 1)
    return float(worst)


@pytest.mark.parametrize(
    ("size", "cells", "allowed"),
    [
        ((0.2, 0.2), "quadrilateral", 0.01),
        ((0.2, 0.2), "triangle", 0.01),
        pytest.param((0.2, 0.2), "unstructured", 0.01, marks=UNSTRUCTURED.marks),
        ((0.1, 0.1, 0.1), "hexahedron", 0.01),
        ((0.1, 0.1, 0.1), "tetrahedron", 0.01),
        # Some of Gmsh's tetrahedra have obtuse angles between their faces.
        pytest.param((0.1, 0.1, 0.1), "unstructured", 0.03, marks=UNSTRUCTURED.marks),
    ],
)
def test_a_quench_makes_nothing_warmer_than_it_was(size, cells: str, allowed: float) -> None:
    assert warming(size, cells) < allowed


def test_a_flux_cools_like_a_half_space() -> None:
    """T = -2 q sqrt(kappa t/pi)/k at the face (Carslaw and Jaeger, 2.9)."""
    q = 250.0
    body = Heated(
        (0.1, 1.0),
        0.01,
        Conduction(
            k=tensor(K, K),
            rho_c=RHO_C,
            initial=still,
            sides=(Neumann(side="bottom", q=lambda x, t: -q),),
        ),
    )
    time = 0.15**2 / KAPPA
    heat = body.to(time)
    drop = 2 * q * np.sqrt(KAPPA * time / np.pi) / K
    assert body.T.min() == pytest.approx(-drop, rel=0.003)
    assert heat.entered["bottom"] == pytest.approx(-q * 0.1 * time, rel=1e-9)
    assert heat.stored == pytest.approx(-q * 0.1 * time, rel=1e-8)


def made_up(k, cells: str, size, h: float) -> float:
    """Root of the mean square error at t = 1 of T = (1 + t) cos(2 x) cos(3 y), in 3-D times cos(z).

    With all kinds of sides.
    """
    dim, k_ = len(size), np.array(k)
    waves = np.array([2.0, 3.0, 1.0])[:dim]

    def shape(x):
        return np.prod(np.cos(waves[:, None] * x[:dim]), axis=0)

    def gradient(x):
        c, s = np.cos(waves[:, None] * x[:dim]), np.sin(waves[:, None] * x[:dim])
        return np.array(
            [-waves[i] * s[i] * np.prod(np.delete(c, i, axis=0), axis=0) for i in range(dim)]
        )

    def flow(x):
        """div(k grad shape)."""
        c, s = np.cos(waves[:, None] * x[:dim]), np.sin(waves[:, None] * x[:dim])
        found = np.zeros(x.shape[1])
        for i in range(dim):
            for j in range(dim):
                if i == j:
                    found -= k_[i, i] * waves[i] ** 2 * np.prod(c, axis=0)
                else:
                    rest = np.prod(np.delete(c, [i, j], axis=0), axis=0)
                    found += k_[i, j] * waves[i] * waves[j] * s[i] * s[j] * rest
        return found

    def into(side, x, t):
        axis, sign = {
            "left": (0, -1),
            "right": (0, 1),
            "bottom": (dim - 1, -1),
            "top": (dim - 1, 1),
            "front": (1, -1),
            "back": (1, 1),
        }[side]
        return (1 + t) * sign * (k_ @ gradient(x))[axis]

    def bath(x, t):
        return (1 + t) * shape(x) + into("right", x, t) / FILM

    sides = [
        Dirichlet(side="bottom", T=lambda x, t: (1 + t) * shape(x)),
        Neumann(side="left", q=lambda x, t: into("left", x, t)),
        Neumann(side="top", q=lambda x, t: into("top", x, t)),
        Robin(side="right", h=lambda x, t: FILM, T=bath),
    ]
    for side in ("front", "back")[: 2 * (dim - 2)]:
        sides.append(Neumann(side=side, q=lambda x, t, side=side: into(side, x, t)))
    conduction = Conduction(
        k=k,
        rho_c=RHO_C,
        initial=shape,
        stress_free=still,
        sides=tuple(sides),
        source=lambda x, t: RHO_C * shape(x) - (1 + t) * flow(x),
        tolerance=1e-2,
    )
    body = Heated(size, h, conduction, cells=cells)
    body.to(1.0)
    return float(np.sqrt(np.mean((body.T - 2 * shape(body.x)) ** 2)))


MADE_UP = [
    (tensor(3.0, 1.0), "quadrilateral", (1.0, 0.8), (0.1, 0.05, 0.025)),
    (turned(tensor(3.0, 1.0), 30), "triangle", (1.0, 0.8), (0.1, 0.05, 0.025)),
    (turned(tensor(3.0, 1.0), 30), "quadrilateral", (1.0, 0.8), (0.1, 0.05, 0.025)),
    (tensor(3.0, 1.0, 2.0), "hexahedron", (0.8, 0.8, 0.8), (0.2, 0.1, 0.05)),
    (turned(tensor(3.0, 1.0, 2.0), 30), "tetrahedron", (0.8, 0.8, 0.8), (0.2, 0.1, 0.05)),
]


@pytest.mark.parametrize(("k", "cells", "size", "steps"), MADE_UP)
def test_the_error_falls_with_the_square_of_the_cells(k, cells, size, steps) -> None:
    """Of a made-up solution with held, flux and film sides and a source; linear in time."""
    errors = [made_up(k, cells, size, h) for h in steps]
    assert rates(errors, steps)[-1] == pytest.approx(2.0, abs=0.15), errors


def in_time(body: Heated, steps: int) -> float:
    """Largest error at t = 1 after equal steps of the method."""
    T = body.T.copy()
    for n in range(steps):
        T = body.equation._try(T, n / steps, 1 / steps).T
    return float(np.abs(T - np.sin(2.0) * (1 + body.x[1])).max())


def swinging(tolerance: float = 1e-4) -> Heated:
    """T = sin(2 t) (1 + y), which linear elements carry exactly; a held, a film and a flux side."""

    def source(x, t):
        return RHO_C * 2 * np.cos(2 * t) * (1 + x[1])

    def bath(x, t):
        return swing(x, t) + K * np.sin(2 * t) / FILM

    sides = (
        Dirichlet(side="left", T=swing),
        Robin(side="top", h=lambda x, t: FILM, T=bath),
        Neumann(side="bottom", q=lambda x, t: -K * np.sin(2 * t)),
    )
    conduction = Conduction(
        k=tensor(K, K), rho_c=RHO_C, initial=still, sides=sides, source=source, tolerance=tolerance
    )
    return Heated((0.5, 0.5), 0.1, conduction)


def swing(x, t):
    """The solution of `swinging`."""
    return np.sin(2 * t) * (1 + x[1])


def time_rate() -> float:
    """Order of the method in its time step."""
    body, counts = swinging(), (8, 16, 32, 64)
    return float(rates([in_time(body, n) for n in counts], 1 / np.array(counts))[-1])


def test_the_error_falls_with_the_square_of_the_time_step() -> None:
    assert time_rate() == pytest.approx(2.0, abs=0.1)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-4, 1e-5])
def test_the_error_is_what_was_allowed(tolerance: float) -> None:
    """In as few steps as an error that falls with the cube of the step needs, or ten times that."""
    body = swinging(tolerance)
    heat = body.to(1.0)
    error = np.abs(body.T - swing(body.x, 1.0)).max() / 1.5
    assert error < 3 * tolerance and heat.substeps < 10 * tolerance ** (-1 / 3)


def test_a_turned_body_conducts_the_same() -> None:
    """k along x and y exchanged with x and y, to round-off; and against the half-space."""
    upright = Heated(
        (0.3, 0.6),
        0.02,
        Conduction(
            k=tensor(1.0, 4.0),
            rho_c=RHO_C,
            initial=hot,
            sides=(
                Dirichlet(side="bottom", T=cold),
                Robin(side="left", h=lambda x, t: FILM, T=cold),
            ),
        ),
    )
    lying = Heated(
        (0.6, 0.3),
        0.02,
        Conduction(
            k=turned(tensor(1.0, 4.0), 90),
            rho_c=RHO_C,
            initial=hot,
            sides=(
                Dirichlet(side="left", T=cold),
                Robin(side="bottom", h=lambda x, t: FILM, T=cold),
            ),
        ),
    )
    for body in (upright, lying):
        body.to(0.002)
    first = upright.T[np.lexsort(upright.x[[1, 0]].round(9))]
    second = lying.T[np.lexsort(lying.x[[0, 1]].round(9))]
    assert first == pytest.approx(second, abs=1e-7 * DT)
    assert first.min() < -0.9 * DT


def mixed(size=(0.4, 0.3), comm: MPI.Comm = MPI.COMM_SELF, cells="triangle") -> Heated:
    """Every way for heat to enter at once, in rock of two kinds."""
    conduction = Conduction(
        k=turned(tensor(3.0, 1.0), 20),
        rho_c=RHO_C,
        initial=lambda x: 300.0 + 50 * x[1],
        k_factor=lambda x: np.where(x[0] > 0.2, 4.0, 1.0),
        rho_c_factor=lambda x: np.where(x[0] > 0.2, 0.5, 1.0),
        sides=(
            Dirichlet(side="bottom", T=lambda x, t: 260.0 - 20 * np.sin(300 * t)),
            Dirichlet(side="left", T=lambda x, t: 260.0 + 0 * t),
            Robin(side="right", h=lambda x, t: FILM * (1 + 100 * t), T=lambda x, t: 280.0),
            Neumann(side="top", q=lambda x, t: 500 * x[0] * t),
        ),
        source=lambda x, t: 1e4 * x[0],
        cracks=FluidFilledCrack(h=lambda x, t: FILM, T=lambda x, t: 250.0),
    )
    body = Heated(size, 0.02, conduction, cells=cells, comm=comm)
    body.alpha[:] = broken_layer(body.x[0] - 0.11, ell=0.03, h=0.02) * (body.x[1] < 0.2)
    return body


def test_what_entered_is_what_is_stored_at_every_step() -> None:
    body = mixed()
    for time in (1e-5, 1e-4, 1e-3, 2e-3, 4e-3, 8e-3):
        heat = body.to(time)
        assert set(heat.entered) == {"bottom", "left", "right", "top", "source", "cracks"}
        assert all(abs(amount) > 0 for amount in heat.entered.values())
        assert heat.imbalance < 1e-8
        assert heat.stored == pytest.approx(sum(heat.entered.values()), rel=1e-7)


def test_a_step_taken_again_is_the_same_to_the_last_bit() -> None:
    body = mixed()
    body.to(1e-3)
    before = body.T.copy()
    first = body.to(2e-3)
    after = body.T.copy()
    body.alpha[:] = 0.0  # something else in between
    body.to(5e-3)
    again = mixed()
    again.equation, again.T, again.time = body.equation, before, 1e-3
    assert again.to(2e-3) == first
    assert np.array_equal(again.T, after)


def test_heat_counts_from_the_stress_free_state() -> None:
    """Held at 320 K, free of stress at 350 K: 30 K below it, wherever it began."""
    conduction = Conduction(
        k=tensor(K, K),
        rho_c=RHO_C,
        initial=hot,
        stress_free=lambda x: 350.0 + 10 * x[1],
        sides=(Dirichlet(side="top", T=lambda x, t: 320.0),),
    )
    body = Heated((0.2, 0.2), 0.05, conduction)
    assert pytest.approx(-50 - 10 * body.x[1]) == body.T
    body.to(10.0)
    assert pytest.approx(-30 - 10 * body.x[1], abs=1e-3) == body.T


def rest_then(**side) -> Heated:
    """At 300 K, and nothing happens till t = 1."""
    given = {"T": lambda x, t: 300.0 - 50 * max(0.0, t - 1), **side}
    kind = Robin if "h" in given else Neumann if "q" in given else Dirichlet
    if kind is Neumann:
        del given["T"]
    conduction = Conduction(
        k=tensor(K, K),
        rho_c=RHO_C,
        initial=hot,
        sides=(kind(side="bottom", **given),),
        kinks=(1.0,),
    )
    return Heated((0.2, 0.2), 0.05, conduction)


@pytest.mark.parametrize(
    "side", [{}, {"h": lambda x, t: FILM}, {"q": lambda x, t: -50 * max(0.0, t - 1)}]
)
def test_a_body_at_rest_stays_at_rest_and_then_does_not(side) -> None:
    """Of 300 K, rounding makes a change that is none."""
    body = rest_then(**side)
    heat = body.to(1.0)
    assert np.abs(body.T).max() < 1e-9 and heat.imbalance < 1e-8
    assert body.to(2.0).stored < 0


def test_steps_end_at_kinks_so_that_no_pulse_is_missed() -> None:
    """A flux that comes and goes within one step of the mechanics: 5 W/m^2 for .19 s, on .2 m."""

    def pulse(x, t):
        return float(np.interp(t, [1.0, 1.001, 1.19, 1.191], [0.0, 5.0, 5.0, 0.0]))

    side = Neumann(side="bottom", q=pulse)
    conduction = Conduction(
        k=tensor(K, K), rho_c=RHO_C, initial=hot, sides=(side,), kinks=(1.0, 1.001, 1.19, 1.191)
    )
    body = Heated((0.2, 0.2), 0.05, conduction)
    assert body.to(2.0).stored == pytest.approx(5 * 0.19 * 0.2, rel=1e-3)


def test_heat_balances_near_a_steady_state_too() -> None:
    conduction = Conduction(
        k=tensor(K, K), rho_c=RHO_C, initial=hot, sides=(Dirichlet(side="bottom", T=cold),)
    )
    body = Heated((0.2, 0.2), 0.02, conduction)
    for time in (0.1, 1.0, 10.0, 100.0, 1000.0):
        assert body.to(time).imbalance < 1e-8
    assert pytest.approx(-DT, abs=1e-6) == body.T


@pytest.mark.parametrize("fault", ["not finite", "negative"])
def test_what_a_formula_gives_inside_the_body_or_later_is_looked_at(fault: str) -> None:
    def film(x, t):
        bad = np.nan if fault == "not finite" else -1.0
        return np.where((np.abs(x[0] - 0.1) < 0.01) & (t > 0.5), bad, 1.0)

    conduction = Conduction(
        k=tensor(K, K), rho_c=RHO_C, initial=hot, sides=(Robin(side="top", h=film, T=cold),)
    )
    body = Heated((0.2, 0.2), 0.05, conduction)
    body.to(0.5)
    with pytest.raises(LoadError, match=r"heat\.top\.h must be finite and not negative everywhere"):
        body.to(1.0)
    with pytest.raises(InputError, match=r"heat\.initial must be finite everywhere"):
        Heated(
            (0.2, 0.2),
            0.05,
            Conduction(k=tensor(K, K), rho_c=1.0, initial=lambda x: np.sqrt(x[0] - 0.1)),
        )


def layer(ell: float, cells_per_ell: int, conduction: Conduction) -> tuple[Heated, float]:
    """A row of cells with a crack across its middle, one of an endless row; and their edge."""
    n = round(cells_per_ell / ell) + 1
    h = 1 / n
    body = Heated((1.0, h), h, conduction)
    body.alpha[:] = broken_layer(body.x[0] - 0.5, ell=ell, h=h)
    return body, h


def resistance(ell: float, cells_per_ell: int, residual: float) -> tuple[float, float]:
    """Of the crack, times the conductivity (a length); measured, and cells in series."""
    conduction = Conduction(
        k=tensor(K, K),
        rho_c=RHO_C,
        initial=still,
        sides=(
            Dirichlet(side="left", T=lambda x, t: 0.0),
            Dirichlet(side="right", T=lambda x, t: 1.0),
        ),
        cracks=Insulating(residual=residual),
    )
    body, h = layer(ell, cells_per_ell, conduction)
    body.to(1e6)
    flux = body.to(1e6 + 1).entered["right"] / h
    along = np.unique(body.x[0].round(9), return_index=True)[1]
    start, rise = body.alpha[along][:-1, None], np.diff(body.alpha[along])[:, None]
    inside = (np.arange(1000) + 0.5) / 1000
    conducting = np.mean(1 - (start + rise * inside) ** 16, axis=1) + residual
    return K / flux - 1, float((h / conducting).sum()) - 1


@pytest.mark.parametrize("residual", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("cells_per_ell", [2, 4, 8])
def test_an_insulating_crack_is_a_layer_of_resistance(residual: float, cells_per_ell: int) -> None:
    """A layer of broken cells in series with its flanks, where alpha falls."""
    measured, expected = resistance(0.04, cells_per_ell, residual)
    assert measured == pytest.approx(expected, rel=2e-3)
    if residual < 1e-3:
        h = 1 / (round(cells_per_ell / 0.04) + 1)
        assert measured == pytest.approx(h / residual, rel=0.03)


def uptake(film: float, *, ell: float = 0.02) -> list[float]:
    """Heat that a crack full of fluid takes up, over that of two half-spaces behind films, in
    intervals from sqrt(kappa t) = 2 ell to a quarter of the spacing."""
    conduction = Conduction(
        k=tensor(K, K),
        rho_c=RHO_C,
        initial=still,
        cracks=FluidFilledCrack(h=lambda x, t: film, T=lambda x, t: -DT),
    )
    body, h = layer(ell, 4, conduction)

    def taken(time: float) -> float:
        """By an area of a face till a time, a kelvin (Carslaw and Jaeger, 2.7)."""
        root = film / K * np.sqrt(KAPPA * time)
        return RHO_C * K / film * (erfcx(root) - 1 + 2 * root / np.sqrt(np.pi))

    body.to((2 * ell) ** 2 / KAPPA)
    found = []
    for length in (2.2 * ell, 2.5 * ell, 3 * ell, 4 * ell, 6 * ell, 9 * ell, 0.25):
        start, end = body.time, length**2 / KAPPA
        heat = body.to(end)
        found.append(-heat.entered["cracks"] / h / (2 * DT * (taken(end) - taken(start))))
    return found


@pytest.mark.parametrize("film", [1e5, 150.0, 10.0])
def test_a_crack_with_a_bath_takes_up_heat_like_two_faces(film: float) -> None:
    assert uptake(film) == pytest.approx(np.ones(7), abs=0.05)

"""The heat equation against closed forms and made-up solutions, its balance, and its purity."""

from staffa.stack import MPI

import numpy as np
import pytest
from scipy.special import erfcx

from bodies import UNSTRUCTURED, printed_on, rates
from heated import Heated, broken_layer, still, tensor, turned
from staffa.heat.body import Bath, Conduction, Film, Held, Inflow, Insulating
from staffa.loads.closed_form import Convective, Face, HalfSpace, Slab

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
    "half-space": (HalfSpace(dT=DT, kappa=KAPPA, face=BOTTOM), Held(side="bottom", T=cold)),
    "slab": (Slab(dT=DT, kappa=KAPPA, face=BOTTOM, L=1.0), Held(side="bottom", T=cold)),
    "convective": (
        Convective(dT=DT, kappa=KAPPA, face=BOTTOM, h=FILM / K),
        Film(side="bottom", h=lambda x, t: FILM, T=cold),
    ),
}


@pytest.mark.parametrize("name", CLOSED)
@pytest.mark.parametrize("cells", ["quadrilateral", "triangle", UNSTRUCTURED])
def test_closed_forms_are_reproduced_to_half_a_percent_of_the_drop(name: str, cells: str) -> None:
    """From sqrt(kappa t) = 3 h on, to half the height; the slab also until it is cold."""
    form, side = CLOSED[name]
    conduction = Conduction(k=tensor(K, K), rho_c=RHO_C, initial=hot, sides=(side,))
    body = Heated((0.15, 1.0), 0.02, conduction, cells=cells)
    lengths = [
        0.01,
        0.02,
        0.04,
        0.06,
        0.09,
        0.12,
        0.18,
        0.22,
        *([0.5, 1.5] if name == "slab" else []),
    ]
    for length in lengths:
        time = length**2 / KAPPA
        heat = body.to(time)
        error = np.abs(body.T - form.temperature(body.x, time)).max() / DT
        assert heat.imbalance < 1e-8
        assert length < 0.06 or error < 0.005, (length, error)


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
    """From a diffusion length of a hundredth of a cell on, in steps that double it."""
    conduction = Conduction(
        k=tensor(*(K,) * len(size)),
        rho_c=RHO_C,
        initial=hot,
        sides=(Held(side="bottom", T=cold), Held(side="left", T=cold)),
    )
    body = Heated(size, 0.01, conduction, cells=cells)
    for length in 0.01 * 2.0 ** np.arange(-7, 4):
        body.to(length**2 / KAPPA)
        assert body.T.max() < allowed * DT and body.T.min() > -(1 + allowed) * DT, length


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
            sides=(Inflow(side="bottom", q=lambda x, t: -q),),
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
        Held(side="bottom", T=lambda x, t: (1 + t) * shape(x)),
        Inflow(side="left", q=lambda x, t: into("left", x, t)),
        Inflow(side="top", q=lambda x, t: into("top", x, t)),
        Film(side="right", h=lambda x, t: FILM, T=bath),
    ]
    for side in ("front", "back")[: 2 * (dim - 2)]:
        sides.append(Inflow(side=side, q=lambda x, t, side=side: into(side, x, t)))
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


@pytest.mark.parametrize(
    ("k", "cells", "size", "steps"),
    [
        (tensor(3.0, 1.0), "quadrilateral", (1.0, 0.8), (0.1, 0.05, 0.025)),
        (turned(tensor(3.0, 1.0), 30), "triangle", (1.0, 0.8), (0.1, 0.05, 0.025)),
        (turned(tensor(3.0, 1.0), 30), "quadrilateral", (1.0, 0.8), (0.1, 0.05, 0.025)),
        (tensor(3.0, 1.0, 2.0), "hexahedron", (0.8, 0.8, 0.8), (0.2, 0.1, 0.05)),
        (turned(tensor(3.0, 1.0, 2.0), 30), "tetrahedron", (0.8, 0.8, 0.8), (0.2, 0.1, 0.05)),
    ],
)
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


def test_the_error_falls_with_the_square_of_the_time_step() -> None:
    """T = sin(2 t) (1 + y), which linear elements carry exactly; a held, a film and a flux side."""

    def T(x, t):
        return np.sin(2 * t) * (1 + x[1])

    def source(x, t):
        return RHO_C * 2 * np.cos(2 * t) * (1 + x[1])

    sides = (
        Held(side="left", T=T),
        Film(side="top", h=lambda x, t: FILM, T=lambda x, t: T(x, t) + K * np.sin(2 * t) / FILM),
        Inflow(side="bottom", q=lambda x, t: -K * np.sin(2 * t)),
    )
    conduction = Conduction(k=tensor(K, K), rho_c=RHO_C, initial=still, sides=sides, source=source)
    body, counts = Heated((0.5, 0.5), 0.1, conduction), (8, 16, 32, 64)
    errors = [in_time(body, n) for n in counts]
    assert rates(errors, 1 / np.array(counts))[-1] == pytest.approx(2.0, abs=0.1), errors
    for tolerance in (1e-3, 1e-4, 1e-5):
        body = Heated((0.5, 0.5), 0.1, Conduction(**{**vars(conduction), "tolerance": tolerance}))
        heat = body.to(1.0)
        error = np.abs(body.T - T(body.x, 1.0)).max() / 1.5
        assert error < 3 * tolerance and heat.substeps < 10 * tolerance ** (-1 / 3), tolerance


def test_a_turned_body_conducts_the_same() -> None:
    """k along x and y exchanged with x and y, to round-off; and against the half-space."""
    upright = Heated(
        (0.3, 0.6),
        0.02,
        Conduction(
            k=tensor(1.0, 4.0),
            rho_c=RHO_C,
            initial=hot,
            sides=(Held(side="bottom", T=cold), Film(side="left", h=lambda x, t: FILM, T=cold)),
        ),
    )
    lying = Heated(
        (0.6, 0.3),
        0.02,
        Conduction(
            k=turned(tensor(1.0, 4.0), 90),
            rho_c=RHO_C,
            initial=hot,
            sides=(Held(side="left", T=cold), Film(side="bottom", h=lambda x, t: FILM, T=cold)),
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
            Held(side="bottom", T=lambda x, t: 260.0 - 20 * np.sin(300 * t)),
            Held(side="left", T=lambda x, t: 260.0 + 0 * t),
            Film(side="right", h=lambda x, t: FILM * (1 + 100 * t), T=lambda x, t: 280.0),
            Inflow(side="top", q=lambda x, t: 500 * x[0] * t),
        ),
        source=lambda x, t: 1e4 * x[0],
        cracks=Bath(h=lambda x, t: FILM, T=lambda x, t: 250.0),
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


@pytest.mark.mpi
@pytest.mark.parametrize("ranks", [2, 3])
def test_ranks_give_the_serial_temperature_and_balance(ranks: int) -> None:
    code = """
from staffa.stack import MPI
from test_heat import mixed
body = mixed(comm=MPI.COMM_WORLD)
for time in (1e-4, 1e-3, 4e-3):
    heat = body.to(time)
    span = body.equation.span(body.T)
    if MPI.COMM_WORLD.rank == 0:
        print(heat.imbalance, heat.substeps, heat.stored, span, *heat.entered.values())
"""
    body = mixed()
    for time, line in zip((1e-4, 1e-3, 4e-3), printed_on(ranks, code), strict=True):
        heat = body.to(time)
        imbalance, substeps, *numbers = (float(word) for word in line)
        assert imbalance < 1e-8 and substeps == heat.substeps
        expected = [heat.stored, body.equation.span(body.T), *heat.entered.values()]
        assert numbers == pytest.approx(expected, rel=1e-7)


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
        sides=(Held(side="top", T=lambda x, t: 320.0),),
    )
    body = Heated((0.2, 0.2), 0.05, conduction)
    assert pytest.approx(-50 - 10 * body.x[1]) == body.T
    body.to(10.0)
    assert pytest.approx(-30 - 10 * body.x[1], abs=1e-3) == body.T


@pytest.mark.parametrize("residual", [1e-2, 1e-4, 1e-6])
@pytest.mark.parametrize("cells_per_ell", [2, 4, 8])
def test_an_insulating_crack_is_a_layer_of_resistance(residual: float, cells_per_ell: int) -> None:
    """A layer of broken cells in series with its flanks, where alpha falls."""
    ell = 0.04
    n = round(cells_per_ell / ell) + 1
    h = 1 / n
    conduction = Conduction(
        k=tensor(K, K),
        rho_c=RHO_C,
        initial=still,
        sides=(
            Held(side="left", T=lambda x, t: 0.0),
            Held(side="right", T=lambda x, t: 1.0),
        ),
        cracks=Insulating(residual=residual),
    )
    body = Heated((1.0, h), h, conduction)
    body.alpha[:] = broken_layer(body.x[0] - 0.5, ell=ell, h=h)
    body.to(1e6)
    flux = body.to(1e6 + 1).entered["right"] / h
    along = np.unique(body.x[0].round(9), return_index=True)[1]
    start, rise = body.alpha[along][:-1, None], np.diff(body.alpha[along])[:, None]
    inside = (np.arange(1000) + 0.5) / 1000
    conducting = np.mean(1 - (start + rise * inside) ** 16, axis=1) + residual
    assert 1 / flux == pytest.approx((h / conducting).sum() / K, rel=1e-3)
    if residual < 1e-3:
        assert 1 / flux == pytest.approx(h / residual / K, rel=0.03)


@pytest.mark.parametrize(("film", "allowed"), [(1e5, 0.02), (30.0, 0.05)])
def test_a_crack_with_a_bath_takes_up_heat_like_two_faces(film: float, allowed: float) -> None:
    """For 2 ell < sqrt(kappa t) < spacing/4, against two half-spaces behind films."""
    ell = 0.02
    n = round(4 / ell) + 1
    h = 1 / n
    conduction = Conduction(
        k=tensor(K, K),
        rho_c=RHO_C,
        initial=still,
        cracks=Bath(h=lambda x, t: film, T=lambda x, t: -DT),
    )
    body = Heated((1.0, h), h, conduction)
    body.alpha[:] = broken_layer(body.x[0] - 0.5, ell=ell, h=h)

    def taken(time: float) -> float:
        """Heat through an area of a face till a time, a kelvin: of a half-space behind a film."""
        root = film / K * np.sqrt(KAPPA * time)
        return RHO_C * K / film * (erfcx(root) - 1 + 2 * root / np.sqrt(np.pi))

    body.to((2 * ell) ** 2 / KAPPA)
    for length in (2.5 * ell, 3 * ell, 4 * ell, 6 * ell, 9 * ell, 0.25):
        start, end = body.time, length**2 / KAPPA
        heat = body.to(end)
        expected = 2 * DT * (taken(end) - taken(start))
        assert heat.entered["cracks"] / h == pytest.approx(-expected, rel=allowed), length

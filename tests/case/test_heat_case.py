"""A case with the heat equation as objects: formulas, tables, tensors, and derived numbers."""

from math import pi, sqrt

import numpy as np
import pytest

from staffa.case.reading.read import parse_case
from staffa.case.scales.case_scales import derived_numbers
from staffa.case.scales.surface_cooling import strongest, surface_exchanges
from staffa.case.values.heat_equation import conduction
from staffa.errors import InputError
from staffa.heat.thermal_body import Dirichlet, FluidFilledCrack, Insulating, Neumann, Robin
from staffa.physics.scales import time_of_tau
from staffa.properties.formula import formula

CASE = """
[domain]
size = [2.0, 1.0]
h = 0.02
[material]
k = [3.0, 2.0]
rho = 4.0
c = 0.25
[damage]
ell = 0.06
[temperature]
profile = "heat"
[heat]
initial = { value = 10.0, gradient = [1.0, -2.0] }
bottom = { h = { t = [1, 3], value = [0, 8] }, T = { formula = "5 - t + x" } }
top = { flux = -0.25 }
left = { T = 6.0 }
[time]
t = [0.1, 2.0]
"""
X = np.array([[0.0, 0.5, 2.0], [0.0, 0.5, 1.0], [0.0, 0.0, 0.0]])
VALUES = [
    ("3", [3, 3, 3]),
    ("7/2", [3.5] * 3),
    ("x + 10*y", [0, 5.5, 12]),
    ("-x**2", [0, -0.25, -4]),
    ("t*x", [0, 1, 4]),
    ("sin(pi*x)", [0, 1, 0]),
    ("where(x > 1, 5, 2)", [2, 2, 5]),
    ("where((x > 0.1) & (y < 0.9), 1, 0)", [0, 1, 0]),
    ("where((x > 1) | ~(y > 0), 1, 0)", [1, 0, 1]),
    ("2**-1 + x % 0.75", [0.5, 1.0, 1.0]),
    ("1e3*sqrt(4)", [2000] * 3),
    (" exp(0) ", [1] * 3),
]


def case(*settings: str):
    return parse_case(CASE, settings)


def at(values, t: float = 0.0) -> list[float]:
    return list(np.broadcast_to(values(X, t), 3))


@pytest.mark.parametrize(("text", "expected"), VALUES)
def test_a_formula_has_the_value_by_hand(text, expected):
    found = formula(text, ("t", "x", "y"))(X, 2.0)
    assert found.shape == (3,) and found == pytest.approx(expected, abs=1e-15)


def test_a_formula_has_no_values_on_a_rank_without_points():
    for text in ("x + t", "3"):
        assert formula(text, ("t", "x"))(np.zeros((3, 0)), 1.0).shape == (0,)


def test_a_formula_sees_nothing_but_what_it_is_given():
    """Names around the call are not taken for the formula's own."""
    secret = 3.0
    with pytest.raises(InputError, match="'secret' is not known there"):
        formula("secret", ("x",))
    assert secret == 3.0


def test_the_heat_equation_has_the_numbers_of_the_case():
    found = conduction(case("heat.tolerance=1e-3", "heat.agreement=0.01"))
    assert found.k == ((3.0, 0.0), (0.0, 2.0)) and found.rho_c == 1.0
    assert (found.tolerance, found.agreement, found.cracks) == (1e-3, 0.01, None)
    assert list(found.initial(X)) == [10.0, 9.5, 10.0] and found.stress_free is None
    assert at(found.source) == [0, 0, 0]
    assert list(found.k_factor(X)) == list(found.rho_c_factor(X)) == [1, 1, 1]


def test_each_side_does_what_the_case_says_of_it():
    left, bottom, top = conduction(case()).sides
    assert isinstance(left, Dirichlet) and left.side == "left" and at(left.T, 7.0) == [6, 6, 6]
    assert isinstance(bottom, Robin) and bottom.side == "bottom"
    assert at(bottom.T, 2.0) == [3.0, 3.5, 5.0]
    table = {t: at(bottom.h, t)[0] for t in (0.0, 1.0, 2.0, 3.0, 9.0)}
    assert table == {0.0: 0.0, 1.0: 0.0, 2.0: 4.0, 3.0: 8.0, 9.0: 8.0}
    assert isinstance(top, Neumann) and top.side == "top" and at(top.q) == [-0.25] * 3


def test_a_body_in_3d_has_three_conductivities_and_six_sides():
    solid = case(
        "domain={size=[1.0,1.0,1.0],h=0.1}",
        "damage.ell=0.3",
        "material.k=2.0",
        'heat={initial=1,back={T=0},front={T={formula="z"}}}',
    )
    found = conduction(solid)
    assert found.k == ((2.0, 0.0, 0.0), (0.0, 2.0, 0.0), (0.0, 0.0, 2.0))
    assert [side.side for side in found.sides] == ["front", "back"]
    assert found.sides[0].T(np.array([[0.0], [0.0], [0.5]]), 0.0) == 0.5


def test_bands_that_overlap_multiply():
    bands = "{lower=[0,0],upper=[1,1],k=2},{lower=[0.4,0],upper=[2,1],k=3,capacity=0.5}"
    found = conduction(case(f"heat.bands=[{bands}]"))
    assert list(found.k_factor(X)) == [2, 6, 3]
    assert list(found.rho_c_factor(X)) == [1, 0.5, 0.5]


def test_cracks_hinder_heat_or_are_full_of_a_fluid():
    hinder = conduction(case("heat.cracks={conductivity=0.01}")).cracks
    assert hinder == Insulating(residual=0.01)
    fluid = conduction(case('heat.cracks={h=2.0,T={formula="y + t"}}')).cracks
    assert isinstance(fluid, FluidFilledCrack) and at(fluid.h) == [2, 2, 2]
    assert at(fluid.T, 1.0) == [1.0, 1.5, 2.0]


def test_a_source_and_a_stress_free_temperature_are_taken_over():
    found = conduction(case("heat.source={t=[0,1],value=[0,4]}", 'heat.stress_free={formula="x"}'))
    assert at(found.source, 0.5) == [2, 2, 2]
    assert found.stress_free is not None and list(found.stress_free(X)) == [0.0, 0.5, 2.0]


@pytest.mark.parametrize(("face", "kappa", "L"), [("bottom", 2.0, 1.0), ("left", 3.0, 2.0)])
def test_heat_diffuses_across_the_face_as_the_rock_conducts_there(face, kappa, L):
    found = derived_numbers(case(f"temperature.face={face}", "time={tau=[0.1,0.4]}"))
    assert (found.kappa, found.L) == (kappa, L)
    assert found.times == tuple(time_of_tau(tau, kappa=kappa, L=L) for tau in (0.1, 0.4))


# What cools the bottom, and the drop by hand: its middle is at 11 at the start, and the left's,
# which is held at 6, at 9.
DROPS = [
    ("{T=4}", 7.0),
    ('{T={formula="9 - 2*t"}}', 6.0),  # at the end, t = 2
    ('{h=0.01,T={formula="9 - 2*t"}}', 6.0),  # of the bath, however thin the film
    ("{T={t=[0,1.93,2],value=[11,1,11]}}", 10.0),  # at a time of the table between the samples
    ("{T={t=[0,3,4],value=[11,11,1]}}", 3.0),  # after the run: the left side counts
    ("{T=12}", 3.0),
    ("{flux=-1}", sqrt(4 / pi)),  # 2 q sqrt(kappa t/pi)/k
    ("{flux={t=[0,2],value=[-1,3]}}", sqrt(4 / pi)),
    ("{flux=1}", 3.0),
]


@pytest.mark.parametrize(("bottom", "drop"), DROPS)
def test_the_drop_is_that_of_the_face_or_else_of_the_coldest_side(bottom, drop):
    found = derived_numbers(case(f"heat.bottom={bottom}", "damage.split=none"))
    assert found.dT == pytest.approx(drop, rel=1e-12)
    assert found.severity == pytest.approx(drop, rel=1e-12), "L = E = Gc = expansion = 1"
    assert found.ell0 == pytest.approx(1 / drop**2, rel=1e-12)
    assert found.dT_c == pytest.approx(sqrt(3 / (8 * 0.06)), rel=1e-12)


def test_a_body_that_is_only_heated_has_no_drop_and_no_unit_of_spacing():
    found = derived_numbers(case("heat={initial=1.0,bottom={T=3.0}}"))
    assert (found.dT, found.severity, found.ell0) == (0.0, 0.0, None)
    assert found.dT_c is not None and found.table()["dT"] == 0.0


def test_a_film_keeps_the_surface_warmer_than_its_bath():
    """b = h sqrt(kappa t)/k: the drop is dT (1 - exp(b^2) erfc(b)), .57242 at b = 1."""
    (film,) = surface_exchanges(case("heat={initial=9.0,bottom={h=1.0,T=4.0}}"))
    assert (film.where, film.drop, film.rise, film.film) == ("bottom", 5.0, 0.0, 0.5)
    assert film.reached == pytest.approx(5 * 0.5724164, rel=1e-6)
    assert not film.at_once and strongest([film], "top") is film


def test_a_side_held_at_what_the_rock_has_there_neither_cools_nor_heats_it():
    """In units 20 °C and a formula's 293.15 may differ by round-off."""
    held = 'heat={initial=293.15,bottom={T={formula="293.15 + 1e-11*t"}}}'
    (same,) = surface_exchanges(case(held))
    assert (same.drop, same.rise) == (0.0, 0.0)


def test_the_times_of_all_tables_are_kinks() -> None:
    more = (
        "heat.source={t=[0.5, 3], value=[0, 1]}",
        "heat.cracks={h=1.0, T={t=[0, 7], value=[1, 2]}}",
    )
    assert conduction(case()).kinks == (1.0, 3.0)
    assert conduction(case(*more)).kinks == (0.0, 0.5, 1.0, 3.0, 7.0)

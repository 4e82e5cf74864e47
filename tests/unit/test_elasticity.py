"""Stiffnesses of every class: how they turn, what they reduce to, what is refused."""

import numpy as np
import pytest

from staffa.errors import InputError
from staffa.physics.elasticity import (
    Full,
    Isotropic,
    Orthotropic,
    TransverselyIsotropic,
    checked,
    compliance,
    inverse,
    isotropic_average,
    turned,
)
from staffa.physics.material import SOLID, lame

X = np.zeros((3, 1))
ROUND_OFF = 1e-13  # relative: a few products of six numbers
SHALE = {"E": 40.0, "nu": 0.2, "E_axis": 20.0, "nu_axis": 0.25, "G_axis": 9.0}
WOOD = {"E": (12.0, 1.0, 0.6), "nu": (0.4, 0.5, 0.35), "G": (0.7, 0.1, 0.8)}


def rotation(seed: int) -> np.ndarray:
    """Some axes in space."""
    q, _ = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    return q * np.sign(np.linalg.det(q))


def at_origin(elasticity) -> np.ndarray:
    return elasticity.stiffness(X)[0]


def some_stiffness(seed: int) -> np.ndarray:
    """A definite one without any symmetry of the rock."""
    a = np.random.default_rng(seed).normal(size=(6, 6))
    return a @ a.T + 6 * np.eye(6)


ALL = {
    "isotropic": Isotropic(E=30.0, nu=0.25),
    "transversely isotropic": TransverselyIsotropic(**SHALE, axes=rotation(1)),
    "orthotropic": Orthotropic(**WOOD, axes=rotation(2)),
    "full": Full(C=some_stiffness(3), axes=rotation(3)),
}


def strain(seed: int) -> np.ndarray:
    e = np.random.default_rng(seed).normal(size=(3, 3))
    return (e + e.T) / 2


def voigt(e: np.ndarray) -> np.ndarray:
    return np.array([e[0, 0], e[1, 1], e[2, 2], 2 * e[1, 2], 2 * e[0, 2], 2 * e[0, 1]])


def fourth_order(C: np.ndarray) -> np.ndarray:
    """C_ijkl of a stiffness, entry by entry."""
    place = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
    return C[place[:, :, None, None], place[None, None]]


@pytest.mark.parametrize("name", ALL)
def test_a_stiffness_is_symmetric_and_definite(name: str) -> None:
    C = at_origin(ALL[name])
    assert np.abs(C - C.T).max() <= ROUND_OFF * np.abs(C).max()
    assert checked(C[None]) is not None


def test_the_isotropic_stiffness_has_lames_coefficients() -> None:
    lambda_, mu = lame(30.0, 0.25, SOLID)
    expected = np.diag([2 * mu] * 3 + [mu] * 3)
    expected[:3, :3] += lambda_
    assert at_origin(ALL["isotropic"]) == pytest.approx(expected, rel=ROUND_OFF)


@pytest.mark.parametrize("seed", range(3))
def test_a_turned_stiffness_is_the_tensor_of_fourth_order_turned(seed: int) -> None:
    C, Q = some_stiffness(seed), rotation(seed)
    expected = np.einsum("pi,qj,rk,sl,pqrs", Q, Q, Q, Q, fourth_order(C))
    found = fourth_order(turned(C, Q))
    assert np.abs(found - expected).max() <= ROUND_OFF * np.abs(C).max()


@pytest.mark.parametrize("name", ALL)
def test_a_strain_along_the_axes_costs_what_it_costs_turned_with_them(name: str) -> None:
    """Rotation invariance: e . C e = (Q e Q^T) . C' (Q e Q^T)."""
    C, Q, e = at_origin(ALL[name]), rotation(7), strain(7)
    before = voigt(e) @ C @ voigt(e)
    after = voigt(Q.T @ e @ Q) @ turned(C, Q) @ voigt(Q.T @ e @ Q)
    assert after == pytest.approx(before, rel=ROUND_OFF)


def test_turned_there_and_back_it_is_what_it_was() -> None:
    C, Q = some_stiffness(5), rotation(5)
    assert turned(turned(C, Q), Q.T) == pytest.approx(C, rel=1e-12)


def test_an_isotropic_stiffness_does_not_feel_a_rotation() -> None:
    C = at_origin(ALL["isotropic"])
    assert np.abs(turned(C, rotation(4)) - C).max() <= ROUND_OFF * C.max()


def test_a_quarter_turn_about_z_swaps_the_first_two_axes() -> None:
    quarter = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    (E1, E2, E3), (nu12, nu23, nu13), (G12, G23, G13) = WOOD["E"], WOOD["nu"], WOOD["G"]
    swapped = Orthotropic(E=(E2, E1, E3), nu=(nu12 * E2 / E1, nu13, nu23), G=(G12, G13, G23))
    found = at_origin(Orthotropic(**WOOD, axes=quarter))
    assert found == pytest.approx(at_origin(swapped), rel=1e-12, abs=1e-12)


def test_a_pull_along_the_axis_of_bedding_stretches_and_contracts_as_its_numbers_say() -> None:
    """Along x, z of a bedding whose normal is x: S column by column."""
    axes = np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    S = np.linalg.inv(at_origin(TransverselyIsotropic(**SHALE, axes=axes)))
    assert S[:3, 0] == pytest.approx([1 / 20, -0.25 / 20, -0.25 / 20], rel=1e-12)
    assert S[:3, 1] == pytest.approx([-0.25 / 20, 1 / 40, -0.2 / 40], rel=1e-12)
    assert np.diag(S)[3:] == pytest.approx([2 * 1.2 / 40, 1 / 9, 1 / 9], rel=1e-12)


def test_the_compliance_of_an_orthotropic_rock_has_its_numbers() -> None:
    S = np.linalg.inv(at_origin(Orthotropic(**WOOD)))
    assert np.diag(S) == pytest.approx([1 / 12, 1.0, 1 / 0.6, 1 / 0.1, 1 / 0.8, 1 / 0.7], rel=1e-12)
    expected = [-0.4 / 12, -0.5 / 1.0, -0.35 / 12]
    assert [S[0, 1], S[1, 2], S[0, 2]] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("seed", range(2))
def test_every_class_with_isotropic_numbers_is_isotropic(seed: int) -> None:
    E, nu, axes = 30.0, 0.25, rotation(seed)
    G = E / (2 * (1 + nu))
    expected = at_origin(Isotropic(E=E, nu=nu))
    for same in (
        TransverselyIsotropic(E=E, nu=nu, E_axis=E, nu_axis=nu, G_axis=G, axes=axes),
        Orthotropic(E=(E,) * 3, nu=(nu,) * 3, G=(G,) * 3, axes=axes),
        Full(C=expected, axes=axes),
    ):
        assert at_origin(same) == pytest.approx(expected, rel=1e-12, abs=1e-12)


def test_the_average_of_an_isotropic_stiffness_is_itself_and_of_another_that_of_all_turns() -> None:
    assert isotropic_average(at_origin(ALL["isotropic"])) == pytest.approx((30.0, 0.25), rel=1e-12)
    C = some_stiffness(8)
    mean = np.mean([turned(C, rotation(seed)) for seed in range(4000)], axis=0)
    E, nu = isotropic_average(C)
    # 4000 turns leave 1/sqrt(4000) = 1.6 % of the scatter between them
    assert np.abs(mean - at_origin(Isotropic(E=E, nu=nu))).max() < 0.03 * np.abs(C).max()


def test_numbers_that_vary_give_each_place_its_own_stiffness() -> None:
    x = np.array([[0.0, 1.0, 2.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]])
    C = Isotropic(E=lambda x: 10 + x[0], nu=0.25).stiffness(x)
    for place, E in enumerate((10.0, 11.0, 12.0)):
        assert C[place] == pytest.approx(at_origin(Isotropic(E=E, nu=0.25)), rel=1e-12)


def test_a_rank_without_points_has_no_stiffnesses() -> None:
    none = np.zeros((3, 0))
    for elasticity in ALL.values():
        assert checked(elasticity.stiffness(none)).shape == (0, 6, 6)


@pytest.mark.parametrize("nu12", [3.4, 3.5])
def test_orthotropic_numbers_are_definite_up_to_the_known_bound(nu12: float) -> None:
    """With the other ratios zero: nu12^2 < E1/E2 = 12, so nu12 < 3.464."""
    numbers = [np.array([v]) for v in (12.0, 1.0, 0.6, nu12, 0.0, 0.0, 0.7, 0.1, 0.8)]
    C = inverse(compliance(tuple(numbers[:3]), tuple(numbers[3:6]), tuple(numbers[6:])))
    if nu12**2 < 12:
        assert checked(C) is C
    else:
        with pytest.raises(InputError, match=r"not positive definite.*eigenvalue is -"):
            checked(C)


def test_a_stiffness_that_is_not_symmetric_is_refused_by_its_entries() -> None:
    C = np.eye(6)
    C[1, 3] = 0.2
    with pytest.raises(InputError, match=r"its entries 2,4 and 4,2 differ by 0\.2"):
        checked(C[None])


def test_a_singular_compliance_has_no_stiffness() -> None:
    half = Isotropic(E=1.0, nu=0.5).stiffness(X)
    with pytest.raises(InputError, match="no finite one"):
        checked(half)

"""Strengths under one and two tensions and under pressure, as asked for; what cracks then carry."""

from dataclasses import dataclass, replace
from math import inf

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest
from scipy.optimize import minimize, nnls

from case.test_bad_input import check_sentence, read, sentence_of
from fem.test_cohesive import GRANITE
from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case
from staffa.evolution.effective_toughness import effective_gc
from staffa.evolution.march import march
from staffa.evolution.problem import Backtracking, Problem
from staffa.evolution.system import build
from staffa.io.run_directory import open_run
from staffa.loads.closed_form import AnyTemperature
from staffa.minimize.alternate import support_reactions
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.damage import cohesive, irwin_length
from staffa.physics.split import SPLITS, driven_share
from staffa.physics.strained import of_principal
from staffa.physics.strength_surface import ROUND, StrengthSurface, least_biaxial
from staffa.physics.trial import try_split
from staffa.records.step import Stop, kept
from staffa.results.crack_network import networks, words_on_openings
from staffa.runs.run import run as run_case
from support.bodies import body, rock, run

E, NU = 2.0, 0.3
SIZES = (2, 3)  # numbers of principal strains: plane stress, and any other state
# Ratios of the strengths: biaxial, compressive.
SURFACES = [(1.0, inf), (0.98, 10.0), (0.9, 8.0), (0.75, 3.0)]


def density(split: StrengthSurface, strains: np.ndarray, g: float) -> float:
    """Return the density of principal strains in any order."""
    return float(split.density(of_principal(tuple(-np.sort(-strains)), E=E, nu=NU), g))


def least_density(split: StrengthSurface, strains: np.ndarray, g: float) -> float:
    """Return the least energy over openings p >= 0, from the definition."""
    n, t = len(strains), 1 / g - 1
    compliance = ((1 + NU) * np.eye(3) - NU) + t * split.sheared * (1.5 * np.eye(3) - 0.5)
    stiffness = np.linalg.inv(compliance[:n, :n] / E)
    c = t * (1 - split.sheared) * (1 + split.hardening) / E
    hard = (np.ones((n, n)) + split.hardening * np.eye(n)) / c
    root = np.linalg.cholesky(stiffness + hard)
    p, _ = nnls(root.T, np.linalg.solve(root, stiffness @ strains))
    return float((strains - p) @ stiffness @ (strains - p) + p @ hard @ p) / 2


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("surface", SURFACES)
def test_the_closed_form_is_the_least_energy_over_openings(surface, n: int) -> None:
    split = StrengthSurface(*surface)
    for strains in np.random.default_rng(0).normal(size=(50, n)):
        for g in (0.99, 0.5, 0.01):
            expected = least_density(split, strains, g)
            assert density(split, strains, g) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("surface", SURFACES)
def test_it_is_convex_of_degree_two_and_falls_with_g(surface, n: int) -> None:
    split = StrengthSurface(*surface)
    try_split(split, plane_stress=n == 2, nu=NU)
    for strains in np.random.default_rng(1).normal(size=(50, n)):
        values = [density(split, strains, g) for g in (1e-6, 0.1, 0.5, 0.9, 1.0)]
        assert np.all(np.diff(values) > -1e-12)
        assert density(split, 3 * strains, 0.4) == pytest.approx(9 * density(split, strains, 0.4))


@pytest.mark.parametrize("surface", SURFACES)
def test_its_slope_has_no_jump(surface) -> None:
    """Along lines through strains where openings shut: the second derivative stays finite."""
    split, x = StrengthSurface(*surface), np.linspace(-2, 2, 4001)
    for start, way in np.random.default_rng(2).normal(size=(10, 2, 3)):
        values = np.array([density(split, start + s * way, 0.1) for s in x])
        stiffest = E * (way @ way) / (1 - 2 * NU)
        bends = np.diff(values, 2) / (x[1] - x[0]) ** 2
        assert bends.min() > -1e-6
        assert bends.max() < stiffest


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("surface", SURFACES)
def test_a_pulled_bar_has_the_energy_of_the_law_alone(surface, n: int) -> None:
    """g E/2 e^2 with free lateral strains: strength, softening and Gc of the law remain."""
    split = StrengthSurface(*surface)
    for g in (0.9, 0.3):
        found = minimize(
            lambda y, g=g: density(split, np.array([1.0, *y]), g), np.zeros(n - 1), tol=1e-14
        )
        assert found.fun == pytest.approx(g * E / 2, rel=1e-7)


STRESSES = {"pulled": (1, 0, 0), "biaxial": (1, 1, 0), "pressed": (-1, 0, 0)}


def strength_over_a_bars(split: StrengthSurface, stress, nu: float = NU) -> float:
    s = np.array(stress, dtype=float)
    strains = (1 + nu) * s - nu * s.sum()
    share = driven_share(split, tuple(-np.sort(-strains)), nu)
    return float(1 / np.sqrt(share * (strains @ s))) if share > 1e-12 else inf


@pytest.mark.parametrize("surface", SURFACES)
def test_damage_starts_at_the_strengths_asked_for(surface) -> None:
    """Whatever nu; a strength that is equal to that of a bar is 0.5 % less."""
    biaxial, compressive = surface
    split = StrengthSurface(*surface)
    for nu in (0.1, 0.3):
        found = {name: strength_over_a_bars(split, s, nu) for name, s in STRESSES.items()}
        assert found["pulled"] == pytest.approx(1, rel=1e-5)
        assert found["biaxial"] == pytest.approx(biaxial, rel=1e-5 if biaxial < 1 else 0.005)
        assert found["pressed"] == pytest.approx(compressive, rel=1e-4)


def test_open_cracks_carry_nothing_and_shut_ones_what_pressure_presses() -> None:
    apart = [np.array(s) for s in ((1.0, 0.0, 0.0), (1.0, 1.0, 0.0), (0.7, 0.4, 0.2))]
    for surface in SURFACES:
        split = StrengthSurface(*surface)
        assert max(density(split, e, 1e-9) for e in apart) < 1e-7
        # The bulk modulus remains; without a compressive strength all that no-tension keeps.
        shut = density(split, -np.ones(3), 1e-9)
        assert shut == pytest.approx(E / (3 * (1 - 2 * NU)) / 2 * 9, rel=1e-6)
    # In plane stress nothing remains with a compressive strength: what is crushed leaves the plane.
    assert density(StrengthSurface(), -np.ones(2), 1e-9) == pytest.approx(E / (1 - NU))
    assert density(StrengthSurface(1.0, 10.0), -np.ones(2), 1e-9) < 1e-5
    slid = np.array([0.5, 0.0, -0.5])
    assert density(StrengthSurface(1.0, 10.0), slid, 1e-9) < 1e-5


def test_the_corner_is_round_and_two_tensions_are_told_apart() -> None:
    assert StrengthSurface().hardening == ROUND
    for compressive in (inf, 3.0):
        least = least_biaxial(compressive)
        assert StrengthSurface(1.0001 * least, compressive).hardening > 1e3
        expected = (2 - (0 if compressive == inf else 1 / 9)) ** -0.5
        assert least == pytest.approx(expected)


# Bodies.

STIFF, GC, STRENGTH = 100.0, 1.0, 12.0
IRWIN = irwin_length(E=STIFF, Gc=GC, strength=STRENGTH)
ELLS = (1 / 10, 1 / 20, 1 / 40)
BIAXIAL, COMPRESSIVE = 0.95, 8.0


@dataclass(frozen=True)
class Loading:
    """Number of loaded axes, and the strength asked for along each, over that of a bar."""

    axes: int
    ratio: float


LOADINGS = {
    "pulled": Loading(axes=1, ratio=1.0),
    "biaxial": Loading(axes=2, ratio=BIAXIAL),
    "pressed": Loading(axes=1, ratio=-COMPRESSIVE),
}


STILL = {2: ("left", "bottom"), 3: ("left", "front", "bottom")}  # sides along x, y and z
MOVED = {2: ("right", "top"), 3: ("right", "back")}


def loaded(name: str, ell: float, factors, *, state="plane stress", h=None, size=0.2) -> Problem:
    """Return a body without friction at its sides that is strained up to factors of the strength.

    In plane strain the stress across the plane is that of nu = 0: none.
    """
    loading, nu = LOADINGS[name], 0.0 if state == "plane strain" else 0.2
    strain = loading.ratio * STRENGTH / STIFF * (1 - nu * (loading.axes - 1))
    dim = 3 if state == "solid" else 2
    sides = [
        SideSupport(side=side, components={axis: no_displacement})
        for axis, side in enumerate(STILL[dim])
    ]
    sides += [
        SideSupport(side=side, components={axis: lambda x, t: strain * size * t})
        for axis, side in enumerate(MOVED[dim][: loading.axes])
    ]
    law = cohesive(irwin=IRWIN, ell=ell)
    split = StrengthSurface(BIAXIAL, COMPRESSIVE)
    return body(
        (size,) * dim,
        h or ell / 4,
        sides=tuple(sides),
        times=tuple(factors),
        material=rock(E=STIFF, nu=nu, ell=ell, law=law, split=split, state=state),
        stop=Stop(change=1e-5, residual=1e-3),
    )


def largest_stress(problem: Problem, name: str) -> float:
    """Return the largest stress along the loaded axes, over the strength asked for."""
    system, found = build(problem), []
    section = float(problem.domain.size[1]) ** (problem.domain.dim - 1)
    for step in march(problem, system):
        assert step.status == "converged"
        assert not step.audit.violations
        forces = support_reactions(system.alternation)
        total = np.abs(forces[system.supports.values(1.0) != 0]).sum()
        found.append(total / section / LOADINGS[name].axes / STRENGTH)
    system.destroy()
    return max(found) / abs(LOADINGS[name].ratio)


FACTORS = (0.5, 0.97, 0.98, 0.99, 1.0, 1.01, 1.02, 1.03)


@pytest.mark.parametrize("name", LOADINGS)
@pytest.mark.parametrize(
    "ell", [ELLS[0], *(pytest.param(ell, marks=pytest.mark.slow) for ell in ELLS[1:])]
)
def test_a_square_has_the_strengths_asked_for_whatever_ell(name: str, ell: float) -> None:
    """Within 2 %, in plane stress, over steps of 1 %."""
    assert largest_stress(loaded(name, ell, FACTORS), name) == pytest.approx(1.0, rel=0.02)


@pytest.mark.slow
@pytest.mark.parametrize("name", LOADINGS)
@pytest.mark.parametrize("state", ["plane strain", pytest.param("solid", marks=pytest.mark.long)])
def test_other_states_have_the_strengths_asked_for(state: str, name: str) -> None:
    """Within 2 %, in plane strain and in 3-D."""
    problem = loaded(name, ELLS[0], FACTORS, state=state, h=0.05 if state == "solid" else None)
    assert largest_stress(problem, name) == pytest.approx(1.0, rel=0.02)


def test_residual_stiffness_leaves_intact_rock_as_it_is() -> None:
    """A bar stores E/2 e^2, with the split by its name too, which knows no residual stiffness."""
    problem = loaded("pulled", ELLS[0], (0.5,), h=0.1)
    split, e = SPLITS[StrengthSurface.name], STRENGTH / STIFF / 2
    material = replace(problem.material, split=split, residual_stiffness=0.05)
    (step,) = run(replace(problem, material=material))
    assert step.energies.elastic == pytest.approx(STIFF / 2 * e**2 * 0.2**2, rel=1e-9)


def pulled_through(ell: float, h: float, factors, length: float = 1.0, **more) -> Problem:
    """Return a bar whose middle is a little weaker, pulled apart."""
    law, split = cohesive(irwin=IRWIN, ell=ell), StrengthSurface(1.0, 10.0)
    sides = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="right", components={0: lambda x, t: STRENGTH / STIFF * length * t}),
        SideSupport(side="bottom", components={1: no_displacement}),
    )
    material = rock(
        E=STIFF,
        nu=0.2,
        ell=ell,
        law=law,
        split=split,
        toughness=lambda x: np.where(np.abs(x[0] - length / 2) < ell / 2, 0.99, 1.0),
    )
    stop = Stop(change=1e-5, residual=1e-3)
    return body(
        (length, 2 * h),
        h,
        cells="quadrilateral",
        sides=sides,
        times=tuple(factors),
        material=material,
        stop=stop,
        **more,
    )


@pytest.mark.slow
@pytest.mark.parametrize("ell", ELLS[:2])
def test_an_open_crack_has_cost_gc(ell: float) -> None:
    """Within 1 % of the effective Gc of the mesh, once stress is gone."""
    h = ell / 5
    problem = pulled_through(ell, h, [0.9, 1.2, 1.5, 2.0, 4.0, 8.0])
    *_, last = run(problem)
    expected = effective_gc(problem.material, dim=2, h=h, cells="quadrilateral")
    assert not last.audit.violations
    assert last.energies.elastic < 0.01 * last.energies.surface
    assert last.energies.surface / (2 * h * GC) == pytest.approx(expected, rel=0.01)


def test_backtracking_breaks_a_long_bar_where_its_energy_is_that_of_a_crack() -> None:
    """A bar three times as long as Irwin's length, at 0.83 of its strength, within two steps."""
    factors, length, h = np.arange(0.75, 1.03, 0.05), 3 * IRWIN, 0.025
    problem = pulled_through(0.1, h, factors, length)
    without = run(problem)
    steps = kept(run(replace(problem, backtracking=Backtracking())))
    assert not any(step.audit.violations for step in [*without, *steps])
    first, late = (
        min(step.time for step in found if step.energies.surface > h * GC)
        for found in (steps, without)
    )
    gc = effective_gc(problem.material, dim=2, h=h, cells="quadrilateral")
    assert late > 0.99
    assert first == pytest.approx(np.sqrt(2 * gc * STIFF / length) / STRENGTH, abs=0.1)


@pytest.mark.parametrize("biaxial", [1.0, 0.85])
def test_a_cooled_face_starts_to_crack_at_the_biaxial_strength(biaxial: float) -> None:
    """Stress is b sigma along the face and across the plane at a drop of b sigma (1 - nu)/(E beta),
    within 2 %."""
    nu, ell = 0.2, 0.1
    exact = biaxial * STRENGTH * (1 - nu) / STIFF
    held = tuple(SideSupport(side=s, components={0: no_displacement}) for s in ("left", "right"))
    split = StrengthSurface(biaxial)
    law = cohesive(irwin=IRWIN, ell=ell)
    material = rock(E=STIFF, nu=nu, ell=ell, law=law, split=split, state="plane strain")
    steps = run(
        body(
            (0.2, 0.2),
            0.05,
            sides=(*held, SideSupport(side="bottom", components={1: no_displacement})),
            load=AnyTemperature(change=lambda x, t: np.full(x.shape[1], -exact * t)),
            times=(0.5, 0.98, 1.0, 1.02),
            material=material,
            stop=Stop(change=1e-5, residual=1e-3),
        )
    )
    surface = [step.energies.surface for step in steps]
    assert surface[1] == pytest.approx(0.0, abs=1e-9)
    assert surface[-1] > 1e-4


# Cases.

TOLD = ("damage.law=cohesive", "damage.strength=1.0")
REFUSED = [
    (("damage.biaxial=0.9",), "damage.biaxial = 0.9 has no meaning", "or take that law"),
    (("damage.split=strength-surface",), "is for damage.law = ", "take that law"),
    ((*TOLD, "damage.biaxial=1.1"), "damage.biaxial = 1.1", "give one between"),
    ((*TOLD, "damage.biaxial=0.7"), "damage.biaxial = 0.7", "give one between"),
    ((*TOLD, "damage.compressive=1.0"), "damage.compressive = 1.0", "give a larger one"),
    (
        (*TOLD, "damage.compressive=10.0", "damage.split=no-tension"),
        'damage.split = "no-tension" takes no damage.compressive',
        "leave one of the two out",
    ),
    (
        (*TOLD, "damage.biaxial=1.0", "material.nu=-0.1"),
        "is for nu >= 0",
        "leave damage.biaxial out",
    ),
    (
        (*TOLD, "damage.compressive=10.0", "material={E=[1,2], nu=[0.2], G=[1]}"),
        "that of damage.compressive, is for isotropic rock",
        "leave damage.compressive out",
    ),
    (
        (
            *TOLD,
            "damage.compressive=10.0",
            "damage.split=strength-surface",
            "material={E=[1,2], nu=[0.2], G=[1]}",
        ),
        "is for isotropic rock",
        "leave damage.compressive and damage.split out",
    ),
]


@pytest.mark.parametrize(("settings", "names", "way_out"), REFUSED)
def test_what_no_surface_can_be_is_refused(settings, names, way_out) -> None:
    check_sentence(sentence_of(lambda: read(settings)), names, way_out)


STRENGTHS = ['damage.biaxial="9.5 MPa"', 'damage.compressive="120 MPa"']


def test_check_tells_all_strengths_and_the_drop_that_they_give() -> None:
    """dT_c = 9.5 MPa (1 - nu)/(E beta) in plane strain; of the law alone 1/sqrt(1.5) of 10 MPa."""
    plane = 'material.plane="strain"'
    for more, biaxial, pressed in ((STRENGTHS, 9.5, "120 MPa"), ([], 10 / 1.5**0.5, "10 MPa")):
        case = parse_case(GRANITE, [plane, *more])
        facts = {name: value for name, value, _ in preview(case).facts}
        drop = biaxial * 1e6 * 0.75 / (40e9 * 8e-6)
        assert float(facts["dT_c"].split()[0]) == pytest.approx(drop, rel=1e-3)
        assert float(facts["two tensions"].split()[0]) == pytest.approx(biaxial, rel=1e-2)
        assert facts["compression"] == pressed
    without = preview(parse_case(GRANITE, [plane, STRENGTHS[0]])).facts
    assert dict(fact[:2] for fact in without)["compression"] == "any"
    told = {name: meaning for name, _, meaning in without}
    assert told["two tensions"].endswith(", as asked for")
    assert told["compression"].endswith(", by default, without damage.compressive")


def test_residual_stiffness_is_no_strength() -> None:
    """The lateral contraction adds none either, as it does with a split that is not made of it."""
    case = parse_case(GRANITE, [*STRENGTHS, "damage.residual_stiffness=0.05"])
    (told,) = [fact[1:] for fact in preview(case).facts if fact[0] == "sigma_c"]
    assert float(told[0].removesuffix(" Pa")) == pytest.approx(10e6, rel=1e-5)
    assert told[1] == "strength of a bar at any ell, with linear softening"


SHUT = """
title = "A block that is cut in two, pressed"
[domain]
size = [2.0, 1.0]
h = 0.1
[material]
E = 40e3
nu = 0.25
Gc = 1e-3
[damage]
law = "cohesive"
strength = 6.0
ell = 0.3
[[cracks]]
start = [1.0, 0.0]
end = [1.0, 1.0]
[temperature]
profile = "none"
[supports]
left = { x = 0.0, y = 0.0 }
right = { x = { t = [0.0, 1.0], u = [0.0, -5e-5] }, y = 0.0 }
[time]
t = [1.0]
"""
PRESSED, FLAT = "damage.compressive=60.0", "damage.biaxial=5.9"
STRAINED = 'material.plane="strain"'


@pytest.mark.parametrize(
    ("settings", "left", "instead"),
    [
        ((PRESSED,), "carries nothing in plane stress", 'out, with damage.split = "strength-'),
        ((PRESSED, FLAT), "carries nothing in plane stress", "compressive out: they"),
        ((PRESSED, STRAINED), "keeps its bulk modulus alone", "strength-surface"),
    ],
)
def test_check_warns_that_shut_cracks_have_no_compressive_strength(settings, left, instead) -> None:
    found = preview(parse_case(SHUT, settings)).warnings
    (said,) = [w for w in found if w.startswith("damage.compressive = 60.0 is that of rock")]
    assert left in said and instead in said


@pytest.mark.parametrize("settings", [(FLAT,), (PRESSED, "supports.right.x.u=[0.0,1e-6]")])
def test_check_does_not_warn_where_no_crack_is_pressed_or_all_carry(settings) -> None:
    assert "damage.compressive" not in " ".join(preview(parse_case(SHUT, settings)).warnings)


@pytest.mark.slow
@pytest.mark.parametrize(("setting", "overlap"), [(PRESSED, True), (FLAT, False)])
def test_sides_of_shut_cracks_that_overlap_are_told_of(tmp_path, setting: str, overlap) -> None:
    run_case(parse_case(SHUT, [setting]), tmp_path / "run")
    done = open_run(tmp_path / "run")
    said = " ".join(words_on_openings(done, networks(done)[0]))
    assert ("overlap, since with damage.compressive" in said) is overlap

"""From the keys of a case to the problem that is solved: each arrives where it belongs."""

from dataclasses import replace

import numpy as np
import pytest

from staffa.case.reading.read import parse_case
from staffa.evolution.problem import Problem
from staffa.geometry.block import SIDES, face_position, opposite
from staffa.loads.closed_form import Convective, Face, HalfSpace, NoLoad, Slab
from staffa.model.supports import GeneralizedPlaneStrain
from staffa.physics.damage import AT2
from staffa.records.step import Stop
from staffa.setup.build import problem

NOWHERE = np.zeros((3, 1))
PLATE = """
[domain]
size = [2.0, 1.0]
h = 0.25
[damage]
ell = 0.5
[temperature]
dT = 3.0
[time]
tau = [0.1, 0.2, 0.4]
"""
BOX = ("domain.size=[2.0, 1.5, 1.0]",)
PULLED = ("temperature={}", 'temperature.profile="none"', "time={t=[0.5, 1.0]}")
HEATED = (
    'temperature={profile="heat"}',
    "material={k=[4.0, 2.0], rho=0.25, c=2.0}",
    "heat={initial=1.0, bottom={T=0.0}}",
)
SHAPES = {2: (), 3: BOX}
FACES = [(dim, face) for dim in SIDES for face in SIDES[dim]]


def built(*settings: str) -> Problem:
    """The problem of the plate with these settings."""
    return problem(parse_case(PLATE, settings))


# A setting, where it arrives in the problem, and as what.
ARRIVALS = [
    ((), "irreversibility.crack_set_only", False),
    (('damage.irreversibility="crack set"',), "irreversibility.crack_set_only", True),
    (("damage.crack_set_threshold=0.7",), "irreversibility.threshold", 0.7),
    (("damage.residual_stiffness=1e-4",), "material.residual_stiffness", 1e-4),
    (("damage.law=AT1",), "material.law.name", "AT1"),
    (("damage.law=AT2",), "material.law.name", "AT2"),
    (("damage.ell=0.3",), "material.ell", 0.3),
    (("material.E=7.0",), "material.E", 7.0),
    (("material.nu=0.3",), "material.nu", 0.3),
    (("material.Gc=7.0",), "material.Gc", 7.0),
    (("material.expansion=7.0",), "material.expansion", 7.0),
    ((), "material.state", "plane stress"),
    (('material.plane="strain"',), "material.state", "plane strain"),
    (BOX, "material.state", "solid"),
    (("material.kappa=7.0",), "load.kappa", 7.0),
    ((), "load.dT", 3.0),
    (HEATED, "load.k", ((4.0, 0.0), (0.0, 2.0))),
    (HEATED, "load.rho_c", 0.5),
    (HEATED, "anchor", "top"),
    (("temperature={severity=6.0}",), "load.dT", 6.0),
    (("temperature={severity=6.0}", "material.Gc=4.0"), "load.dT", 12.0),
    ((), "solvers.displacement", "direct"),
    (BOX, "solvers.displacement", "iterative"),
    (("solver.displacement=iterative",), "solvers.displacement", "iterative"),
    ((*BOX, "solver.displacement=direct"), "solvers.displacement", "direct"),
    ((), "solvers.damage", "tao"),
    (("solver.damage=snes",), "solvers.damage", "snes"),
    (
        ("solver.change=0.01", "solver.residual=0.02", "solver.sweeps=7"),
        "solvers.stop",
        Stop(change=0.01, residual=0.02, sweeps=7),
    ),
    ((), "measuring.depths", ()),
    (("measures.depths=[0.2, 0.6]",), "measuring.depths", (0.2, 0.6)),
    ((), "measuring.threshold", 0.8),
    (("measures.threshold=0.6",), "measuring.threshold", 0.6),
    ((), "domain.size", (2.0, 1.0)),
    (("domain.h=0.3",), "domain.h", 2 / 7),
    ((), "section", None),
    (('supports.section="fixed"',), "section", None),
    (('supports.section="stretch"',), "section", GeneralizedPlaneStrain(bending=False)),
    (('supports.section="free"',), "section", GeneralizedPlaneStrain(bending=True)),
]


@pytest.mark.parametrize(("settings", "where", "expected"), ARRIVALS)
def test_a_key_arrives_where_it_belongs(settings, where, expected) -> None:
    found: object = built(*settings)
    for name in where.split("."):
        found = getattr(found, name)
    assert found == (pytest.approx(expected) if isinstance(expected, float) else expected), (
        f"{where} is {found} with {settings}, not {expected}"
    )


@pytest.mark.parametrize("cells", ["quadrilateral", "triangle", "hexahedron", "tetrahedron"])
def test_the_mesh_has_the_cells_of_the_case(cells: str) -> None:
    three = cells in ("hexahedron", "tetrahedron")
    found = built(f"domain.cells={cells}", *(BOX if three else ()))
    assert found.domain.mesh.topology.cell_name() == cells


# How the body is held, and which components of which sides are then prescribed.
HELD = [
    ((), {}),
    (('supports.left="free"',), {}),
    (('supports.left="rollers"',), {"left": {0}}),
    (('supports.top="rollers"',), {"top": {1}}),
    (('supports.right="clamped"',), {"right": {0, 1}}),
    (('supports.left="rollers"', 'supports.bottom="clamped"'), {"left": {0}, "bottom": {0, 1}}),
    (("supports.top={y=0.1}",), {"top": {1}}),
    (("supports.top={x=0.1, y=0.0}",), {"top": {0, 1}}),
    (('supports.section="fixed"',), {"left": {0}, "right": {0}}),
    (('supports.section="stretch"',), {"left": {0}}),
    (('supports.section="free"',), {"left": {0}}),
    (('supports.section="free"', 'supports.top="rollers"'), {"left": {0}, "top": {1}}),
    ((*BOX, 'supports.front="rollers"'), {"front": {1}}),
    ((*BOX, 'supports.back="clamped"'), {"back": {0, 1, 2}}),
    ((*BOX, 'supports.bottom="rollers"'), {"bottom": {2}}),
    ((*BOX, "supports.back={z=0.1}"), {"back": {2}}),
]


@pytest.mark.parametrize(("settings", "expected"), HELD)
def test_a_side_is_held_as_the_case_says(settings, expected) -> None:
    sides = built(*settings).sides
    found = {support.side: set(support.components) for support in sides}
    assert found == expected and len(sides) == len(found), f"{found} is held, not {expected}"


@pytest.mark.parametrize("how", ["rollers", "clamped"])
def test_what_is_held_never_moves(how: str) -> None:
    (support,) = built(f'supports.left="{how}"').sides
    assert [u(NOWHERE, t) for u in support.components.values() for t in (0.0, 0.3, 9.0)].count(
        0.0
    ) == (3 * len(support.components))


def test_a_constant_displacement_is_there_at_all_times() -> None:
    (support,) = built("supports.top={y=-0.1, x=0.0}").sides
    assert [support.components[1](NOWHERE, t) for t in (0.0, 0.3, 9.0)] == [-0.1] * 3
    assert [support.components[0](NOWHERE, t) for t in (0.0, 0.3, 9.0)] == [0.0] * 3


@pytest.mark.parametrize(
    ("t", "u"),
    [(0.0, 0.1), (1.0, 0.1), (1.25, 0.15), (2.0, 0.3), (3.0, 0.0), (4.0, -0.3), (9.0, -0.3)],
)
def test_a_table_is_straight_between_its_times_and_constant_beyond_them(t: float, u: float) -> None:
    table = "supports.top={y={t=[1.0, 2.0, 4.0], u=[0.1, 0.3, -0.3]}, x=0.5}"
    (support,) = built(table).sides
    found = support.components[1](NOWHERE, t)
    assert found == pytest.approx(u, abs=1e-12), f"{found} at t = {t}, not {u}"
    assert support.components[0](NOWHERE, t) == 0.5, "the other component has its own history"


@pytest.mark.parametrize(("dim", "face"), FACES)
def test_the_cooled_face_is_cold_and_the_opposite_boundary_warm(dim: int, face: str) -> None:
    """Through the load itself: -dT on the face at any time, nothing yet across the body."""
    found = built(*SHAPES[dim], f'temperature.face="{face}"')
    size = found.domain.size
    axis, end = SIDES[dim][face]
    assert found.face == Face(axis=axis, position=face_position(face, size), inward=-end)
    x = np.full((3, 3), 0.37)
    x[axis] = [0.0, size[axis] / 2, size[axis]]
    x[axis] = x[axis] if end < 0 else x[axis][::-1]
    first, last = found.schedule.times[0], found.schedule.times[-1]
    T = found.load.temperature(x, first)
    assert T[0] == -3.0 and T[1:] == pytest.approx([0, 0], abs=1e-9), f"{T} below {face}"
    later = found.load.temperature(x, last)
    assert later[0] == -3.0 < later[1] < later[2] < 0, f"{later} below {face}: cold from there"
    assert found.face.depth(x) == pytest.approx([0, size[axis] / 2, size[axis]])


@pytest.mark.parametrize(("dim", "face"), FACES)
def test_the_anchor_is_across_the_body(dim: int, face: str) -> None:
    across = {
        "left": "right", "right": "left", "bottom": "top",
        "top": "bottom", "front": "back", "back": "front",
    }  # fmt: skip
    assert built(*SHAPES[dim], f'temperature.face="{face}"').anchor == across[face]
    assert opposite(face, dim) == across[face]


def test_without_cooling_there_is_no_face_no_anchor_and_no_tau() -> None:
    found = built(*PULLED, "supports.top={y=0.1}")
    assert (found.face, found.anchor, found.tau_of) == (None, None, None)
    assert isinstance(found.load, NoLoad)
    assert found.schedule.times == (0.5, 1.0)


# L is the depth below the face: the height from the bottom, the width from the left.
@pytest.mark.parametrize(("face", "L"), [("bottom", 1.0), ("left", 2.0)])
def test_profiles_are_as_deep_as_the_body_below_the_face(face: str, L: float) -> None:
    here = f'temperature.face="{face}"'
    slab = built(here, "temperature.profile=slab").load
    film = built(here, "temperature.profile=convective", "temperature.biot=5.0").load
    assert isinstance(slab, Slab) and slab.L == L
    assert isinstance(film, Convective) and film.h == pytest.approx(5.0 / L)
    assert isinstance(built(here).load, HalfSpace)
    assert {load.dT for load in (slab, film)} == {3.0}


@pytest.mark.parametrize(("face", "L"), [("bottom", 1.0), ("right", 2.0)])
def test_times_follow_from_tau_and_go_back_to_it(face: str, L: float) -> None:
    """tau = 2 sqrt(kappa t)/L."""
    found = built(f'temperature.face="{face}"', "material.kappa=0.25")
    expected = [(tau * L) ** 2 / (4 * 0.25) for tau in (0.1, 0.2, 0.4)]
    assert found.schedule.times == pytest.approx(expected, rel=1e-12)
    assert found.tau_of is not None
    assert [found.tau_of(t) for t in found.schedule.times] == pytest.approx([0.1, 0.2, 0.4])


def test_with_the_heat_equation_tau_counts_in_what_the_rock_conducts_across_the_face() -> None:
    """kappa = k/(rho c) = 2/.5."""
    found = built(*HEATED)
    expected = [tau**2 / (4 * 4.0) for tau in (0.1, 0.2, 0.4)]
    assert found.schedule.times == pytest.approx(expected, rel=1e-12)
    assert found.tau_of is not None
    assert [found.tau_of(t) for t in found.schedule.times] == pytest.approx([0.1, 0.2, 0.4])


def test_times_that_are_given_as_such_stay_so() -> None:
    found = built("time={t={start=0.5, stop=1.5, steps=3}}").schedule
    assert found.times == (0.5, 1.0, 1.5) and found.requested == (False,) * 3


def test_outputs_are_among_the_times_and_flagged() -> None:
    found = built("output.at=[0.3, 0.2]")
    assert found.tau_of is not None
    taus = [found.tau_of(t) for t in found.schedule.times]
    assert taus == pytest.approx([0.1, 0.2, 0.3, 0.4]), f"{taus}"
    assert found.schedule.requested == (False, True, True, False)


def test_a_law_and_a_load_of_ones_own_take_the_place_of_the_cases() -> None:
    law, load = AT2(), NoLoad()
    found = problem(parse_case(PLATE), damage=law, temperature=load)
    assert found.material.law is law and found.load is load


def toughness(*settings: str, points: np.ndarray) -> np.ndarray:
    """Toughness over Gc at points of the body, shape (n, dim)."""
    whole = np.zeros((3, len(points)))
    whole[: points.shape[1]] = points.T
    return built(*settings).material.toughness(whole)


LOW = "{lower=[0.0, 0.0], upper=[1.2, 0.5], factor=2.0}"
HIGH = "{lower=[0.8, 0.3], upper=[2.0, 1.0], factor=0.25}"


@pytest.mark.parametrize(
    ("point", "expected"),
    [((0.5, 0.1), 2.0), ((1.0, 0.4), 0.5), ((1.5, 0.8), 0.25), ((0.5, 0.8), 1.0), ((1.5, 0.1), 1)],
    ids=["in one", "in both", "in the other", "above", "beside"],
)
def test_bands_multiply_where_they_overlap(point, expected) -> None:
    found = toughness(f"toughness.bands=[{LOW}, {HIGH}]", points=np.array([point]))
    assert found == pytest.approx([expected]), f"{found} at {point}, not {expected}"


def test_a_band_in_a_box_is_bounded_in_height_too() -> None:
    band = "toughness.bands=[{lower=[0,0,0.4], upper=[1,1,0.6], factor=3.0}]"
    points = np.array([[0.5, 0.5, 0.5], [0.5, 0.5, 0.2], [0.5, 0.5, 0.8], [0.5, 1.2, 0.5]])
    assert toughness(*BOX, band, points=points) == pytest.approx([3, 1, 1, 1])


def test_rock_is_uniform_unless_it_is_said_not_to_be() -> None:
    assert np.all(
        toughness("toughness.seed=5", points=np.random.default_rng(1).random((9, 2))) == 1
    )


LENGTH, AMPLITUDE = 0.01, 0.3
NOISY = (
    f"toughness.amplitude={AMPLITUDE}",
    f"toughness.correlation_length={LENGTH}",
    "toughness.seed=3",
)
SCATTERED = np.random.default_rng(2).random((4_000, 2)) * [2.0, 1.0]


@pytest.fixture(scope="module")
def noise() -> np.ndarray:
    """The random toughness at scattered points, thousands of correlation lengths apart."""
    return toughness(*NOISY, points=SCATTERED)


def test_noise_has_the_mean_and_the_variation_that_are_asked_for(noise: np.ndarray) -> None:
    # 4,000 points, nearly all apart by more than the length: the mean to .3/63, four times;
    # the field is a sum of a thousand waves, so that its variance is known to some per cent.
    mean, variation = noise.mean(), noise.std() / noise.mean()
    assert noise.min() > 0
    assert mean == pytest.approx(1.0, abs=0.02), f"mean {mean}"
    assert variation == pytest.approx(AMPLITUDE, rel=0.1), f"coefficient of variation {variation}"
    skew = ((np.log(noise) - np.log(noise).mean()) ** 3).mean() / np.log(noise).std() ** 3
    assert abs(skew) < 0.1, f"its logarithm is normal; skewness {skew}"


def test_noise_is_a_function_of_position_alone(noise: np.ndarray) -> None:
    order = np.random.default_rng(4).permutation(len(SCATTERED))[:500]
    again = toughness(*NOISY, points=SCATTERED[order])
    gap = np.abs(again - noise[order]).max()
    assert gap < 1e-12, f"{gap}: another order, another rock"


def test_noise_is_alike_nearby_and_forgotten_far_off(noise: np.ndarray) -> None:
    """Gaussian correlation exp(-pi/4 (r/length)^2), as GSTools defines the length."""
    for apart in (0.25, 1.0, 4.0):
        there = toughness(*NOISY, points=SCATTERED + np.array([apart * LENGTH, 0.0]))
        found = np.corrcoef(np.log(noise), np.log(there))[0, 1]
        expected = np.exp(-np.pi / 4 * apart**2)
        # Of a thousand waves of random weight: 1/sqrt(1000), thrice.
        assert found == pytest.approx(expected, abs=0.1), f"{found} at {apart} lengths"


def test_another_seed_is_another_rock_and_the_same_seed_the_same() -> None:
    few = SCATTERED[:100]
    one, same = toughness(*NOISY, points=few), toughness(*NOISY, points=few)
    other = toughness(*NOISY, "toughness.seed=4", points=few)
    assert np.array_equal(one, same)
    assert abs(np.corrcoef(one, other)[0, 1]) < 0.4, "two seeds share nothing"


def test_the_correlation_length_is_twice_ell_if_none_is_given() -> None:
    few, noisy = SCATTERED[:100], ("toughness.amplitude=0.3", "damage.ell=0.25")
    assert toughness(*noisy, points=few) == pytest.approx(
        toughness(*noisy, "toughness.correlation_length=0.5", points=few), rel=1e-12
    )


def test_noise_and_bands_multiply(noise: np.ndarray) -> None:
    both = toughness(*NOISY, f"toughness.bands=[{LOW}]", points=SCATTERED)
    inside = (SCATTERED[:, 0] <= 1.2) & (SCATTERED[:, 1] <= 0.5)
    assert both == pytest.approx(noise * np.where(inside, 2.0, 1.0), rel=1e-12)


def test_noise_where_a_rank_has_no_point_is_empty() -> None:
    assert toughness(*NOISY, points=np.zeros((0, 2))).shape == (0,)


def cracked(*settings: str, points: np.ndarray) -> np.ndarray:
    """True at the points, shape (n, dim), that are cracked from the start."""
    whole = np.zeros((3, len(points)))
    whole[: points.shape[1]] = points.T
    return built(*settings).material.cracked(whole)


def test_a_body_without_cracks_is_whole() -> None:
    assert not cracked(points=SCATTERED).any()


# Clear of the ends of each range by a tenth of a cell: h = .25.
@pytest.mark.parametrize(
    ("point", "expected"),
    [
        ((1.0, 0.3), True),
        ((1.0 + 0.225, 0.3), True),
        ((1.0 - 0.225, 0.3), True),
        ((1.0 + 0.275, 0.3), False),
        ((1.0 - 0.275, 0.3), False),
        ((1.0, 0.5 + 0.1), True),
        ((1.0, 0.5 + 0.15), False),
        ((1.0, 0.0), True),
        ((1.0, 0.95), False),
    ],
)
def test_a_segment_reaches_a_cell_to_its_sides_and_half_a_cell_beyond_its_end(
    point, expected
) -> None:
    crack = "cracks=[{start=[1.0, 0.0], end=[1.0, 0.5]}]"
    assert cracked(crack, points=np.array([point])) == [expected], f"at {point}"


@pytest.mark.parametrize("place", [1.0, 1.03, 1.0625, 1.125, 1.2])
@pytest.mark.parametrize("turned", [False, True])
def test_one_layer_of_cells_breaks_wherever_the_crack_lies_in_the_mesh(
    place: float, turned: bool
) -> None:
    """Two columns of vertices, neighbors, on both sides of the crack or with it on one of them."""
    ends = [[place, 0.0], [place, 0.5]]
    start, end = reversed(ends) if turned else ends
    columns = np.arange(0, 2.01, 0.25)
    row = np.column_stack([columns, np.full(len(columns), 0.25)])
    broken = columns[cracked(f"cracks=[{{start={start}, end={end}}}]", points=row)]
    assert len(broken) == 2, f"a crack at {place} breaks the vertices {broken}"
    assert broken[1] - broken[0] == 0.25 and broken[0] <= place <= broken[1], f"{broken}"


def test_a_slanted_segment_follows_its_line() -> None:
    crack = "cracks=[{start=[0.5, 0.0], end=[1.3, 0.6]}]"
    along = np.linspace(0.05, 0.95, 7)[:, None] * [0.8, 0.6] + [0.5, 0.0]
    across = np.array([-0.6, 0.8])
    assert cracked(crack, points=along).all()
    assert cracked(crack, points=along + 0.22 * across).all()
    assert not cracked(crack, points=along + 0.28 * across).any()
    assert not cracked(crack, points=along - 0.28 * across).any()


def test_several_cracks_are_all_there() -> None:
    cracks = "cracks=[{start=[0.5,0.0],end=[0.5,0.5]},{start=[1.5,0.0],end=[1.5,0.5]}]"
    found = cracked(cracks, points=np.array([[0.5, 0.2], [1.0, 0.2], [1.5, 0.2]]))
    assert list(found) == [True, False, True]


@pytest.mark.parametrize("normal", [[1.0, 0.0, 0.0], [0.0, 7.0, 0.0], [2.0, 0.0, 2.0], [-1, -1, 1]])
def test_a_disc_is_round_and_flat_whatever_its_normal(normal: list[float]) -> None:
    """Inside its radius it is cracked all around, outside nowhere; h = .1."""
    center, radius, h = np.array([1.0, 0.75, 0.5]), 0.3, 0.1
    disc = f"{{center={center.tolist()}, radius={radius}, normal={normal}}}"
    settings = (*BOX, "domain.h=0.1", f"cracks=[{disc}]")
    unit = np.array(normal) / np.linalg.norm(normal)
    first = np.cross(unit, [0.3, 0.5, 0.9])
    first /= np.linalg.norm(first)
    second = np.cross(unit, first)
    turn = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    rim = np.cos(turn)[:, None] * first + np.sin(turn)[:, None] * second
    case = [
        ("its middle", center[None], True),
        ("inside", center + 0.95 * radius * rim, True),
        ("half a cell beyond", center + (radius + 0.4 * h) * rim, True),
        ("beyond", center + (radius + 0.6 * h) * rim, False),
        ("above it", center + 0.5 * radius * rim + 0.9 * h * unit, True),
        ("below it", center + 0.5 * radius * rim - 0.9 * h * unit, True),
        ("far above it", center + 0.5 * radius * rim + 1.1 * h * unit, False),
        ("far below it", center + 0.5 * radius * rim - 1.1 * h * unit, False),
    ]
    for where, points, expected in case:
        found = cracked(*settings, points=points)
        assert np.all(found == expected), f"{where}: {found.sum()} of {len(found)} are cracked"


def test_the_problem_is_frozen_and_can_be_changed_by_a_copy() -> None:
    found = built()
    assert replace(found, anchor="left").anchor == "left" and found.anchor == "top"


def test_adaptive_steps_are_counted_in_the_clock_of_the_case() -> None:
    """Two ell of advance; tau and back; or seconds; no growth where nothing diffuses."""
    keys = "start=0.1, stop=0.4, shortest=0.01, longest=0.1"
    by_tau = built(f"time={{tau={{{keys}}}}}").schedule
    pace = by_tau.pace
    assert pace is not None and (pace.shortest, pace.longest, pace.growth) == (0.01, 0.1, 0.25)
    assert pace.advance == pytest.approx(2 * 0.5)
    assert [pace.clock(t) for t in by_tau.times] == pytest.approx([0.1, 0.4])
    assert pace.time_at(0.3) == pytest.approx(0.3**2 / 4)
    by_time = built(f"time={{t={{{keys}}}}}").schedule
    assert by_time.times == (0.1, 0.4) and by_time.pace is not None
    assert by_time.pace.clock(0.3) == by_time.pace.time_at(0.3) == 0.3
    pulled = built(*PULLED, f"time={{t={{{keys}}}}}", "supports.top={y=0.1}").schedule
    assert pulled.pace is not None and pulled.pace.growth is None
    assert built().schedule.pace is None

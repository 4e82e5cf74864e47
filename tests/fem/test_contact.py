"""Cracks whose faces touch: they slide, rub, stick, and do not pass through one another."""

from itertools import pairwise
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case
from staffa.evolution.march import march
from staffa.evolution.system import build
from staffa.io.run_directory import open_run
from staffa.model.contact import normals_of
from staffa.model.fields import vertices
from staffa.physics.split import SPLITS, Contact, NoTension
from staffa.physics.strained import Faces, isotropic_strain
from staffa.records.step import Step
from staffa.setup.build import problem
from support.paths import DATA
from support.restarting import assert_same, cut_run, finish, whole_run

NEEDS = DATA / "needs"
E, NU = 2.0, 0.3


def steps_of(case) -> list[Step]:
    """All steps of a case; nothing may be amiss in them."""
    setup = problem(case)
    system = build(setup)
    try:
        steps = list(march(setup, system))
    finally:
        system.destroy()
    assert not [step.audit.violations for step in steps if step.audit.violations]
    return steps


def given(name: str, *settings: str):
    """A case of `data/needs`, with settings put over it."""
    return parse_case((NEEDS / name).read_text(), settings)


# The law.


def strained(e: np.ndarray, *, broken: float = 1.0, **more):
    """Strains of the plane, shape (3, n): across and along the faces, and the shear."""
    normal, along, shear = e

    def seen(gamma):
        middle, half = (normal + along) / 2, (normal - along) / 2
        radius = np.sqrt(half**2 + gamma**2)
        square = normal**2 + along**2 + 2 * gamma**2
        return isotropic_strain(
            normal + along, square, (middle + radius, middle - radius), E=E, nu=NU
        )

    faces = Faces(
        broken=broken, normal=normal, unsheared=seen(0 * shear), shear=np.abs(2 * shear), **more
    )
    whole = seen(shear)
    return type(whole)(**{**vars(whole), "faces": faces})


STRAINS = np.random.default_rng(5).normal(size=(2, 3, 400))


@pytest.mark.parametrize("broken", [0.0, 1.0])
@pytest.mark.parametrize("bound", [0.0, 0.3])
def test_convex_and_between_nothing_and_the_whole(broken: float, bound: float) -> None:
    """The energy lies below chords; a frictionless crack keeps between none and all of it."""
    split = Contact(friction=0.5 if bound else 0.0)
    one, other = (strained(e, broken=broken, bound=bound) for e in STRAINS)
    middle = strained(STRAINS.mean(axis=0), broken=broken, bound=bound)
    chord = (split.density(one, 0.1) + split.density(other, 0.1)) / 2
    assert np.all(split.density(middle, 0.1) <= chord * (1 + 1e-12))
    assert split.density(one, 1.0) == pytest.approx(one.psi, rel=1e-12)
    if not bound:
        kept = split.density(one, 0.0)
        assert np.all(kept >= 0) and np.all(kept <= one.psi * (1 + 1e-12))


def test_a_closed_layer_keeps_what_closes_it_alone() -> None:
    """E/2 e_n^2, the least energy of strains that close a crack so far; open it keeps none."""
    e = np.array([[-0.7, 0.4], [0.2, -0.5], [0.3, 0.6]])
    assert Contact().density(strained(e), 0.0) == pytest.approx([E / 2 * 0.49, 0.0], abs=1e-12)


def test_beside_a_crack_squeezing_drives_no_damage() -> None:
    """Strains that press along and across the faces keep all of their energy, shear none of it."""
    pressed = np.array([[-0.7], [-0.4], [0.0]])
    split = Contact()
    assert split.density(strained(pressed, broken=0.0), 0.0) == pytest.approx(
        strained(pressed).psi, rel=1e-12
    )
    sheared = np.array([[0.0], [0.0], [0.5]])
    assert split.density(strained(sheared, broken=0.0), 0.0) == pytest.approx([0.0], abs=1e-12)


def test_friction_is_the_least_energy_over_the_new_slip() -> None:
    """min over s of G/2 (c - s)^2 + b s, by trying many; held faces do not slip."""
    G, bound, e = E / (2 * (1 + NU)), 0.3, np.array([[-0.7], [0.0], [0.4]])
    s = np.linspace(0.0, 0.8, 80_001)
    least = (G / 2 * (0.8 - s) ** 2 + bound * s).min()
    split = Contact(friction=0.5)
    rubbed = split.density(strained(e, bound=bound), 0.0) - E / 2 * 0.49
    assert rubbed == pytest.approx([least], rel=1e-8)
    held = split.density(strained(e, bound=bound, free=0.0), 0.0) - E / 2 * 0.49
    assert held == pytest.approx([G / 2 * 0.64], rel=1e-12)


def test_rock_without_cracks_is_that_of_no_tension() -> None:
    """Strength, and what `check` says of it, are those of "no-tension"."""
    e = strained(STRAINS[0])
    bare = type(e)(**{**vars(e), "faces": None})
    assert Contact().density(bare, 0.2) == pytest.approx(NoTension().density(bare, 0.2))
    assert isinstance(SPLITS["contact"], Contact)


# Normals.


@pytest.mark.parametrize("dim", [2, 3])
def test_the_normal_is_the_direction_of_least_spread(dim: int) -> None:
    """Normal of a jagged layer of points, to a few degrees; a heap of points has none."""
    random = np.random.default_rng(2)
    normal = np.array([0.6, 0.8, 0.0][:dim])
    x = random.uniform(-1, 1, size=(4000 * 10 ** (dim - 2), dim))
    across = x @ normal
    layer = x[np.abs(across) < 0.02]
    found = normals_of(layer, 0.25)
    inner = np.linalg.norm(layer, axis=1) < 0.6
    assert np.degrees(np.arccos(np.abs(found[inner] @ normal).clip(0, 1))).max() < 12
    assert not np.any(normals_of(random.normal(size=(500, dim)), 10.0))
    assert not np.any(normals_of(x[:1], 0.1)) and normals_of(x[:0], 0.1).shape == (0, dim)


# The block, cut at 45 degrees.

CUT = ("domain.h=0.1", "damage.ell=0.1", "output.at=[]")
UNCUT = 0.02 / 2.0 / (1 - 0.25**2)  # the pressed strip's reaction, E = 1


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 0.5, pytest.param(0.9, marks=pytest.mark.long)])
def test_a_cut_block_slides(friction: float) -> None:
    """F6-cut45: below a friction of 1 nothing holds the upper part."""
    step = steps_of(given("F6-cut45.toml", *CUT, *contact(friction)))[-1]
    assert abs(step.reactions["top"][1]) < 1e-3 * UNCUT


@pytest.mark.slow
@pytest.mark.parametrize("friction", [2.0, pytest.param(1.1, marks=pytest.mark.long)])
def test_a_cut_block_sticks(friction: float) -> None:
    """F6-cut45: above it the block is as stiff as uncut, but for the layer of the crack."""
    edges = ("domain.h=0.05", "output.at=[]")
    step = steps_of(given("F6-cut45.toml", *edges, *contact(friction)))[-1]
    assert -step.reactions["top"][1] == pytest.approx(UNCUT, rel=0.025)
    assert step.energies.friction < 0.01 * step.energies.elastic


def contact(friction: float = 0.0) -> tuple[str, str]:
    """The settings of the split."""
    return 'damage.split="contact"', f"damage.friction={friction}"


# A crack in shear along it.


@pytest.mark.slow
def test_a_sheared_crack_releases_what_an_open_one_does() -> None:
    """F6-slip: extra energy of the crack against that with "none", extrapolated to ell = 0."""
    extra = {
        split: [
            steps_of(
                given("F6-slip.toml", f'damage.split="{split}"', f"domain.h={h}", f"damage.ell={h}")
            )[-1].energies.elastic
            - 1.25 * 9
            for h in (0.06, 0.03)
        ]
        for split in ("none", "contact")
    }
    limit = {split: 2 * fine - coarse for split, (coarse, fine) in extra.items()}
    assert limit["contact"] / limit["none"] == pytest.approx(1.0, abs=0.05)
    assert extra["contact"][1] > 0.88 * extra["none"][1]


# A horizontal crack is an inclined one seen along its faces: pressed across, sheared along.
PRESSED = """
[domain]
size = [3.0, 3.0]
h = 0.06
[material]
nu = 0.25
Gc = 1e3
plane = "strain"
[damage]
ell = 0.06
split = "contact"
allow_coarse = true
[temperature]
profile = "none"
[[cracks]]
start = [1.2, 1.5]
end = [1.8, 1.5]
[forces]
top = { x = PUSHED, y = { t = [0.0, 1.0], value = [0.0, -1.0] } }
bottom = { x = PULLED, y = { t = [0.0, 1.0], value = [0.0, 1.0] } }
right = { y = PUSHED }
left = { y = PULLED }
[time]
t = [1.0]
"""
# Of uncracked rock: shear tau^2/(2 G), pressure sigma^2 (1 - nu^2)/(2 E).
WHOLE = 9 * (1.25 + 0.9375 / 2)


def pressed(friction: float, times: str = "[1.0]", *, last: float = 1.0):
    """The case with a friction, other times, and what is left of the shear at t = 2."""
    text = PRESSED
    for name, sign in (("PUSHED", 1.0), ("PULLED", -1.0)):
        table = f"{{ t = [0.0, 1.0, 2.0], value = [0.0, {sign}, {sign * last}] }}"
        text = text.replace(name, table)
    return parse_case(text, [f"damage.friction={friction}", f"time.t={times}"])


@pytest.mark.slow
def test_friction_takes_its_part_of_the_shear() -> None:
    """The extra energy is ((tau - mu sigma_n)/tau)^2 of that without friction, sigma_n = tau."""
    free = steps_of(pressed(0.0))[-1].energies.elastic - WHOLE
    for friction, share in ((0.3, 0.49), (0.6, 0.16), (1.2, 0.0)):
        step = steps_of(pressed(friction))[-1]
        assert (step.energies.elastic - WHOLE) / free == pytest.approx(share, abs=0.02)
        # Work on a slip that goes with tau - mu sigma_n, at a bound that is there from the start.
        rubbed = 2 * friction / (1 - friction) * share * free if share else 0.0
        assert step.energies.friction == pytest.approx(rubbed, rel=0.05, abs=1e-3 * free)


@pytest.mark.slow
def test_work_of_friction_is_that_of_a_bound_that_grows_with_the_load() -> None:
    """In n steps (1 + 1/n)/2 of that in one; the elastic energy is the same. And balances hold."""
    one, *_ = steps_of(pressed(0.3))
    steps = steps_of(pressed(0.3, "[0.5,1.0]"))
    assert steps[-1].energies.friction == pytest.approx(0.75 * one.energies.friction, rel=0.01)
    assert steps[-1].energies.elastic == pytest.approx(one.energies.elastic, rel=1e-3)
    for before, after in pairwise(steps):
        gain = after.audit.work - after.audit.released + after.audit.renewed
        assert after.energies.total - before.energies.total == pytest.approx(gain, abs=1e-2)


@pytest.mark.slow
def test_faces_do_not_pass_through_one_another() -> None:
    """A closed crack is as thick as the rock beside it: no opening, and none that is negative."""
    setup = problem(pressed(0.3))
    system = build(setup)
    list(march(setup, system))
    gone = system.energy.openings.volumes().sum() / 0.6
    system.destroy()
    assert abs(gone) < 0.06  # one cell, strained by about 1


@pytest.mark.slow
def test_slip_is_kept_when_the_shear_goes() -> None:
    """The shear vanishes, the pressure stays: what has slipped by tau - mu sigma_n goes back by
    the same bound, so that friction takes more, and what it holds is no more than mu sigma_n."""
    loaded, unloaded = steps_of(pressed(0.3, "[1.0,2.0]", last=0.0))
    free = steps_of(pressed(0.0))[-1].energies.elastic - WHOLE
    pressure = 9 * 0.9375 / 2
    # The slip at the load was (1 - .3); unloaded it would go back to 0.3 and is held there: the
    # crack is loaded by its own slip, with (mu sigma_n)^2 of the energy.
    assert unloaded.energies.elastic - pressure == pytest.approx(0.09 * free, rel=0.1)
    assert unloaded.energies.friction > loaded.energies.friction


# Restarts, ranks, rules.


@pytest.mark.slow
def test_a_run_that_was_cut_goes_on_to_the_last_bit(tmp_path: Path) -> None:
    """Normals, slip and the work of friction are kept."""
    case = pressed(0.3, "[0.4,0.7,1.0]")
    expected = whole_run(case, tmp_path / "whole")
    looks = 2 + max(step.sweeps for step in expected.steps)
    cut_run(case, tmp_path / "cut", looks)
    assert finish(tmp_path / "cut", looks) >= 2
    assert_same(open_run(tmp_path / "cut"), expected)


def test_check_says_where_closed_cracks_do_not_slide() -> None:
    """F6: under other splits, with a way out; and of friction where there is some."""

    def said(*settings: str) -> list[str]:
        warnings = preview(given("F6-slip.toml", *settings)).warnings
        return [sentence for sentence in warnings if "do not slide" in sentence]

    (sentence,) = said("damage.split=no-tension")
    assert 'damage.split = "contact"' in sentence
    assert len(said("damage.split=spectral")) == 1
    assert said("damage.split=contact") == said("damage.split=none") == []
    cut = preview(given("F6-cut45.toml", "damage.split=no-tension")).warnings
    assert any("do not slide" in sentence for sentence in cut)
    facts = {f[0]: f[1:] for f in preview(given("F6-slip.toml", *contact(0.3))).facts}
    assert facts["friction"][0] == "0.3" and "no second-order test" in facts["friction"][1]


def test_with_friction_the_second_order_is_left_out() -> None:
    """By default; without friction it stays."""
    assert given("F6-slip.toml", *contact(0.3)).solver.stability == "none"
    assert given("F6-slip.toml", *contact(0.0)).solver.stability == "test"


WING = """
[domain]
size = [1.0, 1.0]
h = 0.02
[material]
nu = 0.2
plane = "strain"
[damage]
ell = 0.04
residual_stiffness = 1e-5
allow_coarse = true
[temperature]
profile = "none"
[[cracks]]
start = [0.394, 0.394]
end = [0.606, 0.606]
[supports]
bottom = "rollers"
top = { y = { t = [0.0, 10.0], u = [0.0, -10.0] } }
[time]
t = { start = 2.0, stop = 4.4, steps = 9 }
"""


@pytest.mark.long
@pytest.mark.slow
def test_a_closed_crack_under_pressure_grows_wings() -> None:
    """They leave its tips and run along the pressure (Horii and Nemat-Nasser 1985), and none grow
    where the faces cannot slide."""
    tips = np.array([[0.394, 0.394], [0.606, 0.606]])
    grown = {}
    for split in ("contact", "no-tension"):
        setup = problem(parse_case(WING, [f'damage.split="{split}"']))
        system = build(setup)
        steps = list(march(setup, system))
        assert not [step.audit.violations for step in steps if step.audit.violations]
        x = vertices(system.spaces.alpha)[:, :2]
        broken = x[system.state.alpha.x.array > 0.9]
        system.destroy()
        along = (broken - 0.5).sum(axis=1) / np.sqrt(2)
        across = (broken[:, 1] - broken[:, 0]) / np.sqrt(2)
        grown[split] = broken[(np.abs(along) > 0.17) | (np.abs(across) > 0.05)]
    assert not len(grown["no-tension"])
    for tip, side in zip(tips, (-1, 1), strict=True):
        own = grown["contact"][side * (grown["contact"] - 0.5).sum(axis=1) > 0]
        end = own[(side * own[:, 1]).argmax()]
        way = side * (end - tip)
        assert way[1] > 0.08, f"no wing at {tip}: {way}"
        assert abs(np.degrees(np.arctan2(way[0], way[1]))) < 35, f"the wing at {tip} runs {way}"


def squeezed(*sides: str):
    """The body with its crack between two sides that press with four times the strength."""
    forces = "".join(
        f"{side} = {{ pressure = {{ t = [0.0, 1.0], value = [0.0, 1.0] }} }}\n" for side in sides
    )
    before, _ = PRESSED.replace("Gc = 1e3", "Gc = 0.01").split("[forces]")
    return parse_case(f"{before}[forces]\n{forces}[time]\nt = [0.5, 1.0]\n")


@pytest.mark.slow
@pytest.mark.parametrize("sides", [("left", "right"), ("bottom", "top")])
def test_pressure_along_or_across_a_crack_moves_nothing(sides: tuple[str, str]) -> None:
    """The crack neither grows nor weakens the body, where splits without a direction let it.

    Along it: Hakimzadeh et al., J. Appl. Mech. 92, 091006 (2025), arXiv 2504.16794. Across it:
    Steinke and Kaliske, Comput. Mech. 63, 1019 (2019).
    """
    half, whole = steps_of(squeezed(*sides))
    # Beside its ends the broken layer hands on what it carried along itself: a tenth of a cell.
    assert whole.energies.surface - half.energies.surface < 0.1 * 0.06 * 2 * 0.01
    assert whole.energies.surface - half.energies.surface > -1e-9
    assert whole.energies.elastic == pytest.approx(9 * 0.9375 / 2, rel=0.01)


@pytest.mark.long
@pytest.mark.slow
def test_an_inclined_crack_rubs_as_one_seen_along_its_faces() -> None:
    """At 45 degrees to a pressure sigma_n = tau, over a jagged layer of cells: (1 - mu)^2."""
    before, _ = PRESSED.split("[forces]")
    ramp = "{ pressure = { t = [0.0, 1.0], value = [0.0, 1.0] } }"
    forces = f"top = {ramp}\nbottom = {ramp}\n"
    text = f"{before}[forces]\n{forces}[time]\nt = [1.0]\n"
    ends = ("1.29", "1.71")
    text = text.replace("[1.2, 1.5]", f"[{ends[0]}, {ends[0]}]")
    text = text.replace("[1.8, 1.5]", f"[{ends[1]}, {ends[1]}]")
    finer = ("domain.h=0.04", "damage.ell=0.04")
    whole = 9 * 0.9375 / 2
    free, rubbed = (
        steps_of(parse_case(text, [*finer, f"damage.friction={friction}"]))[-1].energies.elastic
        - whole
        for friction in (0.0, 0.3)
    )
    assert rubbed / free == pytest.approx(0.49, rel=0.05)


SOLID = """
[domain]
size = [1.0, 0.5, 2.0]
h = 0.125
cells = "tetrahedron"
[material]
nu = 0.25
Gc = 1e5
[damage]
ell = 0.125
split = "contact"
allow_coarse = true
[temperature]
profile = "none"
[[cracks]]
center = [0.5, 0.25, 1.0]
radius = 0.8
normal = [-1.0, 0.0, 1.0]
[supports]
bottom = "rollers"
front = "rollers"
back = "rollers"
top = { z = { t = [0.0, 1.0], u = [0.0, -0.02] } }
[time]
t = [1.0]
"""


@pytest.mark.long
@pytest.mark.slow
def test_a_cut_solid_slides() -> None:
    """F6-cut45 in 3-D, without friction."""
    step = steps_of(parse_case(SOLID))[-1]
    assert abs(step.reactions["top"][2]) < 1e-3 * UNCUT / 2

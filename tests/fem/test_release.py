"""G by the G-theta method is what a longer crack releases, and what a growing one costs."""

from dataclasses import dataclass, replace
from functools import partial
from itertools import chain

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from fem.test_surfing import ride
from report.test_report import drawn_manifest, drawn_step
from staffa.evolution.march import march
from staffa.evolution.measures import releasing
from staffa.evolution.problem import Problem
from staffa.evolution.session import Session
from staffa.evolution.system import System, build
from staffa.io.field_output import FieldWriter
from staffa.io.run_directory import Journal, create, open_run
from staffa.loads.forces import Forces
from staffa.measure.fronts import Surface, fronts
from staffa.measure.network import Network
from staffa.model.supports import SideSupport, no_displacement
from staffa.records.tip_release import Release
from staffa.results.release_table import release_table, release_text
from support.bodies import body, quench, rock

H, ELL = 0.02, 0.06
ROLLERS = tuple(
    SideSupport(side=side, components={0: no_displacement}) for side in ("left", "right")
)
CLAMP = (SideSupport(side="left", components={0: no_displacement, 1: no_displacement}),)


def pulled(x: np.ndarray) -> np.ndarray:
    """A prestress across the notch that grows along it."""
    stress = np.zeros((6, x.shape[1]))
    stress[0] = 1 + x[1]
    return stress


# What acts on a plate with a notch in its lower side.
LOADS = {
    "cooled": {"load": quench(1.0), "sides": ROLLERS, "times": (0.05,)},
    "pressed open": {"forces": Forces(crack_pressure=lambda t: 1.0), "sides": ROLLERS},
    "prestressed": {"forces": Forces(prestress=pulled), "sides": CLAMP + ROLLERS[1:]},
    "heavy": {"forces": Forces(gravity=(1.0, 0.0)), "sides": CLAMP},
}


@dataclass(frozen=True, kw_only=True)
class Seen:
    """The energy of the rock and its loads, and G at the tips."""

    bulk: float
    tips: tuple[Release, ...]


def rates(problem: Problem, system: System) -> tuple[Release, ...]:
    """G at the tips of a system's state."""
    grid = FieldWriter(problem.domain.comm, system.spaces).grid
    mesh = None if grid is None else (grid.points, grid.cells)
    return releasing(Session(problem, system), mesh=mesh)()


def notched(depth: float, *, size=(1.0, 1.0), h=H, ell=ELL, state="plane stress", **more) -> Seen:
    """A notch of that depth in the middle of the side y = 0, in rock too tough for it to grow."""

    def cracked(x: np.ndarray) -> np.ndarray:
        return (np.abs(x[0] - size[0] / 2 - h / 2) < 0.51 * h) & (x[1] < depth + h / 10)

    material = rock(ell=ell, Gc=1e4, rho=1.0, cracked=cracked, state=state)
    problem = body(size, h, material=material, **more)
    system = build(problem)
    try:
        list(march(problem, system))
        energy = system.energy
        return Seen(bulk=energy.stored() + energy.loads(), tips=rates(problem, system))
    finally:
        system.destroy()


def difference(depth: float, h: float, **more) -> tuple[float, Seen]:
    """Energy that a notch releases from a cell less to a cell more than a depth, and it itself."""
    less, more_, seen = (notched(depth + d, h=h, **more) for d in (-h, h, 0.0))
    return (less.bulk - more_.bulk) / (2 * h), seen


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "state"),
    [
        ("cooled", "plane stress"),
        ("pressed open", "plane strain"),
        pytest.param("prestressed", "plane stress", marks=pytest.mark.long),
        pytest.param("heavy", "plane stress", marks=pytest.mark.long),
    ],
)
def test_a_held_notch_releases_the_difference_of_energies(name: str, state: str) -> None:
    """The terms that domain integrals are asked for in public: of temperature (MOOSE pull request
    3850), of the pressure in the crack (raccoon issue 121), of eigenstrains and body forces (MOOSE
    pull request 18805)."""
    expected, seen = difference(0.4, H, state=state, **LOADS[name])
    (tip,) = seen.tips
    assert tip.reason is None and tip.direction == pytest.approx((0, 1), abs=1e-3)
    assert tip.position == pytest.approx((0.51, 0.4), abs=H)
    gap = f"{tip.G} by theta, {expected} by energies"
    assert tip.G is not None and abs(tip.G - expected) < 0.02 * expected, gap
    assert tip.uncertainty < 0.05 * tip.G


@pytest.mark.long
def test_a_notch_through_a_slab_releases_the_difference_of_energies_an_area() -> None:
    size, h = (1.2, 1.2, 0.2), 0.04
    faces = (SideSupport(side=side, components={2: no_displacement}) for side in ("bottom", "top"))
    more = {"size": size, "ell": 0.1, "state": "solid", "sides": (*ROLLERS, *faces)}
    expected, seen = difference(0.6, h, forces=LOADS["pressed open"]["forces"], **more)
    known = [tip for tip in seen.tips if tip.G is not None]
    assert known, "there is a front"
    for tip in known:
        assert tip.direction == pytest.approx((0, 1, 0), abs=0.05)
        rate = expected / size[2]
        assert tip.G is not None and abs(tip.G - rate) < 0.05 * rate


@pytest.mark.slow
def test_a_crack_that_grows_releases_the_effective_toughness() -> None:
    found: list[Release] = []

    def look(problem: Problem, system: System) -> None:
        if len(found) < 2:
            found.extend(rates(problem, system))

    followed = ride("AT1", cells_per_ell=3, radius=7, cells=1, look=look)
    assert len(found) == 2
    for tip in found:
        assert tip.G is not None and abs(tip.G - followed.factor) < 0.05 * followed.factor


def network_of(*lines: list[tuple[float, float]], h: float) -> Network:
    """Straight cracks, each cut into pieces of length h."""
    points, elements = [], []
    for start, end in lines:
        n = round(np.hypot(*np.subtract(end, start)) / h)
        first = sum(map(len, points))
        points.append(np.pad(np.linspace(start, end, n + 1), ((0, 0), (0, 1))))
        elements.append(first + np.stack([np.arange(n), np.arange(1, n + 1)], axis=1))
    joined = np.concatenate(points)
    return Network(points=joined, elements=np.concatenate(elements), damage=np.ones(len(joined)))


def square(h: float) -> Surface:
    """The sides of the unit square."""
    at = np.arange(h / 2, 1, h)
    middles = [[(s, 0.0), (s, 1.0), (0.0, s), (1.0, s)] for s in at]
    across = [[(0, 1, 0), (0, 1, 0), (1, 0, 0), (1, 0, 0)] for _ in at]
    places = np.pad(np.array(list(chain(*middles))), ((0, 0), (0, 1)))
    normals = np.array(list(chain(*across)), dtype=float)
    return Surface(middles=places, normals=normals, sizes=np.full(len(places), h / 2))


def test_rings_end_before_faces_and_other_cracks_and_a_reason_says_where_there_is_none() -> None:
    ell, h = 0.03, 0.01
    seen = partial(fronts, surface=square(h), ell=ell, h=h)
    (free,) = seen(network_of([(0.0, 0.5), (0.5, 0.5)], h=h))
    assert free.direction == pytest.approx((1, 0, 0)) and free.radius == pytest.approx(6 * ell)
    (far,) = seen(network_of([(0.0, 0.5), (0.86, 0.5)], h=h))
    assert far.radius == pytest.approx(0.14 - ell - h / 2, abs=1e-3)
    (close,) = seen(network_of([(0.0, 0.5), (0.95, 0.5)], h=h))
    assert close.reason is not None and "a face of the body" in close.reason
    beside = seen(network_of([(0.0, 0.5), (0.5, 0.5)], [(0.0, 0.6), (1.0, 0.6)], h=h))
    assert [tip.radius for tip in beside] == pytest.approx([6 * ell]), "along it nothing changes"
    (before,) = seen(network_of([(0.0, 0.5), (0.5, 0.5)], [(0.6, 0.0), (0.6, 1.0)], h=h))
    assert before.reason is not None and "a crack across its way" in before.reason
    two = seen(network_of([(0.0, 0.5), (0.4, 0.5)], [(0.6, 0.5), (1.0, 0.5)], h=h))
    assert [tip.radius for tip in two] == pytest.approx([0.2 - 2 * ell] * 2, abs=1e-6)


def test_rock_that_changes_within_the_ring_is_said() -> None:
    def stiffer(x: np.ndarray) -> np.ndarray:
        return np.where(x[1] > 0.5, 2.0, 1.0)

    size, depth = (1.0, 1.0), 0.4
    cracked = partial(_slit, depth=depth)
    problem = body(
        size, 0.04, material=rock(ell=0.08, E=stiffer, Gc=1e4, cracked=cracked), sides=ROLLERS,
        load=quench(1.0),
    )  # fmt: skip
    system = build(problem)
    (tip,) = rates(problem, system)
    system.destroy()
    assert tip.G is None and tip.reason == "the rock changes within the ring around the tip"


def _slit(x: np.ndarray, depth: float) -> np.ndarray:
    return (np.abs(x[0] - 0.5) < 0.03) & (x[1] < depth + 1e-3)


def test_a_table_and_a_sentence_tell_it(tmp_path) -> None:
    size = (1.0, 1.0)
    create(tmp_path, "title = 'drawn'\n", drawn_manifest(size))
    known = Release(position=(0.5, 0.4), direction=(0.0, 1.0), G=2.0, uncertainty=0.1, radius=0.3)
    unknown = Release(position=(0.7, 0.9), direction=(0.0, 1.0), reason="a face is near")
    step = drawn_step(1, size, "fields/step-0001.vtkhdf")
    Journal(tmp_path).append(replace(step, released=(known, unknown)))
    run = open_run(tmp_path)
    assert run.steps[0].released == (known, unknown), "kept on disk as it was"
    header, first, second = release_table(run).csv().splitlines()
    assert header == "step,time,tau,tip,x,y,dx,dy,G,uncertainty,radius,reason"
    assert first.split(",")[3:] == ["0", "0.5", "0.4", "0.0", "1.0", "2.0", "0.1", "0.3", ""]
    assert second.endswith(",,,,a face is near")
    assert release_text(run) == "2 at 1 of 2 tips of step 1, uncertain by up to 0.1"

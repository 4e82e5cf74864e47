"""Cracks are measured the same from whichever face they come, and in three dimensions."""

import numpy as np
import pytest

from staffa.evolution.system import build
from staffa.loads.closed_form import Face
from staffa.measure.crack import Gauge, measures
from staffa.model.fields import vertices
from staffa.physics.damage import AT2
from staffa.records.step import Measures
from support.bodies import body, rock

ELL, H = 0.03, 0.01
LONG, DEEP = 1.0, 0.4  # along the cooled face, and below it
DEPTHS = (0.1, 0.2, 0.33)
# Place along the face and depth of each drawn crack, each in the middle of a layer of cells.
DRAWN = [(0.205, 0.3), (0.505, 0.15), (0.855, 0.25)]
TURNED = {
    "bottom": (Face(axis=1, position=0.0, inward=1), (LONG, DEEP)),
    "top": (Face(axis=1, position=DEEP, inward=-1), (LONG, DEEP)),
    "left": (Face(axis=0, position=0.0, inward=1), (DEEP, LONG)),
    "right": (Face(axis=0, position=DEEP, inward=-1), (DEEP, LONG)),
}


def profile(across: np.ndarray, beyond: np.ndarray, h: float, ell: float) -> np.ndarray:
    """AT2's exp(-d/ell) around a layer of broken cells of width h."""
    out = np.maximum(np.abs(across) - h / 2, 0)
    return np.exp(-np.hypot(out, np.maximum(beyond, 0)) / ell)


def measured(problem, face: Face, alpha, depths: tuple[float, ...] = DEPTHS) -> Measures:
    """The measures of a state whose damage is a function of the points."""
    system = build(problem)
    system.state.alpha.x.array[:] = alpha(vertices(system.spaces.alpha))
    h, ell = problem.domain.h, problem.material.ell
    gauge = Gauge(
        face=face,
        depths=depths,
        threshold=0.8,
        prominence=ell,
        h=h,
        toughness_factor=1 + h / (2 * ell),  # 1 + h/(4 c_w ell), c_w = 1/2
    )
    found = measures(problem.domain, system.state, system.energy, gauge)
    system.destroy()
    return found


def end(h: float, ell: float) -> tuple[float, float]:
    """What the end of a drawn crack adds to its length by surface, and by geometry.

    Surface, 1/2 int alpha^2/ell + ell |grad alpha|^2, over half the plane around the end:
    pi/4 ell, and h/2 beyond the end of the layer of width h; over the discrete toughness.
    Geometry, 1/2 int |grad alpha^4|: pi/8 ell and h/2.
    """
    return (np.pi / 4 * ell + h / 2) / (1 + h / (2 * ell)), np.pi / 8 * ell + h / 2


@pytest.fixture(scope="module")
def turned() -> dict[str, Measures]:
    """The same cracks, from each of the four faces."""
    found = {}
    for name, (face, size) in TURNED.items():

        def alpha(x: np.ndarray, face: Face = face) -> np.ndarray:
            depth, along = face.depth(x.T), x[:, 1 - face.axis]
            cracks = [profile(along - place, depth - deep, H, ELL) for place, deep in DRAWN]
            return np.max(cracks, axis=0)

        found[name] = measured(body(size, H, material=rock(ell=ELL, law=AT2())), face, alpha)
    return found


@pytest.mark.parametrize("face", TURNED)
def test_cracks_are_counted_below_their_own_face(turned: dict[str, Measures], face: str) -> None:
    sections = turned[face].sections
    assert [s.cracks for s in sections] == [3, 2, 0], f"from {face}: {sections}"
    assert [s.height for s in sections] == list(DEPTHS)
    places = [place for place, _ in DRAWN]
    assert sections[0].positions == pytest.approx(places, abs=1e-9), "between two vertices each"
    assert sections[0].spacing == pytest.approx((places[2] - places[0]) / 2, abs=1e-9)
    assert sections[1].positions == pytest.approx([places[0], places[2]], abs=1e-9)


@pytest.mark.parametrize("face", TURNED)
def test_depths_are_counted_from_the_cooled_face(turned: dict[str, Measures], face: str) -> None:
    found, (plane, _) = turned[face], TURNED[face]
    assert len(found.tips) == len(DRAWN), f"from {face}: {found.tips}"
    by_place = sorted(found.tips, key=lambda tip: tip.position[1 - plane.axis])
    for tip, (place, deep) in zip(by_place, DRAWN, strict=True):
        # exp(-d/ell) falls below the threshold .8 at .22 ell, within a cell beyond the end.
        assert deep - 1e-9 <= tip.depth <= deep + H, f"from {face}: {tip.depth}, drawn {deep}"
        assert tip.position[1 - plane.axis] == pytest.approx(place, abs=H)
        from_face = plane.inward * (tip.position[plane.axis] - plane.position)
        assert from_face == pytest.approx(tip.depth, abs=1e-12), "position and depth are the same"
    assert found.front == max(tip.depth for tip in found.tips)


@pytest.mark.parametrize("face", ["top", "left", "right"])
def test_a_turned_body_has_the_same_measures(turned: dict[str, Measures], face: str) -> None:
    one, other = turned["bottom"], turned[face]
    # The quadrature of a turned square is the same up to the order of its points.
    assert other.length_surface == pytest.approx(one.length_surface, rel=1e-9)
    assert other.length_geometry == pytest.approx(one.length_geometry, rel=1e-9)
    assert other.front == pytest.approx(one.front, abs=1e-12)
    assert sorted(t.depth for t in other.tips) == pytest.approx(sorted(t.depth for t in one.tips))
    for here, there in zip(one.sections, other.sections, strict=True):
        assert there.positions == pytest.approx(here.positions, abs=1e-9)


@pytest.mark.parametrize("face", TURNED)
def test_the_lengths_are_those_that_were_drawn(turned: dict[str, Measures], face: str) -> None:
    found, length = turned[face], sum(deep for _, deep in DRAWN)
    surface, geometry = length + len(DRAWN) * end(H, ELL)[0], length + len(DRAWN) * end(H, ELL)[1]
    # The profile is drawn, not minimized, on cells of ell/3.
    assert found.length_surface == pytest.approx(surface, rel=0.01), f"{found.length_surface}"
    assert found.length_geometry == pytest.approx(geometry, rel=0.01), f"{found.length_geometry}"


BOX, H3, ELL3 = (1.2, 1.0, 0.6), 0.05, 0.1
FLOOR = Face(axis=2, position=0.0, inward=1)


def boxed(alpha, cells: str = "hexahedron") -> Measures:
    """The measures of a box cooled from below."""
    material = rock(ell=ELL3, law=AT2(), state="solid")
    return measured(body(BOX, H3, cells=cells, material=material), FLOOR, alpha, depths=())


def wall(place: float, deep: float):
    """A flat crack right through the box at x = place, from the bottom to a depth."""
    return lambda x: profile(x[:, 0] - place, x[:, 2] - deep, H3, ELL3)


def half_disc(place: float, radius: float):
    """Half a disc at x = place around the middle of the bottom edge."""

    def alpha(x: np.ndarray) -> np.ndarray:
        radial = np.hypot(x[:, 1] - BOX[1] / 2, x[:, 2])
        return profile(x[:, 0] - place, radial - radius, H3, ELL3)

    return alpha


@pytest.mark.parametrize("cells", ["hexahedron", "tetrahedron"])
def test_a_wall_in_a_box_has_its_depth_and_its_area(cells: str) -> None:
    deep = 0.3
    found = boxed(wall(0.575, deep), cells)
    # A wall ends in a ridge, not in a point: its deepest vertices are one crack.
    assert len(found.tips) == 1, f"{found.tips}"
    assert deep - 1e-9 <= found.front <= deep + H3, f"{found.front}, drawn {deep}"
    assert found.tips[0].position[0] == pytest.approx(0.575, abs=H3)
    assert len(found.tips[0].position) == 3 and found.tips[0].depth == found.front
    surface, geometry = (BOX[1] * (deep + more) for more in end(H3, ELL3))
    # As in 2-D, times the width; the profile is drawn, not minimized, on cells of ell/2.
    assert found.length_surface == pytest.approx(surface, rel=0.02), f"{found.length_surface}"
    assert found.length_geometry == pytest.approx(geometry, rel=0.02), f"{found.length_geometry}"


def test_half_a_disc_in_a_box_has_one_tip_at_its_radius() -> None:
    radius = 0.25
    found = boxed(half_disc(0.575, radius))
    assert len(found.tips) == 1 and found.sections == (), f"{found.tips}"
    assert radius - 1e-9 <= found.front <= radius + H3, f"{found.front}, drawn {radius}"
    x, y, z = found.tips[0].position
    assert x == pytest.approx(0.575, abs=H3) and z == found.front
    # Damage of .8 is .22 ell beyond the rim: so wide is what is cracked at a depth of the radius.
    widest = np.sqrt((radius + 0.22 * ELL3) ** 2 - radius**2)
    assert abs(y - BOX[1] / 2) <= widest, f"at y = {y}, up to {widest} beside the middle"
    # Around the rim of half a circle (Pappus): int exp(-2 d/ell)/ell over the half plane beyond it
    # is pi/4 ell with a moment of ell^2/2, over the end of the layer h/2 with a moment of h ell/4.
    rim = np.pi * (radius * np.pi / 4 * ELL3 + ELL3**2 / 2)
    rim += np.pi * (radius * H3 / 2 + H3 * ELL3 / 4)
    area = np.pi / 2 * radius**2 + rim / (1 + H3 / (2 * ELL3))
    # A disc of five cells on a rectangular mesh.
    assert found.length_surface == pytest.approx(area, rel=0.03), f"{found.length_surface}, {area}"


def test_two_walls_are_two_cracks_with_a_depth_each() -> None:
    one, other = wall(0.275, 0.2), wall(0.875, 0.4)
    found = boxed(lambda x: np.maximum(one(x), other(x)))
    assert len(found.tips) == 2, f"{found.tips}"
    for tip, (place, deep) in zip(found.tips, [(0.275, 0.2), (0.875, 0.4)], strict=True):
        assert tip.position[0] == pytest.approx(place, abs=H3)
        assert deep - 1e-9 <= tip.depth <= deep + H3, f"{tip.depth}, drawn {deep}"
    assert found.front == found.tips[1].depth
    single = [boxed(alpha).length_surface for alpha in (one, other)]
    # Six ell apart: the profiles overlap by exp(-3) = 5 % at their feet, where they are small.
    assert found.length_surface == pytest.approx(sum(single), rel=0.01), f"{single}"


def test_an_unbroken_box_has_no_crack() -> None:
    found = boxed(lambda x: np.zeros(len(x)))
    assert found.tips == () and found.front == 0.0
    assert found.length_surface == found.length_geometry == 0.0

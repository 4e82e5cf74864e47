"""Cracks of a body cooled on several faces are measured from the face that they start on."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from staffa.evolution.system import build
from staffa.loads.closed_form import Face
from staffa.measure.crack import Gauge, measures
from staffa.measure.starting_faces import (
    NOWHERE,
    OtherFace,
    Starts,
    cooled_faces,
    started,
    starts,
)
from staffa.model.fields import vertices
from staffa.physics.damage import AT2
from staffa.records.step import Measures
from support.bodies import body, rock

ELL, H, SIZE = 0.03, 0.01, (1.0, 0.4)
BOTTOM = Face(axis=1, position=0.0, inward=1)
# Ends of each drawn crack, the first of them on the face, in the middle of a layer of cells.
FROM_BOTTOM = [((0.505, 0.0), (0.505, 0.15)), ((0.755, 0.0), (0.755, 0.25))]
FROM_LEFT = [((0.0, 0.105), (0.2, 0.205))]
FROM_TOP = [((0.305, 0.4), (0.305, 0.28)), ((0.905, 0.4), (0.905, 0.3))]
WITHIN = [((0.405, 0.2), (0.405, 0.3))]  # a given crack that reaches no face


def near(x: np.ndarray, start: tuple[float, float], end: tuple[float, float]) -> np.ndarray:
    """Distance of points, shape (n, 3), from a segment."""
    a, way = np.array(start), np.subtract(end, start)
    along = np.clip((x[:, :2] - a) @ way / (way @ way), 0.0, 1.0)
    return np.linalg.norm(x[:, :2] - a - along[:, None] * way, axis=1)


THROUGH = [((0.305, 0.0), (0.305, 0.4))]


def measured(
    drawn: list,
    others: tuple[str, ...],
    depths: tuple[float, ...] = (),
    *,
    before: Measures | None = None,
    cools: bool = True,
) -> Measures:
    """The measures of a body with such cracks, of which other faces than the bottom are cooled."""
    problem = body(SIZE, H, material=rock(ell=ELL, law=AT2()))
    system = build(problem)
    x = vertices(system.spaces.alpha)
    beyond = np.maximum(np.min([near(x, *crack) for crack in drawn], axis=0) - H / 2, 0)
    system.state.alpha.x.array[:] = np.exp(-beyond / ELL)
    gauge = Gauge(
        face=BOTTOM, depths=depths, threshold=0.8, prominence=ELL, h=H, toughness_factor=1.0,
        others=cooled_faces(problem.domain, others), cools=cools,
    )  # fmt: skip
    found = measures(problem.domain, system.state, system.energy, gauge, before=before)
    system.destroy()
    return found


def test_a_crack_is_measured_from_the_face_that_it_starts_on() -> None:
    drawn = [*FROM_BOTTOM, *FROM_LEFT, *FROM_TOP]
    alone = measured(FROM_BOTTOM, ())
    mixed = measured(drawn, ())
    assert len(mixed.tips) == 5 and mixed.front > 0.38, "the far ends count without the faces"
    found = measured(drawn, ("left", "top"))
    assert found.tips == alone.tips and found.front == alone.front
    (left, top) = found.others
    assert (left.face, left.cracks) == ("left", 1) and (top.face, top.cracks) == ("top", 2)
    # Recorded tips lie on vertices above the threshold, up to 2 h beyond the end of a drawn crack.
    assert 0.2 <= left.deepest <= 0.2 + 2 * H and 0.12 <= top.deepest <= 0.12 + 2 * H


def test_a_crack_that_starts_on_no_cooled_face_is_measured_as_before() -> None:
    alone = measured([*FROM_BOTTOM, *WITHIN], ())
    found = measured([*FROM_BOTTOM, *WITHIN, *FROM_TOP], ("top",))
    assert found.tips == alone.tips and len(found.tips) == 3
    assert [other.cracks for other in found.others] == [2]


def test_cracks_of_other_faces_are_left_out_of_the_spacing_by_depth_with_their_number() -> None:
    depths = (0.1, 0.35)
    alone, found = (
        measured(FROM_BOTTOM, (), depths),
        measured([*FROM_BOTTOM, *FROM_TOP], ("top",), depths),
    )
    near_face, deep = found.sections
    assert near_face == alone.sections[0] and near_face.cracks == 2 and near_face.elsewhere == 0
    assert (deep.cracks, deep.spacing, deep.positions, deep.elsewhere) == (0, None, (), 2)


def test_without_other_cooled_faces_nothing_is_counted_apart() -> None:
    found = measured([*FROM_BOTTOM, *FROM_TOP], ())
    assert found.others == () and len(found.tips) == 4


def test_cracks_that_meet_are_parted_halfway_and_a_loose_one_has_no_face() -> None:
    """A chain of points from one face to the other, a step apart, and two points beside it."""
    points = np.zeros((9, 3))
    points[:7, 0], points[7:, 0] = np.arange(7.0), (2.0, 3.0)
    points[7:, 1] = 5.0
    chain = [(k, k + 1) for k in range(6)]
    distances = np.column_stack([points[:, 0] + points[:, 1], 6 - points[:, 0] + points[:, 1]])
    touching = distances <= 1.5
    found = starts(points, np.array([*chain, (7, 8)]), distances, touching, reach=1.5)
    assert list(found[:7]) == [0, 0, 0, 0, 1, 1, 1], "of equal ways, that to the first face"
    assert list(found[7:]) == [NOWHERE, NOWHERE]


def chain(*, layer: float) -> Starts:
    """A crack from one face to another one that lies 10 m away, a point a meter."""
    points = np.zeros((11, 3))
    points[:, 1] = np.arange(11.0)
    kept = points[points[:, 1] > layer]
    edges = np.array([(k, k + 1) for k in range(len(kept) - 1)])
    other = OtherFace(name="top", surface=cKDTree([(0.0, 10.0, 0.0)]))
    return started(kept, edges, kept[:, 1], [other], layer=layer, reach=1.5, cools=True)


def test_a_broken_layer_does_not_move_the_place_where_cracks_are_parted() -> None:
    for layer in (0.0, 1.5, 2.5):
        found = chain(layer=layer)
        assert (
            found.points[found.face == 0, 1].max()
            == 5
            == found.points[found.face == 1, 1].min() - 1
        )


def deep(found: Measures) -> list[tuple[float, float | None, bool]]:
    """Depth, free distance and meeting of each tip."""
    return [(tip.depth, tip.room, tip.met) for tip in found.tips]


def test_a_crack_that_meets_one_of_another_face_keeps_the_depth_that_it_had() -> None:
    """The longer one from the bottom, then both joined: half the way would be 0.2."""
    apart = [((0.305, 0.0), (0.305, 0.29)), ((0.305, 0.4), (0.305, 0.36))]
    before = measured(apart, ("top",))
    ((depth, _, met),) = deep(before)
    assert depth >= 0.29 and not met and before.others[0].joined is None
    joined = measured(THROUGH, ("top",), before=before)
    later = measured(THROUGH, ("top",), before=joined)
    for found in (joined, later):
        assert found.tips == (replace(before.tips[0], met=True),)
        assert found.front == before.front
        assert found.others[0].joined == pytest.approx(0.4)


def test_a_crack_of_another_face_does_not_get_shorter_where_it_is_met() -> None:
    apart = [((0.305, 0.4), (0.305, 0.11)), ((0.305, 0.0), (0.305, 0.04))]
    before = measured(apart, ("top",))
    found = measured(THROUGH, ("top",), before=before)
    assert found.others[0].deepest == before.others[0].deepest >= 0.29
    assert found.front >= before.front


def test_a_crack_that_has_run_through_in_one_step_ends_halfway_without_a_tip() -> None:
    (found,) = deep(measured(THROUGH, ("top",)))
    assert found == (pytest.approx(0.2, abs=H), 0.0, True)


def test_a_crack_of_another_face_ends_with_the_body() -> None:
    """Without a crack of the bottom to meet, as that is not cooled."""
    found = measured(THROUGH, ("top",), cools=False)
    (top,) = found.others
    assert top.sharp(3 * ELL) == pytest.approx(0.4)
    free = measured([((0.305, 0.4), (0.305, 0.28))], ("top",)).others[0]
    assert free.room is None and free.sharp(ELL) == free.deepest + ELL


def test_a_face_that_is_not_cooled_has_no_cracks_of_its_own() -> None:
    at_left = [((0.005, 0.0), (0.005, 0.2)), ((0.005, 0.4), (0.005, 0.3)), *WITHIN]
    within = measured(WITHIN, ())
    found = measured(at_left, ("left", "top"), cools=False)
    assert found.tips == within.tips and all(one.joined is None for one in found.others)


def test_a_broken_layer_at_a_face_that_is_not_cooled_belongs_to_the_faces_beside_it() -> None:
    along = [((0.0, 0.0), (0.7, 0.0))]
    found = measured(along, ("left",), cools=False)
    assert found.tips == () and found.front == 0
    (left,) = found.others
    assert left.cracks == 1 and 0.7 <= left.deepest <= 0.7 + 2 * H


def test_cracks_of_two_further_faces_that_meet_keep_their_depths() -> None:
    apart = [((0.305, 0.4), (0.305, 0.11)), ((0.0, 0.105), (0.255, 0.105))]
    met = [((0.305, 0.4), (0.305, 0.105)), ((0.0, 0.105), (0.305, 0.105))]
    before = measured(apart, ("left", "top"), cools=False)
    found = measured(met, ("left", "top"), before=before, cools=False)
    for one, other in zip(before.others, found.others, strict=True):
        assert other.deepest >= one.deepest and other.sharp(ELL) >= one.sharp(ELL)

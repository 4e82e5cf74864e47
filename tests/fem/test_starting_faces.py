"""Cracks of a body cooled on several faces are measured from the face that they start on."""

import numpy as np

from staffa.evolution.system import build
from staffa.loads.closed_form import Face
from staffa.measure.crack import Gauge, measures
from staffa.measure.starting_faces import NOWHERE, cooled_faces, starts
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


def measured(drawn: list, others: tuple[str, ...], depths: tuple[float, ...] = ()) -> Measures:
    """The measures of a body with such cracks, of which other faces than the bottom are cooled."""
    problem = body(SIZE, H, material=rock(ell=ELL, law=AT2()))
    system = build(problem)
    x = vertices(system.spaces.alpha)
    beyond = np.maximum(np.min([near(x, *crack) for crack in drawn], axis=0) - H / 2, 0)
    system.state.alpha.x.array[:] = np.exp(-beyond / ELL)
    gauge = Gauge(
        face=BOTTOM, depths=depths, threshold=0.8, prominence=ELL, h=H, toughness_factor=1.0,
        others=cooled_faces(problem.domain, others),
    )  # fmt: skip
    found = measures(problem.domain, system.state, system.energy, gauge)
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
    found = starts(points, np.array([*chain, (7, 8)]), distances, reach=1.5)
    assert list(found[[0, 1, 2]]) == [0, 0, 0] and list(found[[4, 5, 6]]) == [1, 1, 1]
    assert list(found[7:]) == [NOWHERE, NOWHERE]

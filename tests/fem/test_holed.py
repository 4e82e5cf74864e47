"""A crack that meets a hole ends at its edge: the network, and the depth of the sharp tip."""

from dataclasses import replace

import numpy as np
import pytest

from fem.test_network import ELL, H, drawn, profile
from report.test_report import drawn_manifest
from staffa.io.vtkhdf import VtkMesh
from staffa.measure.free_distance import room
from staffa.measure.traced_body import Body
from support.bodies import body, rock

HOLE, RADIUS = np.array([0.5, 0.5]), 0.2


@pytest.fixture(scope="module")
def holed() -> VtkMesh:
    """A square of triangles, those in a disc left out."""
    n = 50
    at = np.linspace(0, 1, n + 1)
    points = np.stack([*np.meshgrid(at, at, indexing="ij"), np.zeros((n + 1, n + 1))], axis=-1)
    number = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = (number[i : n + i, j : n + j].ravel() for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
    cells = np.concatenate([np.stack([a, b, c], axis=1), np.stack([a, c, d], axis=1)])
    points = points.reshape(-1, 3)
    middles = points[cells].mean(axis=1)[:, :2]
    cells = cells[np.linalg.norm(middles - HOLE, axis=1) > RADIUS]
    used, cells = np.unique(cells, return_inverse=True)
    return VtkMesh(points=points[used], cells=cells.reshape(-1, 3), type=5)


def test_no_crack_runs_through_a_hole(holed: VtkMesh) -> None:
    """One drawn straight across the hole: two cracks, up to its edge, nothing within."""
    away = np.abs(holed.points[:, 0] - 0.51)
    found = drawn(holed, profile("AT1", away, H, ELL))
    middles = found.points[found.elements].mean(axis=1)[:, :2]
    assert np.linalg.norm(middles - HOLE, axis=1).min() > RADIUS - H
    assert found.size == pytest.approx(1 - 2 * RADIUS, abs=2 * H)
    assert found.cracks.max() == 1
    body_ = Body(holed.points, holed.cells, dim=2, h=H)
    body_.raster(np.zeros(len(holed.points)))
    assert not body_.nearest(found.points)[1].any()


def test_room_is_the_way_to_the_surface() -> None:
    """To the far side of a block, along an axis; none within reach is inf."""
    domain = body((1.0, 0.6), 0.05, material=rock()).domain
    places = np.array([[0.5, 0.45], [0.0, 0.6], [0.3, 0.2]])
    found = room(domain, places, np.array([0.0, 1.0]), reach=0.2)
    assert found == pytest.approx([0.15, 0.0, np.inf])


def test_a_sharp_tip_stays_in_the_body() -> None:
    manifest = replace(drawn_manifest((1.0, 1.0)), tip_reach=0.1)
    assert manifest.sharp(0.3, 0.02) == pytest.approx(0.32)
    assert manifest.sharp(0.3, None) == pytest.approx(0.4)

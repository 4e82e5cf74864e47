"""Reading of the room `verification/bricks`: angles and junctions of patterns that are drawn."""

import numpy as np
import pytest

from staffa.measure.cells import cells
from staffa.plot.cell_planes import ColumnPlane
from verification.bricks.run import JUNCTIONS, TILES, slanted, unfolded

WIDTH, HEIGHT, ELL, PIXEL = 0.5, 0.866, 0.1, 0.01


def drawn(angle: float) -> ColumnPlane:
    """A plane whose slanted joint makes this angle (degrees) with its image."""
    nx, ny = round(WIDTH / PIXEL), round(HEIGHT / PIXEL)
    x, y = np.meshgrid(
        (np.arange(nx) + 0.5) * WIDTH / nx, (np.arange(ny) + 0.5) * HEIGHT / ny, indexing="ij"
    )
    rise = np.tan(np.radians(180 - angle) / 2)  # of the joint, from its middle to the left
    joint = HEIGHT / 2 + rise * (WIDTH / 2 - x)
    oblique = np.abs(y - joint) / np.hypot(1, rise)
    left = np.where(y > HEIGHT / 2 + rise * WIDTH / 2, x, np.inf)
    right = np.where(y < HEIGHT / 2 - rise * WIDTH / 2, WIDTH - x, np.inf)
    away = np.minimum(np.minimum(oblique, left), right)
    damage = np.maximum(1 - away / (2 * ELL), 0) ** 2
    return ColumnPlane(
        depth=0.1,
        axes=(0, 1),
        extent=((0.0, WIDTH), (0.0, HEIGHT)),
        damage=damage,
        threshold=0.8,
        cells=cells(damage, pixel=(PIXEL, PIXEL), ell=ELL, threshold=0.8),
    )


@pytest.mark.parametrize(("angle", "kind"), [(180, "T"), (165, "T"), (135, "Y"), (120, "Y")])
def test_the_angle_of_a_drawn_pattern_and_the_kind_of_its_junctions(angle: int, kind: str) -> None:
    plane = drawn(angle)
    whole, pixel = unfolded(plane)
    found = cells(whole, pixel=pixel, ell=ELL, threshold=0.8, periodic=(True, True))
    assert found.number == TILES
    assert [str(kind) for kind in found.kinds] == [kind] * JUNCTIONS
    assert slanted(plane) == pytest.approx(angle, abs=1)


def test_joints_that_bend_the_other_way_make_more_than_half_a_turn() -> None:
    assert slanted(drawn(200)) == pytest.approx(200, abs=1)


def test_no_angle_without_a_joint() -> None:
    plane = drawn(150)
    plane.damage[20:30] = 0.0
    assert np.isnan(slanted(plane))

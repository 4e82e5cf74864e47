"""The cells of drawn sections are as many, as large and as sided as they were drawn."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial import cKDTree

from staffa.measure.cells import Cells, cell_section, cells
from staffa.measure.patterns import Pattern, pattern
from staffa.records.step import CellSection

EDGE = 1 / 120  # of a pixel
ELL = 4 * EDGE
PERIODIC = (True, True)
OF_CELLS = ("areas", "perimeters", "sides", "ends")
HEXAGON = (2 / np.sqrt(3)) ** 0.5  # two rows of hexagons of unit area are this wide, 3^(1/4) high


def middles(size: tuple[float, float], counts: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """The middles of pixels."""
    x, y = ((np.arange(n) + 0.5) * length / n for length, n in zip(size, counts, strict=True))
    return np.meshgrid(x, y, indexing="ij")


def damage(distance: np.ndarray, ell: float = ELL) -> np.ndarray:
    """The damage of AT1 at a distance from cracks."""
    return np.clip(1 - distance / (2 * ell), 0, 1) ** 2


def to_lines(x: np.ndarray, apart: float, first: float | np.ndarray = 0.0) -> np.ndarray:
    """Distance to the nearest of parallel lines."""
    return np.abs((x - first + apart / 2) % apart - apart / 2)


def to_borders(
    size: tuple[float, float], counts: tuple[int, int], points: np.ndarray
) -> np.ndarray:
    """Distance to the borders of the Voronoi cells of points on a torus, shape (n, 2)."""
    at = np.stack([x.ravel() for x in middles(size, counts)], axis=1)
    near, number = cKDTree(points, boxsize=size).query(at, k=7)
    way = points[number[:, 1:]] - points[number[:, :1]]
    way -= np.round(way / size) * size
    to_bisectors = (near[:, 1:] ** 2 - near[:, :1] ** 2) / (2 * np.linalg.norm(way, axis=2))
    return to_bisectors.min(axis=1).reshape(counts)


def measured(
    alpha: np.ndarray, *, pixel=(EDGE, EDGE), ell=ELL, threshold=0.8, periodic=PERIODIC
) -> Cells:
    return cells(alpha, pixel=pixel, ell=ell, threshold=threshold, periodic=periodic)


def told(found: Cells) -> Pattern:
    """The statistics of drawn cells."""
    return pattern([cell_section(found, depth=0.1, pixel=(EDGE, EDGE))])


def squares(apart: float = 0.25) -> np.ndarray:
    """The damage around a square lattice of cracks on the unit square."""
    x, y = middles((1.0, 1.0), (120, 120))
    return damage(np.minimum(to_lines(x, apart), to_lines(y, apart)))


def bricks(cut: float = 0.0) -> np.ndarray:
    """The damage around courses of bricks, 0.25 high and 0.25 wide, each set off by half a brick.

    Upright cracks end by `cut` below the course's lower crack.
    """
    x, y = middles((1.0, 1.0), (120, 120))
    across = to_lines(x, 0.25, 0.125 * np.floor(y / 0.25))
    upright = np.hypot(across, np.maximum(cut - y % 0.25, 0))
    return damage(np.minimum(upright, to_lines(y, 0.25)))


def honeycomb() -> tuple[np.ndarray, tuple[float, float]]:
    """The damage around 4 x 6 hexagons of unit area, and the raster's pixels."""
    wide, high = HEXAGON, HEXAGON * np.sqrt(3) / 2
    size, counts = (4 * wide, 6 * high), (160, 208)
    row, column = np.divmod(np.arange(24), 4)
    points = np.stack([(column + 0.5 * (row % 2) + 0.3) * wide, (row + 0.4) * high], axis=1)
    alpha = damage(to_borders(size, counts, points % size), ell=0.1)
    return alpha, (size[0] / counts[0], size[1] / counts[1])


def test_hexagons_have_six_sides_and_meet_in_ys() -> None:
    alpha, pixel = honeycomb()
    found = measured(alpha, pixel=pixel, ell=0.1)
    seen = told(found)
    assert (seen.number, seen.interior, seen.histogram) == (24, 24, {6: 24})
    assert seen.area.value == pytest.approx(1.0, rel=1e-9)
    assert seen.area_cv.value < 0.01, "to the pixel"
    assert (seen.hexagonality.value, seen.disorder.value, seen.sides_variance.value) == (1, 0, 0)
    assert seen.junctions == {"T": 0, "Y": 48, "X": 0} and seen.t_share.value == 0
    perimeter = 2 * np.sqrt(2 * np.sqrt(3))  # of a hexagon of unit area
    assert seen.spacing.value == pytest.approx(2 / perimeter, rel=0.03), "to a pixel a side"


def test_bricks_have_six_neighbors_and_meet_in_ts() -> None:
    seen = told(measured(bricks()))
    assert (seen.number, seen.histogram, seen.junctions) == (16, {6: 16}, {"T": 32, "Y": 0, "X": 0})
    assert seen.t_share.value == 1
    assert seen.area.value == pytest.approx(1 / 16, rel=1e-9)
    assert seen.area_cv.value < 0.01


@pytest.mark.parametrize("turn", np.linspace(0, 90, 7))
@pytest.mark.parametrize(
    ("arms", "kind"),
    [
        ((0, 120, 240), "Y"),
        ((0, 135, 240), "Y"),
        ((0, 90, 180), "T"),
        ((0, 70, 180), "T"),
        ((0, 95, 170), "T"),
        ((0, 90, 180, 270), "X"),
    ],
)
def test_a_junction_is_told_by_its_widest_angle(
    arms: tuple[int, ...], kind: str, turn: float
) -> None:
    """150 degrees part a Y from a T; those within 15 of that are not tried."""
    x, y = (a - 0.5 - EDGE / 3 for a in middles((1.0, 1.0), (120, 120)))
    distance = np.full(x.shape, np.inf)
    for arm in np.radians(np.array(arms) + turn):
        along, across = x * np.cos(arm) + y * np.sin(arm), y * np.cos(arm) - x * np.sin(arm)
        distance = np.minimum(distance, np.hypot(np.minimum(along, 0), across))
    found = measured(damage(distance), periodic=(False, False))
    assert found.kinds == (kind,)
    assert found.junctions[0] == pytest.approx([0.5, 0.5], abs=2 * EDGE)


def test_squares_have_four_sides_and_cross() -> None:
    seen = told(measured(squares()))
    assert (seen.number, seen.histogram, seen.junctions) == (16, {4: 16}, {"T": 0, "Y": 0, "X": 16})
    assert seen.area.value == pytest.approx(1 / 16, rel=1e-9) and seen.area_cv.value < 1e-9
    assert seen.disorder.value == 4 and seen.t_share.value is None
    assert seen.spacing.value == pytest.approx(0.125, rel=1e-9), "half the distance across"


def test_parallel_cracks_are_as_far_apart_as_their_spacing_says() -> None:
    x, _ = middles((1.0, 1.0), (120, 120))
    for periodic in (PERIODIC, (True, False)):
        seen = told(measured(damage(to_lines(x, 0.2)), periodic=periodic))
        assert seen.number == 5
        assert seen.spacing.value == pytest.approx(0.2, rel=1e-9)


@pytest.fixture(scope="module")
def poisson() -> Pattern:
    """400 cells of points that lie anywhere, 40 pixels wide."""
    points = np.random.default_rng(7).random((400, 2))
    edge = 1 / 800
    distance = to_borders((1.0, 1.0), (800, 800), points)
    # Thin lines: sides down to a pixel are told.
    return told(measured((distance < 0.7 * edge) * 1.0, pixel=(edge, edge), ell=edge))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "expected"),
    # Okabe, Boots, Sugihara, Chiu, Spatial Tessellations, 2000, section 5.5.
    [("area_cv", 0.529), ("sides_variance", 1.781), ("hexagonality", 0.2946)],
)
def test_poisson_voronoi_is_as_known_within_its_errors(
    poisson: Pattern, name: str, expected: float
) -> None:
    estimate = getattr(poisson, name)
    away = abs(estimate.value - expected) / estimate.error
    assert away < 2.5, f"{name} {estimate.value} +- {estimate.error} beside {expected}"
    assert estimate.error < 0.1 * expected, f"an error of {estimate.error} says little"


@pytest.mark.slow
def test_poisson_voronoi_has_six_sides_by_euler(poisson: Pattern) -> None:
    assert poisson.number == poisson.interior == 400
    assert poisson.sides.value == pytest.approx(6, abs=0.03), "but for sides under a pixel"
    assert poisson.area.value == pytest.approx(1 / 400, rel=1e-9)


@pytest.mark.parametrize("threshold", [0.3, 0.5, 0.7, 0.9])
@pytest.mark.parametrize(("first", "off"), [(0.0, 1e-9), (EDGE / 2, 0.04)])
def test_areas_and_sides_do_not_depend_on_the_threshold(
    threshold: float, first: float, off: float
) -> None:
    """Cracks along the edges of pixels are there to the last one; those along their middles give
    away half a pixel of 30 on each side."""
    x, y = middles((1.0, 1.0), (120, 120))
    alpha = damage(np.minimum(to_lines(x, 0.25, first), to_lines(y, 0.25, first)), 8 * EDGE)
    found = measured(alpha, threshold=threshold)
    assert found.number == 16 and set(found.sides) == {4}
    assert found.areas == pytest.approx(np.full(16, 1 / 16), rel=off)


@pytest.mark.parametrize("ell", [2 * EDGE, 4 * EDGE, 8 * EDGE])
def test_areas_do_not_depend_on_how_wide_a_crack_is(ell: float) -> None:
    """A layer of broken cells, h = 2 pixels wide, at ell = h, the coarsest allowed, too."""
    x, y = middles((1.0, 1.0), (120, 120))
    beyond = np.maximum(np.minimum(to_lines(x, 0.25), to_lines(y, 0.25)) - EDGE, 0)
    found = measured(damage(beyond, ell), ell=ell)
    assert found.number == 16 and set(found.sides) == {4}
    assert found.areas == pytest.approx(np.full(16, 1 / 16), rel=1e-9)


def test_a_crack_that_ends_within_a_cell_divides_nothing() -> None:
    """Every upright crack falls short of the course below it: courses, and no bricks."""
    found = measured(bricks(cut=0.08))
    assert found.number == 4 and set(found.sides) == {2}
    assert found.areas == pytest.approx(np.full(4, 0.25), rel=1e-3)
    assert not found.kinds


def test_a_small_gap_between_cracks_is_no_cell() -> None:
    alpha = squares()
    here = np.hypot(*(x - 0.25 for x in middles((1.0, 1.0), (120, 120))))
    gap = np.abs(here - 2 * ELL) < ELL  # a ring of damage around where four cells meet
    found = measured(np.where(gap, 1.0, np.where(here < ELL, 0.0, alpha)))
    assert found.number == 16


def test_cells_at_an_end_of_the_body_are_known_as_such() -> None:
    found = measured(squares(), periodic=(False, False))
    assert Counter(found.ends.tolist()) == {0: 4, 1: 8, 2: 4}
    seen = told(found)
    assert (seen.number, seen.interior, seen.histogram) == (16, 4, {4: 4})
    # Cells of the same size at the ends are halves of larger ones: 16 cells count as 4 + 4 + 1.
    assert seen.whole_area.value == pytest.approx(1 / 9)
    assert set(found.sides[found.ends == 2]) == {2}


def test_a_cell_goes_on_across_a_periodic_end_only() -> None:
    x, y = middles((1.0, 1.0), (120, 120))
    alpha = damage(np.minimum(to_lines(x, 0.5, 0.25), to_lines(y, 0.5, 0.25)))
    around, between = measured(alpha), measured(alpha, periodic=(False, False))
    assert (around.number, between.number) == (4, 9)
    assert set(around.ends) == {0} and Counter(between.ends.tolist()) == {0: 1, 1: 4, 2: 4}
    corner = np.abs(around.centroids - 0.5).min(axis=1).argmax()
    assert np.abs((around.centroids[corner] + 0.5) % 1 - 0.5) == pytest.approx(0, abs=1e-6)
    assert told(between).whole_area.value == pytest.approx(told(around).area.value)


def test_without_a_crack_all_is_one_cell() -> None:
    found = measured(np.zeros((30, 20)), periodic=(False, False))
    assert found.number == 1 and found.ends.tolist() == [2] and found.cracked == 0
    assert found.areas == pytest.approx([600 * EDGE**2])
    seen = told(found)
    assert seen.interior == 0 and seen.area.value is None and seen.spacing.value is None


@pytest.mark.parametrize("level", [1.0, np.nan])
def test_where_all_is_cracked_or_no_body_there_is_no_cell(level: float) -> None:
    found = measured(np.full((30, 20), level), periodic=(False, False))
    assert found.number == 0 and not found.kinds and not found.tiles.any()
    assert found.cracked == (1 if level == 1 else 0)
    assert told(found).number == 0


def test_outside_of_the_body_there_is_nothing() -> None:
    """A disc quartered by two cracks, through pixels' middles."""
    x, y = middles((1.0, 1.0), (121, 121))
    edge = 1 / 121
    alpha = damage(np.minimum(np.abs(x - 0.5), np.abs(y - 0.5)))
    disc = np.hypot(x - 0.5, y - 0.5) < 0.45
    found = measured(np.where(disc, alpha, np.nan), pixel=(edge, edge), periodic=(False, False))
    assert found.number == 4 and set(found.sides) == {2} and set(found.ends) == {1}
    assert found.areas.sum() == pytest.approx(disc.sum() * edge**2, rel=1e-9)
    assert found.areas == pytest.approx(np.full(4, found.areas.mean()), rel=0.02)
    assert found.kinds == ("X",) and found.junctions[0] == pytest.approx([0.5, 0.5], abs=edge)
    assert (found.tiles[~disc] == 0).all()


def test_the_errors_are_those_of_a_mean() -> None:
    areas = tuple(np.random.default_rng(1).exponential(size=200))
    drawn = CellSection(
        depth=0.1, pixel=(1.0, 1.0), areas=areas, perimeters=areas, sides=(6,) * 200,
        ends=(0,) * 200, junctions={"T": 30, "Y": 70, "X": 0}, cracked=0.0,
    )  # fmt: skip
    seen, twice = pattern([drawn]), pattern([drawn, drawn])
    expected = np.std(areas) / np.sqrt(200)
    assert seen.area.error == pytest.approx(expected, rel=0.1), "drawn 1000 times: 2 %"
    assert seen == pattern([drawn]), "the same numbers are drawn each time"
    assert twice.area.error == pytest.approx(expected / np.sqrt(2), rel=0.1)
    assert twice.sections == 2 and twice.area.value == pytest.approx(seen.area.value)
    part = 32 / 104  # Agresti and Coull
    error = np.sqrt(part * (1 - part) / 104)
    assert (seen.t_share.value, seen.t_share.error) == pytest.approx((0.3, error))
    assert seen.hexagonality.value == 1 and seen.hexagonality.error > 0
    few = replace(drawn, **{name: getattr(drawn, name)[:4] for name in OF_CELLS})
    assert pattern([few]).area.value > 0 and pattern([few]).area.error is None

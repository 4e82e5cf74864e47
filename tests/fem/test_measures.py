"""Cracks drawn by hand are counted, located and measured as they were drawn."""

from dataclasses import replace

import numpy as np
import pytest

from staffa.evolution.system import build
from staffa.measure.crack import Gauge, measures
from staffa.measure.statistics import cracks_on_line, layer_depth, tips
from staffa.model.fields import vertices
from staffa.physics.damage import AT2
from support.bodies import BOTTOM, UNSTRUCTURED, body, rock

# x position and depth of each drawn crack, each in the middle of a layer of cells.
DRAWN = [(0.205, 0.3), (0.505, 0.15), (0.855, 0.3), (1.205, 0.22)]
ELL, H = 0.03, 0.01


def drawn(x: np.ndarray, layer: float) -> np.ndarray:
    """The AT2 profile around straight cracks from the bottom, over a damaged layer."""
    alpha = np.exp(-np.maximum(x[:, 1] - layer, 0) / ELL) * (layer > 0)
    for position, depth in DRAWN:
        beyond = np.maximum(x[:, 1] - depth, 0)
        across = np.maximum(np.abs(x[:, 0] - position) - H / 2, 0)
        alpha = np.maximum(alpha, np.exp(-np.hypot(across, beyond) / ELL))
    return alpha


def gauge(h: float) -> Gauge:
    """What is measured of a body cooled from below, with cells of this edge."""
    return Gauge(
        face=BOTTOM,
        depths=(0.1, 0.2, 0.25, 0.4),
        threshold=0.8,
        prominence=ELL,
        h=h,
        toughness_factor=1 + h / (2 * ELL),
    )


def measured(cells: str, layer: float = 0.0):
    problem = body((1.5, 0.5), H, cells=cells, material=rock(ell=ELL, law=AT2()))
    system = build(problem)
    system.state.alpha.x.array[:] = drawn(vertices(system.spaces.alpha), layer)
    found = measures(problem.domain, system.state, system.energy, gauge(H))
    system.destroy()
    return found


@pytest.mark.parametrize("layer", [0.0, 0.05])
@pytest.mark.parametrize("cells", ["quadrilateral", "triangle", UNSTRUCTURED])
def test_drawn_cracks(cells: str, layer: float) -> None:
    """Vertices that lie anywhere miss a drawn profile's top: 4 % of surface, 3 % of variation."""
    of_surface, of_variation = (0.05, 0.05) if cells == "unstructured" else (0.02, 0.03)
    found = measured(cells, layer)
    assert [s.cracks for s in found.sections] == [4, 3, 2, 0]
    assert found.sections[0].positions == pytest.approx([p for p, _ in DRAWN], abs=H)
    assert found.sections[0].spacing == pytest.approx(1.0 / 3, abs=H)
    assert found.sections[2].spacing == pytest.approx(0.65, abs=H)
    assert found.sections[3].spacing is None
    assert len(found.tips) == 4
    for tip, (position, depth) in zip(found.tips, DRAWN, strict=True):
        assert tip.position[0] == pytest.approx(position, abs=1.01 * H)
        assert depth - H <= tip.depth <= depth + 1.5 * H
    assert found.front == max(tip.depth for tip in found.tips)
    if layer == 0.0:
        length = sum(depth for _, depth in DRAWN)
        # The half disc around a tip adds pi/8 ell to the variation, pi/4 ell to the surface.
        assert found.length_surface == pytest.approx(length + 4 * np.pi / 4 * ELL, rel=of_surface)
        assert found.length_geometry == pytest.approx(
            length + 4 * np.pi / 8 * ELL, rel=of_variation
        )


@pytest.mark.parametrize("slant", [20, 45])
@pytest.mark.parametrize("cells", ["quadrilateral", "triangle"])
def test_a_slanted_crack_crosses_each_depth_once(cells: str, slant: float) -> None:
    """Also a line through the middles of cells, where the two diagonals of a square say two."""
    problem = body((1.0, 0.5), H, cells=cells, material=rock(ell=ELL))
    system = build(problem)
    x, angle = vertices(system.spaces.alpha), np.radians(slant)
    for shift in np.linspace(0, 1, 7) * H:  # where the crack lies in the cells
        away = (x[:, 0] - 0.3 - shift) * np.cos(angle) - x[:, 1] * np.sin(angle)
        profile = np.maximum(1 - np.abs(away) / (2 * ELL), 0) ** 2
        within = np.abs(away) < 0.51 * H / max(np.cos(angle), np.sin(angle))
        system.state.alpha.x.array[:] = np.where(within, 1.0, profile)
        depths = tuple(0.05 + np.arange(0, 0.1, 0.005))
        found = measures(
            problem.domain, system.state, system.energy, replace(gauge(H), depths=depths)
        )
        assert [s.cracks for s in found.sections] == [1] * len(depths), shift
    system.destroy()


@pytest.mark.parametrize("cells", ["quadrilateral", "triangle"])
@pytest.mark.parametrize("off", [-1e-17, 0.0, 1e-17])
def test_a_stub_as_deep_as_the_prominence_is_a_crack(cells: str, off: float) -> None:
    """From the face on, three cells; round-off in the place of the face must not decide."""
    problem = body((1.5, 0.5), H, cells=cells, material=rock(ell=ELL))
    system = build(problem)
    face = replace(BOTTOM, position=off)
    x, alpha = vertices(system.spaces.alpha), system.state.alpha.x.array
    places = np.linspace(0.1, 1.4, 9).round(2)
    for long, count in [(4, 9), (3, 9), (2, 0)]:
        away = np.abs(x[:, [0]] - places).min(axis=1)
        alpha[:] = (away < 0.4 * H) & (x[:, 1] < (long + 0.4) * H)
        at_face = replace(gauge(H), face=face)
        found = measures(problem.domain, system.state, system.energy, at_face).tips
        assert len(found) == count, long
        assert [tip.depth for tip in found] == pytest.approx([long * H] * count)
    system.destroy()


def test_section_counts_runs() -> None:
    x = np.linspace(0, 1, 101)
    alpha = np.zeros(101)
    alpha[[10, 11, 50, 80]] = 0.9
    found = cracks_on_line(x[::-1], alpha[::-1], height=0.2, threshold=0.8)
    assert found.cracks == 3 and found.positions == pytest.approx((0.105, 0.5, 0.8))
    assert found.spacing == pytest.approx((0.8 - 0.105) / 2)


def test_section_at_the_ends_and_empty() -> None:
    x = np.linspace(0, 1, 11)
    ends = np.zeros(11)
    ends[[0, 10]] = 1.0
    assert cracks_on_line(x, ends, height=0.0, threshold=0.5).cracks == 2
    assert cracks_on_line(x, np.zeros(11), height=0.0, threshold=0.5).cracks == 0
    assert cracks_on_line(np.zeros(0), np.zeros(0), height=0.0, threshold=0.5).cracks == 0


def test_section_within_a_damaged_layer_counts_none() -> None:
    x, alpha = np.linspace(0, 1, 101), np.full(101, 0.95)
    assert cracks_on_line(x, alpha, height=0.0, threshold=0.8).cracks == 0


def chain(points: list[tuple[float, float]]) -> tuple[np.ndarray, np.ndarray]:
    """A polyline as a graph."""
    n = len(points)
    return np.array(points), np.array([(i, i + 1) for i in range(n - 1)])


def test_tips_of_a_fork() -> None:
    """A crack that forks has two tips if both branches are longer than the prominence."""
    stem = [(0.0, d) for d in np.arange(0, 0.31, 0.05)]
    left = [(-0.05 * k, 0.3 + 0.05 * k) for k in range(1, 5)]
    right = [(0.05 * k, 0.3 + 0.05 * k) for k in range(1, 3)]
    points = np.array(stem + left + right)
    n, m = len(stem), len(left)
    edges = [(i, i + 1) for i in range(n + m - 1)]
    edges += [(n - 1, n + m), *[(n + m + i, n + m + i + 1) for i in range(len(right) - 1)]]
    for prominence, count in [(0.05, 2), (0.15, 1)]:
        found = tips(points, points[:, 1], np.array(edges), prominence=prominence)
        assert len(found) == count
        assert found[0].depth == pytest.approx(0.5)


def test_rough_edge_is_no_crack() -> None:
    points, edges = chain([(0.1 * k, 0.05 + 0.01 * (k % 2)) for k in range(20)])
    assert tips(points, points[:, 1], edges, prominence=0.03) == ()


def test_no_points_no_tips() -> None:
    assert tips(np.zeros((0, 2)), np.zeros(0), np.zeros((0, 2), dtype=int), prominence=0.1) == ()


def test_layer_depth_is_that_of_the_bins_more_than_half_cracked() -> None:
    points = np.full(6, 10)
    assert layer_depth(np.array([10, 9, 6, 5, 0, 0]), points, bin_depth=0.1) == pytest.approx(0.25)
    assert layer_depth(np.zeros(6, dtype=int), points, bin_depth=0.1) == 0.0
    assert layer_depth(points, points, bin_depth=0.1) == pytest.approx(0.55)

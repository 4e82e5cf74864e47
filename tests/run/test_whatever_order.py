"""The crack network is a function of the fields: of no order of points and cells."""

from pathlib import Path

import numpy as np
import pytest

from fem.test_opening import LONG, cooled, seen
from staffa.io.vtkhdf import read_vtkhdf
from staffa.measure.statistics import tips
from staffa.measure.tracing import network


@pytest.mark.parametrize("cells", ["quadrilateral", "triangle"])
def test_a_network_is_the_same_in_any_order(cells: str, tmp_path: Path) -> None:
    """To the last bit, openings to round-off, for points and cells in random orders."""
    ell = LONG / 10
    first = seen(cooled(ell, "plane stress", cells=cells), tmp_path / "fields.vtkhdf")
    grid, values = read_vtkhdf(first.fields)
    strains = np.stack([values["opening_strain"], values["intact_strain"]], axis=1)
    for seed in (1, 2):
        random = np.random.default_rng(seed)
        points, members = random.permutation(len(grid.points)), random.permutation(len(grid.cells))
        number = np.argsort(points)
        again = network(
            grid.points[points], number[grid.cells][members], alpha=values["alpha"][points],
            strains=strains[members], dim=2, h=ell / 4, ell=ell, crack=0.8, tip=0.25,
        )  # fmt: skip
        assert np.array_equal(again.elements, first.network.elements)
        assert np.array_equal(again.points, first.network.points)
        assert again.opening == pytest.approx(first.network.opening, rel=1e-9, abs=1e-12)
        assert again.uncertainty == pytest.approx(first.network.uncertainty, rel=1e-6, abs=1e-9)


def test_tips_do_not_hang_on_round_off() -> None:
    """Depths equal but for rounding; one just as deep as the prominence asks for counts."""
    x, depth = np.array([0.1, 0.2, 0.3, 0.3]), np.array([0.3, 0.3, 0.3, 0.0])
    edges = np.array([[0, 1], [1, 2], [2, 3]])
    found = set()
    for sign in (-1, 0, 1):
        off = depth + sign * np.array([1e-17, -2e-17, 4e-17, 0.0])
        tip = tips(np.stack([x, off], axis=1), off, edges, prominence=0.1)
        found.add(tuple(t.position[0] for t in tip))
        off = depth + sign * np.array([0.0, 0.0, 0.0, 1e-17])
        assert len(tips(np.stack([x, off], axis=1), off, edges, prominence=0.3)) == 1
        assert tips(np.stack([x, off], axis=1), off, edges, prominence=0.301) == ()
    assert len(found) == 1

"""Small versions of `make verify ONLY=columns-theory`: energies of even arrays of sharp cracks."""

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from verification.columns_theory import table
from verification.columns_theory.variation import Solved, Wave

DEPTH, LAYER, STEP = 0.5, 0.3, 0.01


@pytest.fixture(scope="module")
def hexagons() -> Solved:
    """Hexagons on a coarse mesh, with the softest pattern, also without its symmetry."""
    waves = {"rows": table.ROWS, "without mirrors": Wave(k=table.ROWS.k)}
    return table.solved("hexagons", DEPTH, 0.16, waves, per_side=2)


def test_release_rate_is_the_derivative_of_the_energy() -> None:
    lower, here, upper = (
        table.solved("parallel", depth, 0.04) for depth in (DEPTH - STEP, DEPTH, DEPTH + STEP)
    )
    difference = (lower.energy(LAYER) - upper.energy(LAYER)) / (2 * STEP)
    # A central difference over 2 % of the depth is off by the square of that.
    assert here.release(LAYER)[0] == pytest.approx(difference, rel=5e-3)


def test_parallel_cracks_lose_stability_where_the_table_says() -> None:
    depth = 45.1 / 64  # row p = 64 of physics/doubling.py; its sqrt(kappa t) is 20.2
    ready = table.solved("parallel", depth, 0.01)
    layer = table.loss(ready, 0.3)
    assert layer == pytest.approx(20.2 / 64, rel=0.01)
    # Steps of .01 at the tip make G 1 % too large; the spacing goes as a^0.8 at loss of stability.
    assert table.spacing(ready.release(layer)[0]) == pytest.approx(64, rel=0.04)


def test_mirrors_leave_the_softest_pattern_as_it_is(hexagons: Solved) -> None:
    even = hexagons.at(LAYER)
    with_mirrors, _ = hexagons.softest(even, "rows")
    without, _ = hexagons.softest(even, "without mirrors")
    assert with_mirrors == pytest.approx(without, rel=1e-8)


def test_release_rate_has_the_symmetry_of_the_hexagon(hexagons: Solved) -> None:
    _, local = hexagons.release(LAYER)
    np.testing.assert_allclose(local, np.tile(local[:2], 6), rtol=1e-8)


def test_hexagons_grow_unevenly_once_the_cold_goes_deeper_than_the_cracks(
    hexagons: Solved,
) -> None:
    shallow, deep = (hexagons.softest(hexagons.at(layer), "rows")[0] for layer in (0.2, 0.5))
    assert shallow > 0 > deep

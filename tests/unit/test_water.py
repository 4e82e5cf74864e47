"""Viscosity of water for estimates, against tables."""

import pytest

from staffa.physics.water import viscosity


@pytest.mark.parametrize(
    ("celsius", "expected"), [(20, 1.002e-3), (60, 4.66e-4), (100, 2.82e-4), (200, 1.34e-4)]
)
def test_the_viscosity_of_water_is_that_of_tables(celsius: float, expected: float) -> None:
    """IAPWS 2008, at saturation."""
    assert viscosity(celsius + 273.15) == pytest.approx(expected, rel=0.04)

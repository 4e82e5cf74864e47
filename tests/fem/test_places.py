"""Places that are one are one: round-off decides nowhere on which side of a line rock lies."""

import numpy as np
import pytest

from staffa.case.reading.read import parse_case
from staffa.case.scales.case_scales import least_factor
from staffa.case.schema.boxes import Box, product
from staffa.case.schema.case import Case
from staffa.errors import InputError
from staffa.geometry.places import in_box
from staffa.setup.build import problem
from support.bodies import run

# Lower side of a band, and of a region's box, in the middle of a column of cells.
BAND, REGION = 0.325, 0.725
CASE = """
[domain]
size = [{size}]
h = {h}
[material]
{material}
[damage]
ell = {ell}
[toughness]
bands = [{{ lower = [{band}], upper = [{end}], factor = 0.8 }}]
[temperature]
profile = "slab"
severity = 8.0
[regions.stiff]
lower = [{region}]
upper = [{end}]
E = {stiff}
[supports]
left = "rollers"
right = "rollers"
[time]
tau = [0.1, 0.2]
[solver]
change = 1e-9
residual = 1e-8
"""


def cased(length: float | None = None, E: float = 50.0) -> Case:
    """A plate of 1 x .4, scaled; or of that many mm, of a modulus (GPa), in units."""

    def written(*lengths: float) -> str:
        if length is None:
            return ", ".join(map(repr, lengths))
        return ", ".join(f'"{length * x!r} mm"' for x in lengths)

    material, stiff = "nu = 0.3", "2.0"
    if length is not None:
        toughness = E * 1e9 * length * 1e-3  # Gc = E L, as it is scaled
        material = f'E = "{E!r} GPa"\nnu = 0.3\nGc = "{toughness!r} J/m^2"\nexpansion = "1e-5 1/K"'
        material += '\nkappa = "1 mm^2/s"'
        stiff = f'"{2 * E!r} GPa"'
    return parse_case(
        CASE.format(
            size=written(1.0, 0.4),
            h=written(0.05),
            material=material,
            ell=written(0.15),
            band=written(BAND, 0.0),
            end=written(1.0, 0.4),
            region=written(REGION, 0.0),
            stiff=stiff,
        )
    )


def scaled_energies(length: float | None = None, E: float = 50.0) -> list[float]:
    """Total energy of each step, over E and the square of the length."""
    unit = 1.0 if length is None else E * 1e9 * (length * 1e-3) ** 2
    return [step.energies.total / unit for step in run(problem(cased(length, E)))]


@pytest.mark.slow
def test_a_case_scaled_and_in_units_is_the_same_where_a_band_ends_on_middles_of_cells() -> None:
    expected = scaled_energies()
    for length in (3.3, 12.7, 57.0):  # round-off once decided there
        assert scaled_energies(length) == pytest.approx(expected, rel=1e-10), f"{length} mm"


def test_a_box_holds_its_sides_and_no_more() -> None:
    x = np.array([[0.3 - 2e-10, 0.3, 0.1 + 0.2, 0.3 + 2e-10, 0.31], [0.0] * 5, [0.0] * 5])
    assert in_box((0.3, -1.0), (1.0, 1.0), x, h=1.0).tolist() == [True] * 5
    assert in_box((0.0, -1.0), (0.3, 1.0), x, h=1.0).tolist() == [True] * 4 + [False]
    assert in_box((0.3, -1.0), (1.0, 1.0), x, h=1e-3).tolist() == [False] + [True] * 4


def test_on_a_side_that_two_bands_share_both_count() -> None:
    left = Box(lower=(0.0, 0.0), upper=(0.1 + 0.2, 1.0))
    right = Box(lower=(0.3, 0.0), upper=(1.0, 1.0))
    x = np.array([[0.2, 0.3, 0.1 + 0.2, 0.4], [0.5] * 4, [0.0] * 4])
    found = product(x, [(left, 2.0), (right, 3.0)], h=0.1)
    assert found.tolist() == [2.0, 6.0, 6.0, 3.0]


def test_bands_that_touch_within_round_off_do_not_overlap() -> None:
    """A sliver between 300 um and .3 mm is not the weakest place."""
    case = cased()
    bands = [
        {"lower": [0.0, 0.0], "upper": [0.1 + 0.2, 0.4], "factor": 0.5},
        {"lower": [0.3, 0.0], "upper": [1.0, 0.4], "factor": 0.8},
    ]
    keys = case.toughness.model_validate({"bands": bands})
    assert least_factor(case.model_copy(update={"toughness": keys})) == 0.5


DEEP = """
[domain]
size = [1.0, 0.9]
h = 0.1
[damage]
ell = 0.15
[temperature]
profile = "slab"
severity = 8.0
[time]
tau = [0.1]
[measures]
depths = [{depth}]
"""


@pytest.mark.parametrize("depth", [0.9, 0.3 * 3], ids=repr)
def test_a_depth_that_is_the_body_is_outside_however_it_is_written(depth: float) -> None:
    with pytest.raises(InputError, match="lies outside the body"):
        parse_case(DEEP.format(depth=depth))

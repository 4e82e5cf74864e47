"""A front that a formula moves through the body, as `staffa check` tells it."""

import pytest

from staffa.case.check.preview import Preview, preview
from staffa.case.reading.read import parse_case
from staffa.case.reading.ready_cases import ready_case
from staffa.case.scales.moving_front import moving_front

STRIP = """
[domain]
size = [3.0, 1.0]
h = 0.02
[damage]
ell = 0.06
[toughness]
amplitude = 0.02
[temperature]
profile = "formula"
T = "-9*where(x < 0.5*t, 1, exp(-5*(x - 0.5*t)))"
[time]
t = { start = 0.1, stop = 4.0, steps = 40 }
[output]
at = [4.0]
"""


def told(*settings: str) -> Preview:
    return preview(parse_case(STRIP, settings))


def fact(known: Preview, name: str) -> str:
    return next(value for what, value, _ in known.facts if what == name)


def test_a_front_is_told_with_its_speed_its_length_and_what_follows() -> None:
    known = told()
    assert fact(known, "front") == "0.5 along x"
    assert float(fact(known, "length of the front")) == pytest.approx(1 / 5, rel=0.02)
    assert float(fact(known, "Peclet number")) == pytest.approx(5, rel=0.02)
    assert float(fact(known, "W/ell0")) == pytest.approx(81, rel=1e-3)
    assert fact(known, "W/V") == "2"
    assert not known.warnings and not known.notes


def test_a_case_in_units_tells_them() -> None:
    known = preview(ready_case("strip"))
    assert fact(known, "front") == "0.00025 m/s along x"
    assert fact(known, "length of the front") == "2.01 mm" and fact(known, "W/V") == "40 s"


@pytest.mark.parametrize(
    ("T", "speed"),
    [
        ("-9*where(y < 0.1*t, 1, exp(-9*(y - 0.1*t)))", 0.1),
        ("-9*where(x > 3 - 0.5*t, 1, exp(-5*(3 - 0.5*t - x)))", -0.5),
    ],
)
def test_a_front_along_any_axis_and_either_way_is_found(T: str, speed: float) -> None:
    front = moving_front(parse_case(STRIP, [f'temperature.T="{T}"']), 4.0)
    assert front is not None and front.axis == (1 if "y" in T else 0)
    assert front.speed == pytest.approx(speed, rel=0.02)


@pytest.mark.parametrize(
    "T",
    [
        "-9*t*exp(-y)",  # falls everywhere
        "-9*exp(-(x/(0.1 + 0.7*t**0.5))**2)",  # diffuses: no steady speed
        "-9*where(x + y < 0.5*t, 1, 0)",  # oblique
        "-9*where(x < 1.5, 1, 0)",  # stands
    ],
)
def test_what_does_not_move_steadily_along_an_axis_is_no_front(T: str) -> None:
    assert moving_front(parse_case(STRIP, [f'temperature.T="{T}"']), 4.0) is None


def test_a_front_shorter_than_three_cells_is_warned_of() -> None:
    known = told('temperature.T="-9*where(x < 0.5*t, 1, exp(-25*(x - 0.5*t)))"')
    (warning,) = known.warnings
    assert "does not resolve the front" in warning and "3 h or longer" in warning


def test_a_step_in_which_the_front_leaps_is_noted_with_the_step_to_take() -> None:
    (note,) = told("time.t={start=1.0,stop=4.0,steps=4}").notes
    assert "moves 8.33 ell in a step" in note and "steps of 0.12" in note

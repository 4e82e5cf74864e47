"""Tables in time are met: steps end at each jump, extreme and kink of what is prescribed.

Others ask for the same: MOOSE forces a step at every point of a piecewise function, and a short one
after it (github.com/idaholab/moose/issues/13361 and pull 20304); diffrax takes the times of jumps
of an external force (github.com/patrick-kidger/diffrax/issues/58).
"""

from itertools import pairwise

import numpy as np
import pytest

from staffa.case.check.cost import steps
from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case
from staffa.case.scales.case_scales import derived_numbers
from staffa.case.scales.knots import DEPART, MOST, departure, knots
from staffa.case.scales.pace import plan
from staffa.case.scales.prescribed import curves
from staffa.case.schema.case import Case
from staffa.evolution.schedule import AdaptiveSteps

# A bar that is pulled and let go (its peak lay between two steps).
PULLED = """
[domain]
size = [1.0, 0.4]
h = 0.02
[material]
E = 100.0
nu = 0.0
[damage]
ell = 0.1
[temperature]
profile = "none"
[supports]
left = "rollers"
right = { x = { t = [0.0, 1.0, 1.2, 2.2, 3.0], u = [0.0, 0.0, 0.5, 0.0, 0.0] } }
[time]
t = { start = 0.1, stop = 3.0, shortest = 0.01, longest = 1.0 }
"""
# A wall that is shocked after a day of rest.
SHOCKED = """
[domain]
size = ["0.2 m", "0.1 m"]
h = "4 mm"
[material]
E = "65 GPa"
nu = 0.2
Gc = "61.5 J/m^2"
expansion = "6e-6 1/K"
k = "3.05 W/(m K)"
rho = "2750 kg/m^3"
c = "790 J/(kg K)"
[damage]
ell = "12 mm"
[temperature]
profile = "heat"
face = "bottom"
[heat]
initial = "150 °C"
[heat.bottom.T]
t = ["0 s", "1 d", "86410 s", "2 d"]
value = ["150 °C", "150 °C", "20 °C", "20 °C"]
[time]
t = { start = "1 min", stop = "2 d", shortest = "5 s", longest = "6 h" }
"""


def walked(case: Case) -> np.ndarray:
    """The times of a run in which no crack runs."""
    walk, times = AdaptiveSteps(plan(case, derived_numbers(case))), []
    while (time := walk.next()) is not None:
        walk.onward(time, 0.0)
        times.append(time)
    return np.array(times)


def test_steps_end_at_every_peak_and_kink_of_a_table() -> None:
    times = walked(parse_case(PULLED))
    assert {1.0, 1.2, 2.2} <= set(times.tolist()), times


def test_a_pulse_shorter_than_any_step_is_not_stepped_over() -> None:
    pulse = "supports.right.x={t=[0.0,2.0,2.0001,2.0002,3.0],u=[0.0,0.0,0.5,0.0,0.0]}"
    times = walked(parse_case(PULLED, [pulse]))
    assert {2.0, 2.0001, 2.0002} <= set(times.tolist()), times


def test_a_pulse_before_the_first_time_is_not_stepped_over() -> None:
    pulse = "supports.right.x={t=[0.0,0.01,0.02,3.0],u=[0.0,0.5,0.0,0.0]}"
    assert {0.01, 0.02, 0.1} <= set(walked(parse_case(PULLED, [pulse])).tolist())


@pytest.mark.parametrize(
    ("key", "value", "turns"),
    [
        ("forces.top.pressure", "{t=[0.0,1.5,1.6],value=[0.0,0.0,3.0]}", {1.5, 1.6}),
        ("forces.crack_pressure", "{t=[0.0,1.5,1.6],value=[0.0,0.0,3.0]}", {1.5, 1.6}),
        ("forces.top.y", '{formula="where(t < 1.7, x, 3*x)"}', {1.7}),
    ],
)
def test_forces_are_met_as_displacements_are(key: str, value: str, turns: set[float]) -> None:
    """A jump of a formula is closed in on from both sides."""
    times = walked(parse_case(PULLED, [f"{key}={value}"]))
    for turn in turns:
        before, after = times[times <= turn][-1], times[times >= turn][0]
        assert after - before <= 1e-8 * 3.0, f"{times} do not meet {turn}"


def test_steps_are_short_again_after_a_late_shock_and_grow_from_there() -> None:
    """A day of rest lets them grow to the longest; those after it grow by half at most."""
    times = walked(parse_case(SHOCKED))
    day, over = 86400.0, 86410.0
    assert {day, over} <= set(times.tolist())
    lengths = np.diff(times)
    assert lengths[times[1:] <= day].max() > 3600, "they were long before"
    after = times[times >= over] - day
    grown = np.diff(after) / after[:-1]
    assert np.diff(after)[0] <= 10.0, f"the first step after the shock takes {np.diff(after)[0]} s"
    assert grown[np.diff(after) < 6 * 3600].max() <= 1.25**2 - 1 + 1e-9, grown


def test_without_a_table_steps_are_those_of_the_cold_alone() -> None:
    held = ['heat.bottom={T="20 °C"}', "time.t.longest='1 h'"]
    times = walked(parse_case(SHOCKED, held))
    grown = np.diff(times) / times[:-1]
    assert grown[:10] == pytest.approx([1.25**2 - 1] * 10, rel=1e-9)


@pytest.mark.parametrize("seed", range(5))
def test_between_knots_a_value_departs_by_two_percent_at_most(seed: int) -> None:
    rng = np.random.default_rng(seed)
    t = np.cumsum(rng.exponential(size=400))
    values = np.cumsum(rng.normal(size=(400, 3)), axis=0)
    found = knots(t, values)
    assert found is not None and len(found.times) < 400
    apart, _ = departure(t, values, found.times)
    assert apart == pytest.approx(found.depart, rel=1e-9) and apart <= DEPART
    for column in values.T:
        for extreme in (column.argmin(), column.argmax()):
            near = np.interp(t[extreme], found.times, np.interp(found.times, t, column))
            assert abs(near - column[extreme]) <= DEPART * np.ptp(values, axis=0).max()


def test_a_peak_is_a_knot_to_the_digit_and_so_are_both_ends_of_a_plateau() -> None:
    t = np.linspace(0.0, 10.0, 1001)
    peak, plateau = np.exp(-((t - 3.21) ** 2)), np.clip(t - 4.0, 0.0, 2.0)
    found = knots(t, np.column_stack([peak, plateau]))
    assert found is not None
    for turn in (3.21, 4.0, 6.0):
        assert np.abs(found.times - turn).min() < 1e-9, f"{found.times} lack {turn}"


def test_noise_that_is_small_makes_no_knots() -> None:
    t = np.linspace(0.0, 1.0, 10_000)
    value = t + 0.005 * np.random.default_rng(0).normal(size=len(t)).clip(-2, 2)
    found = knots(t, value[:, None])
    assert found is not None and len(found.times) < 10 and found.depart <= DEPART


def test_a_log_of_ten_thousand_noisy_rows_has_no_more_steps_than_check_says() -> None:
    t = np.linspace(0.0, 3.0, 10_000)
    u = np.random.default_rng(1).normal(size=len(t))
    log = f"supports.right.x={{t={t.tolist()},u={u.tolist()}}}"
    case = parse_case(PULLED, [log])
    told = preview(case)
    number = next(value for name, value, _ in told.facts if name == "steps")
    planned = steps(case, derived_numbers(case)).number
    assert number == f"{planned} or more" and len(walked(case)) == planned
    assert MOST <= planned <= MOST + 4
    (warning,) = [w for w in told.warnings if "the most there may be" in w]
    assert warning.startswith("supports.right.x: steps end at ")


def test_check_lists_the_times_at_which_steps_end() -> None:
    facts = {name: (value, meaning) for name, value, meaning in preview(parse_case(PULLED)).facts}
    value, meaning = facts["steps end at"]
    assert value == "1, 1.2, 2.2" and "supports.right.x" in meaning


def test_times_that_are_given_and_miss_a_peak_are_told() -> None:
    missed = [w for w in preview(parse_case(PULLED, ["time.t=[1.1,2.05,3.0]"])).warnings]
    (warning,) = [w for w in missed if "no step sees" in w]
    assert warning.startswith("supports.right.x: at t = 1.2") and "time.t" in warning
    met = preview(parse_case(PULLED, ["time.t=[1.0,1.2,2.2,3.0]"])).warnings
    assert not [w for w in met if "no step sees" in w]


def test_thirty_years_may_begin_by_the_minute() -> None:
    """Production wells are logged by the second at first and by the year at last."""
    case = parse_case(
        SHOCKED,
        [
            'time.t={start="1 min",stop="30 years",shortest="10 s",longest="1 year"}',
            'heat.bottom={T="20 °C"}',
            'output.at=["90 s", "30 years"]',
        ],
    )
    times = walked(case)
    assert times[0] == 60.0 and 90.0 in times and times[-1] == pytest.approx(30 * 3.15576e7)
    assert all(later > earlier for earlier, later in pairwise(times))
    assert len(times) < 100


def test_curves_of_formulas_show_what_is_steep() -> None:
    """A pulse of a thousandth of the run, between two of the times that a formula is looked at."""
    narrow = 'forces.top.y={formula="exp(-((t - 1.50175)/0.0015)**2)"}'
    (curve,) = [c for c in curves(parse_case(PULLED, [narrow])) if c.where == "forces.top.y"]
    assert curve.values.max() == pytest.approx(1.0, abs=0.02)

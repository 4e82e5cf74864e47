"""Bodies that nothing heats or cools: joined hot, or still evening out."""

import numpy as np
import pytest

import staffa
from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case
from staffa.errors import InputError

# A layer of glass on steel, joined at 120 °C and now at 20 °C.
JOINED = """
[domain]
size = ["100 mm", "4 mm"]
h = "0.5 mm"
[material]
E = "200 GPa"
nu = 0.3
Gc = "1e7 J/m^2"
expansion = "17e-6 1/K"
k = "20 W/(m K)"
rho = "7800 kg/m^3"
c = "500 J/(kg K)"
[regions.glass]
lower = ["0 mm", "2.5 mm"]
upper = ["100 mm", "4 mm"]
E = "64 GPa"
nu = 0.2
expansion = "3.25e-6 1/K"
[damage]
ell = "2 mm"
[temperature]
profile = "heat"
face = "bottom"
[heat]
initial = "20 °C"
stress_free = "120 °C"
[time]
t = ["1 s"]
[output]
probes = [{ name = "l", start = ["0 mm", "0 mm"], end = ["100 mm", "0 mm"], points = 11 }]
"""


def timoshenko(thick: tuple[float, float], E: tuple[float, float], strain: float) -> float:
    """Curvature (1/m) of two layers that are joined (J. Opt. Soc. Am. 11, 233, 1925, eq. 4)."""
    h, m, n = sum(thick), thick[0] / thick[1], E[0] / E[1]
    return 6 * strain * (1 + m) ** 2 / (h * (3 * (1 + m) ** 2 + (1 + m * n) * (m**2 + 1 / (m * n))))


@pytest.mark.slow
def test_layers_joined_hot_bend_as_timoshenko_says(tmp_path) -> None:
    case = parse_case(JOINED)
    steps = staffa.run(case, tmp_path / "run")
    x = np.linspace(0.0, 0.1, 11)
    u = np.array(steps[-1].probed)[:, 2]
    middle = slice(2, 9)  # away from the free ends
    found = abs(2 * np.polyfit(x[middle], u[middle], 2)[0])
    expected = timoshenko((2.5e-3, 1.5e-3), (200e9, 64e9), (17e-6 - 3.25e-6) * 100.0)
    assert expected == pytest.approx(0.3688, abs=1e-4)
    assert found == pytest.approx(expected, rel=0.01), f"{found:.4f}, by Timoshenko {expected:.4f}"
    assert steps[-1].audit.violations == ()


@pytest.mark.parametrize(
    "given",
    [
        'heat.initial={value="20 °C", gradient=["0 K/m", "-100 K/m"]}',
        'heat.initial={formula="293 + 10*y"}',
    ],
)
def test_a_body_that_evens_out_needs_no_side(given: str) -> None:
    """MOOSE issue 9291: a body that starts at an uneven temperature, free of strain there."""
    case = parse_case(JOINED.replace('stress_free = "120 °C"', ""), (given,))
    assert case.heat is not None and case.heat.stress_free is None


@pytest.mark.slow
def test_an_uneven_body_evens_out_and_is_strained_by_that_alone(tmp_path) -> None:
    """MOOSE issue 9291, and GEOS pull request 3568: strain counts from the uneven start."""
    given = (
        'heat.initial={value="20 °C", gradient=["0 K/m", "10 K/mm"]}',
        'heat.stress_free={value="20 °C", gradient=["0 K/m", "10 K/mm"]}',
        'time.t=["1 us", "100 s"]',
        "domain.size=['20 mm', '4 mm']",
        "domain.h=0.25 mm",
        "damage.ell=1 mm",
        "regions={}",
        "supports.section=stretch",
        'output.probes=[{name="p", point=["10 mm", "0 mm"]}]',
    )
    first, last = staffa.run(parse_case(JOINED, given), tmp_path / "run")
    (T, *_), (T_end, *_) = first.probed[0], last.probed[0]
    assert pytest.approx(0.0, abs=0.1) == T and T_end == pytest.approx(20.0, rel=1e-4)
    held = 200e9 * (17e-6 * 40.0) ** 2 / 24 * 20e-3 * 4e-3  # it may not bend
    assert first.energies.elastic < 1e-4 * held
    # Linear elements cannot follow the strain across: off by about 2 (h/H)^2.
    assert last.energies.elastic == pytest.approx(held, rel=0.01)


def test_a_body_that_was_joined_hot_is_not_told_to_cool_more() -> None:
    said = preview(parse_case(JOINED))
    assert not any("raise the drop" in sentence for sentence in said.warnings), said.warnings
    assert any("strained from the start" in meaning for _, _, meaning in said.facts)


@pytest.mark.parametrize("stress_free", ['"20 °C"', '"293.15 K"', '"68 degF"'])
def test_a_body_that_nothing_strains_is_refused(stress_free: str) -> None:
    with pytest.raises(InputError, match="heats and cools nothing"):
        parse_case(JOINED, (f"heat.stress_free={stress_free}",))

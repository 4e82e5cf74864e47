"""The table [forces] of a case: what it becomes, which split it takes, and a run with all of it."""

import numpy as np
import pytest

from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case
from staffa.case.reading.ready_cases import ready_case
from staffa.case.schema.toml_text import to_toml
from staffa.case.values.applied_forces import forces

CASE = """
title = "squeezed"
[domain]
size = ["2 m", "1 m"]
h = "0.1 m"
[material]
plane = "strain"
E = "50 GPa"
nu = 0.25
Gc = "80 J/m^2"
expansion = "8e-6 1/K"
kappa = "1e-6 m^2/s"
rho = "2700 kg/m^3"
[damage]
ell = "0.3 m"
[temperature]
dT = "20 K"
[supports]
left = "rollers"
right = "rollers"
top = "rollers"
[forces]
gravity = ["0 m/s^2", "-10 m/s^2"]
pore_pressure = { formula = "1e6 - 1e4*y" }
biot = 0.5
crack_pressure = { t = ["0 s", "1 h"], value = ["0 MPa", "1 MPa"] }
[forces.prestress]
xx = "-5 MPa"
yy = { value = "-10 MPa", gradient = ["0 Pa/m", "0.03 MPa/m"] }
zz = "-6 MPa"
xy = { formula = "1e3*x*y" }
[forces.bottom]
pressure = "10 MPa"
x = { formula = "2e6*x*t/3600" }
[time]
t = ["1 h", "2 h"]
"""


def test_what_it_becomes() -> None:
    """Numbers at points and times, as written."""
    found = forces(parse_case(CASE))
    x = np.array([[0.0, 2.0], [0.0, 0.5], [0.0, 0.0]])
    assert found.gravity == (0.0, -10.0)
    assert found.prestress is not None and found.pore_pressure is not None
    assert found.crack_pressure is not None and found.crack_volume is None
    expected = np.array([[-5e6, -5e6], [-10e6, -9.985e6], [-6e6, -6e6], [0, 0], [0, 0], [0, 1e3]])
    assert found.prestress(x) == pytest.approx(expected)
    assert found.pore_pressure(x, 0.0) == pytest.approx([1e6, 0.995e6])
    assert found.biot == 0.5
    assert [found.crack_pressure(t) for t in (0.0, 1800.0, 7200.0)] == [0.0, 0.5e6, 1e6]
    (bottom,) = found.sides
    assert bottom.side == "bottom" and bottom.pressure is not None and bottom.force is not None
    assert bottom.pressure(x, 0.0) == pytest.approx([10e6, 10e6])
    assert bottom.force(x, 1800.0) == pytest.approx(np.array([[0.0, 2e6], [0.0, 0.0]]))


def test_pressures_of_place_and_time() -> None:
    text = CASE.replace('{ formula = "1e6 - 1e4*y" }', '{ formula = "1e6 - 1e4*y + 10*t" }')
    given = '{ t = ["0 s", "1 h"], value = ["0 MPa", "1 MPa"] }'
    text = text.replace(given, '{ formula = "2e5*x*t/3600" }')
    found = forces(parse_case(text))
    x = np.array([[0.0, 2.0], [0.0, 0.5], [0.0, 0.0]])
    assert found.pore_pressure(x, 100.0) == pytest.approx([1.001e6, 0.996e6])
    assert found.crack_pressure is None
    assert found.crack_field(x, 1800.0) == pytest.approx([0.0, 2e5])


def test_it_reads_back() -> None:
    """As resolved, with the split that it takes."""
    case = parse_case(CASE)
    assert case.damage.split == "no-tension"
    assert parse_case(to_toml(case)) == case
    assert parse_case(to_toml(case, explained=True)) == case


def test_forces_without_pores_read_back() -> None:
    """Nothing is said of pores that would have no meaning without a pressure in them."""
    pores = CASE[CASE.index("pore_pressure") : CASE.index("crack_pressure")]
    case = parse_case(CASE.replace(pores, ""))
    assert case.forces is not None and case.forces.pore_pressure is None
    assert parse_case(to_toml(case)) == case


def split_fact(case) -> tuple[str, str]:
    """The words of check on the split."""
    ((value, meaning),) = (f[1:] for f in preview(case).facts if f[0] == "energy split")
    return value, meaning


@pytest.mark.parametrize(
    ("settings", "split", "why"),
    [
        (
            (),
            "no-tension",
            "forces (prestress, gravity, pore_pressure, crack_pressure, bottom) may press",
        ),
        (("material.nu=-0.1",), "volumetric-deviatoric", "may press cracks shut"),
        (('damage.split="star-convex"',), "star-convex", "may press cracks shut"),
    ],
)
def test_check_says_which_split_and_why(settings, split: str, why: str) -> None:
    """As a fact."""
    facts = {
        name: (value, meaning) for name, value, meaning in preview(parse_case(CASE, settings)).facts
    }
    value, meaning = facts["energy split"]
    assert value == split and why in meaning


def test_cold_alone_takes_no_split() -> None:
    """And says so."""
    value, meaning = split_fact(ready_case("slab"))
    assert value == "none" and "only cooling acts" in meaning

"""Rock whose E, nu, Gc and expansion depend on temperature: energies, strains, what cracks cost."""

import numpy as np
import pytest

import staffa
from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case
from staffa.evolution.system import build
from staffa.io.run_directory import open_run
from staffa.runs.resume import resume
from staffa.runs.run import Watcher, run
from support.restarting import After, stopped

# A plate between rollers that is heated evenly by a source, so that its temperature is known.
EVEN = """
[domain]
size = ["20 mm", "10 mm"]
h = "5 mm"
[material]
E = "70 GPa"
nu = 0.2
Gc = "1e6 J/m^2"
expansion = "8e-6 1/K"
k = "3 W/(m K)"
rho = "2500 kg/m^3"
c = "800 J/(kg K)"
[damage]
ell = "8 mm"
split = "none"
[temperature]
profile = "heat"
face = "top"
[heat]
initial = "20 °C"
source = "2e6 W/m^3"
[supports]
left = "rollers"
right = "rollers"
bottom = "rollers"
[time]
t = ["100 s", "200 s", "300 s"]
[output]
probes = [{ name = "p", point = ["10 mm", "5 mm"] }]
"""
RATE = 2e6 / (2500 * 800)  # K/s


def heated(tmp_path, *settings: str, text: str = EVEN):
    """The steps of the case with settings put over it, each with nothing amiss."""
    steps = staffa.run(parse_case(text, settings), tmp_path / "run")
    for step in steps:
        assert step.audit.violations == (), step.audit.violations
        assert step.heat.imbalance < 1e-8
    return steps


def held(E: float, strain: float) -> float:
    """Energy (J/m) of the plate whose length is held, in plane stress, at a free strain."""
    return E * strain**2 / 2 * 20e-3 * 10e-3


def test_energy_is_that_of_the_modulus_at_the_temperature(tmp_path) -> None:
    """PeriLab issue 343, Kratos issue 7641: E of temperature, here a table."""
    table = 'material.E={T=["20 °C","120 °C","320 °C"], value=["70 GPa","60 GPa","20 GPa"]}'
    factor = "material.nu={T=['20 °C','320 °C'], value=[0.2,0.3]}"
    for step in heated(tmp_path, table, factor):
        T = RATE * step.time
        assert step.probed[0][0] == pytest.approx(T, rel=1e-5)
        E = np.interp(T, [0, 100, 300], [70e9, 60e9, 20e9])
        assert step.energies.elastic == pytest.approx(held(E, 8e-6 * T), rel=1e-5)
        assert step.audit.balance < 1e-12


FORMS = {
    "tangent table": '{T=["20 °C","420 °C"], value=["8e-6 1/K","16e-6 1/K"]}',
    "secant table": '{T=["20 °C","420 °C"], value=["8e-6 1/K","12e-6 1/K"], secant="20 °C"}',
    "tangent formula": '{formula="8e-6 + 2e-8*(T - 293.15)"}',
    "secant formula": '{formula="8e-6 + 1e-8*(T - 293.15)", secant="20 °C"}',
}


@pytest.mark.parametrize(
    "form",
    [
        "secant table",
        "tangent formula",
        pytest.param("tangent table", marks=pytest.mark.long),
        pytest.param("secant formula", marks=pytest.mark.long),
    ],
)
def test_tangent_and_secant_expansion_give_one_strain(form: str, tmp_path) -> None:
    """WARP3D issue 7, MOOSE issue 4717: with secant coefficients the strain is
    alpha(T) (T - ref) - alpha(T0) (T0 - ref), here of a body that is free of stress at 120 °C."""
    for step in heated(
        tmp_path,
        f"material.expansion={FORMS[form]}",
        "heat.initial=120 °C",
        "time.t=['100 s', '200 s']",
    ):
        T = 100.0 + RATE * step.time  # above 20 °C
        strain = (8e-6 * T + 1e-8 * T**2) - (8e-6 * 100 + 1e-8 * 100**2)
        assert step.energies.elastic == pytest.approx(held(70e9, strain), rel=1e-5)


def test_secant_expansion_is_zero_where_the_body_is_free_of_stress(tmp_path) -> None:
    """GEOS pull request 3568: no thermal stress before temperature changes, whatever `secant`."""
    given = 'material.expansion={formula="8e-6 + 1e-8*(T - 293.15)", secant="800 °C"}'
    first, *_ = heated(tmp_path, given, "heat.source=1e-6 W/m^3", "time.t=['1 s']")
    assert first.energies.elastic < 1e-12


def test_properties_of_temperature_differ_by_region_and_place(tmp_path) -> None:
    """Two halves in parallel, each with another law, one with a factor by place too."""
    steps = heated(
        tmp_path,
        'material.E={formula="70e9*(1 + 20*(y - 0.0025))*(1 - 1e-3*(T - 293.15))"}',
        "material.nu=0.0",
        "domain.size=['20 mm', '10 mm']",
        'regions={upper={lower=["0 mm","5 mm"], upper=["20 mm","10 mm"], '
        'E={T=["20 °C","320 °C"], value=["10 GPa","40 GPa"], '
        'factor={formula="1 + 20*(y - 0.0075)"}}}}',
    )
    for step in steps:
        T = RATE * step.time
        E = (70e9 * (1 - 1e-3 * T) + (10e9 + 1e8 * T)) / 2
        assert step.energies.elastic == pytest.approx(held(E, 8e-6 * T), rel=1e-5)


def test_prestress_is_that_of_the_rock_at_the_start(tmp_path) -> None:
    """The strain of the prestress is that of E before the first step: softening relaxes it."""
    steps = heated(
        tmp_path,
        'material.E={T=["20 °C","320 °C"], value=["70 GPa","35 GPa"]}',
        "material.nu=0.0",
        "material.expansion=1e-9 1/K",
        'forces.prestress={xx="-10 MPa"}',
        "damage.split=none",
    )
    for step in steps:
        softer = 1 - 0.5 * RATE * step.time / 300
        strain = 10e6 / 70e9
        expected = held(softer * 70e9, strain + 1e-9 * RATE * step.time) - held(70e9, strain)
        assert step.energies.elastic == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(
    "given, said",
    [
        ("heat.initial=420 °C", "ends at 320 °C, and temperatures at 420 °C"),
        ("heat.initial=0 °C", "begins at 20 °C, and temperatures at 0 °C"),
        ("heat.initial=320 °C", ""),
    ],
)
def test_check_warns_of_a_table_that_ends_too_early(given: str, said: str) -> None:
    table = 'material.E={T=["20 °C","320 °C"], value=["70 GPa","60 GPa"]}'
    found = [w for w in preview(parse_case(EVEN, (given, table))).warnings if "the table" in w]
    assert len(found) == bool(said)
    assert all(w.startswith("material.E: the table") and said in w for w in found), found


@pytest.mark.slow
def test_a_split_keeps_its_balance_where_the_stiffness_changes(tmp_path) -> None:
    """A heated plate between rollers is only pressed, and carries it with the E of its heat."""
    table = 'material.E={T=["20 °C","120 °C","320 °C"], value=["70 GPa","60 GPa","20 GPa"]}'
    nu = "material.nu={T=['20 °C','320 °C'], value=[0.2,0.3]}"
    weak = ("material.Gc=10 J/m^2", "damage.split=no-tension")
    for step in heated(tmp_path, table, nu, *weak):
        T = RATE * step.time
        E = np.interp(T, [0, 100, 300], [70e9, 60e9, 20e9])
        assert step.energies.surface < 1e-12
        assert step.energies.elastic == pytest.approx(held(E, 8e-6 * T), rel=1e-5)


def test_thermal_power_has_the_slopes_of_all_laws() -> None:
    """dE/dT, dnu/dT, dGc/dT beyond what is spent, and expansion: by differences of the energy."""
    system = build(staffa.problem(parse_case(CRACKING, ('material.nu={formula="0.1 + 3e-4*T"}',))))
    energy, state, seeded = system.energy, system.state, np.random.default_rng(1)
    state.u.x.array[:] = 1e-5 * seeded.normal(size=state.u.x.array.size)
    state.T.x.array[:] = -200 * seeded.uniform(size=state.T.x.array.size)
    state.alpha.x.array[:] = seeded.uniform(0.1, 0.4, size=state.alpha.x.array.size)
    energy.book()
    spent = energy.energies().surface
    direction = seeded.uniform(size=state.T.x.array.size)
    energy.direction.x.array[:] = direction

    def slope(of) -> float:
        """Its derivative along `direction`, by central differences."""
        step, start = 1e-3, state.T.x.array.copy()
        found = []
        for sign in (1, -1):
            state.T.x.array[:] = start + sign * step * direction
            found.append(of())
        state.T.x.array[:] = start
        return (found[0] - found[1]) / (2 * step)

    assert energy.thermal_power() == pytest.approx(slope(energy.total), rel=1e-6)
    assert abs(slope(lambda: energy.energies().surface)) < 1e-9 * spent, "what is spent stays"
    state.alpha.x.array[:] += 0.3
    of_surface = slope(lambda: energy.energies().surface)
    assert of_surface > 1e-4 * spent, "new damage costs what Gc is now"
    assert energy.thermal_power() == pytest.approx(slope(energy.total), rel=1e-6)
    system.destroy()


# A notched plate that cools until it cracks, and warms again.
CRACKING = """
[domain]
size = ["40 mm", "20 mm"]
h = "2 mm"
[material]
E = { T = ["20 °C", "420 °C"], value = ["70 GPa", "50 GPa"] }
nu = 0.2
Gc = { T = ["20 °C", "420 °C"], value = ["10 J/m^2", "30 J/m^2"] }
expansion = { T = ["20 °C", "420 °C"], value = ["8e-6 1/K", "12e-6 1/K"] }
k = { T = ["20 °C", "420 °C"], value = ["3 W/(m K)", "2 W/(m K)"] }
rho = "2500 kg/m^3"
c = { formula = "800 + 0.5*(T - 293.15)" }
[damage]
ell = "6 mm"
split = "none"
[toughness]
amplitude = 0.1
seed = 1
[temperature]
profile = "heat"
face = "bottom"
[heat]
initial = "420 °C"
bottom = { h = { T = ["20 °C","120 °C","140 °C","250 °C"], value = ["500 W/(m^2 K)","2000 W/(m^2 K)","9000 W/(m^2 K)","400 W/(m^2 K)"] }, T = { t = ["0 s","60 s","61 s"], value = ["20 °C","20 °C","400 °C"] } }
[supports]
left = "rollers"
right = "rollers"
[time]
t = ["20 s", "60 s", "120 s", "3000 s"]
[solver]
guess = "none"
"""  # noqa: E501


@pytest.mark.slow
def test_a_cracked_body_that_warms_again_has_spent_what_it_had(tmp_path) -> None:
    """Surface energy counts at the toughness of the time when cracks grew."""
    steps = heated(tmp_path, text=CRACKING)
    surfaces = [step.energies.surface for step in steps]
    assert surfaces[1] > 0.1, "it must have cracked"
    # To what the solvers leave: the toughness of 400 °C is 1.5 times that of the time of growth.
    assert surfaces[3] == pytest.approx(surfaces[2], rel=1e-6)
    assert steps[3].energies.elastic < 0.1 * steps[1].energies.elastic
    lengths = [step.measures.length_surface for step in steps]
    assert lengths[3] == pytest.approx(lengths[2], rel=1e-6)


@pytest.mark.long
def test_a_run_that_goes_on_gives_the_same_bits(tmp_path) -> None:
    case = parse_case(CRACKING, ("time.t=['20 s', '60 s', '90 s']",))
    whole = run(case, tmp_path / "whole")
    stopped(lambda: run(case, tmp_path / "cut", watcher=Watcher(stop=After(10))))
    resume(tmp_path / "cut")
    found = open_run(tmp_path / "cut").steps
    assert len(open_run(tmp_path / "whole").steps) == len(found) == len(whole)
    for one, other in zip(whole, found, strict=True):
        assert other.energies == one.energies and other.heat == one.heat


def surfaces_of_cracking(out) -> list[tuple[float, float, float]]:
    """Surface and elastic energy and heat of the cracked plate, step by step."""
    case = parse_case(CRACKING, ("time.t=['20 s', '60 s']",))
    steps = staffa.run(case, out)
    return [(s.energies.surface, s.energies.elastic, s.heat.stored) for s in steps]

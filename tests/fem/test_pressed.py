"""Pressed rock does not break: the default split, and what is said of steps without one."""

from math import sqrt
from pathlib import Path

import numpy as np
import pytest

import staffa
from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case, read_case
from staffa.case.values.pressing_loads import pressing
from staffa.physics.damage import LAWS, strength
from staffa.physics.split import SPLITS
from staffa.records.step import Step
from support.bodies import needs_gmsh
from support.meshes import written

# The four inputs that broke under pressure, with the values that are right for them.
PUSHED_BAR = """
[domain]
size = [1.0, 0.3]
h = 0.02
[material]
E = 100.0
nu = 0.3
Gc = 1.0
[damage]
ell = 0.1
[temperature]
profile = "none"
[supports]
left = "rollers"
right = { x = { t = [0.0, 1.0], u = [0.0, -0.3] } }
[time]
t = [0.6, 0.7, 1.0]
"""

HOT_PLATE = """
[domain]
size = ["0.4 m", "0.1 m"]
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
ell = "15 mm"
[temperature]
profile = "heat"
face = "bottom"
[heat]
initial = "20 °C"
bottom = { T = { t = ["0 s", "2 hours"], value = ["20 °C", "80 °C"] } }
top = { T = { t = ["0 s", "2 hours"], value = ["20 °C", "80 °C"] } }
[supports]
left = "rollers"
right = "rollers"
[time]
t = ["1 hour", "2 hours"]
"""

IR_DISC = """
[domain]
shape = { kind = "disc", radius = "5 mm" }
h = "0.16 mm"
[material]
E = "350 GPa"
nu = 0.22
Gc = "35 J/m^2"
expansion = "8e-6 1/K"
k = "25 W/(m K)"
rho = "3900 kg/m^3"
c = "900 J/(kg K)"
[damage]
ell = "0.48 mm"
[temperature]
profile = "heat"
face = "side"
[heat]
initial = "20 °C"
source = { formula = "2.4e9*exp(-(x**2+y**2)/0.002**2)" }
side = { h = "50 W/(m^2 K)", T = "20 °C" }
[time]
t = ["0.2 s", "0.6 s"]
"""

BRAZILIAN = """
[domain]
mesh = "disc.msh"
[material]
nu = 0.2
[damage]
ell = 0.075
[temperature]
profile = "none"
[supports]
"lower platen" = { x = 0.0, y = 0.0 }
"upper platen" = { x = 0.0, y = { t = [0.0, 1.0], u = [0.0, -30.0] } }
[time]
t = [0.7, 0.75]
"""


def ran(text: str, *settings: str, folder: Path = Path()) -> list[Step]:
    """The steps of a case; what its audit finds violated is an error here."""
    problem = staffa.problem(parse_case(text, settings, folder=folder))
    system = staffa.build(problem)
    steps = list(staffa.march(problem, system))
    system.destroy()
    assert not any(step.audit.violations for step in steps)
    return steps


def test_a_pushed_bar_carries_all_of_its_load() -> None:
    """E eps A at a strain of -0.3, where without a split it broke at -0.194."""
    *_, last = ran(PUSHED_BAR)
    assert last.energies.surface == 0
    assert last.reactions["left"][0] == pytest.approx(9.0, rel=1e-6)
    assert last.audit.notes == ()


def test_a_heated_plate_between_rollers_does_not_break() -> None:
    """It is pressed alone: what the elastic solution stores, and its reaction."""
    *_, last = ran(HOT_PLATE)
    assert last.energies.surface == 0
    assert last.energies.elastic == pytest.approx(142.12, rel=1e-4)
    assert last.reactions["left"][0] == pytest.approx(2.1474e6, rel=1e-4)


@needs_gmsh
def test_a_disc_heated_in_its_middle_is_whole_as_long_as_its_edge_holds() -> None:
    """The hot middle is pressed; 0.984 J/m at 0.6 s."""
    *_, last = ran(IR_DISC)
    assert last.energies.surface == 0
    assert last.energies.elastic == pytest.approx(0.984, rel=2e-3)


def disc(gmsh) -> None:
    """A disc of radius 1, with platens over 8 degrees on either side of its vertical axis."""
    geo, model = gmsh.model.geo, gmsh.model
    middle = geo.addPoint(0, 0, 0)
    ends = np.radians([-82.0, 0.0, 82.0, 98.0, 180.0, 262.0])
    points = [geo.addPoint(np.cos(a), np.sin(a), 0) for a in ends]
    arcs = [geo.addCircleArc(points[k], middle, points[(k + 1) % 6]) for k in range(6)]
    rock = geo.addPlaneSurface([geo.addCurveLoop(arcs)])
    geo.synchronize()
    for tag, name, arc in ((10, "upper platen", arcs[2]), (11, "lower platen", arcs[5])):
        model.addPhysicalGroup(1, [arc], tag)
        model.setPhysicalName(1, tag, name)
    model.addPhysicalGroup(2, [rock], 1)
    model.setPhysicalName(2, 1, "rock")


def load(step: Step) -> float:
    """Motion of the upper platen, downwards."""
    return -step.reactions["upper platen"][1]


@needs_gmsh
def test_a_brazilian_disc_is_not_crushed_at_its_platens(tmp_path: Path) -> None:
    """It bears more than 2 P/(pi D) = sigma_c/sqrt(1 - nu^2), P = 7.17, at which its middle breaks
    if stresses there were even; without a split it is crushed at a thirtieth of that."""
    written(tmp_path / "disc.msh", disc, h=0.025)
    (step,) = ran(BRAZILIAN, "time.t=[0.7]", folder=tmp_path)
    assert step.energies.surface < 1e-6
    assert load(step) == pytest.approx(7.39, rel=0.01)


@needs_gmsh
@pytest.mark.long
def test_a_brazilian_disc_splits_from_its_middle(tmp_path: Path) -> None:
    """At a load between 7.39 and 7.9; cracks beside that of the middle may follow in the step."""
    written(tmp_path / "disc.msh", disc, h=0.025)
    problem = staffa.problem(parse_case(BRAZILIAN, folder=tmp_path))
    system = staffa.build(problem)
    before, after = staffa.march(problem, system)
    assert 7.17 < load(before) < 7.9 and load(after) < 0.7 * load(before)
    alpha = system.state.alpha
    x = alpha.function_space.tabulate_dof_coordinates()
    assert alpha.x.array[np.hypot(x[:, 0], x[:, 1]) < 0.1].max() > 0.95
    system.destroy()


# Two inputs of public reports.

BIMATERIAL = """
[domain]
size = [0.4, 0.2]
h = 0.02
[material]  # glass
E = 70.0
nu = 0.22
Gc = 2e-6
expansion = 8e-6
k = 1.0
[regions.steel]
lower = [0.0, 0.1]
upper = [0.4, 0.2]
E = 200.0
nu = 0.22
Gc = 1.0
expansion = 12e-6
[damage]
ell = 0.06
[temperature]
profile = "heat"
face = "bottom"
[heat]
initial = 0.0
bottom = { T = { t = [0.0, 1.0], value = [0.0, -200.0] } }
top = { T = { t = [0.0, 1.0], value = [0.0, -200.0] } }
[supports]
section = "stretch"
[time]
t = [0.5, 3.0]
"""


def layers() -> tuple[float, float, float]:
    """Stresses of glass and of steel, and the energy: sum of E_i (eps + a_i dT) h_i = 0."""
    E, a, h, drop, width = np.array([70.0, 200.0]), np.array([8e-6, 12e-6]), 0.1, 200.0, 0.4
    eps = -float(E @ a) * drop / E.sum()
    stress = E * (eps + a * drop)
    return *stress.tolist(), float((stress**2 / (2 * E)).sum() * h * width)


def test_glass_fused_to_steel_that_cools_is_pressed_and_whole() -> None:
    """After the bimaterial beam of github.com/hugary1995/raccoon, pull request 91: two layers of
    one plate that expand unlike one another, cooled evenly, free to shorten but not to bend. The
    glass is pressed by more than it bears in tension."""
    case = parse_case(BIMATERIAL)
    glass, steel, energy = layers()
    bears = strength(LAWS["AT1"], E=70.0, Gc=2e-6, ell=0.06)
    assert glass < -1.3 * bears and steel > 0
    assert pressing(case) == ("thermal mismatch (regions.steel.expansion)",)
    *_, last = ran(BIMATERIAL)
    assert last.energies.surface == 0
    assert last.energies.elastic == pytest.approx(energy, rel=1e-3)
    broken = ran(BIMATERIAL, "damage.split=none")
    assert broken[-1].energies.surface > 0
    assert any("pressed rock: " in note for step in broken for note in step.audit.notes)


HOT_CORE = """
[domain]
shape = { kind = "disc", radius = 1.0 }
h = 0.06
[material]
nu = 0.2
Gc = 1.0
expansion = 1.0
[damage]
ell = 0.18
[temperature]
profile = "heat"
face = "side"
[heat]
initial = { formula = "3.2*exp(-(x**2+y**2)/0.16)" }
stress_free = 0.0
side = { T = 0.0 }
[time]
t = [1e-6]
"""


@needs_gmsh
def test_a_hot_core_is_pressed_and_whole() -> None:
    """After danielchou0916.github.io/fem_benchmarks/pff/3_disk, a disc with a heated core.

    Of a free disc in plane stress, with M(r) = int_0^r T s ds/r^2: the middle is pressed by
    E a (T(0)/2 - M(R)), and the disc stores E a^2/2 (int T^2 dA - (int T dA)^2/(pi R^2)).
    """
    core, top = 0.4**2, 3.2  # T = top exp(-r^2/core), R = 1
    mean, square = (top**n * core / n * (1 - np.exp(-n / core)) for n in (1, 2))  # over pi
    p = top / 2 - mean / 2
    bears = strength(LAWS["AT1"], E=1.0, Gc=1.0, ell=0.18)
    # The biaxial pressure p of the core stores as much as a tension of p sqrt(2 (1 - nu)).
    assert p * sqrt(2 * (1 - 0.2)) > 1.15 * bears
    assert pressing(parse_case(HOT_CORE)) == (
        "an uneven start (heat.initial)",
        "a start above heat.stress_free",
    )
    (step,) = ran(HOT_CORE)
    assert step.energies.surface == 0
    assert step.energies.elastic == pytest.approx(np.pi / 2 * (square - mean**2), rel=0.01)
    (without,) = ran(HOT_CORE, "damage.split=none")
    assert without.energies.surface > 0
    assert len(without.audit.notes) == 1


# --- which loads may press rock ---

COOLED = """
[domain]
size = [1.0, 1.0]
h = 0.1
[material]
nu = 0.2
[damage]
ell = 0.3
[temperature]
profile = "heat"
[heat]
initial = 1.0
bottom = { T = 0.0 }
[time]
t = { start = 0.1, stop = 1.0, steps = 3 }
"""

# What is set, and what presses then; nothing where that is empty.
LOADS = [
    ((), ()),
    (("heat.bottom={h=10.0, T=0.0}",), ()),
    (("heat.bottom={T={t=[0.0, 0.5], value=[1.0, 0.0]}}",), ()),
    (("heat.bottom={T={formula='exp(-t)'}}",), ()),
    (("heat.bottom={flux=-1.0}",), ()),
    (("heat.source=-1.0",), ()),
    (("heat.cracks={h=1.0, T=0.5}",), ("warming up again (heat.cracks)",)),
    (("heat.cracks={h=1.0, T=0.0}",), ()),
    (("heat.stress_free=2.0",), ()),
    (("heat.bottom={T=1.5}",), ("heating (heat.bottom)",)),
    (("heat.bottom={T={formula='1.2*x'}}",), ("heating (heat.bottom)",)),
    (("heat.top={flux={formula='sin(10*t)'}}",), ("heating (heat.top)",)),
    (("heat.source=0.1",), ("heating (heat.source)",)),
    (("heat.cracks={h=1.0, T=2.0}",), ("heating (heat.cracks)",)),
    (
        ("heat.bottom={T={t=[0.0, 0.5, 0.9], value=[1.0, 0.0, 1.0]}}",),
        ("warming up again (heat.bottom)",),
    ),
    (
        ("heat.bottom={T=0.0, h={t=[0.0, 1.0], value=[2.0, 1.0]}}",),
        ("warming up again (heat.bottom)",),
    ),
    (
        ("heat.bottom={flux={t=[0.0, 1.0], value=[-1.0, 0.0]}}",),
        ("warming up again (heat.bottom)",),
    ),
    (("heat.initial={formula='1 + x'}",), ("an uneven start (heat.initial)",)),
    (("heat.stress_free=0.5",), ("a start above heat.stress_free",)),
    (("heat.stress_free={formula='2 + x'}",), ("an uneven heat.stress_free",)),
    (
        ("material.expansion={formula='1 + x'}",),
        ("thermal mismatch (material.expansion)",),
    ),
    (("material.expansion=[1.0, 2.0]",), ("thermal mismatch (material.expansion)",)),
    (("material.expansion=[1.0, 1.0]",), ()),
    (
        ("regions.clay={lower=[0.0, 0.0], upper=[1.0, 0.5], expansion=2.0}",),
        ("thermal mismatch (regions.clay.expansion)",),
    ),
    (("regions.clay={lower=[0.0, 0.0], upper=[1.0, 0.5], E=2.0}",), ()),
    (("supports.top={y=-0.1}",), ("supports that move (top)",)),
    (("supports.top={y=0.1}",), ("supports that move (top)",)),
    (("supports.top={y=0.0}",), ()),
    (("forces.top={pressure=1.0}",), ("forces (top)",)),
    (
        ("forces.gravity=[0.0, -1.0]", "supports.bottom='rollers'", "heat.bottom={T=1.5}"),
        ("forces (gravity)", "heating (heat.bottom)"),
    ),
]


@pytest.mark.parametrize(("settings", "reasons"), LOADS)
def test_what_may_press_the_rock_gives_it_a_safe_split(settings, reasons) -> None:
    """From the loads at all times; what only cools takes none. `check` says which, and why."""
    case = parse_case(COOLED, settings)
    assert pressing(case) == reasons
    assert case.damage.split == ("no-tension" if reasons else "none")
    ((value, meaning),) = (f[1:] for f in preview(case).facts if f[0] == "energy split")
    assert value == case.damage.split and meaning.startswith("by default, as ")
    assert all(reason in meaning for reason in reasons or ("only cooling acts",))


@pytest.mark.parametrize("profile", ["half-space", "slab", "convective"])
def test_closed_forms_of_cooling_take_no_split(profile: str) -> None:
    """Their face is never warmer than before."""
    text = COOLED.replace("[heat]\ninitial = 1.0\nbottom = { T = 0.0 }\n", "")
    biot = ["temperature.biot=10.0"] if profile == "convective" else []
    case = parse_case(text, [f"temperature.profile={profile}", "temperature.dT=2.0", *biot])
    assert case.damage.split == "none"


@pytest.mark.parametrize(
    ("rock", "kind"),
    [("material.nu=-0.1", "with nu < 0"), ("material={E=[1,2], nu=[0.2], G=[1]}", "anisotropic")],
)
def test_rock_that_takes_no_safe_split_is_warned_of(rock: str, kind: str) -> None:
    """It breaks under pressure all the same."""
    case = parse_case(COOLED, ["heat.bottom={T=1.5}", rock])
    assert case.damage.split == "volumetric-deviatoric"
    (said,) = (w for w in preview(case).warnings if "volumetric-deviatoric" in w)
    assert f"rock that is {kind} takes no split that prevents it" in said


def test_no_split_is_warned_of_where_something_presses() -> None:
    """Not where a bar is only pulled."""

    def warned(*settings: str) -> bool:
        case = parse_case(PUSHED_BAR, ["damage.split=none", *settings])
        return any(w.startswith('damage.split = "none"') for w in preview(case).warnings)

    assert warned()
    assert not warned("supports.right={x={t=[0.0, 1.0], u=[0.0, 0.3]}}")
    assert warned("supports.right={x={t=[0.0, 1.0], u=[0.3, -0.1]}}")
    assert warned("supports.right={y=0.1}")


class Flash:
    """A load of a script."""

    def temperature(self, x, t):
        return 0.1 * t * x[0]


def test_a_load_of_a_script_may_press(tmp_path: Path) -> None:
    """Nothing is known of it, so that the split is safe, unless the case gives one; the run keeps
    which it was."""
    case = parse_case(COOLED, ["domain.h=0.5", "damage.ell=1.0", "time.t=[0.1]"])
    assert case.damage.split == "none"
    assert staffa.problem(case).material.split is SPLITS["none"]
    assert staffa.problem(case, temperature=Flash()).material.split is SPLITS["no-tension"]
    asked = parse_case(COOLED, ["domain.h=0.5", "damage={ell=1.0, split='none'}", "time.t=[0.1]"])
    assert staffa.problem(asked, temperature=Flash()).material.split is SPLITS["none"]
    staffa.run(case, tmp_path / "run", temperature=Flash())
    assert read_case(tmp_path / "run" / "case.toml").damage.split == "no-tension"
    assert staffa.resume(tmp_path / "run", temperature=Flash())


# --- what a step without a split says ---


def test_a_step_in_which_pressed_rock_breaks_says_so_with_the_place() -> None:
    """Held against the split that is safe; where nothing grows, nothing is said."""
    whole, broken, after = ran(PUSHED_BAR, "damage.split=none")
    assert whole.audit.notes == ()
    (said,) = broken.audit.notes
    assert said.startswith("pressed rock: 100 % of the energy that drove damage")
    assert 'take damage.split = "no-tension"' in said
    x, y = (float(c) for c in said.split("at (")[1].split(")")[0].split(", "))
    assert 0 <= x <= 1 and 0 <= y <= 0.3
    assert after.audit.notes == ()  # broken through, it grows no more


def test_nothing_is_said_where_cold_cracks_rock_that_is_pulled() -> None:
    """Within 5 %: cracks are driven by the tension across them."""
    settings = ["domain.h=0.05", "damage.ell=0.15", "heat.initial=20.0", "time.t=[0.02, 0.1]"]
    steps = ran(COOLED, *settings, "supports.left=rollers", "supports.right=rollers")
    assert steps[-1].energies.surface > 0.1
    assert all(step.audit.notes == () for step in steps)


PRESSED_FACE = """
[domain]
size = ["3 m", "1.5 m"]
h = "40 mm"
[material]
E = "50 GPa"
nu = 0.25
Gc = "64.8 J/m^2"
expansion = "8e-6 1/K"
k = "3 W/(m K)"
rho = "2700 kg/m^3"
c = "800 J/(kg K)"
[damage]
ell = "120 mm"
[toughness]
amplitude = 0.1
seed = 1
[temperature]
profile = "heat"
face = "bottom"
[heat]
initial = "180 °C"
bottom = { h = "800 W/(m^2 K)", T = "40 °C" }
[supports]
left = "rollers"
right = "rollers"
top = "rollers"
[forces]
prestress = { xx = "-5 MPa" }
[time]
t = ["30 min", "1 h", "1.5 h"]
"""


@pytest.mark.slow
def test_the_last_of_newtons_steps_is_not_taken_whole_if_the_energy_rises_on_the_way() -> None:
    """Closed cracks hold one another: a direction of little slope led to 1e19 of the energy."""
    case = parse_case(PRESSED_FACE)
    problem = staffa.problem(case)
    steps = list(staffa.march(problem, staffa.build(problem)))
    assert [step.status for step in steps] == ["converged"] * 3
    for step in steps:
        assert step.audit.violations == (), step.audit.violations
        assert step.audit.largest_rise < 1e-9
    assert steps[-1].sweeps < 60, "it was 515, and 69 by alternation alone"

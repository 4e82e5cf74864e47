"""Warnings and notes of `staffa check` on chance, tables, supports, ell and the cooled depth."""

from math import erfc, exp, pi, sqrt

import pytest

from staffa.case.check.preview import Preview, preview
from staffa.case.reading import ready_cases
from staffa.case.reading.read import parse_case
from staffa.case.schema.quantity_text import amount, at_least, at_most
from staffa.errors import InputError

SLAB = """
[domain]
size = [2.0, 1.0]
h = 0.02
[material]
nu = 0.2
[damage]
ell = 0.06
[temperature]
profile = "slab"
severity = 10.0
[time]
tau = [0.03, 0.4]
"""
EVEN = "the rock is uniform and bottom is cooled evenly"
PULLED = """
[domain]
size = [1.0, 0.5]
h = 0.02
[damage]
ell = 0.06
[temperature]
profile = "none"
[supports]
left = { x = 0.0 }
right = { x = { t = [0.0, 1.0], u = [0.0, 3.0] } }
[time]
t = [0.5, 1.0]
"""


def said(*settings: str, text: str = SLAB) -> Preview:
    return preview(parse_case(text, settings))


def fact(known: Preview, name: str) -> tuple[str, str]:
    return next((value, meaning) for key, value, meaning in known.facts if key == name)


def evenly(*settings: str, text: str = SLAB) -> list[str]:
    return [w for w in said(*settings, text=text).warnings if w.startswith("the rock is uniform")]


def test_uniform_rock_under_even_loads_is_told_how_to_give_a_seed():
    (warning,) = evenly()
    assert warning.startswith(EVEN)
    assert "toughness.amplitude = 0.05, with toughness.seed = 1" in warning
    assert not evenly("toughness.amplitude=0.05", "toughness.seed=1")
    assert evenly("toughness.amplitude=0.0"), "as if it were not given"


@pytest.mark.parametrize(
    "decides",
    [
        "cracks=[{start=[1.0,0.0],end=[1.0,0.1]}]",
        "toughness.bands=[{lower=[0.9,0.0],upper=[1.1,0.1],factor=0.9}]",
        "material.Gc={mean=1.0, variation=0.1, length=0.2}",
        'material.E={formula="1 + 0.1*x"}',
        "regions.a={lower=[0.0,0.0],upper=[1.0,1.0],E=1.5}",
        "temperature.severity=2.0",  # nothing cracks
        'forces.prestress={xx={formula="-0.1*x"}}',
    ],
)
def test_of_rock_in_which_something_decides_it_is_not_said(decides):
    assert not evenly(decides)


@pytest.mark.parametrize(
    "even",
    [
        "toughness.bands=[{lower=[0.0,0.0],upper=[2.0,0.1],factor=0.9}]",
        "regions.a={lower=[0.0,0.5],upper=[2.0,1.0],E=1.5}",
        "domain.cells=triangle",
        "damage.law=AT2",
        'forces.prestress={xx={formula="-0.1*y"}}',
    ],
)
def test_what_is_the_same_all_along_the_face_decides_nothing(even):
    assert evenly(even)


def test_of_a_bar_pulled_evenly_it_is_said_if_the_bar_breaks():
    """sigma_c = sqrt(3/(8 * .06)) = 2.5 = its strain at E = 1; it is pulled to 3."""
    (warning,) = evenly(text=PULLED)
    assert warning.startswith("the rock is uniform and pulled evenly")
    less = "supports.right={x={t=[0.0,1.0],u=[0.0,2.4]}}"
    assert not evenly(less, text=PULLED)
    assert not evenly("supports.right={x=3.0, y=0.0}", text=PULLED)


def early(*settings: str, text: str = PULLED) -> list[str]:
    return [w for w in said(*settings, text=text).warnings if "the table ends" in w]


def test_a_table_of_displacements_that_ends_early_is_told():
    (warning,) = early("time.t=[0.5, 1.5]")
    assert warning == (
        "supports.right.x: the table ends at t = 1.0, and the run at t = 1.5: in between its value "
        "stays 3.0; if that is meant, give this value at the end of the run too"
    )
    assert not early(), "the table ends with the run"
    meant = "supports.right={x={t=[0.0,1.0,1.5],u=[0.0,3.0,3.0]}}"
    assert not early("time.t=[0.5, 1.5]", meant)


@pytest.mark.parametrize(
    ("setting", "where"),
    [
        ("forces.top={pressure={t=[0.0,1.0],value=[0.0,0.1]}}", "forces.top.pressure"),
        ("forces.top={x={t=[0.0,1.0],value=[0.0,0.1]}}", "forces.top.x"),
        ("forces.crack_pressure={t=[0.0,1.0],value=[0.0,0.1]}", "forces.crack_pressure"),
    ],
)
def test_so_is_every_table_of_forces(setting, where):
    known = early("time.t=[0.5,1.0,2.0]", "supports.right={x=0.1}", setting)
    assert [w.split(": ")[0] for w in known] == [where], known


@pytest.mark.parametrize(
    ("heat", "where"),
    [
        ("bottom={T={t=[0.0,0.01],value=[10.0,0.0]}}", "heat.bottom.T"),
        ("bottom={flux={t=[0.0,0.01],value=[0.0,-40.0]}}", "heat.bottom.flux"),
        ("bottom={h={t=[0.0,0.01],value=[1.0,9.0]},T=0.0}", "heat.bottom.h"),
        ("source={t=[0.0,0.01],value=[0.0,-4.0]}", "heat.source"),
        ("cracks={h=1.0,T={t=[0.0,0.01],value=[10.0,0.0]}}", "heat.cracks.T"),
    ],
)
def test_and_every_table_of_heat(heat, where):
    given = (f"heat={{initial=10.0, {heat}}}", "time={t=[0.0002,0.04]}")
    known = early('temperature={profile="heat"}', *given, text=SLAB)
    assert [w.split(": ")[0] for w in known] == [where], known


def test_a_table_in_a_case_that_counts_in_tau_is_held_against_the_time():
    """tau = .4 is t = tau^2 L^2/(4 kappa) = .04."""
    table = "forces.top={pressure={t=[0.0,0.02],value=[0.0,0.1]}}"
    (warning,) = early(table, text=SLAB)
    assert "ends at t = 0.02, and the run at t = 0.04" in warning
    assert not early(table.replace("0.02", "0.041"), text=SLAB)


@pytest.mark.parametrize(
    ("setting", "rule"),
    [
        ("solver.residual=1e6", "solver.residual = 1e6: it must lie between 1e-08 and 0.9"),
        ("solver.residual=1.0", "no force starts a crack, and a step ends undamaged"),
        ("solver.residual=1e-20", "it must lie between 1e-08 and 0.9"),
        ("solver.change=0.5", "it must lie between 1e-12 and 0.01: with more, steps end while"),
        ("solver.backtracking_tolerance=0.5", "no earlier state is ever gone back to"),
    ],
)
def test_a_tolerance_that_switches_the_physics_off_is_refused(setting, rule):
    with pytest.raises(InputError) as error:
        said(setting)
    assert rule in str(error.value).replace("1000000.0", "1e6")


def test_a_crack_that_keeps_much_of_its_stiffness_is_told():
    (warning,) = said("damage.residual_stiffness=0.05", "toughness.amplitude=0.01").warnings
    assert warning.startswith("damage.residual_stiffness = 0.05: a crack still carries 0.05 of")
    assert not said("damage.residual_stiffness=1e-3", "toughness.amplitude=0.01").warnings


def test_a_face_that_is_damaged_all_over_is_told_in_plain_words():
    """10.5 sqrt(ell ell0) < 4 ell beyond ell = (10.5/4)^2 ell0; ell0 = .01 at dT = 10."""
    assert not [n for n in said("temperature.severity=10").notes if "whole face" in n]
    drop = 20.0  # ell0 = .0025
    (note,) = (n for n in said(f"temperature.severity={drop}").notes if "whole face" in n)
    apart = 10.5 * sqrt(0.06 / drop**2)
    assert f"would start {apart:.3g} apart, and the damage of one is 4 ell = 0.24 wide" in note
    assert "sqrt(kappa t) is ell (tau = 0.12)" in note, "2 ell/L"
    assert f"take damage.ell <= 6.9 ell0 = {int(1e4 * (10.5 / 4) ** 2 / drop**2) / 1e4}" in note


def test_a_run_that_ends_before_cracks_part_is_warned_of():
    """sqrt(kappa t) = tau/2 = .03 at the end, half of ell: cracks part at one of them."""
    late = ("temperature.severity=20", "time.tau=[0.03, 0.06]", "toughness.amplitude=0.05")
    (warning,) = (w for w in said(*late).warnings if "run ends while" in w)
    assert "it is 0.5 ell at the end; go on to tau = 0.12, or take damage.ell <= 0.03" in warning
    on = ("temperature.severity=20", "time.tau=[0.03, 0.12]", "toughness.amplitude=0.05")
    assert not [w for w in said(*on).warnings if "run ends while" in w]


def test_a_note_on_nucleation_names_the_h_and_the_ell_that_see_it():
    """ell0 = 1/40^2; h <= sqrt(ell ell0). The whole face would be damaged with ell >= h^2/ell0."""
    (note,) = (n for n in said("temperature.severity=40").notes if "nucleation" in n)
    assert note.endswith("to see it take h <= 0.00612")
    assert sqrt(0.06 / 40**2) == pytest.approx(0.006124, abs=1e-6)
    fine = ("temperature.severity=40", "domain.h=0.00612")
    assert not [n for n in said(*fine).notes if "nucleation" in n]


def test_cold_that_has_passed_the_opposite_boundary_is_told():
    """sqrt(kappa t) = tau/2 of the depth."""
    (note,) = (n for n in said("time.tau=[0.03, 1.2]").notes if "cooling has" in n)
    assert (
        "the diffusion length is 0.6 of the depth: cooling has passed the opposite boundary" in note
    )
    assert "results after tau = 1 hold for this body" in note and "make the body 1.2 deep" in note
    assert not [n for n in said("time.tau=[0.03, 1.0]").notes if "cooling has" in n]


ROLLERS = ("supports.left=rollers", "supports.right=rollers")


def test_rollers_that_hold_a_plate_are_told_with_the_stress_they_make():
    """Mean drop of a slab: dT (1 - sum of 2/m^2 exp(-m^2 t)), m = (k + 1/2) pi, t = .04."""
    modes = [(k + 0.5) * pi for k in range(50)]
    mean = 10 * (1 - sum(2 / m**2 * exp(-(m**2) * 0.04) for m in modes))
    (note,) = said(*ROLLERS).notes
    assert note.startswith("supports of left, right: the body is constrained along its face")
    assert f"a mean stress of {mean:.3g}, {mean / 2.5:.2g} sigma_c" in note, mean
    assert 'take supports.section = "stretch", or "free" if it may bend too' in note
    assert not said("supports.section=stretch").notes, "what the note asks for"
    value, meaning = fact(said("supports.section=stretch"), "supports")
    assert (value, meaning) == (
        'section "stretch"',
        "left and right stay upright: free to shorten, not to bend; no force along the face",
    )


def test_behind_a_film_the_mean_stress_is_less():
    """Heat that has left a half-space through the film, over rho c L, with b = h sqrt(t) = .2 h:
    dT (exp(b^2) erfc(b) - 1 + 2 b/sqrt(pi))/(h L)."""
    text = SLAB.replace('"slab"', '"heat"').replace("severity = 10.0", "")
    text = text.replace("tau = [0.03, 0.4]", "t = [0.000225, 0.04]")
    for h in (2.0, 20.0):
        b = 0.2 * h
        mean = 10 * (exp(b * b) * erfc(b) - 1 + 2 * b / sqrt(pi)) / h
        heat = f"heat={{initial=10.0, bottom={{h={h}, T=0.0}}}}"
        (note,) = (n for n in said(heat, *ROLLERS, text=text).notes if "mean stress" in n)
        assert f"a mean stress of about {mean:.3g}" in note, mean


def test_a_body_that_nothing_holds_is_told():
    (note,) = said().notes
    assert note.startswith("nothing supports the body: it is loose and shortens and bends")
    assert fact(said(), "supports") == ("none", "it shortens and bends freely")
    assert not said("supports.left=rollers").notes, "a plane of symmetry"


def test_amounts_are_rounded_to_the_safe_side_and_in_units_that_are_read_easily():
    case = parse_case(
        """
    domain = { size = ["2 m", "1 m"], h = "20 mm" }
    material = { E = "1 Pa", Gc = "1 J/m^2", expansion = "1 1/K", kappa = "1 m^2/s" }
    damage = { ell = "60 mm" }
    temperature = { profile = "slab", dT = "1 K" }
    time = { t = ["2 s"] }
    """
    )
    assert (
        at_most(case, 0.0031459, "m") == "3.14 mm" and at_least(case, 0.0031459, "m") == "3.15 mm"
    )
    assert at_most(case, 0.03 / 3, "m") == "10 mm" and at_least(case, 3 * 0.01, "m") == "30 mm"
    assert at_least(case, -47.51e6, "Pa") == "-47.6 MPa"
    assert [amount(case, t, "s") for t in (30.0, 90.0, 7200.0)] == ["30 s", "1.5 min", "2 h"]
    assert at_most(parse_case(SLAB), 0.0031459, "m") == "0.00314", "a scaled case has no units"


@pytest.mark.parametrize("name", ["slab", "slab-paper"])
def test_no_ell_is_told_that_another_sentence_would_speak_against(name):
    """h^2/ell0 is .292 for `slab`, 124 times what keeps its face from being damaged all over, and
    1.17 for `slab-paper`, more than the body is deep."""
    (note,) = (n for n in preview(ready_cases.ready_case(name)).notes if "nucleation" in n)
    assert "damage.ell >=" not in note and "take h <= " in note


def test_nor_one_as_wide_as_the_body():
    """dT_c is 2.5; at a drop of .7 it takes ell = .06 (2.5/.7)^2 = .765, and L/4 is .25."""
    (mild,) = (w for w in said("temperature.severity=0.7").warnings if "will crack" in w)
    assert mild.endswith("raise the drop of the face to 2.5 or more")
    (more,) = (w for w in said("temperature.severity=2.0").warnings if "will crack" in w)
    assert "damage.ell >= 0.0938 (a lower strength)" in more


def thin(*settings: str, text: str = PULLED) -> list[str]:
    return [w for w in said(*settings, text=text).warnings if "smallest extent" in w]


def test_of_a_bar_pulled_along_its_length_the_width_does_not_bound_ell():
    """Its crack runs across the bar, so that the length has to hold 4 ell."""
    assert not thin("domain.size=[1.0, 0.12]")
    (warning,) = thin("domain.size=[0.2, 0.12]")
    assert "is 3.3 ell" in warning and "ell <= 0.05" in warning
    for other in (
        "supports.right={x=3.0, y=0.1}",
        "cracks=[{start=[0.5,0.0],end=[0.5,0.02]}]",
        "forces.top={pressure=0.1}",
    ):
        (warning,) = thin("domain.size=[1.0, 0.12]", other)
        assert "is 2 ell" in warning, other
    assert not [w for w in preview(ready_cases.ready_case("bar")).warnings if "extent" in w]


@pytest.mark.parametrize("held", [(), ROLLERS])
def test_nothing_is_said_of_cold_where_a_face_is_heated(held):
    text = SLAB.replace('"slab"', '"heat"').replace("severity = 10.0", "")
    text = text.replace("tau = [0.03, 0.4]", "t = [0.000225, 0.4]")
    notes = said("heat={initial=0.0, bottom={T=10.0}}", *held, text=text).notes
    assert not [n for n in notes if "cold" in n or "cools" in n], notes
    loose = [n for n in notes if "it is loose and lengthens and bends as it warms" in n]
    assert len(loose) == (not held)


def test_a_time_and_a_depth_in_an_error_have_their_unit():
    for setting, words in (
        ('output.at=["13 hours"]', "lies outside the run, which goes to t = 12 h;"),
        ('measures.depths=["1.2 m"]', "lies outside the body, which is 1 m deep;"),
    ):
        with pytest.raises(InputError) as error:
            ready_cases.ready_case("squeezed", [setting])
        assert words in str(error.value)

"""`staffa check` with [forces]: squeeze, thermal stress, net tension, signs, plane strain."""

from math import ceil, erfc, exp, pi, sqrt

import numpy as np
import pytest

from staffa.case.check.preview import Preview, preview
from staffa.case.reading.read import parse_case
from staffa.case.rules.initial_stress import initial_normal_stresses
from staffa.errors import InputError

E, NU, GC, EXPANSION, ELL = 65e9, 0.3, 61.5, 6e-6, 0.03
# A granite face that is cooled by 140 K.
COLD_FACE = """
[domain]
size = ["1 m", "0.5 m"]
h = "10 mm"
[material]
E = "65 GPa"
nu = 0.3
Gc = "61.5 J/m^2"
expansion = "6e-6 1/K"
k = "3.05 W/(m K)"
rho = "2750 kg/m^3"
c = "790 J/(kg K)"
[damage]
ell = "30 mm"
[toughness]
amplitude = 0.1
[temperature]
profile = "heat"
face = "bottom"
[heat]
initial = "200 °C"
bottom = { T = "60 °C" }
[supports]
left = "rollers"
right = "rollers"
top = "rollers"
[time]
t = { start = "2 min", stop = "3 hours", steps = 10 }
"""
# A bar's strength, and what no-tension makes of it in plane stress (docs/how-to/forces.md).
STRENGTH = sqrt(3 * GC * E / (8 * ELL))
STARTS = STRENGTH / sqrt(1 - NU**2)


def said(*settings: str) -> Preview:
    return preview(parse_case(COLD_FACE, settings))


def facts(*settings: str) -> dict[str, str]:
    return {name: value for name, value, _ in said(*settings).facts}


def test_a_squeeze_of_80_mpa_is_more_than_140_k_overcome():
    """E expansion dT = 54.6 MPa < s + 7.41 MPa; it takes 87.4 MPa/(E expansion) = 224.1 K."""
    squeezed = 'forces.prestress={xx="-80 MPa"}'
    needed = (80e6 + STARTS) / (E * EXPANSION)
    assert round(E * EXPANSION * 140) == 54_600_000
    assert needed == pytest.approx(224.12, abs=0.01)
    known = facts(squeezed)
    expected = {
        "initial stress": "-80 MPa",
        "thermal stress": "54.6 MPa",
        "net tension": "-25.4 MPa",
        "drop it takes": "224.2 K",  # what the warning says too: enough of it
        "will it crack": "no",
    }
    assert {name: known[name] for name in expected} == expected
    (warning,) = said(squeezed).warnings
    assert warning.startswith(
        "nothing will crack: E expansion dT = 54.6 MPa is less than the squeeze of 80 MPa and the "
        "7.41 MPa at which damage starts, 87.4 MPa together"
    )
    assert (
        "raise the drop of the face to 224.2 K or more, or squeeze it by 47.1 MPa only" in warning
    )


def test_with_the_numbers_to_take_it_cracks():
    """On both sides of what the warning says."""
    for squeeze, drop, verdict in (
        ("-80 MPa", 224.0, "perhaps"),  # where the random toughness is low
        ("-80 MPa", 225.0, "hardly"),
        ("-47.1 MPa", 140.0, "hardly"),
        ("-15 MPa", 140.0, "yes"),
    ):
        given = (f'forces.prestress={{xx="{squeeze}"}}', f'heat.bottom={{T="{200 - drop} °C"}}')
        assert facts(*given)["will it crack"] == verdict, (squeeze, drop)


def test_a_smaller_squeeze_names_the_ell_that_cracks():
    """Net tension 4.6 MPa: the strength falls to it at ell (7.41/4.6)^2."""
    squeezed = 'forces.prestress={xx="-50 MPa"}'
    net = E * EXPANSION * 140 - 50e6
    ell = ELL * (STARTS / net) ** 2
    (warning,) = (w for w in said(squeezed).warnings if "will crack" in w)
    assert ell == pytest.approx(0.07785, rel=1e-3)
    assert "damage.ell >= 77.9 mm (a lower strength)" in warning
    bigger = facts(squeezed, 'damage.ell="78.0 mm"')
    assert bigger["will it crack"] == "hardly", bigger["will it crack"]


def test_a_prestress_in_tension_above_the_strength_is_refused():
    """30 MPa against 7.41 MPa, with the sign of the geologist."""
    with pytest.raises(InputError) as error:
        said('forces.prestress={xx="30 MPa"}')
    sentence = str(error.value)
    assert sentence.startswith('forces.prestress.xx = "30 MPa": before cooling begins')
    assert "30 MPa of tension along x, and it breaks at 7.41 MPa" in sentence
    assert sentence.endswith(
        'stresses count positive in tension, so that squeezed rock has "-30 MPa"'
    )


@pytest.mark.parametrize(("stress", "refused"), [(0.999 * STARTS, False), (1.001 * STARTS, True)])
def test_the_strength_at_rest_is_the_bound(stress, refused):
    setting = f'forces.prestress={{xx="{stress} Pa"}}'
    if refused:
        with pytest.raises(InputError, match="of tension along x"):
            said(setting)
    else:
        assert facts(setting)["initial stress"] == "7.4 MPa"


def test_a_tension_that_the_rock_bears_asks_whether_its_sign_is_meant():
    (warning,) = said('forces.prestress={xx="2 MPa"}').warnings
    assert warning.startswith("forces.prestress.xx reaches 2 MPa of tension")
    assert warning.endswith('is that meant? Rock that is squeezed so has "-2 MPa"')
    assert not said('forces.prestress={xx="-2 MPa"}').warnings
    sloped = '{value="-1 MPa", gradient=["0 MPa/m", "10 MPa/m"]}'  # 4 MPa at the top
    (warning,) = said(f"forces.prestress={{xx={sloped}}}").warnings
    assert "forces.prestress.xx reaches 3." in warning


@pytest.mark.parametrize(
    ("setting", "words"),
    [
        ('forces.bottom={pressure="-3 MPa"}', "forces.bottom.pressure reaches -3 MPa, which pulls"),
        ('forces.crack_pressure="-3 MPa"', "forces.crack_pressure reaches -3 MPa, which pulls"),
        ('forces.gravity=["0 m/s^2", "9.81 m/s^2"]', "points up, along y: is that meant?"),
    ],
)
def test_other_signs_that_may_be_those_of_another_convention_are_asked_about(setting, words):
    assert any(words in warning for warning in said(setting).warnings), said(setting).warnings
    other = setting.replace("-3", "3").replace('"9.81', '"-9.81')
    assert not any("is that meant" in warning for warning in said(other).warnings)


def test_pores_take_off_of_the_squeeze():
    """b p = 6 MPa more tension than the whole."""
    given = ('material.plane="strain"', 'forces.pore_pressure="10 MPa"', "forces.biot=0.6")
    squeezed = 'forces.prestress={xx="-20 MPa",yy="-20 MPa",zz="-20 MPa"}'
    around = ('forces.bottom={pressure="20 MPa"}',)
    assert facts(*given, squeezed, *around)["initial stress"] == "-14 MPa"


def test_the_initial_stress_is_that_of_a_block_in_equilibrium():
    """Weight on a block between rollers in plane strain: nu/(1 - nu) of it sideways."""
    case = parse_case(
        COLD_FACE,
        (
            'material.plane="strain"',
            'forces.gravity=["0 m/s^2", "-10 m/s^2"]',
            "supports.top=free",
            "supports.bottom=rollers",
        ),
    )
    y = np.array([0.0, 0.2, 0.5])
    found = initial_normal_stresses(case, np.array([0 * y + 0.5, y, 0 * y]))
    upright = -2750 * 10 * (0.5 - y)
    assert found is not None
    assert found[1] == pytest.approx(upright)
    assert found[0] == pytest.approx(upright * NU / (1 - NU))
    assert found[2] == pytest.approx(upright * NU / (1 - NU))


def test_a_prestress_between_free_sides_squeezes_nothing():
    free = ("supports.left=free", "supports.right=free", 'forces.prestress={xx="-80 MPa"}')
    known = facts(*free)
    assert known["initial stress"] == "0 Pa" and known["will it crack"] == "yes"
    pressed = ('forces.left={pressure="80 MPa"}', 'forces.right={pressure="80 MPa"}')
    known = facts(*free, *pressed)
    assert known["initial stress"] == "-80 MPa" and known["will it crack"] == "no"


def test_of_a_free_face_the_pressure_that_holds_the_prestress_is_told():
    (warning,) = said('forces.prestress={yy="-12 MPa"}').warnings
    assert 'give what acts on it: forces.bottom = { pressure = "12 MPa" }' in warning
    acted = ('forces.prestress={yy="-12 MPa"}', 'forces.bottom={pressure="12 MPa"}')
    assert not said(*acted).warnings


def test_rock_without_a_split_that_breaks_under_pressure_is_refused():
    with pytest.raises(InputError, match=r"of pressure along x, and with this damage\.split"):
        said('forces.prestress={xx="-80 MPa"}', "damage.split=none")


def test_in_plane_strain_the_cures_are_told_with_their_numbers():
    """E expansion dT = 54.6 MPa across the plane against sigma_c of a bar between two planes."""
    (warning,) = (w for w in said('material.plane="strain"').warnings if "plane strain" in w)
    thermal = E * EXPANSION * 140
    colder, zz = STRENGTH / (E * EXPANSION), thermal - STRENGTH
    ell = ELL * (STRENGTH / thermal) ** 2
    assert f"colder by {colder:.3g} K or more (of 140 K)" in warning
    assert (f"{zz / 1e6:.1f}", f"{ell * 1e6:.0f}") == ("47.5", "503")
    assert 'forces.prestress.zz = "-47.6 MPa" or below' in warning
    assert "damage.ell <= 502 um" in warning
    squeezed = 'forces.prestress={zz="-47.6 MPa"}'
    for cure in ('material.plane="stress"', squeezed, 'damage.ell="502 um"', 'domain.h="0.1 mm"'):
        settings = ['material.plane="strain"', cure, *(['domain.h="0.1 mm"'] * ("um" in cure))]
        left = [w for w in said(*settings).warnings if "in plane strain" in w]
        assert bool(left) == ("domain.h" in cure), left


def test_a_block_is_squeezed_along_both_of_its_sides():
    """No-tension with tension t along both and none across: its energy less that of the narrowing,
    t^2 (1 + nu)(1 - 2 nu)/E, against sigma_c^2/(2 E); the
    thermal stress is E expansion dT/(1 - nu)."""
    solid = (
        'domain={size=["0.4 m","0.4 m","0.4 m"], h="10 mm"}',
        "supports.front=rollers",
        "supports.back=rollers",
        'forces.prestress={xx="-20 MPa", yy="-20 MPa"}',
    )
    starts = STRENGTH / sqrt(2 * (1 + NU) * (1 - 2 * NU))
    known = facts(*solid)
    assert known["thermal stress"] == f"{E * EXPANSION * 140 / (1 - NU) / 1e6:.3g} MPa"
    needed = (20e6 + starts) * (1 - NU) / (E * EXPANSION)
    assert known["drop it takes"] == f"{ceil(100 * needed) / 100:.4g} K"
    less = (*solid[:3], 'forces.prestress={xx="-20 MPa", yy="-5 MPa"}')
    assert facts(*less)["initial stress"] == "-5 MPa", "where it is squeezed least"
    assert float(facts(*less)["drop it takes"][:-2]) < float(known["drop it takes"][:-2])


def test_a_squeeze_that_ends_counts_when_it_is_least():
    """The pressure on the sides falls from 80 to 10 MPa."""
    falling = 'pressure={t=["0 s","3 hours"],value=["80 MPa","10 MPa"]}'
    free = ("supports.left=free", "supports.right=free")
    known = facts(*free, f"forces.left={{{falling}}}", f"forces.right={{{falling}}}")
    assert known["initial stress"] == "-10 MPa" and known["will it crack"] == "yes"


def across_the_plane(*settings: str) -> list[str]:
    given = ('material.plane="strain"', 'heat.bottom={T="40 °C"}', *settings)
    return [w for w in said(*given).warnings if "in plane strain" in w]


@pytest.mark.parametrize("given", ["", ', zz="-54.3 MPa"', ', zz="3 MPa"'])
def test_the_prestress_across_the_plane_is_told_as_a_whole_and_is_enough(given):
    """Cracks that open against xx = -15 MPa add nu 15 MPa across the plane to E expansion dT; the
    whole zz is told, whatever part of it is given."""
    bears = STRENGTH * sqrt((1 - NU) / ((1 + NU) * (1 - 2 * NU)))  # no-tension in plane strain
    needed = E * EXPANSION * 160 + NU * 15e6 - bears
    told = f"{ceil(needed / 1e5) / 10:.1f} MPa"
    assert told == "58.7 MPa"
    (warning,) = across_the_plane(f'forces.prestress={{xx="-15 MPa"{given}}}')
    assert f'forces.prestress.zz = "-{told}" or below' in warning
    assert not across_the_plane(f'forces.prestress={{xx="-15 MPa", zz="-{told}"}}')
    assert across_the_plane('forces.prestress={xx="-15 MPa", zz="-58.6 MPa"}')


def test_of_a_prestress_with_a_gradient_what_is_missing_is_told():
    sloped = '{value="-49.5 MPa", gradient=["0 MPa/m", "-1 MPa/m"]}'
    (warning,) = across_the_plane(f'forces.prestress={{xx="-15 MPa", zz={sloped}}}')
    assert "a forces.prestress.zz that is lower by 9.2 MPa" in warning


STRAIN = ('material.plane="strain"', 'forces.prestress={xx="-15 MPa"}')


def test_where_the_stress_across_the_plane_decides_damage_starts_at_that_stress():
    """Nothing squeezes across the plane: it breaks at 8.2 MPa, after E expansion dT/(1 - nu)."""
    known = {name: (value, meaning) for name, value, meaning in said(*STRAIN).facts}
    bears = STRENGTH * sqrt((1 - NU) / ((1 + NU) * (1 - 2 * NU)))
    net = E * EXPANSION * 140 / (1 - NU) - 15e6
    told = f"the sum of both; damage starts across the plane, at {bears / 1e6:.3g} MPa there"
    assert known["initial stress"][0] == "-15 MPa"
    assert known["net tension"] == (f"{net / 1e6:.3g} MPa", told)
    assert float(known["drop it takes"][0][:-2]) == pytest.approx(
        bears * (1 - NU) / (E * EXPANSION), abs=0.01
    )


def test_and_the_ell_that_cracks_it_follows_from_that_stress():
    """At 10 K the net tension across the plane is 5.57 MPa, which breaks it at ell (8.2/5.57)^2."""
    (warning,) = (w for w in said(*STRAIN, 'heat.bottom.T="190 °C"').warnings if "crack" in w)
    assert "the face drops by 10 K at most, and damage starts at 14.73 K" in warning
    assert "damage.ell >= 65.1 mm (a lower strength)" in warning
    bigger = facts(*STRAIN, 'heat.bottom.T="190 °C"', 'damage.ell="65.2 mm"')
    assert bigger["will it crack"] == "hardly"


@pytest.mark.parametrize(("squeeze", "told"), [("-80 MPa", False), ("-2 MPa", True)])
def test_the_mean_stress_of_held_rock_counts_what_squeezes_it(squeeze, told):
    """Mean of dT erfc(y/w) down to L, w = 2 sqrt(kappa t)."""
    b = 0.5 / (2 * sqrt(3.05 / (2750 * 790) * 10800))  # L/w
    mean = E * EXPANSION * 140 * (b * erfc(b) + (1 - exp(-b * b)) / sqrt(pi)) / b
    found = [
        n for n in said(f'forces.prestress={{xx="{squeeze}"}}').notes if "constrained along" in n
    ]
    assert bool(found) == told
    for note in found:
        net = mean - 2e6
        stress = "cooling and [forces] give it, through its whole depth, a mean stress of about "
        assert f"{stress}{net / 1e6:.3g} MPa, {net / STARTS:.2g} sigma_c" in note


def test_rock_that_is_heated_is_not_pulled_by_cold():
    assert not [n for n in said('heat.bottom.T="400 °C"').notes if "thermal stress at" in n]


def sheared(*settings: str) -> list[str]:
    return [w for w in said(*settings).warnings if "its shear" in w]


def test_a_shear_that_pulls_more_than_the_rock_bears_is_told():
    """Principal values of xx = -15, xy = -60 MPa are -7.5 ± sqrt(7.5^2 + 60^2)."""
    (warning,) = sheared('forces.prestress={xx="-15 MPa", xy="-60 MPa"}')
    tension = -7.5 + sqrt(7.5**2 + 60**2)
    assert f"a tension of {tension:.3g} MPa along a slanting direction" in warning
    assert "smaller shear" in warning
    assert not sheared('forces.prestress={xx="-15 MPa", yy="-15 MPa", xy="-16 MPa"}')
    assert sheared('forces.prestress={xx="-15 MPa", yy="-15 MPa", xy="-24 MPa"}')
    around = 'forces.prestress={xx="-15 MPa", yy="-15 MPa", zz="-15 MPa", xy="-16 MPa"}'
    strain, pores = 'material.plane="strain"', ('forces.pore_pressure="10 MPa"', "forces.biot=0.8")
    assert not sheared(around, strain)
    assert sheared(around, strain, *pores)


def test_so_is_one_of_a_solid_body():
    """xx = yy = zz = -15, yz = 40 MPa: 25 MPa along the diagonal of y and z."""
    solid = ('domain={size=["0.4 m","0.4 m","0.4 m"], h="10 mm"}',)
    given = 'forces.prestress={xx="-15 MPa", yy="-15 MPa", zz="-15 MPa", yz="40 MPa"}'
    (warning,) = sheared(*solid, given)
    assert "a tension of 25 MPa along" in warning

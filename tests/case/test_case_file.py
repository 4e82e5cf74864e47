"""Case files: what is written reads back as the same case, and explains itself."""

import re
import tomllib

import pytest
from pydantic import BaseModel

from staffa.case.reading import ready_cases
from staffa.case.reading.read import parse_case, read_case
from staffa.case.scales.case_scales import derived_numbers
from staffa.case.schema.case import Case
from staffa.case.schema.force_keys import ForceKeys
from staffa.case.schema.heat_keys import HeatKeys
from staffa.case.schema.quantity_text import is_scaled, quantities
from staffa.case.schema.reservoir_keys import ReservoirKeys
from staffa.case.schema.toml_text import OPTIONAL, to_toml
from staffa.errors import InputError
from support.circulation_cases import wall

SCALED = """
[domain]
size = [2.0, 1.0]
h = 0.02
[material]
nu = 0.25
[damage]
ell = 0.06
[temperature]
severity = 12.5
[time]
tau = [0.1, 0.4]
"""
# The same body: L = 50 mm, E = 64 GPa, Gc = 20 J/m^2, expansion dT = 12.5 sqrt(Gc/(E L)).
IN_UNITS = """
[domain]
size = ["10 cm", "50 mm"]
h = "1000 um"
[material]
E = "64 GPa"
nu = 0.25
Gc = "20 N/m"
expansion = "9.882117688026186e-6 1/K"
kappa = "1 mm^2/s"
[damage]
ell = "3 mm"
[temperature]
dT = "100 K"
[time]
t = ["6.25 s", "100 s"]
"""
PULLED_IN_UNITS = """
[domain]
size = ["1 m", "0.3 m"]
h = "2 cm"
[material]
E = "100 MPa"
Gc = "1 kJ/m^2"
[damage]
ell = "10 cm"
[temperature]
profile = "none"
[toughness]
amplitude = 0.1
[[cracks]]
start = [0.0, "10 cm"]
end = ["0.2 m", "10 cm"]
[supports]
left = { x = 0.0 }
right = { x = { t = [0.0, "1 min"], u = [0.0, "25 cm"] }, y = 0.0 }
[time]
t = { start = 0.0, stop = "1 min", steps = 10 }
"""
DISCS = """
[domain]
size = [1.0, 1.0, 1.0]
h = 0.1
[damage]
ell = 0.2
[temperature]
severity = 3.0
face = "back"
[[cracks]]
center = [0.5, 1.0, 0.5]
radius = 0.2
normal = [1, 0, 0]
[time]
t = [0.01]
"""
HEATED = """
[domain]
size = [2.0, 1.0]
h = 0.02
[damage]
ell = 0.06
[temperature]
profile = "heat"
[heat]
initial = { value = 1.0, gradient = [0.0, -0.5] }
stress_free = { formula = "1 - x/4" }
bottom = { h = { t = [0, 0.1], value = [0, 8] }, T = { formula = "where(t < 0.01, 1, 0)" } }
top = { flux = -0.25 }
left = { T = 0.0 }
source = { t = [0.0, 0.1], value = [0.0, -3.0] }
bands = [{ lower = [0.0, 0.4], upper = [2.0, 0.6], k = 0.5 }]
cracks = { conductivity = 0.01 }
tolerance = 1e-3
[time]
tau = [0.1, 0.4]
"""
HEATED_IN_UNITS = """
[domain]
size = ["10 cm", "5 cm", "5 cm"]
h = "5 mm"
[material]
E = "60 GPa"
Gc = "20 J/m^2"
expansion = "8e-6 1/K"
k = ["3 W/(m K)", "3 W/(m K)", "2.5 W/(m K)"]
rho = "2.7 g/cm^3"
c = "800 J/(kg K)"
[damage]
ell = "15 mm"
[temperature]
profile = "heat"
face = "back"
[heat]
initial = "300 °C"
back = { h = "500 W/(m^2 K)", T = { t = [0, "1 min"], value = ["300 °C", "20 °C"] } }
front = { flux = { t = [0, "1 min"], value = [0, "1 kW/m^2"] } }
source = { formula = "100*exp(-t/60)*(z > 0.02)*1.0" }
cracks = { h = "50 W/(m^2 K)", T = "0 °C" }
[time]
t = { start = "1 s", stop = "10 min", steps = 30 }
"""
CASES = {name: ready_cases.text(name) for name in ready_cases.ready_case_names()} | {
    "scaled": SCALED,
    "in units": IN_UNITS,
    "pulled in units": PULLED_IN_UNITS,
    "discs": DISCS,
    "heated": HEATED,
    "heated in units": HEATED_IN_UNITS,
}
NASTY = [
    'a "b" \\ c',
    "tab\tline\nreturn\r",
    "\x7f\x00 \u2028",
    "é µ 長 🪨",
    "'",
    "# no",
    "\U000e0001",
    "",
]


@pytest.mark.parametrize("explained", [False, True], ids=["bare", "explained"])
@pytest.mark.parametrize("name", CASES)
def test_what_is_written_reads_back_as_the_same_case(name, explained):
    case = parse_case(CASES[name])
    text = to_toml(case, explained=explained)
    again = parse_case(text)
    assert again == case
    assert to_toml(again, explained=explained) == text, "numbers are kept as they were written"
    assert derived_numbers(again) == derived_numbers(case)


@pytest.mark.parametrize("title", NASTY, ids=ascii)
def test_any_text_is_written_as_toml_reads_it(title):
    """Also what no title may hold, since it goes to terminals."""
    case = parse_case(SCALED).model_copy(update={"title": title})
    assert tomllib.loads(to_toml(case))["title"] == title
    assert tomllib.loads(to_toml(case, explained=True))["title"] == title


def keys_of(model: BaseModel) -> dict[str, object]:
    return {name: getattr(model, name) for name in type(model).model_fields}


@pytest.mark.parametrize("name", CASES)
def test_the_resolved_case_has_every_default_written_out(name):
    case = parse_case(CASES[name])
    written = tomllib.loads(to_toml(case))
    for table, section in keys_of(case).items():
        if isinstance(section, BaseModel):
            missing = [
                key
                for key, value in keys_of(section).items()
                if value is not None and key not in written[table]
            ]
            assert not missing, f"[{table}] lacks {missing}"
    assert written["domain"]["cells"] and written["solver"]["displacement"] in (
        "direct",
        "iterative",
    )


@pytest.mark.parametrize("name", CASES)
def test_every_key_has_a_comment_directly_above_it(name):
    lines = to_toml(parse_case(CASES[name]), explained=True).splitlines()
    keys = [n for n, line in enumerate(lines) if re.match(r"(# )?[A-Za-z_]+ = ", line)]
    bare = [lines[n] for n in keys if not re.match(r"# \S", lines[n - 1]) or n - 1 in keys]
    assert len(keys) > 35 and not bare, f"no comment above {bare}"


def test_every_key_of_every_table_is_explained_and_a_key_without_value_has_an_example():
    lines = to_toml(parse_case(SCALED), explained=True).splitlines()
    for table, field in Case.model_fields.items():
        model = OPTIONAL.get(table, field.annotation)
        if not (isinstance(model, type) and issubclass(model, BaseModel)):
            continue
        start = lines.index(f"# [{table}]" if table in OPTIONAL else f"[{table}]")
        end = next((n for n in range(start + 1, len(lines)) if lines[n].startswith("[")), None)
        for key in model.model_fields:
            found = [x for x in lines[start:end] if x.removeprefix("# ").startswith(f"{key} = ")]
            assert found and not found[0].endswith('= ""'), f"[{table}] {key}: {found}"


def test_the_comments_of_a_new_case_can_be_taken_away_one_by_one():
    """A commented key is an example that reads."""
    text = to_toml(parse_case(SCALED), explained=True)
    on = text.replace("# correlation_length", "correlation_length").replace("# [[", "[[")
    on = on.replace("# start =", "start =").replace("# end =", "end =")
    case = parse_case(on)
    assert case.toughness.correlation_length == 0.06 and len(case.cracks) == 1


@pytest.mark.parametrize(
    ("table", "model", "until", "left_out"),
    [
        ("heat", HeatKeys, "# [reservoir]\n", ("front", "back", "bands")),
        ("reservoir", ReservoirKeys, "# [forces]\n", ("python", "fields")),
        ("forces", ForceKeys, "# Supports of the body", ("front", "back")),
    ],
)
def test_a_table_that_is_not_there_is_explained_by_one_that_reads(table, model, until, left_out):
    text = to_toml(parse_case(PULLED_IN_UNITS), explained=True)
    start, end = text.index(f"# [{table}]\n"), text.index(until)
    keys = re.findall(rf"^# ([a-z_]+ = .*|\[{table}\])$", text[start:end], re.MULTILINE)
    shown = tomllib.loads("\n".join(key for key in keys if not key.startswith(left_out)))
    found = model.model_validate(shown[table])
    assert set(model.model_fields) - set(left_out) == found.model_fields_set


def test_what_the_heat_equation_adds_to_the_rock_is_one_in_a_scaled_case_and_else_absent():
    heated, cooled = parse_case(HEATED).material, parse_case(SCALED).material
    assert (heated.k, heated.rho, heated.c, heated.kappa) == (1, 1, 1, None)
    assert (cooled.k, cooled.rho, cooled.c, cooled.kappa) == (None, None, None, 1)


def test_settings_are_put_over_the_file(tmp_path):
    path = tmp_path / "my.toml"
    path.write_text(SCALED)
    case = read_case(
        path,
        ["damage.law=AT2", "domain.h = 0.05", "toughness.seed=7", "title=a b", "time.tau=[0.2]"],
    )
    found = (case.damage.law, case.domain.h, case.toughness.seed, case.title, case.time.tau)
    assert found == ("AT2", 0.05, 7, "a b", (0.2,))
    assert read_case(path).damage.law == "AT1", "the file itself is as it was"


def test_of_two_settings_of_a_key_the_last_counts():
    assert parse_case(SCALED, ["domain.h=0.05", "domain.h=0.04"]).domain.h == 0.04


@pytest.mark.parametrize("number", [".05", "+.05", "5.e-2", ".5E-1"])
def test_a_number_of_a_setting_may_begin_or_end_with_its_point(number):
    """TOML refuses that, shells and people do not."""
    assert parse_case(SCALED, [f"domain.h={number}"]).domain.h == 0.05


def test_a_setting_may_have_a_unit():
    assert parse_case(IN_UNITS, ["domain.h=0.5 mm"]).domain.h == 0.5e-3


def test_a_setting_reaches_an_entry_of_a_list_by_its_name_or_number():
    case = wall("reservoir.wells.in.T=80 °C", "reservoir.fractures.1.opening=0.3 mm")
    found = (case.reservoir.wells[0].T, case.reservoir.fractures[0].opening)
    assert found == pytest.approx((353.15, 0.3e-3))
    assert wall("domain.size.2=8 m").domain.size == (12.0, 8.0)
    assert case.reservoir.wells[1] == wall().reservoir.wells[1]


@pytest.mark.parametrize(
    ("setting", "part"),
    [
        ("reservoir.wells.inn.T=80 °C", "no entry of this list is 'inn'; it has in, out."),
        ("reservoir.fractures.2.opening=1 mm", "is '2'; count from 1 to 1"),
        ("reservoir.wells.0.T=1", "no entry of this list is '0'"),
        ("domain.size.3=3 m", "no entry of this list is '3'; count from 1 to 2"),
    ],
)
def test_an_entry_that_is_not_there_is_refused(setting, part):
    with pytest.raises(InputError) as caught:
        wall(setting)
    assert part in str(caught.value)


def test_the_same_body_in_units_and_scaled_is_the_same():
    scaled, units = derived_numbers(parse_case(SCALED)), derived_numbers(parse_case(IN_UNITS))
    assert scaled.severity == pytest.approx(units.severity, rel=1e-9)
    assert scaled.dT / scaled.dT_c == pytest.approx(units.dT / units.dT_c, rel=1e-9)
    assert scaled.ell0 / scaled.L == pytest.approx(units.ell0 / units.L, rel=1e-9)
    assert [t / scaled.L**2 for t in scaled.times] == pytest.approx(
        [1e-6 * t / units.L**2 for t in units.times], rel=1e-9
    )


@pytest.mark.parametrize("name", CASES)
def test_a_case_has_units_throughout_or_not_at_all(name):
    case = parse_case(CASES[name])
    given = [q.has_units for key, q in quantities(case) if q != 0.0 and key != "output.at"]
    assert set(given) == {not is_scaled(case)}


def test_zero_needs_no_unit():
    case = parse_case(PULLED_IN_UNITS)
    assert not is_scaled(case) and case.cracks[0].start == (0.0, 0.1)


PUSHED = """
[domain]
size = [1.0, 0.3, 0.3]
h = 0.05
[material]
E = 100.0
[damage]
ell = 0.1
[temperature]
profile = "none"
[supports]
left = { x = 0.0 }
right = { x = { t = [0.0, 1.0], u = [0.0, -0.4] } }
[time]
t = [0.5, 0.55]
"""


@pytest.mark.parametrize(
    ("settings", "solver"),
    [
        (["domain.size=[1.0,0.3]"], "direct"),
        (["damage.split=none"], "iterative"),
        ([], "direct"),
        (['damage.split="volumetric-deviatoric"'], "direct"),
        (['damage.split="volumetric-deviatoric"', "domain.h=0.01"], "iterative"),
    ],
)
def test_a_small_body_with_a_split_takes_a_factorization_in_3d_too(settings, solver):
    """Under pressure multigrid took thousands of iterations a sweep."""
    case = parse_case(PUSHED, settings)
    assert case.solver.displacement == solver
    asked = parse_case(PUSHED, [*settings, 'solver.displacement="iterative"'])
    assert asked.solver.displacement == "iterative"

"""The table [reservoir]: bad inputs in one sentence each, and the model that a case becomes."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from scipy.special import erfc

from case.test_bad_input import check_sentence, sentence_of
from staffa.case.check.preview import Preview, preview
from staffa.case.reading.read import parse_case, read_case
from staffa.case.reading.ready_cases import ready_case
from staffa.case.rules import require_loaded
from staffa.case.scales.breakthrough import DRAWDOWNS, breakthrough
from staffa.case.scales.case_scales import derived_numbers
from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import to_toml
from staffa.case.values.applied_forces import forces
from staffa.case.values.attached_files import attached
from staffa.case.values.reservoir_model import reservoir_model
from staffa.physics.saturation import saturation_pressure
from staffa.reservoir.interpreter import VARIABLE
from staffa.reservoir.reservoir_load import ReservoirLoad
from staffa.setup.simulators import reservoir_load

GOOD = """
[domain]
size = ["30 m", "15 m"]
h = "1 m"
[material]
E = "40 GPa"
Gc = "100 J/m^2"
expansion = "8e-6 1/K"
k = "2.5 W/(m K)"
rho = "2650 kg/m^3"
c = "868 J/(kg K)"
[damage]
ell = "3 m"
[temperature]
profile = "reservoir"
[reservoir]
temperature = "200 °C"
pressure = "20 MPa"
beyond = { top = "25 m" }
permeability = "1e-16 m^2"
porosity = 0.01
fractures = [{ side = "bottom", opening = "0.2 mm", height = "0.1 m" }]
wells = [
    { name = "in", at = ["0 m", "0 m"], rate = "0.005 kg/s", T = "60 °C" },
    { name = "out", at = ["30 m", "0 m"], pressure = "20 MPa" },
]
[time]
t = ["3 days", "20 days"]
"""
IN = 'name="in",at=["0 m","0 m"]'
OUT = '{name="out",at=["30 m","0 m"],pressure="20 MPa"}'
SOLID = ('domain.size=["30 m","30 m","15 m"]',)
TWO_WAYS = "reservoir.feedback=true"
STRAIN = 'material.plane="strain"'
CLOSED = (
    'reservoir.simulator="single"',
    'reservoir.water={rho="1000 kg/m^3",c="4200 J/(kg K)",mu="0.3 mPa s"}',
)


def wells(*given: str) -> str:
    return f"reservoir.wells=[{','.join(given)}]"


def injector(*keys: str) -> str:
    return wells(f"{{{','.join((IN, *keys))}}}", OUT)


def fracture(keys: str) -> str:
    return f"reservoir.fractures=[{{{keys}}}]"


FIELDS = (
    "reservoir={}",
    'reservoir.simulator="fields"',
    'reservoir.fields={t=["0 s","30 d"],files=["a.vtu","b.vtu"],T="T",T_unit="°C",p="p"}',
)
# The change to the good case; what the sentence names; the rule or the way out.
BAD = [
    ('temperature.profile="heat"', "[reservoir] has no meaning", 'profile = "reservoir"'),
    ('heat={initial="20 °C"}', "[heat] has no meaning", 'profile = "heat"'),
    ('material.kappa="1 mm^2/s"', "material.kappa", "give k, rho and c"),
    ('temperature.dT="100 K"', "temperature.dT", "where [reservoir] says what does"),
    ("time={tau=[0.1]}", "time.tau = [0.1]", "give time.t, with units"),
    ('reservoir.simulator="tough"', "reservoir.simulator", '"darts", "single", "fields"'),
    ('reservoir.python="/bin/sh"', "reservoir.python", "allow it with --outside"),
    ('reservoir.feedback="both"', "reservoir.feedback", "true or false"),
    ('reservoir.coupling="once"', "reservoir.coupling", '"iterated", "explicit"'),
    # rock and water
    ("reservoir.temperature={}", "reservoir.temperature", "write"),
    ('reservoir.temperature="400 °C"', "reaches 400 °C", "constant properties"),
    ('reservoir.temperature="200 K"', "reaches -73.15 °C", "constant properties"),
    ('reservoir.pressure="250 MPa"', "reaches 250 MPa", "a lower pressure"),
    (injector('rate="5 g/s"', 'T="-5 °C"'), "('in'), T = \"-5 °C\"", "1 to 350 °C"),
    ('reservoir.temperature={formula="500+t"}', "'t' is not known", "x, y"),
    ('reservoir.temperature={formula="20*x"}', "it is 0 at (0 -0.05) m", "above absolute zero"),
    (
        'reservoir.temperature={value="200 °C",gradient=["1 K/m"]}',
        "reservoir.temperature.gradient",
        "it needs 2 numbers",
    ),
    ('reservoir.pressure="0 MPa"', "reservoir.pressure", "larger than zero"),
    ('reservoir.pressure="1 MPa"', "boils below 1.55 MPa", "give a higher pressure"),
    ('reservoir.pressure="5 mm"', "does not measure a pressure", '"20 MPa"'),
    ('reservoir.pressure={formula="2e7-1e6*y"}', "it is -", "finite and larger than zero"),
    ('reservoir.permeability="0 m^2"', "reservoir.permeability", "larger than zero"),
    ('reservoir.permeability="-1 m^2"', "reservoir.permeability", "larger than zero"),
    ('reservoir.permeability={formula="1e-16*(y-1)"}', "it is -1.05e-16", "larger than zero"),
    ("reservoir.porosity=1.0", "reservoir.porosity = 1.0", "less than 1"),
    ("reservoir.porosity=0", "reservoir.porosity = 0", "larger than zero"),
    ('reservoir.porosity="30 %"', "reservoir.porosity", "without quotes"),
    ('reservoir.water="steam"', "reservoir.water", '"iapws"'),
    ('reservoir.water={rho="1000 kg/m^3"}', "reservoir.water.c is missing", "4200 J/(kg K)"),
    ("reservoir.biot=1.5", "reservoir.biot = 1.5", "at most 1"),
    ("reservoir.biot=1.0", "reservoir.biot = 1", "leave it out (then it is 0)"),
    ("reservoir.tolerance=0.5", "reservoir.tolerance = 0.5", "at most 0.1"),
    # the reservoir around the body
    ('reservoir.h="1 mm"', "reservoir.h gives", "take a larger h"),
    ('reservoir.thickness="0 m"', "reservoir.thickness", "larger than zero"),
    ('reservoir.beyond={up="5 m"}', "reservoir.beyond.up", "it has bottom, left, right, top"),
    ('reservoir.beyond={top="-5 m"}', "reservoir.beyond.top", "larger than zero"),
    ('reservoir.beyond={bottom="5 m"}', "reservoir.beyond.bottom goes on", "leave one out"),
    ('reservoir.boxes=[{lower=["0 m","0 m"],upper=["5 m","5 m"]}]', "boxes, entry 1", "porosity"),
    (
        'reservoir.boxes=[{lower=["5 m","0 m"],upper=["5 m","5 m"],porosity=0.1}]',
        "boxes, entry 1: lower",
        "swap or move",
    ),
    # fractures
    (
        fracture('side="bottm",opening="1 mm",height="1 m"'),
        "entry 1, side",
        "Did you mean 'bottom'?",
    ),
    (fracture('side="bottom",opening="1 mm"'), "entry 1, height is missing", '"0.1 m"'),
    (fracture('side="bottom",opening="1 mm",height="0 m"'), "height", "larger than zero"),
    (fracture('side="bottom",opening="1 mm",height="1 mm"'), "opening", "take higher ones"),
    (
        fracture('start=["0 m","5 m"],end=["99 m","5 m"],opening="1 mm"'),
        "entry 1, end = ",
        "move it in",
    ),
    (
        fracture('start=["0 m","5 m"],end=["0 m","5 m"],opening="1 mm"'),
        "start and end are both",
        "move one of them",
    ),
    (
        fracture('center=["5 m","5 m"],radius="1 m",normal=[1.0,0.0],opening="1 mm"'),
        "a fracture of a 2-D body has start and end",
        "give these",
    ),
    (
        fracture('start=["0 m","5 m"],side="top",end=["5 m","5 m"],opening="1 mm"'),
        "does not go with the other keys",
        "leave it or them out",
    ),
    # wells
    ("reservoir.wells=[]", "reservoir.wells is missing", "write it like wells ="),
    (wells(OUT), "no injector", "add one"),
    (wells(f'{{{IN},rate="1 kg/s",T="60 °C"}}'), "no producer", "add one"),
    (injector('rate="1 kg/s"'), "entry 1 ('in'), rate", 'T = "60 °C"'),
    (injector('rate="1 kg/s"', 'pressure="30 MPa"', 'T="60 °C"'), "both are given", "exactly one"),
    (injector('T="60 °C"'), "neither is given", "exactly one"),
    (injector('rate="-1 kg/s"', 'T="60 °C"'), "it produces", "leave T out"),
    (injector('rate="0 kg/s"', 'T="60 °C"'), "nothing flows", "leave the well out"),
    (injector('rate="1 l/s"', 'T="60 °C"'), "does not measure a mass rate", '"5 kg/s"'),
    (injector('rate="1 kg/s"', 'T="360 °C"'), "reaches 360 °C", "1 to 350 °C"),
    (injector('pressure="10 kPa"', 'T="60 °C"'), "boils below 19.9 kPa", "a higher pressure"),
    (
        wells(OUT, '{name="in",at=["31 m","0 m"],rate="1 kg/s",T="60 °C"}'),
        "entry 2 ('in'), at = ",
        "let reservoir.beyond reach it",
    ),
    (
        wells(OUT, '{name="in",at=["3 m"],rate="1 kg/s",T="60 °C"}'),
        "entry 2 ('in'), at = ",
        "it needs 2 numbers",
    ),
    (
        wells(OUT, '{name="out",at=["3 m","0 m"],rate="1 kg/s",T="60 °C"}'),
        'entry 2, name = "out"',
        "choose another",
    ),
    (
        wells(OUT, '{name="in",at=["30 m","0 m"],rate="1 kg/s",T="60 °C"}'),
        "'out' is in the same cell",
        "move one",
    ),
    (
        wells(OUT, '{name="in",at=["29.8 m","0 m"],rate="1 kg/s",T="60 °C"}'),
        "'out' is in the same cell",
        "move one",
    ),
    (
        wells(OUT, '{name="a/b",at=["3 m","0 m"],rate="1 kg/s",T="60 °C"}'),
        'name = "a/b"',
        "letters, digits, spaces",
    ),
    (
        wells(OUT, '{name="=1+1",at=["3 m","0 m"],rate="1 kg/s",T="60 °C"}'),
        'name = "=1+1"',
        "begin with a letter",
    ),
]
TOGETHER = [
    (("reservoir={}", 'temperature.profile="reservoir"'), "reservoir.temperature", "is missing"),
    ((STRAIN, 'forces.pore_pressure="1 MPa"'), "forces.pore_pressure", "leave it out"),
    (('forces.crack_pressure="1 MPa"',), "forces.crack_pressure", "leave it out"),
    (('forces={gravity=["0 m/s^2","-9.81 m/s^2"],biot=0.5}',), "forces.biot", "reservoir.biot"),
    (("material.k=['2 W/(m K)','3 W/(m K)']",), "material.k = ", "give one number"),
    (('domain.symmetry="axis"',), "domain.symmetry", "take a 3-D body"),
    (
        ('domain={shape={kind="disc",radius="10 m"},h="1 m"}',),
        "domain.shape",
        "take domain.size",
    ),
    (
        (*SOLID, 'reservoir.thickness="2 m"'),
        "reservoir.thickness",
        "leave it out",
    ),
    ((*SOLID,), "entry 1 ('in'), at = ", "it needs 3 numbers"),
    (('reservoir.simulator="single"',), "[reservoir]: ", "water of constant properties"),
    ((*CLOSED, "reservoir.fractures=[]"), "reservoir.fractures is missing", 'side = "bottom"'),
    ((*CLOSED, 'reservoir.temperature={formula="473-y"}'), "one temperature", '"darts"'),
    ((*CLOSED, injector('pressure="30 MPa"', 'T="60 °C"')), "two wells", '"darts"'),
    (('reservoir.simulator="fields"',), "reservoir.fields is missing", "files = [...]"),
    ((FIELDS[2],), "reservoir.fields", "a.vtu"),
    ((*CLOSED, TWO_WAYS), "reservoir.feedback = true", 'take "darts"'),
    ((*FIELDS, TWO_WAYS), "reservoir.fields", "a.vtu"),
    ((TWO_WAYS, "solver.backtracking=true"), "solver.backtracking = true", '"explicit"'),
    ((TWO_WAYS, "reservoir.agreement=0.5"), "reservoir.agreement", "0.1"),
    (
        (TWO_WAYS, 'reservoir.openings={smallest="2 mm",largest="1 mm"}'),
        "reservoir.openings.smallest = ",
        "change one",
    ),
    (
        (TWO_WAYS, 'reservoir.openings={smallest="0 mm"}'),
        "reservoir.openings.smallest",
        "larger than zero",
    ),
    (
        (TWO_WAYS, 'reservoir.openings={largest="1 cm"}'),
        "reservoir.openings.largest = ",
        "that or less",
    ),
    (
        (TWO_WAYS, 'reservoir.openings={spread="5 m"}'),
        "reservoir.openings.spread = ",
        "at least 6 m",
    ),
    (
        (TWO_WAYS, 'reservoir.openings={largest="0.1 mm"}'),
        'side = "bottom": opening = "0.2 mm"',
        "change one",
    ),
    ((TWO_WAYS, 'reservoir.openings={width="1 mm"}'), "has no key 'width'", "it has"),
]


def read(settings: Sequence[str] = ()) -> Case:
    case = parse_case(GOOD, settings)
    require_loaded(case)
    return case


@pytest.mark.parametrize(("setting", "names", "way_out"), BAD, ids=lambda v: v[:50])
def test_a_bad_reservoir_is_refused_in_one_sentence(setting: str, names: str, way_out: str) -> None:
    check_sentence(sentence_of(lambda: read([setting])), names, way_out)


@pytest.mark.parametrize(("settings", "names", "way_out"), TOGETHER, ids=lambda v: str(v)[:50])
def test_what_does_not_go_with_a_reservoir_is_refused_in_one_sentence(
    settings: tuple[str, ...], names: str, way_out: str
) -> None:
    said = sentence_of(lambda: read(settings)).replace(str(Path.cwd()), "")
    check_sentence(said, names, way_out)


def test_a_reservoir_is_needed_in_si_units() -> None:
    scaled = GOOD[: GOOD.index("[reservoir]")] + "[reservoir]\n[time]\nt = [1.0]\n"
    for given in ('"30 m", "15 m"', '"1 m"', '"3 m"'):
        scaled = scaled.replace(given, given.replace(" m", "").replace('"', ""))
    scaled = "\n".join(line for line in scaled.splitlines() if '"' not in line or "prof" in line)
    check_sentence(sentence_of(lambda: parse_case(scaled)), "[reservoir] needs units", "a unit")


def test_a_reservoir_without_its_table_is_refused() -> None:
    gone = GOOD[: GOOD.index("[reservoir]")] + GOOD[GOOD.index("[time]") :]
    check_sentence(sentence_of(lambda: parse_case(gone)), "[reservoir] is missing", "doublet")


def test_a_name_of_a_program_is_taken_with_leave_and_not_kept(tmp_path: Path) -> None:
    program = tmp_path / "python"
    program.touch()
    (tmp_path / "my.toml").write_text(GOOD.replace("[reservoir]", '[reservoir]\npython = "python"'))
    said = sentence_of(lambda: read_case(tmp_path / "my.toml"))
    check_sentence(said, "reservoir.python", "STAFFA_DARTS")
    case = read_case(tmp_path / "my.toml", outside=True)
    assert case.reservoir is not None and case.reservoir.interpreter == str(program)
    assert "python" not in to_toml(case), "the record of a run names no program"


def test_a_case_becomes_the_model_of_a_simulator() -> None:
    model = reservoir_model(read())
    lower, upper = ((edges[0], edges[-1]) for edges in model.grid.edges[:2])
    assert lower == (0, 30) and upper == pytest.approx((-0.05, 40))
    row = model.grid.row((1, -1))
    rock = np.setdiff1d(np.arange(model.grid.size), row)
    assert model.permeability[row] == pytest.approx(0.2e-3**3 / (12 * 0.1), rel=1e-12)
    assert model.permeability[rock] == pytest.approx(1e-16, rel=1e-12)
    assert model.rho_c[rock] == pytest.approx(2650 * 868) and np.all(model.conductivity == 2.5)
    assert np.all(model.T == 473.15) and np.all(model.p == 20e6) and model.water is None
    into, out = model.wells
    assert (into.name, into.rate, into.T, into.pressure) == ("in", 0.005, 333.15, None)
    assert set(into.cells) | set(out.cells) <= set(row), "wells on a side lie in its fracture"


def test_properties_of_the_reservoir_are_those_of_the_place() -> None:
    """Formulas, boxes and regions; beyond the body the rock is that of the nearest place."""
    model = reservoir_model(
        read(
            [
                "reservoir.fractures=[]",
                'reservoir.permeability={formula="1e-16*(2 + x/30)"}',
                'reservoir.boxes=[{lower=["0 m","10 m"],upper=["30 m","50 m"],porosity=0.2}]',
                'reservoir.temperature={value="200 °C",gradient=["0 K/m","-1 K/m"]}',
                'regions={lid={lower=["0 m","12 m"],upper=["30 m","15 m"],k="5 W/(m K)"}}',
                'forces.gravity=["0 m/s^2","-9.81 m/s^2"]',
            ]
        )
    )
    x, y, _ = model.grid.centers.T
    assert model.permeability == pytest.approx(1e-16 * (2 + x / 30), rel=1e-12)
    assert np.array_equal(model.porosity, np.where(y > 10, 0.2, 0.01))
    assert pytest.approx(473.15 - y, rel=1e-12) == model.T
    assert np.array_equal(model.conductivity, np.where(y > 12, 5.0, 2.5)) and y.max() > 15
    assert model.gravity == (0, -9.81, 0)


def test_a_fracture_in_the_rock_conducts_by_the_cube_of_its_opening() -> None:
    """Through each section across it: area times permeability is thickness w^3/12 more."""
    line = fracture('start=["0 m","7 m"],end=["30 m","7 m"],opening="1 mm"')
    given = wells(
        '{name="in",at=["0 m","7 m"],rate="1 kg/s",T="60 °C"}',
        '{name="out",at=["30 m","7 m"],pressure="20 MPa"}',
    )
    model = reservoir_model(read([line, given, 'reservoir.thickness="2 m"', "reservoir.beyond={}"]))
    section = model.grid.volumes / model.grid.sizes[:, 0]
    added = section * (model.permeability[:, 0] - 1e-16)
    more = added.reshape(model.grid.shape, order="F").sum(1)
    assert more[5:-5] == pytest.approx(2 * 1e-9 / 12, rel=1e-3), "away from its ends"


def test_a_solid_has_a_reservoir_too() -> None:
    given = wells(
        '{name="in",at=["5 m","5 m","5 m"],rate="1 kg/s",T="60 °C"}',
        '{name="out",at=["25 m","25 m","5 m"],rate="-1 kg/s"}',
    )
    disc = fracture(
        'center=["15 m","15 m","5 m"],radius="14 m",normal=[0.0,0.0,1.0],opening="1 mm"'
    )
    model = reservoir_model(read([*SOLID, given, disc, 'reservoir.h="3 m"']))
    assert model.grid.dim == 3 and model.permeability.max() > 1e-13
    for well in model.wells:
        center = model.grid.centers[well.cells[0]]
        assert np.all(np.abs(center - 5) < 2) or np.all(np.abs(center - [25, 25, 5]) < 2)


def test_the_water_presses_in_pores_by_biot_and_on_the_fracture() -> None:
    stress, strain = forces(read()), forces(read([STRAIN]))
    assert (stress.fluid, stress.biot, strain.biot) == (True, 0.0, 1.0)
    assert stress.fluid_sides == ("bottom",) and stress.balanced
    squeezed = 'forces.prestress={xx="-30 MPa",yy="-20 MPa"}'
    assert not forces(read([squeezed])).balanced, "a total stress is beside the whole pressure"
    assert forces(read([STRAIN, "reservoir.biot=0.5"])).biot == 0.5
    plain = forces(
        parse_case(
            GOOD[: GOOD.index("[reservoir]")]
            .replace('profile = "reservoir"', 'profile = "none"')
            .replace('k = "2.5 W/(m K)"', "")
            .replace('rho = "2650 kg/m^3"', "")
            .replace('c = "868 J/(kg K)"', "")
            + '[time]\nt = ["1 s"]'
        )
    )
    assert not plain.fluid and plain.at_rest


def told(*settings: str) -> Preview:
    return preview(read(settings))


def test_breakthrough_is_that_of_the_closed_form() -> None:
    """Lauwerier: one wall takes the heat of the flow of 5 g/s and metre, erfc = drawdown."""
    case = read([CLOSED[1]])
    found = breakthrough(case)
    assert found is not None
    k, rho_c = 2.5, 2650 * 868
    for t, share in zip(found[0], DRAWDOWNS, strict=True):
        there = erfc(k * 30 / (2 * 4200 * 0.005 * np.sqrt(k / rho_c * t)))
        assert there == pytest.approx(share, rel=1e-9)


def test_breakthrough_of_two_wells_in_a_layer_begins_with_the_shortest_way() -> None:
    """pi h D^2 (rho c)/(3 c q) for the straight streamline, later for the others."""
    case = read(["reservoir.fractures=[]", "reservoir.beyond={}", CLOSED[1]])
    found = breakthrough(case)
    assert found is not None
    stored = 0.01 * 4.2e6 + 0.99 * 2650 * 868
    first = np.pi * 30**2 * stored / (3 * 4200 * 0.005)
    assert found[0][0] == pytest.approx(first, rel=1e-3) and first < found[0][0] < found[0][1]
    assert (
        breakthrough(read(["reservoir.boxes=[]", injector('pressure="30 MPa"', 'T="60 °C"')]))
        is None
    )


def test_check_tells_of_the_simulator_and_of_the_scales(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv(VARIABLE, "/nowhere/python")
    known = told()
    facts = {name: (value, meaning) for name, value, meaning in known.facts}
    assert facts["simulator"][0] == "not found" and "make reservoir" in facts["simulator"][1]
    assert any("/nowhere/python" in said and "make reservoir" in said for said in known.warnings)
    c, rate, length, k, half = 4250, 0.005, 30, 2.5, 0.05
    assert float(facts["Peclet number"][0]) == pytest.approx(c * rate * length / k / half, rel=0.01)
    kappa = 2.5 / 2650 / 868
    assert float(facts["Fourier number"][0]) == pytest.approx(kappa * 20 * 86400 / 40**2, rel=0.1)
    value, meaning = facts["thermal stress"]
    over = 40e9 * 8e-6 * 140 / derived_numbers(read()).sigma_c
    assert value == "44.8 MPa" and f"E expansion dT: {over:.3g} sigma_c" in meaning
    assert facts["thermal breakthrough"][1].startswith("drawdown of 0.01 and 0.1: one fracture")
    for name in ("memory of the simulator", "time of the simulator"):
        assert facts[name][0].startswith("about"), facts


def test_the_flow_in_cracks_and_its_cost_are_told() -> None:
    def facts(*settings: str) -> dict[str, tuple[str, str]]:
        return {name: (value, meaning) for name, value, meaning in told(*settings).facts}

    assert facts()["flow in cracks"][0] == "none"
    value, meaning = facts(TWO_WAYS)["flow in cracks"]
    assert value == "20 um to 2 mm" and "spread over 6 m" in meaning and "24 m" in meaning
    # Once for the way, twice more to agree, and once for the shadow.
    ways = ((), (TWO_WAYS, 'reservoir.coupling="explicit"'), (TWO_WAYS,))
    shown = [facts(*settings)["time of the simulator"][0] for settings in ways]
    assert shown == ["about 4 s", "about 5 s", "about 7 s"]


@pytest.mark.parametrize(
    ("settings", "part"),
    [
        ((STRAIN,), "in plane strain no crack of the plane relieves the stress"),
        ((injector('rate="5 g/s"', 'T="250 °C"'),), "this water heats the rock"),
        ((injector('pressure="19 MPa"', 'T="60 °C"'),), "an injector that takes water out"),
        ((injector('rate="5 g/s"', 'T="199 °C"'),), "hardly anything will crack"),
        ((fracture('side="bottom",opening="1 mm",height="2 m"'),), "height <= 265 mm"),
        (('time.t=["1 days","20 years"]',), "reservoir.beyond.top >= "),
        (("reservoir.fractures=[]", 'reservoir.h="5 m"'), "take h <= 1.3 m"),
        (('reservoir.h="5 m"',), "take h <= 3 m"),
        (
            (injector('rate="5 g/s"', 'T="60 °C"').replace('pressure="20 MPa"', 'rate="-6 g/s"'),),
            "its pressure falls",
        ),
        (('reservoir.permeability="1e-20 m^2"',), "pores are so tight"),
        (("reservoir.shadow=false",), "reservoir.shadow = false does not count"),
        (('reservoir.openings={smallest="1 um"}',), "reservoir.openings = "),
        (("reservoir.agreement=1e-4",), "give reservoir.feedback = true"),
        (('reservoir.coupling="explicit"',), "reservoir.coupling = "),
        ((TWO_WAYS, "reservoir.agreement=1e-4"), "take agreement >= 0.001"),
        ((TWO_WAYS, 'reservoir.openings={spread="20 m"}'), "the cells hardly tell one"),
    ],
    ids=lambda v: str(v)[:40],
)
def test_a_likely_mistake_is_warned_of(settings: tuple[str, ...], part: str) -> None:
    warned = [said for said in told(*settings).warnings if part in said]
    assert len(warned) == 1 and "\n" not in warned[0], told(*settings).warnings


def test_water_that_damages_all_cooled_rock_is_warned_of_with_ways_out() -> None:
    """12 mu q L/w^3 = 135 kPa, where 3 Gc/(8 ell) over 2 expansion dT = 5.58 kPa is borne."""
    water, said = CLOSED[1], "damages all of this rock"
    (warned,) = [text for text in told(water).warnings if said in text]
    assert "by up to 135 kPa" in warned and "above 5.58 kPa" in warned
    assert "opening >= 579 um, damage.ell <= 124 mm, or a rate <= 0.000206 kg/s" in warned

    def warns(*settings: str) -> bool:
        return any(said in text for text in told(water, *settings).warnings)

    for opening, expected in ((570, True), (579, False)):
        given = fracture(f'side="bottom",opening="{opening} um",height="0.1 m"')
        assert warns(given) is expected, opening
    for rate, expected in ((0.000210, True), (0.000206, False)):
        assert warns(injector(f'rate="{rate} kg/s"', 'T="60 °C"')) is expected, rate
    assert not warns(STRAIN), "pores carry the pressure, cracked or not"
    assert not warns('damage.law="AT2"'), "no threshold"


def test_no_split_is_asked_for_where_water_presses_a_block_by_less_than_the_strength() -> None:
    """At most 12 mu q/w^3 4/pi ln(L/r): 55 kPa for 0.2 mm, 6.8 kPa for 0.4 mm, and the strength is
    0.71 MPa."""
    ways = [
        '{name="in",at=["0 m","15 m","0 m"],rate="0.005 kg/s",T="60 °C"}',
        '{name="out",at=["30 m","15 m","0 m"],pressure="20 MPa"}',
    ]
    for opening, expected in (("0.2 mm", True), ("0.4 mm", False)):
        given = fracture(f'side="bottom",opening="{opening}",height="0.1 m"')
        warned = told(*SOLID, wells(*ways), given, 'damage.split="none"').warnings
        assert any("breaks as easily as under tension" in w for w in warned) is expected, warned


def test_water_boils_below_the_pressure_of_the_steam_tables() -> None:
    """IAPWS: 0.101325 MPa at 373.124 K, 1.5549 MPa at 473.15 K, 22.064 MPa at 647.096 K."""
    found = saturation_pressure(np.array([373.124, 473.15, 647.096, 700.0]))
    assert found == pytest.approx([101325, 1.5549e6, 22.064e6, 22.064e6], rel=1e-4)


def test_a_wall_can_be_computed_in_closed_form() -> None:
    load = reservoir_load(read([*CLOSED, injector('rate="5 g/s"', 'T="60 °C"')]))
    assert isinstance(load, ReservoirLoad)
    engine = load.open()
    _, account, _ = engine.advance(engine.start(), None, 3 * 86400.0)
    assert 1e-7 < account.imbalance < load.balance, "a sum over cells, which the audit accepts"


def table(folder: Path, name: str, rows: Sequence[tuple[float, float, float, float]]) -> None:
    lines = [",".join(f"{value:g}" for value in row) for row in rows]
    (folder / name).write_text("\n".join(["x,y,T,p", *lines]) + "\n")


def given_by_files(folder: Path, *settings: str) -> Case:
    """T falls at y = 0 by 100 K from the first file to the second, and p rises by 1 MPa."""
    for name, cold in (("a.csv", 0.0), ("b.csv", 100.0)):
        corners = [(x, y) for x in (0.0, 30.0) for y in (0.0, 15.0)]
        rows = [(x, y, 200 - cold * (1 - y / 15), 20 + cold / 100) for x, y in corners]
        table(folder, name, rows)
    text = GOOD[: GOOD.index("[reservoir]")] + GOOD[GOOD.index("[time]") :]
    (folder / "my.toml").write_text(text)
    given = 'files=["a.csv","b.csv"],T="T",T_unit="°C",p="p",p_unit="MPa"'
    fields = f'reservoir.fields={{t=["0 s","30 d"],{given}}}'
    case = read_case(folder / "my.toml", ['reservoir.simulator="fields"', fields, *settings])
    require_loaded(case)
    return case


def test_files_of_any_simulator_give_temperature_and_pressure(tmp_path: Path) -> None:
    case = given_by_files(tmp_path)
    assert case.reservoir is not None and case.reservoir.fields is not None
    series, x = case.reservoir.fields.series, np.array([[15.0], [0.0], [0.0]])
    assert series.temperature(x, 15 * 86400.0) == pytest.approx([-50])
    assert series.pressure is not None and series.pressure(x, 0.0) == pytest.approx([20e6])
    assert forces(case).fluid and derived_numbers(case).dT == pytest.approx(100)
    assert [file.name for file in attached(case)] == ["a.csv", "b.csv"]
    facts = {name: value for name, value, _ in preview(case).facts}
    assert facts["reservoir"] == "2 files" and "simulator" not in facts


@pytest.mark.parametrize(
    ("setting", "names", "way_out"),
    [
        ('time.t=["40 d"]', 'ends at "30 d"', "end the run earlier"),
        ('reservoir.fields.t=["1 s","30 d"]', 'begins at "1 s"', 't = "0 s" too'),
        ('reservoir.fields.t=["0 s"]', "t has 1 numbers", "as many of each"),
        ('reservoir.fields.t=["0 s","0 s"]', "comes after", "increasing order"),
        ('reservoir.fields.T_unit="MPa"', "T_unit", '"20 °C"'),
        ('reservoir.fields.T="X"', "X", "it has"),
        ('reservoir.fields.unit="1 mm"', "does not cover the body", "unit = "),
        ('reservoir.fields.files=["a.csv","c.csv"]', "there is no file", "folder of the case"),
        (wells(OUT), "reservoir.wells", "leave one of them out"),
        ('reservoir.permeability="1e-15 m^2"', "reservoir.permeability", "leave one of them out"),
    ],
    ids=lambda v: v[:40],
)
def test_bad_files_of_a_simulator_are_refused_in_one_sentence(
    tmp_path: Path, setting: str, names: str, way_out: str
) -> None:
    said = sentence_of(lambda: given_by_files(tmp_path, setting))
    check_sentence(said.replace(str(tmp_path), ""), names, way_out)


def test_a_pressure_that_broken_rock_does_not_bear_is_told_before_the_run() -> None:
    """12 mu q L/w^3 of both halves, against sqrt(.01 eta) sigma_c. With ell = 1.5 m and h = 0.5 m
    runs of 60 days ended with the body in two at 0.5, 0.6, 0.7 and 0.8 mm, and not at 1 mm."""
    water = 'reservoir.water={rho="1000 kg/m^3",c="4200 J/(kg K)",mu="0.3 mPa s"}'
    single = ["reservoir.feedback=false", 'reservoir.simulator="single"', water]
    single += ["damage.ell=1.5 m", "domain.h=0.5 m", "reservoir.h=1 m"]

    def warned(opening: float) -> list[str]:
        fracture = f'[{{side="bottom",opening="{opening} mm",height="0.1 m"}}]'
        case = ready_case("fracture-wall", [*single, f"reservoir.fractures={fracture}"])
        return [w for w in preview(case).warnings if "the body in two" in w]

    (told,) = warned(0.8)
    check_sentence(told, "up to 2.11 kPa", "above about 1 kPa", "take opening >= 1.03 mm")
    assert warned(0.5) and not warned(1.1)
    assert not [w for w in preview(ready_case("fracture-wall")).warnings if "body in two" in w]

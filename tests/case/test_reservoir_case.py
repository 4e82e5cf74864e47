"""The table [reservoir]: bad inputs in one sentence each, and the model that a case becomes."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest
from scipy.special import erfc

from case.test_bad_input import check_sentence, sentence_of
from staffa.case.check.preview import Preview, preview
from staffa.case.reading.read import parse_case, read_case
from staffa.case.rules import require_loaded
from staffa.case.scales.breakthrough import DRAWDOWNS, breakthrough
from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import to_toml
from staffa.case.values.applied_forces import forces
from staffa.case.values.reservoir_model import reservoir_model
from staffa.physics.saturation import saturation_pressure
from staffa.reservoir.interpreter import VARIABLE

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
    ("reservoir.feedback=true", "reservoir.feedback = true", "leave it out"),
    ('reservoir.simulator="tough"', "reservoir.simulator", '"darts", "single", "fields"'),
    ('reservoir.python="/bin/sh"', "reservoir.python", "allow it with --outside"),
    ('reservoir.openings={smallest="1 um"}', "has no key 'openings'", "it has agreement"),
    ("reservoir.shadow=true", "has no key 'shadow'", "it has agreement"),
    # rock and water
    ("reservoir.temperature={}", "reservoir.temperature", "write"),
    ('reservoir.temperature="400 °C"', "reaches 400 °C", "constant properties"),
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
    ("reservoir.agreement=0.5", "reservoir.agreement = 0.5", "between 1e-08 and 0.1"),
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
    (injector('rate="1 kg/s"', 'T="360 °C"'), "T = ", "take a lower one"),
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
        "'out' is at the same place",
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
        ('domain={shape={kind="disc",radius="10 m"},h="1 m"}', 'temperature.face="side"'),
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

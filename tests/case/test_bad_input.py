"""Bad input: one sentence that names the key and the way out, exit code 2, nothing written."""

import os
import re
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

from staffa.case.check.preview import preview
from staffa.case.reading import ready_cases
from staffa.case.reading.read import parse_case, read_case
from staffa.case.reading.size_limits import LARGEST_FILE
from staffa.case.rules import require_loaded
from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import inline
from staffa.errors import InputError
from staffa.io import run_directory
from support.commands import forked
from support.paths import BIN

GOOD = """
title = "small"
[domain]
size = [1.0, 1.0]
h = 0.1
[damage]
ell = 0.3
[temperature]
severity = 10.0
[time]
t = [0.1, 0.2]
"""
PULLED = ("temperature={}", 'temperature.profile="none"')
HEATED = ("temperature={}", 'temperature.profile="heat"', "heat.initial=1.0")
COOLED = (*HEATED, "heat.bottom={T=0.0}")
FORMULA = ('temperature={profile="formula",T="-9*t*exp(-y)"}',)
SOLID = ("domain.size=[1.0, 1.0, 1.0]",)
# What no user should have to know.
JARGON = (
    "Input should|Value error|validat|pydantic|NoneType|Tuple|tuple|dict|literal|float|Traceback"
    "|Error|None|True|False|Keys|Segment|Disc\\b|UniformT|AdaptiveT|Prescribed|Quantity|namespace|recursion"
    "|Formula\\b|Geotherm|InTime|InTemp|Heat[A-Z]|Force[A-Z]|SideF|StressW|Node"
)
ENDS, PACE = "start=0.1,stop=0.2", "shortest=0.01,longest=0.1"
BOX = "lower=[0.0,0.0], upper=[1.0,0.1]"

# The change to the good case; what the sentence names; the rule or the way out.
VALUES = [
    ('solver.guess="fine"', 'solver.guess = "fine"', 'one of "coarser", "none"'),
    ('solver.stability="yes"', "solver.stability", 'one of "test", "report", "follow", "none"'),
    ('solver.backtracking="yes"', "solver.backtracking", "true or false, without quotes"),
    ("solver.backtracking=3", "solver.backtracking = 3", "true or false, without quotes"),
    ("solver.backtracking_tolerance=2", "solver.backtracking_tolerance = 2", "1e-14 and 0.1"),
    ("solver.backtracking_tolerance=0.0", "solver.backtracking_tolerance", "larger than zero"),
    # probes
    ("output.checkpoint=3", "output.checkpoint = 3", "write checkpoint like { steps = 10"),
    ("output.checkpoint={steps=0}", "output.checkpoint.steps = 0", "at least 1"),
    ("output.checkpoint={minutes=0.0}", "output.checkpoint.minutes = 0.0", "larger than zero"),
    ("output.checkpoint={hours=1}", "output.checkpoint", "minutes, steps"),
    ("output.probes=3", "output.probes = 3", "write probes like"),
    ('output.probes=[{name="a"}]', "output.probes, entry 1, point is missing", "point = [0.5"),
    ("output.probes=[{point=[0.5,0.5]}]", "entry 1, name is missing", "name ="),
    ('output.probes=[{name="",point=[0.5,0.5]}]', 'name = ""', "a name has 1 to 60 characters"),
    ('output.probes=[{name=" ",point=[0.5,0.5]}]', 'name = " "', "1 to 60 characters"),
    ('output.probes=[{name="a\\nb",point=[0.5,0.5]}]', "name = ", "that can be printed"),
    ('output.probes=[{name="a",point=[2.0,0.5]}]', "point = [2.0, 0.5] lies outside", "move it in"),
    ('output.probes=[{name="a",point=[0.5]}]', "point = [0.5]", "it needs 2 numbers"),
    ('output.probes=[{name="a",start=[0.0,0.0],end=[0.5,9.0]}]', "end = [0.5, 9.0]", "move it in"),
    ('output.probes=[{name="a",start=[0.1,0.1],end=[0.1,0.1]}]', "start and end", "give a point"),
    ('output.probes=[{name="a",start=[0.0,0.0]}]', "entry 1, end is missing", "end = [0.5"),
    (
        'output.probes=[{name="a",start=[0.0,0.0],end=[0.5,0.5],points=1}]',
        "entry 1, points = 1",
        "at least 2",
    ),
    (
        'output.probes=[{name="a",start=[0.0,0.0],end=[0.5,0.5],points=5000}]',
        "entry 1, points = 5000",
        "at most 1,000",
    ),
    (
        'output.probes=[{name="a",point=[0.1,0.1]},{name="a",point=[0.2,0.2]}]',
        'entry 2, name = "a"',
        "choose another",
    ),
    ('output.probes=[{name="a",point=[0.1,0.1],end=[0.2,0.2]}]', "'point'", "leave it or them out"),
    # the body
    ("domain.size=3", "domain.size = 3", "write size like [5.0, 1.0]"),
    ('domain.size="5 mm"', 'domain.size = "5 mm"', "write size like [5.0, 1.0]"),
    ("domain.size=[1.0]", "domain.size = [1.0]", "two numbers (2-D) or three (3-D)"),
    ("domain.size=[]", "domain.size = []", "two numbers (2-D) or three (3-D)"),
    ("domain.size=[1,1,1,1]", "domain.size = [1, 1, 1, 1]", "two numbers (2-D) or three (3-D)"),
    ("domain.size=[1.0,-1.0]", "domain.size, entry 2 = -1.0", "larger than zero"),
    ("domain.size=[1.0,inf]", "domain.size, entry 2 = inf", "a finite number"),
    ("domain.size=[true,1.0]", "domain.size, entry 1 = true", 'a text like "5 mm"'),
    ("domain.h=0", "domain.h = 0", "larger than zero"),
    ("domain.h=-0.0", "domain.h = -0.0", "larger than zero"),
    ("domain.h=nan", "domain.h = nan", "a finite number"),
    ("domain.h=1e400", "domain.h = inf", "a finite number"),
    ("domain.h=1e-40", "domain.h = 1e-40", "between 1e-30 and 1e+30; check its unit"),
    (f"domain.h=1{'0' * 400}", "domain.h = 1000", "between 1e-30 and 1e+30; check its unit"),
    ("domain.h=1e-9", "domain.h = 1e-09", "take a larger h"),
    ("domain.h=2.0", "domain.h = 2.0", "take a smaller h"),
    ("domain.h=[0.1]", "domain.h = [0.1]", 'a text like "5 mm"'),
    ("domain.h=1979-05-27", "domain.h = 1979-05-27", 'a text like "5 mm"'),
    ('domain.h=""', 'domain.h = ""', 'write it like "5 mm"'),
    ('domain.h="0.1"', 'domain.h = "0.1"', "leave out the quotes if the case is scaled"),
    ('domain.h="5 mm/s"', "'mm/s' does not measure a length", 'write it like "5 mm"'),
    ('domain.h="5 mn"', "'mn' is no unit that staffa knows", 'write it like "5 mm"'),
    ('domain.h="1,5 mm"', "',5 mm' is no unit", 'write it like "5 mm"'),
    ('domain.h="9**9**9**9 m"', "domain.h", 'write it like "5 mm"'),
    ('domain.cells="hexahedron"', "domain.cells", "use quadrilateral or triangle or unstructured"),
    ('domain.cells="triangel"', "domain.cells", "Did you mean 'triangle'?"),
    ('domain.elements="cubic"', "domain.elements", '"linear", "quadratic", "reduced"'),
    ('domain.elements="quadratic"', "does not fit quadrilateral cells", '"linear" and "reduced"'),
    ("domain.cells=4", "domain.cells = 4", '"quadrilateral", "triangle"'),
    # the rock
    ("material.E=-70.0", "material.E = -70.0", "larger than zero"),
    ('material.E="70 gpa"', "'gpa' is no unit", 'write it like "70 GPa"'),
    ('material.E="GPa"', 'material.E = "GPa"', "begins with a number"),
    ('material.E="5 mm"', "'mm' does not measure a stress", 'write it like "70 GPa"'),
    ('material.E="70 GPa"', 'material.E = "70 GPa" has one', "give every number a unit, or none"),
    ("material.Gc=0.0", "material.Gc = 0.0", "larger than zero"),
    ("material.nu=0.6", "material.nu = 0.6", "at most 0.5"),
    ("material.nu=-1", "material.nu = -1", "larger than -1"),
    ("material.nu=true", "material.nu = true", "one number, without quotes"),
    ('material.nu="0.2"', 'material.nu = "0.2"', "one number, without quotes"),
    ("material.nu=inf", "material.nu = inf", "a finite number"),
    ('material.plane="shear"', "material.plane", '"stress", "strain"'),
    # the damage
    ("damage.ell=0.05", "damage.ell = 0.05", "set damage.allow_coarse = true"),
    ("damage.ell=2.0", "damage.ell = 2.0", "take a smaller ell"),
    ('damage.law="AT3"', "damage.law", '"AT1", "AT2"'),
    ('damage.law="at1"', "damage.law", "Did you mean 'AT1'?"),
    ('damage.irreversibility="crackset"', "damage.irreversibility", "Did you mean 'crack set'?"),
    ("damage.crack_set_threshold=1.5", "damage.crack_set_threshold = 1.5", "at most 1"),
    ("damage.residual_stiffness=0", "damage.residual_stiffness = 0", "larger than 0"),
    ('damage.allow_coarse="yes"', "damage.allow_coarse", "true or false, without quotes"),
    # its variation
    ("toughness.amplitude=1.0", "toughness.amplitude = 1.0", "less than 1"),
    ("toughness.seed=1.5", "toughness.seed = 1.5", "a whole number"),
    ("toughness.seed=-1", "toughness.seed = -1", "at least 0"),
    ("toughness.bands=[3]", "toughness.bands, entry 1 = 3", "write bands like [{ lower"),
    (f"toughness.bands=[{{{BOX}}}]", "entry 1, factor is missing", "factor = 3.0"),
    (f"toughness.bands=[{{{BOX}, factor=0}}]", "entry 1, factor = 0", "larger than zero"),
    # the cooling
    ('temperature.face="botom"', "face 'botom'", "Did you mean 'bottom'?"),
    ('temperature.face="front"', "face 'front'", "it has bottom, left, right, top"),
    ("temperature.face=3", "temperature.face = 3", "a text in quotes"),
    ("temperature.dT=3.0", "temperature.dT and temperature.severity", "give exactly one of them"),
    ('temperature.dT="5 degC"', "'degC' has its own zero", 'write it like "120 K"'),
    ("temperature.severity=-1", "temperature.severity = -1", "larger than zero"),
    ('temperature.profile="halfspace"', "temperature.profile", "Did you mean 'half-space'?"),
    ('temperature.profile="none"', "temperature.severity = 10.0", "leave one of them out"),
    ('temperature.profile="convective"', "temperature.biot is missing", "biot = 10.0"),
    ("temperature.biot=3.0", "temperature.biot = 3", 'temperature.profile = "convective"'),
    ('temperature.T="-t"', 'T = "-t" has no meaning', 'take temperature.profile = "formula"'),
    ('temperature={profile="formula"}', "temperature.T is missing", 'write it like T = "-80*exp('),
    ("temperature.T=3", "temperature.T = 3", "a text in quotes"),
    ("heat.initial=1.0", "[heat] has no meaning with temperature.profile", "leave it out"),
    ("material.k=2.0", "material.k = 2.0 has no meaning", "give kappa, which is k/(rho c)"),
    ("material.rho=2.0", "material.rho = 2.0 has no meaning", "give kappa"),
    ("material.c=2.0", "material.c = 2.0 has no meaning", "give kappa"),
    ("heat=4", "heat = 4", "a line [heat] with its keys below it"),
    # the supports
    ('supports.left="roller"', "supports.left", "Did you mean 'rollers'?"),
    ("supports.left=3", "supports.left = 3", "or a table like { y = {"),
    ("supports.left={}", "supports.left = {}", "give at least one of x, y"),
    ("supports.left={q=1}", "supports.left has no key 'q'", "it has x, y, z"),
    ("supports.left={z=1}", "supports.left.z", "it has x and y"),
    ("supports.left={x=true}", "supports.left.x = true", 'a text like "5 mm"'),
    ("supports.left={x={t=[0,1]}}", "supports.left.x.u is missing", "u = [0.0, 0.1]"),
    ("supports.left={x={t=[0,1],u=[0]}}", "t has 2 numbers and u has 1", "as many of each"),
    ("supports.left={x={t=[],u=[]}}", "t has 0 numbers and u has 0", "at least one"),
    ("supports.left={x={t=[1,0],u=[0,1]}}", "supports.left.x.t: 0.0 comes after 1.0", "order"),
    ("supports.left={x={t=[0,1],u=[0,nan]}}", "supports.left.x.u, entry 2 = nan", "finite"),
    ('supports.front="rollers"', "supports.front", "it has bottom, left, right, top"),
    ('supports.section="bend"', "supports.section", '"stretch", "free"'),
    # the cracks
    ("cracks=3", "cracks = 3", "write cracks like [{ start = [0.5, 0.0]"),
    ("cracks=[{start=[0.5,0]}]", "cracks, entry 1, end is missing", "end = [0.5, 0.1]"),
    ("cracks=[{start=[0.5,0],end=[0.5,0,1]}]", "cracks, entry 1, end", "it needs 2 numbers"),
    ("cracks=[{start=[0.5,0],end=[0.5,0]}]", "both [0.5, 0.0]", "a crack needs a length"),
    ("cracks=[{start=[0.5,0],end=[0.5,4]}]", "end = [0.5, 4.0] lies outside", "move it in"),
    ("cracks=[{center=[0,0],radius=1,normal=[1,0]}]", "cracks, entry 1", "this body is 2-D"),
    # the times
    ("time.t=[]", "time.t = []", "give at least one time"),
    ("time.t=0.1", "time.t = 0.1", "write t like { start"),
    ("time.t=[0.2,0.1]", "time.t: 0.1 comes after 0.2", "in increasing order"),
    ("time.t=[0.1,0.1]", "time.t: 0.1 comes after 0.1", "no two of them equal"),
    ("time.t=[-1.0,0.1]", "time.t, entry 1 = -1.0", "must not be negative"),
    ("time.t=[0.0,0.1]", "time.t: the first time is 0", "start later"),
    ("time.tau=[0.1]", "time.tau and time.t: both are given", "give exactly one of them"),
    ("time={}", "time.tau and time.t: neither is given", "give exactly one of them"),
    ("time.t={start=0.1,stop=0.2,steps=0}", "time.t.steps = 0", "at least 2"),
    ("time.t={start=0.1,stop=0.2,steps=1}", "time.t.steps = 1", "or give a list"),
    ("time.t={start=0.1,stop=0.2,steps=2.5}", "time.t.steps = 2.5", "a whole number"),
    ("time.t={start=0.1,stop=0.2,steps=1000000}", "time.t.steps", "at most 100,000"),
    ("time.t={start=0.2,stop=0.1,steps=3}", "stop = 0.1 must be larger", "start = 0.2"),
    ("time.t={start=0.1,stop=0.2}", "time.t.steps is missing", "steps = 40"),
    ("time.t={start=0.1,stop=0.2,shortest=0.01}", "time.t.longest is missing", "longest = "),
    ("time.t={start=0.1,stop=0.2,longest=0.01}", "time.t.shortest is missing", "shortest = "),
    (f"time.t={{{ENDS},shortest=0.0,longest=0.1}}", "time.t.shortest = 0.0", "larger than zero"),
    (f"time.t={{{ENDS},shortest=0.2,longest=0.1}}", "longest = 0.1 must not", "shortest = 0.2"),
    (f"time.t={{start=0.2,stop=0.1,{PACE}}}", "stop = 0.1 must be larger", "start = 0.2"),
    (
        f"time.t={{{ENDS},{PACE},steps=3}}",
        "time.t: 'steps' does not go with",
        "leave it or them out",
    ),
    (f"time.t={{{ENDS},{PACE},advance=0.5}}", "advance = 0.5 ell is less", "a larger advance"),
    (f"time.t={{{ENDS},shortest=1e-13,longest=0.1}}", "shortest = 1e-13 is less", "a longer one"),
    (f"time.t={{{ENDS},{PACE},growth=-1.0}}", "time.t.growth = -1.0", "larger than zero"),
    (f"time.t={{start=0.0,stop=0.1,{PACE}}}", "time.t: the first time is 0", "start later"),
    # the outputs, measures and solvers
    ("output.at=[0.3]", "output.at: 0.3 lies outside the run", "goes to t = 0.2"),
    ("output.at=[0.0]", "output.at: 0.0 lies outside the run", "leave it out"),
    ("output.at=[0.1,0.1]", "output.at: 0.1 is there twice", "leave one out"),
    ('output.at=["1 s"]', 'output.at = "1 s" has one', "give every number a unit, or none"),
    ("output.at=0.1", "output.at = 0.1", "write at like [0.1, 0.2, 0.4]"),
    ('output.steps="some"', "output.steps", '"requested", "all"'),
    ('output.fields="all"', 'output.fields = "all"', "called output.steps now"),
    ("output.fields=3", "output.fields = 3", 'write fields like ["u", "alpha"'),
    ('output.fields=["alhpa"]', 'entry 1 = "alhpa"', "Did you mean 'alpha'?"),
    ('output.fields=["u","alpha"]', 'lacks "T"', "add it"),
    ('output.fields=["alpha","T","u","T"]', 'output.fields: "T" is there twice', "leave one out"),
    ("measures.depths=[1.0]", "measures.depths: 1.0", "take smaller depths"),
    ("measures.depths=[0.1,0.2,0.1]", "measures.depths: 0.1 is there twice", "leave one out"),
    ("measures.threshold=0", "measures.threshold = 0", "larger than 0"),
    ('solver.displacement="cg"', "solver.displacement", '"direct", "iterative"'),
    ("solver.change=10", "solver.change = 10", "cracks still grow"),
    ("solver.sweeps=true", "solver.sweeps = true", "a whole number"),
    # keys and tables
    ("domian.h=0.1", "no key 'domian'", "Did you mean 'domain'?"),
    ("titel=3", "no key 'titel'", "Did you mean 'title'?"),
    ("domain.H=0.1", "[domain] has no key 'H'", "Did you mean 'h'?"),
    ("temperature.severety=3", "no key 'severety'", "Did you mean 'severity'?"),
    ("damage.nu=0.3", "[damage] has no key 'nu'", "it stands in [material]"),
    ("material.alpha=1e-5", "[material] has no key 'alpha'", "it is called 'expansion' here"),
    ("damage.epsilon=0.1", "[damage] has no key 'epsilon'", "it is called 'ell' here"),
    ("cracks=[{start=[0.5,0],ende=[0.5,1]}]", "no key 'ende'", "Did you mean 'end'?"),
    ("domain=4", "domain = 4", "a line [domain] with its keys below it"),
    ("title=4", "title = 4", "a text in quotes"),
    (f'title="{"x" * 300}"', "title", "at most 200 characters"),
    (
        'title="\\u001b]0;x\\u0007"',
        'title = "\\u001b]0;x\\u0007"',
        "one line of at most 200 characters",
    ),
    (f'domain.h="{"1" * 100_000} m"', 'domain.h = "111', "too long for a length"),
    (f'domain.h="1 {"m*" * 50_000}m"', 'domain.h = "1 m*m', "too long for a length"),
    (
        f"toughness.bands=[{f'{{{BOX},factor=2.0}},' * 101}]",
        "toughness.bands",
        "at most 100 entries",
    ),
    (f"output.at=[{'0.1,' * 25_000}]", "more than 25,000 values", "{ start, stop, steps }"),
    (f"{'a.' * 20_000}a=1", "--set a.a.a.", "a key of too many names; shorten it"),
    ("damage.ell=" + "[" * 20 + "]" * 20, "no case file", "nested too deeply"),
    # settings
    ("damage.law", "--set damage.law", "write it like --set damage.law=AT2"),
    ("=3", "--set =3", "write it like --set damage.law=AT2"),
    ("title.x=3", "--set title.x=3: 'title' is no table", "--set damage.law=AT2"),
    ("damage.=3", "--set damage.=3", "write it like --set damage.law=AT2"),
]
COMBINED = [
    (
        [
            *("material.E=1.0", "material.nu=0.2", "material.E_axis=0.5", "material.nu_axis=0.1"),
            *("material.G_axis=0.3", "material.axis=[0,1]", 'output.fields=["alpha","T","E"]'),
        ],
        'output.fields: "E" is a number of isotropic rock',
        "leave it out",
    ),
    (
        ("material.nu=0.5", 'material.plane="strain"'),
        "in plane strain",
        "0.49 or less, or material.plane",
    ),
    ((*SOLID, "material.nu=0.5"), "material.nu = 0.5", "take 0.49 or less"),
    ((*SOLID, 'material.plane="stress"'), "material.plane", "leave it out"),
    ((*SOLID, "measures.depths=[1.0]"), "measures.depths: 1.0", "take smaller depths"),
    ((*SOLID, 'supports.section="free"'), "supports.section", "in 3-D give rollers"),
    ((*SOLID, "cracks=[{start=[0,0,0],end=[1,0,0]}]"), "cracks, entry 1", "this body is 3-D"),
    (
        (*SOLID, "cracks=[{center=[0,0,0],radius=0.1,normal=[0,0,0]}]"),
        "normal = [0.0, 0.0, 0.0] is no direction",
        "not all zero",
    ),
    (
        ("toughness.bands=[{lower=[0,0],upper=[1],factor=2}]",),
        "entry 1, upper = [1.0]",
        "it needs 2 numbers",
    ),
    (
        ("toughness.bands=[{lower=[0,0.5],upper=[1,0.1],factor=2}]",),
        "upper = [1.0, 0.1]",
        "larger than lower",
    ),
    (
        ("toughness.bands=[{lower=[0,2],upper=[1,3],factor=2}]",),
        "from [0.0, 2.0] to [1.0, 3.0] lies outside",
        "move it in",
    ),
    (
        ('supports.section="free"', 'supports.left="clamped"'),
        'supports.left = "clamped"',
        "leave one out",
    ),
    (
        ('supports.section="stretch"', 'supports.bottom="clamped"'),
        'supports.bottom = "clamped"',
        "leave one out",
    ),
    (
        ('supports.section="stretch"', 'supports.right="rollers"'),
        'supports.right = "rollers" holds x',
        "leave one out",
    ),
    (
        ('supports.section="free"', 'temperature.face="left"'),
        'temperature.face = "left"',
        "its bottom or top",
    ),
    (
        (f"time.t={{{ENDS},{PACE}}}", "output.at=[0.05]"),
        "output.at: 0.05 lies before time.t.start = 0.1",
        "start earlier",
    ),
    (PULLED, "the case loads nothing", "give one of them"),
    ((*PULLED, "supports.left={x=0.0}"), "the case loads nothing", "give one of them"),
    (
        (*PULLED, "supports.left={x=1.0}", "time={tau=[0.1]}"),
        "time.tau has no meaning",
        "give time.t",
    ),
    (
        (*PULLED, "supports.left={x=1.0}", "measures.depths=[0.1]"),
        "measures.depths = [0.1]",
        "leave it out",
    ),
    (("time={tau=[0.1]}", 'output.at=["1 s"]'), 'output.at: "1 s" is a time', "give tau here"),
    (HEATED, "[heat] heats and cools nothing", 'like bottom = { T = "5 °C" }'),
    (
        (*COOLED, "material.E={T=[1.0,0.5], value=[1.0,2.0]}"),
        "material.E.T: 0.5 comes after",
        "increas",
    ),
    ((*COOLED, "material.E={T=[0.5,1.0], value=[1.0]}"), "material.E: T has 2", "as many of each"),
    (
        (*COOLED, "material.E={T=[0.5,1.0], value=[1.0,-1.0]}"),
        "material.E.value",
        "larger than zero",
    ),
    ((*COOLED, 'material.E={T=[0.5,1.0], value=["1 J/m^2",1.0]}'), "material.E.value", "J/m^2"),
    ((*COOLED, "material.nu={T=[0.5,1.0], value=[0.2,0.6]}"), "material.nu", "between -1 and 0.5"),
    ((*COOLED, 'material.Gc={formula="1 - T"}'), 'material.Gc.formula = "1 - T"', "give a table"),
    ((*COOLED, 'material.Gc={formula="floor(T) + 1"}'), "material.Gc.formula", "no derivative"),
    ((*COOLED, 'material.Gc={formula="2 - T"}', "solver.backtracking=true"), "backtracking", "out"),
    (
        (*COOLED, 'material.Gc={formula="2 - T"}', 'damage.irreversibility="crack set"'),
        "material.Gc",
        'irreversibility = "damage"',
    ),
    ((*COOLED, "material.rho={T=[0.5,1.0], value=[1.0,2.0]}"), "material.rho", "into c"),
    (
        (
            *COOLED,
            "material.axis=[0.0,1.0]",
            "material.E_axis=1.0",
            "material.nu_axis=0.2",
            "material.G_axis=0.4",
            "material.E={T=[0.5,1.0], value=[1.0,2.0]}",
        ),
        "material.E",
        "give one value",
    ),
    (('material.E={formula="1 + T"}',), 'temperature.profile = "half-space" knows', "[heat]"),
    (
        (*HEATED, "heat.bottom={h={T=[1.0,0.0], value=[1.0,2.0]}, T=0.0}"),
        "heat.bottom.h.T: 0.0 comes after 1.0",
        "increasing",
    ),
    (
        (*HEATED, 'heat.bottom={h={formula="T - 0.5"}, T=0.0}'),
        'heat.bottom.h.formula = "T - 0.5"',
        "not negative",
    ),
    (
        (*FORMULA, 'temperature.T="-z*t"'),
        "temperature.T = \"-z*t\": 'z' is not known",
        "it may use",
    ),
    (
        (*FORMULA, 'temperature.T="-T*t"'),
        "'T' is not known there",
        "it may use numbers, pi, t, x, y",
    ),
    ((*FORMULA, 'temperature.T="-1/t"'), "not finite at t = 0, x = 0, y = 0", "so everywhere"),
    ((*FORMULA, 'temperature.T="-(0.15 - t)**0.5"'), "its value is not finite at t = 0.15", "so"),
    ((*FORMULA, 'temperature.T="x > t"'), "is true or false and no number", "where(x > 1, 5, 2)"),
    ((*FORMULA, 'temperature.T=""'), 'temperature.T = "": that is no formula', "it may use"),
    ((*FORMULA, f'temperature.T="{"1" * 201}"'), "temperature.T", "at most 200 characters"),
    ((*FORMULA, "temperature.severity=10.0"), "temperature.severity = 10.0", "temperature.T says"),
    ((*FORMULA, "temperature.dT=10.0"), "temperature.dT = 10.0 cools nothing", "leave one of them"),
    ((*FORMULA, "temperature.biot=1.0"), "temperature.biot = 1.0", "leave one of them out"),
    ((*FORMULA, 'temperature.face="botom"'), "no face 'botom'", "Did you mean 'bottom'?"),
    ((*FORMULA, "measures.depths=[0.1]"), "measures.depths = [0.1]", 'like face = "bottom"'),
    ((*FORMULA, "time={tau=[0.1]}"), "time.tau has no meaning", "give time.t"),
    ((*FORMULA, "heat.initial=1.0"), "[heat] has no meaning", "leave it out"),
    ((*FORMULA, "material.k=2.0"), "material.k = 2.0 has no meaning", "leave it out"),
    ((*FORMULA, 'material.E={formula="1 + T"}'), 'temperature.profile = "formula" knows', "[heat]"),
    (
        (*FORMULA, 'temperature.face="left"', 'supports.section="fixed"'),
        'temperature.face = "left"',
        "take one of these",
    ),
    ((*HEATED, "heat.cracks={conductivity=0.1}"), "[heat] heats and cools nothing", "give one"),
    (HEATED[:2], "[heat] is missing", 'initial = "20 °C" and bottom = { T = "5 °C" }'),
    ((*HEATED[:2], "heat.bottom={T=0}"), "heat.initial is missing", 'initial = "20 °C"'),
    ((*PULLED, "supports.left={x=1.0}", "heat.initial=1"), "[heat] has no meaning", "leave it out"),
    ((*SOLID, *COOLED, "material.k=[1,1]"), "material.k = [1.0, 1.0]", "it needs 3 numbers"),
    (
        (*COOLED, 'heat.top={h={formula="x - 0.5"},T=0.0}'),
        "heat.top.h.formula",
        "a film coefficient must not be negative, and there it is -0.5",
    ),
    (
        ('domain.size=["1 m","1 m"]', 'domain.h="0.1 m"', 'damage.ell="0.3 m"', 'time.t=["1 s"]'),
        "material.E is missing",
        'E = "70 GPa"',
    ),
]
# The change to a case with the heat equation; what the sentence names; the rule or the way out.
HEAT = [
    ("temperature.dT=3.0", "temperature.dT = 3.0 cools nothing", "leave one of them out"),
    ("temperature.severity=3.0", "temperature.severity = 3.0 cools nothing", "where [heat] says"),
    ("temperature.biot=3.0", "temperature.biot = 3.0 cools nothing", "leave one of them out"),
    ("material.kappa=1.0", "material.kappa = 1.0 has no meaning", "give k, rho and c"),
    # the rock
    ("material.k=-1.0", "material.k = -1.0", "larger than zero"),
    ("material.k=[1.0]", "material.k = [1.0]", "it needs 2 numbers"),
    ("material.k=[1.0,2.0,3.0]", "material.k = [1.0, 2.0, 3.0]", "it needs 2 numbers"),
    ("material.k=[]", "material.k = []", "it needs 2 numbers"),
    ("material.k=[1.0,-2.0]", "material.k, entry 2 = -2.0", "larger than zero"),
    ("material.k={}", "material.k = {}", 'write k like "2.5 W/(m K)" or ["2.5 W/(m K)"'),
    ('material.k="2 W/m"', "'W/m' does not measure a conductivity", '"2.5 W/(m K)"'),
    ("material.rho=0", "material.rho = 0", "larger than zero"),
    ("material.c=-0.5", "material.c = -0.5", "larger than zero"),
    ("material.conductivity=2.0", "no key 'conductivity'", "it is called 'k' here"),
    ("material.density=2.0", "no key 'density'", "it is called 'rho' here"),
    ("material.cp=2.0", "no key 'cp'", "it is called 'c' here"),
    # the start
    ("heat.initial=true", "heat.initial = true", 'a text like "20 °C"'),
    ("heat.initial=[1.0]", "heat.initial = [1.0]", 'write initial like "20 °C" or {'),
    ("heat.initial={value=1.0}", "heat.initial.gradient is missing", 'gradient = ["0 K/m"'),
    ("heat.initial={gradient=[0,1]}", "heat.initial.value is missing", 'value = "20 °C"'),
    ("heat.initial={value=1,gradient=[1]}", "heat.initial.gradient = [1.0]", "2 numbers"),
    ("heat.initial={value=1,gradient=1}", "heat.initial.gradient = 1", "write gradient like ["),
    (
        "heat.initial={t=[0],value=[1]}",
        "heat.initial has no key 't'",
        "formula, gradient, name, unit, value",
    ),
    ('heat.initial={value=1,formula="x"}', "'value' does not go with", "leave it or them out"),
    ('heat.initial={formula="t"}', "'t' is not known there", "it may use numbers, pi, x, y, +"),
    ("heat.stress_free={value=1,gradient=[1]}", "heat.stress_free.gradient", "2 numbers"),
    ('heat.stress_free={formula="z"}', "heat.stress_free.formula", "'z' is not known there"),
    ("heat.T0=1.0", "[heat] has no key 'T0'", "it is called 'initial' here"),
    # the sides
    ("heat.front={T=0.0}", "heat.front: a 2-D body has no such face", "bottom, left, right, top"),
    ("heat.botom={T=0.0}", "[heat] has no key 'botom'", "Did you mean 'bottom'?"),
    ("heat.bottom=3.0", "heat.bottom = 3.0", 'write bottom like { T = "5 °C" } or { flux'),
    ("heat.bottom={}", "heat.bottom = {} says nothing", "leave it out to insulate the side"),
    ("heat.bottom={h=2.0}", "heat.bottom = { h = 2.0 } is a film without a bath", "add the bath"),
    ("heat.bottom={T=0.0,flux=1.0}", "a given flux and a given temperature", "leave out T"),
    ("heat.bottom={h=2.0,flux=1.0}", "a given flux", "leave out flux, or leave out h"),
    ("heat.bottom={h=2.0,T=0.0,flux=1.0}", "a given flux", "leave out h and T"),
    ("heat.bottom={h=0.0,T=0.0}", "heat.bottom.h = 0.0", "larger than zero"),
    ("heat.bottom={h=-1.0,T=0.0}", "heat.bottom.h = -1.0", "larger than zero"),
    ("heat.bottom={h=true,T=0.0}", "heat.bottom.h = true", 'a text like "500 W/(m^2 K)"'),
    ("heat.bottom={T=nan}", "heat.bottom.T = nan", "a finite number"),
    ('heat.bottom={T="cold"}', 'heat.bottom.T = "cold"', 'write it like "20 °C"'),
    ('heat.bottom={flux="5 W/m"}', "'W/m' does not measure a heat flux", '"0.06 W/m^2"'),
    ("heat.bottom={q=1.0}", "heat.bottom has no key 'q'", "it is called 'flux' here"),
    ("heat.bottom={convection=1.0}", "no key 'convection'", "it is called 'h' here"),
    ("heat.bottom={T={t=[0,1]}}", "heat.bottom.T.value is missing", 'value = ["20 °C"'),
    ("heat.bottom={T={value=[0,1]}}", "heat.bottom.T.t is missing", 't = ["0 s", "10 min"]'),
    ("heat.bottom={T={t=[0,1],value=[0]}}", "t has 2 numbers and value has 1", "as many of each"),
    ("heat.bottom={T={t=[],value=[]}}", "heat.bottom.T: t has 0 numbers", "at least one"),
    ("heat.bottom={T={t=[1,0],value=[0,1]}}", "heat.bottom.T.t: 0.0 comes after 1.0", "order"),
    ("heat.bottom={T={t=[0,0],value=[0,1]}}", "heat.bottom.T.t: 0.0 comes after 0.0", "equal"),
    ("heat.bottom={T={t=[-1],value=[0]}}", "heat.bottom.T.t, entry 1 = -1", "not be negative"),
    ("heat.bottom={T={t=[0],value=[nan]}}", "heat.bottom.T.value, entry 1 = nan", "finite"),
    ("heat.bottom={T={t=[0],value=1.0}}", "heat.bottom.T.value = 1.0", "write value like ["),
    (
        "heat.bottom={T={t=[0],u=[1.0]}}",
        "heat.bottom.T has no key 'u'",
        "it has field_unit, file, formula, name, t, unit, value",
    ),
    ("heat.bottom={h={t=[0],value=[-1]},T=0}", "h.value, entry 1 = -1", "not be negative"),
    ('heat.bottom={T={formula="1",t=[0]}}', "heat.bottom.T: 't' does not go", "leave it or them"),
    # the source, the bands, the cracks, the errors
    ("heat.source=true", "heat.source = true", 'a text like "2e-6 W/m^3"'),
    ("heat.source={t=[0,1],value=[0]}", "heat.source: t has 2 numbers", "as many of each"),
    ("heat.bands=3", "heat.bands = 3", "write bands like [{ lower"),
    (f"heat.bands=[{{{BOX}}}]", "heat.bands, entry 1 changes nothing", "give k, a factor"),
    (f"heat.bands=[{{{BOX},k=-1}}]", "heat.bands, entry 1, k = -1", "larger than zero"),
    (f"heat.bands=[{{{BOX},capacity=0}}]", "heat.bands, entry 1, capacity = 0", "larger than"),
    (f"heat.bands=[{{{BOX},factor=2}}]", "no key 'factor'", "it has capacity, k, lower, upper"),
    ("heat.bands=[{lower=[0,2],upper=[1,3],k=2}]", "heat.bands, entry 1: the box", "move it in"),
    ("heat.bands=[{lower=[0],upper=[1,3],k=2}]", "heat.bands, entry 1, lower", "2 numbers"),
    ("heat.cracks=0.1", "heat.cracks = 0.1", "write cracks like { conductivity = 0.001 }"),
    ("heat.cracks={}", "heat.cracks = {} says nothing", "or leave it out"),
    ("heat.cracks={conductivity=0.0}", "heat.cracks.conductivity = 0.0", "larger than zero"),
    ("heat.cracks={conductivity=1.5}", "heat.cracks.conductivity = 1.5", "at most 1"),
    ('heat.cracks={conductivity="1 m"}', "heat.cracks.conductivity", "without quotes"),
    ("heat.cracks={conductivity=0.1,T=0.0}", "heat.cracks = {", "leave one of them out"),
    ("heat.cracks={h=1.0}", "has no temperature of the fluid", 'like T = "5 °C"'),
    ("heat.cracks={T=1.0}", "has no film between fluid and rock", 'h = "500 W/(m^2 K)"'),
    ("heat.cracks={flux=1.0}", "heat.cracks has no key 'flux'", "it has T, conductivity, h"),
    ("heat.tolerance=0.0", "heat.tolerance = 0.0", "larger than zero"),
    ("heat.tolerance=1e-25", "heat.tolerance = 1e-25", "at least 1"),
    ("heat.tolerance=0.1", "heat.tolerance = 0.1", "less than 0.1"),
    ("heat.agreement=1.0", "heat.agreement = 1.0", "1e-08 and 0.1"),
    # units
    ('heat.bottom={T="5 °C"}', 'heat.bottom.T = "5 °C" has one', "give every number a unit"),
    ('heat.source={t=["1 s"],value=[1.0]}', 'heat.source.t = "1 s" has one', "a unit, or none"),
]
FORMULAS = [
    ("", "that is no formula", "it may use numbers, pi, t, x, y, + - * / **"),
    ("1 +", "that is no formula", "and abs, arccos"),
    ("1; 2", "that is no formula", "it may use"),
    ("(" * 150, "that is no formula", "it may use"),
    ("q + 1", "'q' is not known there", "it may use"),
    ("z", "'z' is not known there", "it may use numbers, pi, t, x, y, +"),
    ("T", "'T' is not known there", "Did you mean 't'?"),
    ("sine(x)", "'sine' is not known there", "Did you mean 'sin'?"),
    ("sum(x)", "'sum' is not known there", "it may use"),
    ("sin", "'sin' is not known there", "it may use"),
    ("x(1)", "'x' is not known there", "it may use"),
    ("__import__('os')", "'__import__' is not known there", "it may use"),
    ("x.tofile('f')", "more than a formula", "it may use"),
    ("x.real", "more than a formula", "it may use"),
    ("x[0]", "more than a formula", "it may use"),
    ("'a'", "more than a formula", "it may use"),
    ("1j", "more than a formula", "it may use"),
    ("[1, 2]", "more than a formula", "it may use"),
    ("x if y else 1", "more than a formula", "it may use"),
    ("x > 1 and y > 1", "more than a formula", "it may use"),
    ("0 < x < 1", "more than a formula", "it may use"),
    ("lambda: 1", "more than a formula", "it may use"),
    ("(x := 1)", "more than a formula", "it may use"),
    ("where(x > 1, 2, y=3)", "more than a formula", "it may use"),
    ("sin(*x)", "more than a formula", "it may use"),
    ("1if x else 2", "more than a formula", "it may use"),
    ("x // 2", "more than a formula", "it may use"),
    ("9**9**9**9", "its value is not finite", "it must be so everywhere"),
    ("1/0", "its value is not finite", "it must be so everywhere"),
    ("1/x", "not finite at t = 0, x = 0, y = 0", "it must be so everywhere"),
    ("1/t", "not finite at t = 0, x = 0, y = 0", "it must be so everywhere"),
    ("sqrt(0.15 - t)", "not finite at t = 0.16, x = 0", "it must be so everywhere"),
    ("1/(x - 0.55)", "not finite at t = 0, x = 0.55", "it must be so everywhere"),
    ("log(-1)", "its value is not finite", "it must be so everywhere"),
    ("x > 0.5", "true or false and no number", "where(x > 1, 5, 2)"),
    ("sin(x, y)", "it cannot be computed", "what its functions are given"),
    ("where(x, 1, 2)", "it cannot be computed", "what its functions are given"),
    ("x + 1 > 1 & y > 2", "more than a formula", "it may use"),
    ("1" * 400, "at most 200 characters", "heat.bottom.T.formula"),
    ("x\n+ 1\x00", "that is no formula", "it may use"),
]
# Two settings that meet on an edge, and the component that they contradict each other in.
CONTRADICTIONS = [
    (("supports.left={x=0.0}", "supports.bottom={x=0.05}"), ("left", "bottom", "x")),
    (('supports.left="rollers"', "supports.bottom={x=0.05}"), ("left", "bottom", "x")),
    (('supports.left="clamped"', "supports.top={y=0.05}"), ("left", "top", "y")),
    (('supports.section="fixed"', "supports.top={x=0.05}"), ("left", "top", "x")),
    (
        ("supports.left={y={t=[0,1],u=[0,0.1]}}", "supports.top={y=0.1}"),
        ("left", "top", "y"),
    ),
    (
        ("supports.left={y={t=[0,1],u=[0,0.1]}}", "supports.top={y={t=[0,2],u=[0,0.1]}}"),
        ("left", "top", "y"),
    ),
    (
        (*SOLID, 'supports.front="clamped"', "supports.top={z=0.1}"),
        ("front", "top", "z"),
    ),
]
CONSISTENT = [
    ("supports.left={x=0.05}", "supports.bottom={x=0.05}"),
    ("supports.left={x=0.0}", "supports.right={x=0.05}"),
    ('supports.bottom="clamped"', "supports.top={x=0.05,y=0.0}"),
    ('supports.left="rollers"', 'supports.bottom="clamped"'),
    ('supports.left="rollers"', "supports.bottom={y=0.05}"),
    ('supports.left="rollers"', "supports.bottom={x={t=[0,1],u=[0,0]}}"),
    (
        "supports.left={y={t=[0,1,2],u=[0,0.1,0.2]}}",
        "supports.top={y={t=[0,2],u=[0,0.2]}}",
    ),
    ('supports.section="fixed"', "supports.top={x=0.0,y=0.05}"),
    (*SOLID, 'supports.front="rollers"', "supports.top={z=0.1}"),
]
TEXTS = [
    ("", "[domain] is missing", "`staffa new slab` writes a case"),
    ("{", "my.toml is no TOML file", "(at line 1, column 1); correct it there"),
    ('{"domain": 1}', "my.toml is no TOML file", "(at line 1, column 1); correct it there"),
    ("domain: 1", "my.toml is no TOML file", "expected '=' after a key"),
    ("[damage]\nlaw = AT1", "a text needs quotes", "(at line 2, column 7)"),
    ("[damage\nlaw = 1", "my.toml is no TOML file", "correct it there"),
    ("title = 'a'\ntitle = 'b'\n", "a key is given twice", "(at line 2, column 12)"),
    ("[domain]\n[domain]", "a table is given twice", "(at line 2, column 8)"),
    ("domain.h = 1\n[domain]\nsize = [1, 1]", "a table is given twice", "correct it there"),
    ("x = " + "[" * 5000, "my.toml is no case file", "nested too deeply"),
    ("x = " + "1" * 5000, "my.toml is no TOML file", "too long; shorten it"),
    ("x = 1" + "\n[x]" * 300_000, "my.toml is no case file", "larger than 1,000,000 bytes"),
    ("x." * 400_000 + "x = 1", "my.toml has a key of too many names", "shorten it"),
    ("[" + "'x'. " * 100_000 + "x]", "my.toml has a key of too many names", "shorten it"),
    ("a.b = 1\n" * 3, "a key is given twice", "correct it there"),
    (
        "x = [" + "[]," * 25_001 + "]",
        "my.toml holds more than 25,000 values",
        "as a separate file",
    ),
    (
        '"a\\nb\\u001b[31m" = 1',
        "no key 'a\\u000ab\\u001b[31m'",
        "it has authors, cracks, damage, domain",
    ),
    ("x" * 5000 + " = 1", "no key 'xxx", "it has authors, cracks, damage, domain"),
]

RANDOM = "mean=1.0, variation=0.3, length"
BEDDED = "E=1.0, nu=0.2, E_axis=1.0, nu_axis=0.2, G_axis=0.5"
UNIT = [[float(i == j) for j in range(6)] for i in range(6)]
UNEVEN = [[1.0, 0.5, 0.0, 0.0, 0.0, 0.0], *UNIT[1:]]
NEGATIVE = [[-1.0, 0.0, 0.0, 0.0, 0.0, 0.0], *UNIT[1:]]
CLAY = "regions.clay={lower=[0.0,0.0], upper=[1.0,0.5], "
PORES = ('material.plane="strain"',)
CRACK = ("cracks=[{start=[0.5,0.0],end=[0.5,0.3]}]",)
FORCES = [
    (("forces={}",), "[forces] says nothing", "give prestress, gravity"),
    (("forces=3",), "forces = 3", "a line [forces] with its keys below it"),
    (("forces.prestres={xx=1.0}",), "[forces] has no key 'prestres'", "Did you mean 'prestress'?"),
    (("forces.prestress={}",), "forces.prestress says nothing", "give xx, yy"),
    (("forces.prestress=1.0",), "forces.prestress = 1.0", "write prestress like { xx = "),
    (("forces.prestress={xx=true}",), "forces.prestress.xx = true", 'a text like "70 GPa"'),
    (("forces.prestress={zx=1.0}",), "forces.prestress has no key 'zx'", "it has xx, xy"),
    (("forces.prestress={zz=1.0}",), "forces.prestress.zz: plane stress has none", "leave it out"),
    (("forces.prestress={xz=1.0}",), "forces.prestress.xz: a 2-D body has none", "leave it out"),
    (
        ("forces.prestress={xx={value=1.0,gradient=[1.0]}}",),
        "forces.prestress.xx.gradient = [1.0]",
        "it needs 2 numbers",
    ),
    (('forces.prestress={xx={formula="z"}}',), "'z' is not known there", "it may use"),
    (('forces.prestress={xx={formula="t"}}',), "'t' is not known there", "it may use"),
    (('forces.prestress={xx={formula="1/x"}}',), "not finite at x = 0", "it must be so everywhere"),
    (
        ("forces.gravity=[-1.0]", "material.rho=1.0"),
        "forces.gravity = [-1.0]",
        "it needs 2 numbers",
    ),
    (("forces.gravity=-1.0",), "forces.gravity = -1.0", "write gravity like ["),
    (("material.rho=1.0",), "material.rho = 1.0 has no meaning", "leave it out"),
    (("forces.topp={pressure=1.0}",), "[forces] has no key 'topp'", "Did you mean 'top'?"),
    (
        ("forces.front={pressure=1.0}",),
        "forces.front: a 2-D body has no such face",
        "bottom, left, right, top",
    ),
    (("forces.top={}",), "forces.top says nothing", "give pressure, x or y"),
    (("forces.top={z=1.0}",), "forces.top.z", "a 2-D body has no such axis"),
    (
        ("forces.top={p=1.0}",),
        "forces.top has no key 'p'",
        "it has pressure, x, y, z",
    ),
    (("forces.top=3",), "forces.top = 3", "write top like {"),
    (
        ("forces.top={pressure={t=[0.0,1.0],value=[1.0]}}",),
        "t has 2 numbers and value has 1",
        "give as many of each",
    ),
    (('forces.top={x={formula="1/x"}}',), "forces.top.x.formula", "so everywhere"),
    (("forces.pore_pressure=1.0",), "in plane stress pores", 'material.plane = "strain"'),
    ((*PORES, "forces.pore_pressure=true"), "forces.pore_pressure = true", "a text like"),
    (("forces.biot=0.5", "forces.prestress={xx=-1.0}"), "forces.biot = 0.5", "leave it out"),
    ((*PORES, "forces={biot=1.5,pore_pressure=1.0}"), "forces.biot = 1.5", "at most 1"),
    ((*CRACK, "forces={crack_pressure=1.0,crack_volume=1.0}"), "crack_volume", "one of them out"),
    ((*CRACK, 'forces.crack_pressure={formula="x*z"}'), "'z' is not known there", "pi, t, x, y"),
    ((*CRACK, 'forces.crack_volume={formula="x"}'), "'x' is not known there", "pi, t, "),
    ((*PORES, 'forces.pore_pressure={formula="1/(t-0.1)"}'), "is not finite", "t = 0.1"),
    ((*PORES, 'forces.prestress={xx={formula="t"}}'), "'t' is not known there", "x, y"),
    (("forces.crack_volume=1.0",), "no crack for the fluid", "give one in [[cracks]]"),
    ((*CRACK, "forces.crack_volume=-1.0"), "forces.crack_volume = -1.0", "must not be negative"),
    (
        (*CRACK, 'forces.crack_volume={formula="0.15 - t"}'),
        'forces.crack_volume.formula = "0.15 - t"',
        "must not be negative, and is at t = 0.",
    ),
    (('forces.gravity=["0 m/s^2", "5"]',), "an acceleration in quotes", 'like "9.81 m/s^2"'),
    (
        (*CRACK, "forces.crack_volume=1.0", 'solver.stability="report"'),
        'solver.stability = "report"',
        "take forces.crack_pressure",
    ),
    (('damage.split="miehe"',), 'damage.split = "miehe"', 'one of "none", "volumetric-deviatoric"'),
    (('damage.split="spectral"', "material.nu=0.5"), "nu = 0.5 has none", "take 0.49 or less"),
    (
        ("forces.top={pressure=1.0}", 'supports.bottom="clamped"', "material.nu=0.5"),
        'damage.split = "no-tension", the default where something may be pressed',
        "take 0.49 or less",
    ),
    (("damage.gamma=3.0",), "damage.gamma = 3 has no meaning", "leave it out"),
    (("damage.friction=0.3",), "damage.friction = 0.3 has no meaning", '"contact"'),
    (
        ('damage={ell=0.3,split="contact",friction=-0.1}',),
        "damage.friction = -0.1",
        "at least 0",
    ),
    (
        ('damage.split="contact"', "solver.backtracking=true"),
        "solver.backtracking = true",
        "leave it out",
    ),
    (
        ('damage={ell=0.3,split="contact",friction=0.3}', 'solver.stability="test"'),
        'solver.stability = "test"',
        "leave it out",
    ),
    (
        (
            *COOLED,
            'damage={ell=0.3,split="contact",friction=0.3}',
            "heat.cracks={conductivity=1.0}",
        ),
        "heat.cracks",
        "leave one of them out",
    ),
    (
        (*CRACK, 'damage={ell=0.3,split="contact",friction=0.3}', "forces.crack_volume=1.0"),
        "forces.crack_volume",
        "take forces.crack_pressure",
    ),
    (
        ('damage.split="contact"', "material.nu=-0.1"),
        "material.nu = -0.1",
        "volumetric-deviatoric",
    ),
    (('damage={ell=0.3,split="star-convex",gamma=-1.0}',), "damage.gamma = -1.0", "at least 0"),
    (
        ('damage.split="spectral"', "material.nu=-0.1"),
        "material.nu = -0.1",
        "volumetric-deviatoric",
    ),
    (
        ('damage.split="no-tension"', "material={E=[1,2], nu=[0.2], G=[1]}"),
        "is for isotropic rock",
        '"volumetric-deviatoric"',
    ),
]

ROCK = [
    # a value that varies
    ("material.E={}", "material.E = {}", 'write E like "70 GPa"'),
    ('material.E={formula="1 + z"}', "material.E.formula", "'z' is not known there"),
    ('material.E={formula="1 + t"}', "material.E.formula", "'t' is not known there"),
    ('material.E={formula="x - 0.5"}', "it is -0.4762 somewhere", "must be larger than zero"),
    ('material.E={formula="1/(y - y)"}', "material.E.formula", "it must be so everywhere"),
    ('material.E={formul="x"}', "material.E has no key 'formul'", "Did you mean 'formula'?"),
    ('material.E={formula="x", mean=1.0}', "material.E: 'mean'", "leave it or them out"),
    ('material.nu={formula="x"}', "it is 0.9762 somewhere", "keep it between -1 and 0.5"),
    ("material.E={mean=1.0}", "material.E.variation is missing", "variation = 0.2"),
    ("material.E={variation=0.1, length=1.0}", "material.E.mean is missing", "mean = "),
    ("material.E={mean=1.0, variation=0.1}", "material.E.length is missing", "length = 0.06"),
    (f"material.E={{{RANDOM}=0.0}}", "material.E.length = 0.0", "larger than zero"),
    ("material.E={mean=-1.0, variation=0.1, length=1}", "material.E.mean", "larger than zero"),
    ("material.E={mean=1.0, variation=2, length=1}", "material.E.variation = 2", "at most 1"),
    (f'material.E={{{RANDOM}=1.0, distribution="gauss"}}', "distribution", '"weibull"'),
    (f'material.E={{{RANDOM}=1.0, distribution="normal"}}', "E.variation = 0.3", '"lognormal"'),
    (f"material.E={{{RANDOM}=1.0, seed=-1}}", "material.E.seed = -1", "at least 0"),
    (f"material.E={{{RANDOM}=[1.0]}}", "material.E.length = [1.0]", "one number, or 2"),
    (f"material.E={{{RANDOM}=1.0, angle=30}}", "material.E.angle turns nothing", "leave it out"),
    (f'material.E={{{RANDOM}=[1,2], angle="3 mm"}}', "measure a rotation", '"30 deg"'),
    (f"material.E={{{RANDOM}=[1,2], axes=[[1,0,0],[0,1,0]]}}", "E.axes is for 3-D", "give angle"),
    ("material.nu={mean=0.7, variation=0.1, length=1}", "it is 0.7 somewhere", "between -1 and"),
    ('material.E={file="none.vtu", name="E"}', "there is no file", "the folder of the case"),
    ('material.E={file="none.vtu"}', "material.E.name is missing", 'name = "E"'),
    ('material.E={file=3, name="E"}', "material.E.file = 3", "a text in quotes"),
    # elasticity
    ("material.E=[1.0, 2.0]", "material.G is missing", "an orthotropic rock has a list of each"),
    ("material={E=[1,2], nu=[0.2], G=[1,2]}", "material.G = [1.0, 2.0]", "G12 is enough"),
    ("material={E=[1,2], nu=0.2, G=[1]}", "material.nu = 0.2", "nu12 is enough"),
    ("material={E=[1,2], nu=[2.0], G=[1]}", "not positive definite", "smaller Poisson's ratios"),
    ("material={E=[1,2], nu=[0.2], G=[1], axis=[0,1]}", "material.axis", "its axes by angle"),
    ("material.G=1.0", "material.E = 1.0", "E1, E2 are enough"),
    ("material.E_axis=1.0", "material.nu_axis is missing", "has all five"),
    (f"material={{{BEDDED}}}", "material.axis is missing", "axis = [0.0, 1.0]"),
    (f"material={{{BEDDED}, G=[1], axis=[0,1]}}", "lists of E, nu and G", "one of the two out"),
    (f"material={{{BEDDED}, axis=[0,0]}}", "material.axis = [0.0, 0.0]", "not all zero"),
    (f"material={{{BEDDED}, axis=[0,1,0]}}", "axis = [0.0, 1.0, 0.0]", "give 2 numbers"),
    ("material.stiffness=3", "material.stiffness = 3", "write stiffness like [[1.2"),
    ("material.stiffness=[[1,2],[3]]", "2 rows of 1 and 2 numbers", "six rows of six"),
    (f"material={{stiffness={UNIT}, E=2.0}}", "E cannot stand beside it", "one of them out"),
    (f"material.stiffness={UNEVEN}", "entries 1,2 and 2,1 differ", "give both the same"),
    (f"material.stiffness={NEGATIVE}", "smallest eigenvalue is -1", "off the diagonal"),
    (f"{CLAY} {BEDDED}, axis=[0,1]}}\nmaterial.nu=0.5", "material.nu = 0.5", "0.49 or less"),
    # directions
    ("material.axis=[0,1]", "material.axis turns nothing", "leave it out"),
    ("material.angle=30", "material.angle turns nothing", "leave it out"),
    ("material={Gc=[1,2], angle=3, axis=[0,1]}", "axis and angle both say", "give one of them"),
    ("material={Gc=[1,2], axes=[[1,0],[0,1]]}", "axes is for 3-D", "give angle"),
    ('material={Gc=[1,2], angle="30"}', 'material.angle = "30"', 'write it like "30 deg"'),
    ("material.Gc=[1]", "material.Gc = [1.0]", "it needs 2 numbers"),
    ('material.Gc=[1,{formula="x"}]', "material.Gc, entry 2", '"10 J/m^2"'),
    ("material={Gc=[1,2,3], axis=[0,1]}", "material.Gc = [1.0, 2.0, 3.0]", "since axis is given"),
    ("material.expansion=[1]", "material.expansion = [1.0]", "2 or 3 numbers"),
    ("material.expansion=[1,-2]", "material.expansion, entry 2 = -2", "larger than zero"),
    ('material={plane="strain", expansion=[1,2]}', "expansion = [1.0, 2.0]", "needs 3 numbers"),
    # regions
    ("regions=3", "regions = 3", "write regions like { clay ="),
    ("regions.clay=3", "regions.clay = 3", "a line [regions.clay] with its keys below"),
    ("regions.clay={}", "[regions.clay] says nothing", "give what differs"),
    ("regions.clay={E=2.0}", "[regions.clay] needs its box", "give both"),
    ("regions.clay={E=2.0, lower=[0,0]}", "[regions.clay] needs its box", "give both"),
    ("regions.clay={E=2, lower=[0], upper=[1,1]}", "regions.clay, lower = [0.0]", "2 numbers"),
    ("regions.clay={E=2, lower=[0,0], upper=[0,1]}", "regions.clay: upper", "must be larger"),
    ("regions.clay={E=2, lower=[3,3], upper=[4,4]}", "outside the body", "move it in"),
    (f"{CLAY} Gc=-1.0}}", "regions.clay.Gc = -1.0", "larger than zero"),
    (f"{CLAY} e=1.0}}", "regions.clay has no key 'e'", "Did you mean 'E'?"),
    (f"{CLAY} young=1.0}}", "regions.clay has no key 'young'", "it is called 'E' here"),
    (f"{CLAY} k=2.0}}", "regions.clay.k = 2.0 has no meaning", "leave it out"),
    (f"{CLAY} angle=30}}", "regions.clay.angle turns nothing", "leave it out"),
    (f"{CLAY} E=[1,2]}}", "regions.clay.nu is missing", "gives all of it"),
    (f'{CLAY} E={{formula="-y"}}}}', "regions.clay.E", "must be larger than zero"),
    ('regions={""={E=2.0}}', '[regions.""]', "1 to 60 characters"),
]
ROCK_3D = [
    ("material={Gc=[1,2,3], axes=[[1,0,0],[1,1,0]]}", "they enclose 45 degrees", "turn one"),
    ("material={Gc=[1,2,3], axes=[[1,0,0]]}", "material.axes", "two directions"),
    ("material={Gc=[1,2,3], angle=3}", "material.angle = 3.0", "give axes"),
    ("material.Gc=[1,2]", "material.Gc = [1.0, 2.0]", "it needs 3 numbers"),
    ("material.expansion=[1,2]", "material.expansion = [1.0, 2.0]", "it needs 3 numbers"),
    ("material={E=[1,2], nu=[0.2], G=[1]}", "material.E = [1.0, 2.0]", "[E1, E2, E3]"),
    (f"material.E={{{RANDOM}=[1,2], angle=3}}", "material.E.length", "one number, or 3"),
    (f"material.E={{{RANDOM}=[1,2,3], angle=3}}", "material.E.angle = 3.0", "give axes"),
]


AXIAL = 'domain.symmetry="axis"'
# Of bodies of revolution.
AXIS = [
    (('domain.symmetry="z"',), 'domain.symmetry = "z"', 'must be one of "axis"'),
    (("domain.symmetry=true",), "domain.symmetry = true", "axis"),
    (("domain.hole=0.1",), "domain.hole = 0.1", 'domain.symmetry = "axis"'),
    ((AXIAL, "domain.hole=0.0"), "domain.hole = 0.0", "larger than zero"),
    ((AXIAL, *SOLID), "the body is 3-D", "leave symmetry out"),
    ((AXIAL, 'material.plane="strain"'), 'material.plane = "strain"', "leave one of them out"),
    ((AXIAL, 'supports.section="free"'), 'supports.section = "free"', "leave it out"),
    ((AXIAL, 'supports.left="rollers"'), "supports.left", "'left' is the axis"),
    ((AXIAL, "forces.left={pressure=1.0}"), "forces.left", "'left' is the axis"),
    ((AXIAL, *HEATED, "heat.left={T=0.0}"), "heat.left", "'left' is the axis"),
    ((AXIAL, 'temperature.face="left"'), "temperature.face", "'left' is the axis"),
    ((AXIAL, 'temperature.face="right"'), "'right' runs around the axis", 'profile = "heat"'),
    ((AXIAL, "supports.bottom={x=0.1}"), "supports.bottom.x = 0.1", "leave x out"),
    ((AXIAL, "forces.gravity=[1.0,0.0]"), "forces.gravity = [1.0, 0.0]", "x component as 0"),
    ((AXIAL, "forces.prestress={xx=-1.0}"), "xx = -1.0 acts along r", "give zz = -1.0"),
    ((AXIAL, "forces.prestress={xy=0.1}"), "forces.prestress.xy = 0.1", "0 at x = 0"),
    ((AXIAL, "cracks=[{start=[0.0,0.1],end=[0.0,0.3]}]"), "cracks, entry 1", "move an end away"),
    ((AXIAL, "material.expansion=[1.0,2.0]"), "material.expansion", "it needs 3 numbers"),
    ((AXIAL, "material.expansion=[1.0,1.0,2.0]"), "its expansion is not", "axis = [0.0, 1.0]"),
    ((AXIAL, "material={Gc=[1.0,2.0],angle=30}"), "its Gc is not", "without an angle"),
    ((AXIAL, "material={E=[1,1,2],nu=[0,0,0],G=[1,1,1]}"), "its stiffness is not", "3-D body"),
    (
        (
            'domain={symmetry="axis",size=[1.0,1.0],h=0.1,hole=0.5}',
            "cracks=[{start=[0.2,0.1],end=[0.7,0.3]}]",
        ),
        "start = [0.2, 0.1] lies outside the body",
        "from (0.5 0) to (1.5 1)",
    ),
    (('domain={shape={kind="disc",radius=1.0},h=0.1,symmetry="axis"}',), '"disc" would be', "size"),
]


def sentence_of(call) -> str:
    with pytest.raises(InputError) as caught:
        call()
    return str(caught.value)


def check_sentence(said: str, *parts: str) -> None:
    for part in parts:
        assert part in said, f"'{part}' is not in: {said}"
    assert "\n" not in said and said.isprintable(), f"more than one line: {said!r}"
    assert len(said) < 400, f"{len(said)} characters: {said}"
    assert not re.search(JARGON, said), f"jargon in: {said}"
    strays = re.search(r"[.;,:]{2}|  ", said.replace("...", ""))
    assert not strays, f"double punctuation or space in: {said}"


def read(settings: Sequence[str]) -> Case:
    """As `check` and `run` do: it must load the body by itself, too."""
    case = parse_case(GOOD, settings)
    require_loaded(case)
    return case


def test_the_case_that_the_others_change_is_good():
    assert read(()).dim == 2


@pytest.mark.parametrize(("setting", "names", "way_out"), VALUES, ids=lambda v: v[:40])
def test_a_bad_value_is_refused_in_one_sentence(setting, names, way_out):
    check_sentence(sentence_of(lambda: read([setting])), names, way_out)


@pytest.mark.parametrize(("settings", "names", "way_out"), COMBINED, ids=lambda v: str(v[-1])[:40])
def test_values_that_do_not_go_together_are_refused_in_one_sentence(settings, names, way_out):
    check_sentence(sentence_of(lambda: read(settings)), names, way_out)


@pytest.mark.parametrize(("setting", "names", "way_out"), HEAT, ids=lambda v: v[:40])
def test_a_bad_value_of_the_heat_equation_is_refused_in_one_sentence(setting, names, way_out):
    check_sentence(sentence_of(lambda: parse_case(GOOD, [*COOLED, setting])), names, way_out)


@pytest.mark.parametrize(("setting", "names", "way_out"), ROCK, ids=lambda v: v[:40])
def test_a_bad_rock_is_refused_in_one_sentence(setting, names, way_out):
    said = sentence_of(lambda: parse_case(GOOD, setting.splitlines()))
    check_sentence(said.replace(str(Path.cwd()), ""), names, way_out)


@pytest.mark.parametrize(("setting", "names", "way_out"), ROCK_3D, ids=lambda v: v[:40])
def test_a_bad_rock_of_a_solid_is_refused_in_one_sentence(setting, names, way_out):
    check_sentence(sentence_of(lambda: parse_case(GOOD, [*SOLID, setting])), names, way_out)


@pytest.mark.parametrize(("settings", "names", "way_out"), FORCES, ids=lambda v: str(v[-1])[:40])
def test_a_bad_force_is_refused_in_one_sentence(settings, names, way_out):
    check_sentence(sentence_of(lambda: read(settings)), names, way_out)


@pytest.mark.parametrize(("settings", "names", "way_out"), AXIS, ids=lambda v: str(v[-1])[:40])
def test_a_bad_body_of_revolution_is_refused_in_one_sentence(settings, names, way_out):
    check_sentence(sentence_of(lambda: read(settings)), names, way_out)


def test_the_rock_of_a_case_in_units_has_them_throughout():
    for setting, key in (
        ("material.E={mean=1.0, variation=0.1, length=1.0}", "material.E.mean = 1.0"),
        ('material.E={mean="1 Pa", variation=0.1, length=1.0}', "material.E.length = 1.0"),
        ("regions.a={E=2.0, lower=[0,0], upper=[1,1]}", "regions.a.E = 2.0"),
    ):
        said = sentence_of(lambda setting=setting: parse_case(IN_UNITS, [setting]))
        check_sentence(said, f"{key} has no unit but", "give every number a unit, or none")
    axis = ['material.k=["1 W/(m K)", "2 W/(m K)"]', "material.angle=30"]
    assert parse_case(IN_UNITS, axis).material.angle == 30


@pytest.mark.parametrize(("text", "names", "way_out"), FORMULAS, ids=lambda v: ascii(v[:20]))
def test_a_bad_formula_is_refused_in_one_sentence(text, names, way_out):
    setting = f"heat.bottom={{T={{formula={inline(text)}}}}}"
    said = sentence_of(lambda: parse_case(GOOD, [*COOLED, setting]))
    check_sentence(said, "heat.bottom.T.formula", names, way_out)


IN_UNITS = """
[domain]
size = ["1 m", "1 m"]
h = "0.1 m"
[material]
E = "1 GPa"
Gc = "1 J/m^2"
expansion = "1e-5 1/K"
k = "2 W/(m K)"
rho = "2000 kg/m^3"
c = "800 J/(kg K)"
[damage]
ell = "0.3 m"
[temperature]
profile = "heat"
[heat]
initial = "20 °C"
bottom = { T = "5 °C" }
[time]
t = ["1 s"]
"""


@pytest.mark.parametrize(
    ("name", "example"),
    [("k", "2.5 W/(m K)"), ("rho", "2700 kg/m^3"), ("c", "800 J/(kg K)"), ("expansion", "9e-6")],
)
def test_with_units_the_heat_equation_has_no_rock_by_default(name, example):
    lines = [line for line in IN_UNITS.splitlines() if not line.startswith(f"{name} = ")]
    said = sentence_of(lambda: parse_case("\n".join(lines)))
    check_sentence(said, f"material.{name} is missing", f'write it like {name} = "{example}')


@pytest.mark.parametrize(
    ("setting", "key"),
    [
        ("heat.bottom={T=5.0}", "heat.bottom.T = 5.0"),
        ("heat.bottom={T=0.0}", "heat.bottom.T = 0.0"),
        ("heat.initial=0", "heat.initial = 0.0"),
        ('heat.initial={value="5 °C",gradient=[0,1]}', "heat.initial.gradient = 1.0"),
        ('heat.bottom={T={t=[5],value=["5 °C"]}}', "heat.bottom.T.t = 5.0"),
        ("heat.source=3.0", "heat.source = 3.0"),
        ("material.k=[2.0, 2.0]", "material.k = 2.0"),
        ('heat.cracks={h=2.0,T="5 °C"}', "heat.cracks.h = 2.0"),
        ("heat.bands=[{lower=[0,0],upper=[1,1],k=2}]", "heat.bands.upper = 1.0"),
    ],
)
def test_of_a_case_in_units_a_number_without_one_is_refused(setting, key):
    """A temperature of zero too: 0 K and 0 °C are not the same."""
    said = sentence_of(lambda: parse_case(IN_UNITS, [setting]))
    check_sentence(said, f"{key} has no unit but", "give every number a unit, or none")


def test_weight_has_no_density_by_default_in_units_and_1_in_a_scaled_case():
    lines = [line for line in IN_UNITS.splitlines() if not line.startswith(("rho", "k =", "c ="))]
    text = "\n".join(lines).split("[temperature]")[0]
    given = [
        *('temperature.profile="none"', 'time.t=["1 s"]'),
        'forces.gravity=["0 m/s^2", "-9.8 m/s^2"]',
    ]
    said = sentence_of(lambda: parse_case(text, given))
    check_sentence(said, "material.rho is missing", 'write it like rho = "2700 kg/m^3"')
    assert parse_case(GOOD, ["forces.gravity=[0.0, -1.0]"]).material.rho == 1.0


def test_a_setting_quotes_names_as_toml_does():
    box = "{E=2.0, lower=[0,0], upper=[1,1]}"
    case = parse_case(
        GOOD,
        [
            f'regions."a b.c"={box}',
            f"regions.'d=e'={box}",
            'regions . "a b.c" .nu = 0.3',
            f"regions.Störung={box}",
            "damage.law=AT2",
        ],
    )
    assert list(case.regions) == ["a b.c", "d=e", "Störung"]
    assert case.regions["a b.c"].nu == 0.3 and case.damage.law == "AT2"


@pytest.mark.slow
def test_a_damaged_field_is_told_of_once(tmp_path):
    """In a separate process: what VTK would print goes to a stream that pytest cannot catch."""
    (tmp_path / "E.vtu").write_text("<VTKFile><hello>")
    text = f"{GOOD}[material]\nE = {{ file = 'E.vtu', name = 'E' }}\n"
    (tmp_path / "my.toml").write_text(text)
    done = staffa(tmp_path, "check", "my.toml")
    assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr
    check_sentence(done.stderr.rstrip("\n"), "E.vtu holds no mesh that can be read", "as .vtu")


def test_zero_needs_no_unit_but_as_a_temperature():
    settings = ["heat.top={flux=0}", 'heat.left={T={t=[0,"1 s"],value=["0 °C","1 °C"]}}']
    assert parse_case(IN_UNITS, settings).heat.top.flux == 0


@pytest.mark.parametrize(("settings", "parts"), CONTRADICTIONS, ids=str)
def test_sides_that_meet_and_contradict_each_other_are_refused(settings, parts):
    one, other, name = parts
    said = sentence_of(lambda: parse_case(GOOD, settings))
    meet = f"supports.{one} and supports.{other} meet, and hold {name} differently"
    check_sentence(said, meet, f"give both the same, or take {name} from one of them")


@pytest.mark.parametrize("settings", CONSISTENT, ids=str)
def test_sides_that_meet_and_agree_are_fine(settings):
    assert parse_case(GOOD, settings).supports


@pytest.mark.parametrize(("text", "names", "way_out"), TEXTS, ids=lambda v: repr(v[:20]))
def test_a_text_that_is_no_case_is_refused_in_one_sentence(text, names, way_out):
    check_sentence(sentence_of(lambda: parse_case(text, name="my.toml")), names, way_out)


@pytest.mark.parametrize("key", ["[domain]", "[damage]", "[time]", "size = ", "h = ", "ell = "])
def test_what_is_missing_is_named(key):
    lines = [line for line in GOOD.splitlines() if not line.startswith(key)]
    if key.startswith("["):  # its keys would else belong to the table above
        start = GOOD.index(key)
        end = GOOD.find("\n[", start + 1)
        lines = [GOOD[:start], GOOD[end:] if end > 0 else ""]
    check_sentence(sentence_of(lambda: parse_case("\n".join(lines))), key.removesuffix(" = "))


def test_a_time_of_zero_is_fine_without_a_jump_in_temperature():
    pulled = parse_case(GOOD, [*PULLED, "supports.left={x=1.0}", "time.t=[0.0, 1.0]"])
    film = parse_case(
        GOOD, ['temperature.profile="convective"', "temperature.biot=1", "time.t=[0.0, 1.0]"]
    )
    assert pulled.time.t == film.time.t == (0.0, 1.0)


ELSEWHERE = {
    "beside": ("../E.vtu", "lies outside of the folder of the case file", "--outside"),
    "by its whole path": ("/etc/passwd", "/etc/passwd lies outside", "--outside"),
    "in and out again": ("deep/../../E.vtu", "lies outside", "copy it there"),
    "by a link": ("link.vtu", "E.vtu lies outside", "--outside"),
    "a folder": ("deep", "it is no ordinary file", "the folder of the case file"),
    "a pipe": ("pipe", "it is no ordinary file", "the folder of the case file"),
    "no text": ("E\0.vtu", "a path has at most 1000 characters", "which can be printed"),
    "a long name": ("E" * 5000, "a path has at most 1000 characters", "E..."),
}


@pytest.mark.timeout(60)
@pytest.mark.parametrize("what", ELSEWHERE)
@pytest.mark.parametrize("key", ["material.E={{file={}, name='E'}}", "domain={{mesh={}}}"])
def test_only_ordinary_files_in_the_folder_of_a_case_are_read(tmp_path, key, what):
    folder, (name, *parts) = tmp_path / "case", ELSEWHERE[what]
    (folder / "deep").mkdir(parents=True)
    (tmp_path / "E.vtu").touch()
    (folder / "link.vtu").symlink_to(tmp_path / "E.vtu")
    os.mkfifo(folder / "pipe")
    setting = key.format(inline(name))
    key = "material.E" if "material" in setting else "domain.mesh"
    said = sentence_of(lambda: parse_case(GOOD, [setting], folder=folder))
    check_sentence(said.replace("../", ""), key, *parts)


def test_a_file_elsewhere_is_read_if_that_is_said(tmp_path):
    (tmp_path / "E.vtu").touch()
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "my.toml").write_text(
        f"{GOOD}[material]\nE = {{ file = '../E.vtu', name = 'E' }}\n"
    )
    said = sentence_of(lambda: read_case(tmp_path / "deep" / "my.toml", outside=True))
    check_sentence(said.replace("../", ""), "E.vtu holds no mesh that can be read")


def test_a_file_that_only_names_others_is_refused(tmp_path):
    (tmp_path / "many.pvtu").touch()
    setting = 'material.E={file="many.pvtu", name="E"}'
    said = sentence_of(lambda: parse_case(GOOD, [setting], folder=tmp_path))
    check_sentence(said, "many.pvtu is none of .vtu, .vti", "write the field as one .vtu")


def test_factors_of_bands_that_leave_nothing_are_refused():
    band = "{lower=[0.0,0.0], upper=[1.0,1.0], factor=1e-20},"
    said = sentence_of(lambda: preview(parse_case(GOOD, [f"toughness.bands=[{band * 2}]"])))
    check_sentence(said, "toughness.bands", "1e-40 times material.Gc", "take others")


def file_of(folder: Path, kind: str) -> Path:
    path = folder / "my.toml"
    if kind == "folder":
        path.mkdir()
    elif kind == "run":
        path.mkdir()
        (path / "case.toml").write_text(GOOD)
    elif kind == "below a file":
        path.write_text(GOOD)
        path = path / "my.toml"
    elif kind != "missing":
        content = {"binary": b"\x00\xff\xfe", "latin": "title = 'Größe'".encode("latin-1")}
        path.write_bytes(content.get(kind, b"#" * (LARGEST_FILE + 1)))
    return path


@pytest.mark.parametrize(
    ("kind", "way_out"),
    [
        ("missing", "`staffa new slab > my.toml` writes one"),
        ("folder", "name the TOML file in it"),
        ("run", "case.toml is one"),
        ("below a file", "name a TOML file that you may read"),
        ("binary", "it is not UTF-8 text; save it as such"),
        ("latin", "it is not UTF-8 text; save it as such"),
        ("huge", "larger than 1,000,000 bytes; a case is a page"),
    ],
)
def test_a_file_that_is_no_case_is_refused_in_one_sentence(tmp_path, kind, way_out):
    path = file_of(tmp_path, kind)
    check_sentence(sentence_of(lambda: read_case(path)), "my.toml", way_out)


def test_an_endless_file_is_refused():
    check_sentence(
        sentence_of(lambda: read_case(Path("/dev/zero"))), "/dev/zero", "a case is a page"
    )


def test_a_file_from_windows_is_read(tmp_path):
    path = tmp_path / "my.toml"
    path.write_bytes(b"\xef\xbb\xbf" + GOOD.replace("\n", "\r\n").encode())
    assert read_case(path).title == "small"


def test_an_unknown_ready_case_is_named_with_the_nearest():
    check_sentence(sentence_of(lambda: ready_cases.text("slap")), "'slap'", "Did you mean 'slab'?")


@pytest.mark.parametrize("kind", ["a run", "a file", "below a file"])
def test_a_place_that_cannot_take_a_run_is_refused(tmp_path, kind):
    place, way_out = tmp_path / "out", {"a run": "another folder", "a file": "new or empty"}
    if kind == "a run":
        place.mkdir()
        (place / "case.toml").write_text(GOOD)
    else:
        place.write_text("")
    asked = place / "deep" / "er" if kind == "below a file" else place
    said = sentence_of(lambda: run_directory.require_free(asked))
    check_sentence(said, f"--out {asked}", way_out.get(kind, "you may write to"))


def staffa(folder: Path, *arguments: str, ranks: int = 0) -> subprocess.CompletedProcess:
    """The command, in a folder that must stay as it is; with ranks, the installed one."""
    if not ranks:
        return forked(*arguments, folder=folder)
    return subprocess.run(
        [BIN / "mpiexec", "-n", str(ranks), BIN / "staffa", *arguments],
        cwd=folder,
        capture_output=True,
        text=True,
        timeout=120,
    )


VARIED = ("--set", "toughness.amplitude=0.1")
OVER_H = ("--over", "domain.h=0.1,0.05")
COMMANDS = [
    (("check", "none.toml"), "no file none.toml"),
    (("check", "my.toml", "--set", "material.nu=0.7"), "material.nu = 0.7"),
    (("new", "slap"), "Did you mean 'slab'?"),
    (("run", "my.toml", "--out", "runs/a", "--set", "damage.ell=0.01"), "damage.allow_coarse"),
    (("run", "my.toml", "--out", "my.toml"), "--out my.toml is a file"),
    (("run", "my.toml", "--out", "done"), "go on with `staffa resume done`"),
    (("run", "my.toml", "--wall-time", "soon"), "--wall-time soon: "),
    (("resume", "none"), "no folder none"),
    (("resume", "done"), "done is no run directory"),
    (("resume", "done", "--wall-time", "0 h"), "--wall-time 0 h: "),
    (("show", "my.toml"), "my.toml"),
    (("ensemble", "my.toml", "--seeds", "3"), "toughness.amplitude = 0"),
    (("ensemble", "my.toml", "--seeds", "1", *VARIED), "--seeds 1: "),
    (("ensemble", "my.toml", "--seeds", "3", "--first", "-1", *VARIED), "--first -1: "),
    (("ensemble", "my.toml", "--seeds", "2", "--first", f"{2**32 - 1}", *VARIED), "4294967296"),
    (("ensemble", "my.toml", "--seeds", "2", "--out", "done", *VARIED), "done holds a run already"),
    (("ensemble", "my.toml", "--seeds", "2", "--out", "my.toml", *VARIED), "my.toml is a file"),
    (("ensemble", "my.toml", "--seeds", "2", "--jobs", "0", *VARIED), "--jobs 0: "),
    (("ensemble", "my.toml", "--seeds", "2", "--member", "3", *VARIED), "--member 3: "),
    (("study", "my.toml"), "--over material.Gc="),
    (("study", "my.toml", *OVER_H[:1], "domain.h=0.1,2.0"), "domain.h = 2.0"),
    (("study", "my.toml", *OVER_H[:1], "domain.hh=0.1,0.2"), "Did you mean 'h'?"),
    (("study", "my.toml", *OVER_H[:1], "temperature={},3"), "temperature"),
    (("study", "my.toml", *OVER_H, "--seeds", "2"), "toughness.amplitude = 0"),
    (("study", "my.toml", *OVER_H, "--seeds", "0"), "--seeds 0: "),
    (("study", "my.toml", *OVER_H, "--seeds", "600", *VARIED), "1,200 runs"),
    (("study", "my.toml", *OVER_H, "--first", "-1"), "--first -1: "),
    (("study", "my.toml", *OVER_H, "--samples", "3"), "--samples draws from ranges"),
    (("study", "my.toml", *OVER_H, "--member", "3"), "--member 3: this command has 2 members"),
    (("study", "my.toml", *OVER_H, "--jobs", "2", "--member", "1"), "--jobs and --member"),
    (("study", "my.toml", *OVER_H, "--slurm", "my.toml"), "--slurm my.toml is there already"),
    (("study", "my.toml", *OVER_H, "--slurm", "none/job.sh"), "there is no folder none"),
    (("study", "my.toml", *OVER_H, "--out", "done"), "done holds a run already"),
    (("study", "none.toml", *OVER_H), "no file none.toml"),
]


def files_in(folder: Path) -> list[tuple[str, float]]:
    return sorted((str(path), path.stat().st_mtime) for path in folder.rglob("*"))


@pytest.fixture
def place(tmp_path) -> Path:
    """A folder with a good case and a run."""
    (tmp_path / "my.toml").write_text(GOOD)
    (tmp_path / "done").mkdir()
    (tmp_path / "done" / "steps.jsonl").touch()
    return tmp_path


@pytest.mark.slow
@pytest.mark.parametrize(("arguments", "part"), COMMANDS, ids=lambda v: str(v)[:40])
def test_the_command_says_it_once_and_leaves_no_trace(place, arguments, part):
    before = files_in(place)
    done = staffa(place, *arguments)
    assert done.returncode == 2, f"exit code {done.returncode}: {done.stderr}"
    assert done.stdout == "", done.stdout
    assert done.stderr.count("\n") == 1, done.stderr
    check_sentence(done.stderr.rstrip("\n"), "staffa: ", part)
    assert files_in(place) == before


@pytest.mark.slow
@pytest.mark.parametrize(
    ("stub", "parts"),
    [
        ("raise ImportError", ("which is not installed", "pip install gmsh")),
        ("raise OSError('libGLU.so.1 is missing')", ("(libGLU.so.1 is missing)", "install what")),
    ],
)
def test_unstructured_cells_without_gmsh_are_refused(place, stub, parts, monkeypatch):
    (place / "gmsh.py").write_text(stub)
    before, path = files_in(place), [str(place), os.environ.get("PYTHONPATH", "")]
    monkeypatch.setenv("PYTHONPATH", os.pathsep.join(path).rstrip(os.pathsep))
    monkeypatch.setenv("PYTHONDONTWRITEBYTECODE", "1")
    unstructured = ("--set", "domain.cells=unstructured")
    done = staffa(place, "run", "my.toml", "--out", "runs/a", *unstructured, ranks=1)
    assert done.returncode == 2, f"exit code {done.returncode}: {done.stderr}"
    assert done.stderr.count("\n") == 1, done.stderr
    check_sentence(done.stderr.rstrip("\n"), 'domain.cells = "unstructured"', *parts)
    assert files_in(place) == before

"""Parts of a case that were made for themselves, together: in one case they still hold."""

from pathlib import Path

import numpy as np
import pytest
import pyvista

from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case
from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import to_toml
from staffa.case.values.elements import elements_of
from staffa.case.values.pressing_loads import pressing
from staffa.errors import InputError
from staffa.io.run_directory import open_run
from staffa.runs.resume import _pressed
from staffa.runs.run import run

HEATED = """
[domain]
size = ["60 mm", "50 mm"]
h = "5 mm"
[material]
E = "65 GPa"
nu = 0.2
Gc = "60 J/m^2"
expansion = "6e-6 1/K"
k = "3 W/(m K)"
rho = "2750 kg/m^3"
c = "790 J/(kg K)"
[damage]
ell = "15 mm"
[temperature]
profile = "heat"
face = "bottom"
[heat]
initial = "150 °C"
bottom = { T = "20 °C" }
[supports]
left = "rollers"
right = "rollers"
[time]
t = ["10 s", "1 min"]
"""
TABLE = '{T=["20 °C","300 °C"],value=["60 GPa","70 GPa"]'
FILE = '{file="T.vtu",name="T",field_unit="°C"}'


def heated(*settings: str, folder: Path = Path()) -> Case:
    return parse_case(HEATED, settings, folder=folder)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """A folder with a field of temperatures, and one of factors that covers half of the body."""
    whole = pyvista.ImageData(dimensions=(7, 6, 1), spacing=(0.01, 0.01, 1.0))
    whole.point_data["T"] = np.full(whole.n_points, 20.0)
    whole.cast_to_unstructured_grid().save(tmp_path / "T.vtu")
    half = pyvista.ImageData(dimensions=(4, 6, 1), spacing=(0.01, 0.01, 1.0))
    half.point_data["f"] = np.ones(half.n_points)
    half.cast_to_unstructured_grid().save(tmp_path / "half.vtu")
    return tmp_path


@pytest.mark.parametrize(
    "side",
    [
        f"heat.bottom={{T={FILE}}}",
        f'heat.bottom={{h="500 W/(m^2 K)",T={FILE}}}',
        f"heat.initial={FILE}",
        f"heat.stress_free={FILE}",
    ],
)
def test_temperatures_of_files_and_properties_of_temperature(side: str, folder: Path) -> None:
    """`check` ended in a traceback: the range of temperatures knew no files."""
    case = heated(f"material.E={TABLE}}}", side, folder=folder)
    assert preview(case).facts


@pytest.mark.parametrize(
    ("factor", "said"),
    [
        ('{formula="x-1"}', r"material\.E\.factor.*larger than zero"),
        ('{formula="foo"}', r"material\.E\.factor\.formula.*'foo' is not known"),
        ('{file="half.vtu",name="f"}', r"material\.E\.factor.*does not reach"),
        ('{mean=1.0,variation=0.9,distribution="normal",length=0.01}', r"material\.E\.factor"),
    ],
)
def test_factors_of_tables_of_temperature_are_looked_at(
    factor: str, said: str, folder: Path
) -> None:
    with pytest.raises(InputError, match=said):
        heated(f"material.E={TABLE},factor={factor}}}", folder=folder)


def test_elements_are_those_of_the_largest_poissons_ratio_of_a_table() -> None:
    nu = "material.nu={T=[" + '"20 °C","300 °C"],value=[0.3,0.49]}'
    assert elements_of(heated(nu, "material.plane=strain")) == "reduced"
    assert elements_of(heated("material.plane=strain")) == "linear"


LATE = 'top={h={t=["0 s","1 h"],value=["0 W/(m^2 K)","9000 W/(m^2 K)"]},T="149 °C"}'


def test_a_film_that_opens_late_may_warm_what_has_cooled() -> None:
    """Though its fluid is colder than the start: the rock broke by pressure, without a split."""
    assert pressing(heated()) == ()
    (reason,) = pressing(heated(f"heat.{LATE}"))
    assert reason == "warming up again (heat.top)"
    assert heated(f"heat.{LATE}").damage.split == "no-tension"
    fluid = 'heat.cracks={h="500 W/(m^2 K)",T="149 °C"}'
    assert pressing(heated(fluid)) == ("warming up again (heat.cracks)",)
    assert pressing(heated('heat.top={h="500 W/(m^2 K)",T="149 °C"}')) == ()


def test_a_run_that_is_made_longer_says_what_comes_to_press_its_rock() -> None:
    warm = 'heat.bottom={T={t=["0 s","1 min","2 min"],value=["20 °C","20 °C","150 °C"]}}'
    old = parse_case(to_toml(heated(warm)), ["damage.split=none"])
    longer = parse_case(to_toml(old), ['time.t=["10 s","1 min","5 min"]'])
    said = _pressed(old, longer)
    assert said and "warming up again (heat.bottom)" in said
    assert _pressed(longer, longer) is None and _pressed(old, old) is None


def test_a_case_to_be_edited_leaves_open_what_follows_from_it() -> None:
    text = to_toml(heated(), explained=True)
    assert "\nsplit = " not in text and "\nelements = " not in text
    assert parse_case(text, [f"heat.{LATE}"]).damage.split == "no-tension"


def test_the_record_tells_why_a_split_was_taken(tmp_path: Path) -> None:
    run(heated('heat.bottom={T="200 °C"}', 'time.t=["1 s"]'), tmp_path / "run")
    manifest = open_run(tmp_path / "run").manifest
    assert manifest.split == "no-tension"
    assert manifest.split_reason.startswith("by default, as heating (heat.bottom)")


SLIT = """
[domain]
size = [1.0, 1.0]
h = 0.05
[material]
nu = 0.2
[damage]
ell = 0.05
[temperature]
profile = "none"
[supports]
bottom = "rollers"
top = { y = 0.001 }
[[cracks]]
start = [0.0, 0.5]
end = [0.45, 0.5]
[time]
t = [1.0]
[output]
at = [1.0]
"""


def test_friction_is_refused_with_elements_whose_slip_is_no_number_a_cell() -> None:
    contact = "damage={ell=0.05,split='contact',friction=0.3}"
    with pytest.raises(InputError, match=r"domain\.elements = \"reduced\".*\"linear\""):
        parse_case(SLIT, [contact, "domain.elements=reduced"])
    near = parse_case(SLIT, [contact, "material={nu=0.49,plane='strain'}"])
    assert near.domain.elements == "linear"


@pytest.mark.slow
def test_a_tip_whose_faces_may_slide_has_the_same_energy_release_rate(tmp_path: Path) -> None:
    """Without friction; the normals of faces are no property of the rock."""
    found = {}
    for split in ("none", "contact"):
        run(parse_case(SLIT, [f"damage.split={split}"]), tmp_path / split)
        (tip,) = open_run(tmp_path / split).steps[-1].released
        found[split] = tip.G
    assert found["none"] and found["contact"] == pytest.approx(found["none"], rel=0.02)


UNEVEN = """
[domain]
size = ["1 m", "1 m"]
h = "4 cm"
[material]
E = "10 GPa"
nu = 0.2
Gc = "1e9 J/m^2"
expansion = "1e-5 1/K"
k = "3 W/(m K)"
rho = "2750 kg/m^3"
c = "790 J/(kg K)"
[damage]
ell = "4 cm"
split = "none"
[temperature]
profile = "heat"
face = "bottom"
[heat]
initial = "100 °C"
stress_free = { value = "0 °C", gradient = ["200 K/m", "0 K/m"] }
bottom = { T = "100 °C" }
[supports]
bottom = "rollers"
top = "rollers"
[[cracks]]
start = ["0 m", "0.5 m"]
end = ["0.45 m", "0.5 m"]
[time]
t = ["1 s"]
[output]
at = ["1 s"]
"""


@pytest.mark.slow
def test_a_law_of_temperature_that_changes_nothing_leaves_the_energy_release_rate(
    tmp_path: Path,
) -> None:
    """The stress-free temperature is fixed in space, where a law looks at it too."""
    found = {}
    law = '{T=["-100 °C","100 °C","300 °C"],value=["20 GPa","10 GPa","1 GPa"]}'
    for name, settings in {"number": [], "law": [f"material.E={law}"]}.items():
        run(parse_case(UNEVEN, settings), tmp_path / name)
        found[name] = open_run(tmp_path / name).steps[-1].released[0].G
    assert found["number"] and found["law"] == pytest.approx(found["number"], rel=2e-3)

"""The table domain.refine: bad inputs in one sentence each, and the halvings that it asks for."""

from pathlib import Path

import pytest

from case.test_bad_input import GOOD, check_sentence, files_in, read, sentence_of, staffa
from case.test_reservoir_case import GOOD as RESERVOIR
from staffa.case.check.cost import duration
from staffa.case.check.preview import preview
from staffa.case.reading.read import parse_case, read_case
from staffa.case.reading.ready_cases import ready_case
from staffa.case.schema.toml_text import to_toml
from support.bodies import needs_gmsh
from support.meshes import plate, written

TRIANGLES = "domain.cells=triangle"
SOLID = "domain.size=[1.0,1.0,1.0]"
NAMED = '[[cracks]]\nname = "fault"\n[regions.sand]\n[regions.shale]\n'
OFF = "or leave domain.refine out"
DISC = 'domain={shape={kind="disc",radius=1.0},h=0.1,refine=true}'
BORED = (
    'domain={shape={kind="plate with hole",size=[4.0,4.0],radius=0.5},h=0.1,'
    'refine={coarsest="4 h"}}'
)

# The change to the good case on triangles; what the sentence names; the rule or the way out.
KEYS = [
    ('domain.refine="yes"', 'domain.refine = "yes"', "true or false"),
    ("domain.refine=3", "domain.refine = 3", "true or false"),
    ("domain.refine=[true]", "domain.refine = [true]", "true or false"),
    ('domain.refine={from="8 h"}', "domain.refine has no key 'from'", "ahead, coarsest"),
    ('domain.refine={coarsest="8"}', 'coarsest = "8"', "a number of h above 0 and up to 1,000,000"),
    ("domain.refine={coarsest=8}", "domain.refine.coarsest = 8", "a text in quotes"),
    ('domain.refine={coarsest="8 ell"}', 'coarsest = "8 ell"', 'like "4 h"'),
    ('domain.refine={coarsest="0 h"}', 'coarsest = "0 h"', 'like "4 h"'),
    ('domain.refine={coarsest="-4 h"}', 'coarsest = "-4 h"', 'like "4 h"'),
    (f'domain.refine={{coarsest="1{"0" * 400} h"}}', 'coarsest = "1000', "up to 1,000,000"),
    ('domain.refine={ahead="2"}', 'ahead = "2"', "a number of ell above 0 and up to 1,000,000"),
    ('domain.refine={ahead="2 h"}', 'ahead = "2 h"', 'like "4 ell"'),
    ('domain.refine={ahead="0 ell"}', 'ahead = "0 ell"', 'like "4 ell"'),
    ("domain.refine={drive=0}", "domain.refine.drive = 0", "larger than zero"),
    ("domain.refine={drive=1.5}", "domain.refine.drive = 1.5", "at most 1"),
    ('domain.refine={drive="a"}', 'domain.refine.drive = "a"', "one number"),
    ("domain.refine={drop=0.0}", "domain.refine.drop = 0.0", "larger than zero"),
    ("domain.refine={drop=2}", "domain.refine.drop = 2", "at most 1"),
    ("domain.refine={drop=nan}", "domain.refine.drop = nan", "a finite number"),
]

RULES = [
    (("domain.refine=true",), "quadrilateral cells cannot be split", 'cells = "triangle"'),
    (("domain.cells=quadrilateral", "domain.refine={drop=0.1}"), "quadrilateral", OFF),
    ((SOLID, "domain.refine=true"), "hexahedron cells cannot be split", 'cells = "tetrahedron"'),
    ((SOLID, "domain.cells=hexahedron", "domain.refine=true"), "hexahedron", '"unstructured"'),
    ((TRIANGLES, "domain.refine=true", "domain.h=0.2"), "a sixteenth of the body", OFF),
    ((TRIANGLES, 'domain.refine={coarsest="1.9 h"}'), "refine.coarsest, 0.19, with which", OFF),
    (
        (TRIANGLES, 'domain.refine={coarsest="2 h"}', "domain.h=0.21"),
        "those that begin with 2 h would be 0.167 long when halved",
        "take domain.h = 0.167",
    ),
    ((DISC,), 'the coarse cells of a "disc"', "a body with flat faces"),
    ((BORED,), 'the coarse cells of a "plate with hole"', OFF),
]


@pytest.mark.parametrize(("setting", "names", "way_out"), KEYS, ids=lambda v: v[:40])
def test_a_bad_value_is_refused_in_one_sentence(setting, names, way_out) -> None:
    said = sentence_of(lambda: read([TRIANGLES, setting]))
    check_sentence(said, "domain.refine", names, way_out)


@pytest.mark.parametrize(("settings", "names", "way_out"), RULES, ids=lambda v: str(v)[:40])
def test_a_body_that_cannot_be_refined_is_refused(settings, names, way_out) -> None:
    said = sentence_of(lambda: read(settings))
    check_sentence(said, "domain.refine = ", names, way_out)


@needs_gmsh
def test_a_mesh_from_a_file_needs_h(tmp_path: Path) -> None:
    """With h it is halved from its mean edge on; without, nothing says how far."""
    written(tmp_path / "plate.msh", plate, h=0.2)
    text = GOOD.replace("size = [1.0, 1.0]\nh = 0.1", 'mesh = "plate.msh"\nrefine = true')
    text = text.replace("severity = 10.0", 'severity = 10.0\nface = "floor"')
    (tmp_path / "my.toml").write_text(text + NAMED)
    said = sentence_of(lambda: read_case(tmp_path / "my.toml"))
    check_sentence(said, "domain.refine = true", "refined down to domain.h; give domain.h", OFF)
    assert read_case(tmp_path / "my.toml", ["domain.h=0.04"]).domain.halvings == 2
    said = sentence_of(lambda: read_case(tmp_path / "my.toml", ["domain.h=0.15"]))
    mean, way_out = "the mean edge of the mesh, 0.187", "take domain.h <= 0.09"
    check_sentence(said, "domain.refine = true", mean, "domain.h = 0.15", way_out, OFF)


def test_the_cells_of_a_reservoir_stay_as_they_are() -> None:
    settings = (TRIANGLES, "domain.refine=true")
    said = sentence_of(lambda: parse_case(RESERVOIR, settings))
    check_sentence(said, "domain.refine = true", "[reservoir]", "leave domain.refine out")


@pytest.mark.parametrize(
    ("setting", "halvings"),
    [
        ("domain.refine=false", 0),
        ("domain.refine=true;domain.h=0.025", 1),
        ("domain.refine={};domain.h=0.025", 1),
        ('domain.refine={coarsest="2 h"}', 1),
        ('domain.refine={coarsest="4 h"}', 1),
        ('domain.refine={coarsest="5 h"}', 1),
        ('domain.refine={coarsest="2 h"};domain.h=0.167', 1),
    ],
)
def test_edges_are_halved_as_often_as_the_body_allows(setting: str, halvings: int) -> None:
    """A side of 10 h has 5 cells of 2 h; 3 cells of 4 h would end at .83 h. By default cells begin
    with a sixteenth of the side."""
    case = read([TRIANGLES, *setting.split(";")])
    assert case.domain.halvings == halvings
    assert parse_case(to_toml(case)).domain.halvings == halvings


@pytest.mark.slow
def test_the_command_says_it_once_and_leaves_no_trace(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(GOOD)
    before = files_in(tmp_path)
    for setting in ("domain.refine=true", 'domain.refine={ahead="2 h"}'):
        done = staffa(tmp_path, "run", "my.toml", "--out", "runs/a", "--set", setting)
        assert (done.returncode, done.stdout) == (2, ""), done.stderr
        assert done.stderr.count("\n") == 1, done.stderr
        check_sentence(done.stderr.rstrip("\n"), "staffa: ", "domain.refine")
        assert files_in(tmp_path) == before


def test_check_names_a_mesh_that_follows_the_cracks_where_it_pays() -> None:
    long, keys = ready_case("ceramic-strip"), ["domain.refine=true", 'domain.cells="triangle"']
    cells, why = {name: facts for name, *facts in preview(long).facts}["if refined"]
    refined = ready_case("ceramic-strip", keys)
    end = {name: value for name, value, _ in preview(refined).facts}["cells, end"]
    assert cells.startswith(f"{end} cells at the end, ")
    assert all(key.replace("=", " = ") in why for key in keys)
    assert duration(refined, 1) < 0.5 * duration(long, 1)
    for other in (refined, ready_case("slab"), ready_case("cylinder"), ready_case("doublet")):
        assert "if refined" not in [name for name, *_ in preview(other).facts]

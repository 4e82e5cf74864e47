"""Whatever is given as a case is one, or is refused in one sentence, and nothing else happens."""

import copy
import os
import tomllib
from datetime import date
from pathlib import Path

import numpy as np
import pytest
import pyvista
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from staffa.case.check.preview import preview
from staffa.case.reading import ready_cases
from staffa.case.reading.inspect_mesh import mesh_of
from staffa.case.reading.read import parse_case, read_case
from staffa.case.schema.toml_text import inline, to_toml
from staffa.errors import InputError
from staffa.geometry.simplices import mesh_outline
from staffa.properties.mesh_field import read_field
from support import meshes
from support.bodies import needs_gmsh
from support.commands import forked

TEXTS = {name: ready_cases.text(name) for name in ready_cases.ready_case_names()}
RICH = """
[domain]
size = [1.0, 0.5]
h = 0.05
[material]
E = { formula = "1 + x" }
nu = 0.2
Gc = { mean = 1.0, variation = 0.2, length = [0.3, 0.1], angle = 30.0, seed = 2 }
rho = 1.0
[regions.cap]
lower = [0.0, 0.3]
upper = [1.0, 0.5]
E = [2.0, 1.0, 2.0]
nu = [0.2, 0.1, 0.2]
G = [0.5, 0.5, 0.5]
angle = 20.0
[damage]
ell = 0.15
[temperature]
profile = "heat"
[heat]
initial = 1.0
bottom = { h = 10.0, T = { formula = "0.1*sin(t)" } }
right = { flux = { t = [0.0, 1.0], value = [0.0, -0.1] } }
[forces]
prestress = { xx = -0.5, yy = -0.2 }
gravity = [0.0, -0.1]
top = { pressure = { t = [0.0, 0.1], value = [0.0, 0.2] } }
[supports]
left = "rollers"
right = { x = { t = [0.0, 1.0], u = [0.0, 0.1] } }
[[cracks]]
start = [0.5, 0.0]
end = [0.5, 0.1]
[time]
t = { start = 0.01, stop = 0.4, shortest = 0.0005, longest = 0.1 }
[output]
at = [0.1]
probes = [{ name = "axis", start = [0.5, 0.2], end = [0.5, 0.4], points = 5 }]
"""
TEXTS["rich"] = RICH
CASES = [tomllib.loads(text) for text in TEXTS.values()]
TABLES = [table for case in CASES for table in case.values() if isinstance(table, dict)]
KEYS = sorted({key for table in TABLES for key in table})
WORDS = sorted({word for text in TEXTS.values() for word in text.split()})
UNITS = ["m", "mm", "GPa", "K", "°C", "s", "J/m^2", "1/K", "mm^2/s", "W/(m K)", "deg", "9**9**9"]
PIECES = [*"xyzt+-*/()<>&~,9 ", "**", "1e9", "sin(", "where(", "__import__", "[", "lambda "]

# The same examples each time.
SEEDED = settings(
    derandomize=True, deadline=None, database=None, suppress_health_check=list(HealthCheck)
)
NUMBERS = st.one_of(
    st.floats(),
    st.integers(-3, 12),
    st.sampled_from([0.1, 0.5, 10**400, -(2**63), 2**32, 1e-310, 1e300, 1e-30, 1e30]),
)
SCALARS = st.one_of(
    NUMBERS,
    st.booleans(),
    st.dates(date(1900, 1, 1)),
    st.text(max_size=20),
    st.sampled_from(WORDS),
    st.builds("{} {}".format, NUMBERS, st.sampled_from(UNITS)),
    st.lists(st.sampled_from(PIECES), max_size=30).map("".join),
    st.sampled_from(["../x.msh", "/etc/passwd", "x\0.vtu", "my.toml", "~", ".", ""]),
)
NAMES = st.one_of(
    st.sampled_from([*KEYS, "formula", "file", "name", "mean", "kind", "mesh", "shape", "Q"]),
    st.text(max_size=8),
)
VALUES = st.recursive(
    SCALARS,
    lambda held: st.lists(held, max_size=4) | st.dictionaries(NAMES, held, max_size=4),
    max_leaves=8,
)


def owners(value) -> list:
    """Every table and list of a case."""
    if not isinstance(value, dict | list):
        return []
    inside = value.values() if isinstance(value, dict) else value
    return [value, *(owner for held in inside for owner in owners(held))]


@st.composite
def like(draw, value):
    """Another value of the same kind."""
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        return draw(VALUES)
    number = draw(st.sampled_from([0, 1, -1, 2, 0.5, 0.05, 1.5, 1e-3, 1e3, 1e9]))
    if isinstance(value, str):
        _, gap, unit = value.partition(" ")
        return f"{number}{gap}{unit}" if gap else draw(st.sampled_from(WORDS)).strip('",')
    return type(value)(number)


@st.composite
def changed(draw) -> str:
    """A ready case of which one to three things are other than they were."""
    case = copy.deepcopy(draw(st.sampled_from(CASES)))
    for _ in range(draw(st.integers(1, 3))):
        owner = draw(st.sampled_from([owner for owner in owners(case) if owner] or [case]))
        places = list(owner) if isinstance(owner, dict) else range(len(owner))
        place = draw(st.sampled_from(places)) if owner else "domain"
        what = draw(st.sampled_from(["like", "another", "none", "nested", "renamed", "one more"]))
        before = owner[place] if owner else None
        if what == "like":
            owner[place] = draw(like(before))
        elif what == "another":
            owner[place] = draw(VALUES)
        elif what == "none":
            del owner[place]
        elif what == "nested":
            owner[place] = draw(st.sampled_from([[before], {"x": before}, [[before] * 3] * 3]))
        elif isinstance(owner, list):
            owner.insert(place, draw(VALUES | st.just(before)))
        else:
            owner[draw(NAMES)] = owner.pop(place) if what == "renamed" else draw(VALUES)
    return "\n".join(f"{inline(name)} = {inline(value)}" for name, value in case.items())


@st.composite
def spoiled(draw) -> bytes:
    """The file of a ready case, cut, or with bytes or lines that were not there."""
    text = draw(st.sampled_from(list(TEXTS.values()))).encode()
    for _ in range(draw(st.integers(1, 4))):
        where = draw(st.integers(0, len(text)))
        lines = text.split(b"\n")
        line = draw(st.integers(0, len(lines) - 1))
        what = draw(st.sampled_from(["cut", "byte", "inserted", "line", "moved", "windows"]))
        if what == "cut":
            text = text[:where]
        elif what == "byte":
            text = text[:where] + draw(st.binary(max_size=2)) + text[where + 1 :]
        elif what == "inserted":
            text = text[:where] + draw(st.sampled_from(TOKENS) | st.binary()) + text[where:]
        elif what == "line":
            text = b"\n".join([*lines[:line], lines[line], *lines[line:]])
        elif what == "moved":
            text = b"\n".join([*lines[:line], *lines[line + 1 :], lines[line]])
        else:
            text = b"\xef\xbb\xbf" + text.replace(b"\n", b"\r\n")
    return text


TOKENS = [b"[", b"]", b"[[", b"{", b"}", b"=", b'"', b"'''", b"#", b"\\", b".", b"-", b"9" * 5000,
          b"\0", b"\x1b[31m", b"[" * 2000, b"a." * 3000, b"inf", b"nan", b"\xff"]  # fmt: skip


def judge(read) -> None:
    """A case can be looked at, and is the same when it was written and read; or it is refused."""
    try:
        case = read()
        said = preview(case)
    except InputError as error:
        assert str(error).isprintable() and len(str(error)) < 2000, str(error)
        return
    assert all(sentence.isprintable() for sentence in (case.title, *said.warnings))
    assert parse_case(to_toml(case)) == case


def judge_file(folder: Path, content: bytes) -> None:
    (folder / "my.toml").write_bytes(content)
    judge(lambda: read_case(folder / "my.toml"))
    assert [path.name for path in folder.iterdir()] == ["my.toml"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    return tmp_path_factory.mktemp("fuzz")


def test_what_is_changed_are_cases() -> None:
    for text in TEXTS.values():
        case = parse_case(text)
        assert parse_case(to_toml(case)) == case


@settings(SEEDED, max_examples=800)
@given(text=changed())
def test_a_changed_case_is_a_case_or_refused(text: str) -> None:
    judge(lambda: parse_case(text))


@settings(SEEDED, max_examples=200)
@given(content=spoiled())
def test_a_spoiled_file_is_a_case_or_refused(folder: Path, content: bytes) -> None:
    judge_file(folder, content)


@settings(SEEDED, max_examples=200)
@given(key=st.sampled_from(KEYS), text=st.text(max_size=60), name=st.sampled_from(list(TEXTS)))
def test_any_setting_is_a_setting_or_refused(key: str, text: str, name: str) -> None:
    for setting in (text, f"domain.{key}={text}", f"{key}.{text}=1"):
        judge(lambda setting=setting: parse_case(TEXTS[name], [setting]))


@pytest.mark.long
@pytest.mark.timeout(3600)
@settings(SEEDED, max_examples=20_000, derandomize=False)
@given(text=changed())
def test_many_changed_cases_are_cases_or_refused(text: str) -> None:
    judge(lambda: parse_case(text))


@pytest.mark.long
@pytest.mark.timeout(3600)
@settings(SEEDED, max_examples=20_000, derandomize=False)
@given(content=spoiled())
def test_many_spoiled_files_are_cases_or_refused(folder: Path, content: bytes) -> None:
    judge_file(folder, content)


@pytest.mark.slow
@settings(SEEDED, max_examples=5)
@given(content=spoiled() | changed().map(str.encode))
def test_the_command_ends_in_words_and_writes_nothing(folder: Path, content: bytes) -> None:
    (folder / "my.toml").write_bytes(content)
    done = forked("check", "my.toml", folder=folder, timeout=60)
    said = done.stderr
    assert (done.returncode, said.count("\n")) in {(0, 0), (2, 1)}, said
    assert "Traceback" not in said and bool(done.stdout) == (done.returncode == 0)
    assert [path.name for path in folder.iterdir()] == ["my.toml"]


# Of each file; `make verify` asks for 250.
MUTATIONS = int(os.environ.get("STAFFA_FUZZ", "25"))
CHANGES = st.lists(
    st.tuples(
        st.floats(0, 1, exclude_max=True),
        st.one_of(
            st.binary(min_size=1, max_size=8),
            st.sampled_from([b"", b"nan", b"-1", b"99999999999", b"0", b"<", b"$End", b"\x00"]),
        ),
        st.integers(0, 40),
    ),
    min_size=1,
    max_size=4,
)


def mutated(content: bytes, changes: list[tuple[float, bytes, int]]) -> bytes:
    """A file with some bytes taken out, and others put in their place."""
    for where, put, out in changes:
        at = int(where * len(content))
        content = content[:at] + put + content[at + out :]
    return content


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> dict[str, bytes]:
    """A mesh and a field that are good."""
    folder = tmp_path_factory.mktemp("whole")
    meshes.written(folder / "a.msh", meshes.plate, h=0.5)
    grid = pyvista.ImageData(dimensions=(3, 3, 2)).cast_to_unstructured_grid()
    grid.point_data["E"] = np.arange(float(grid.n_points))
    grid.save(folder / "a.vtu", binary=False)
    assert mesh_of(folder / "a.msh", 1.0, "a.msh").cells.size
    assert read_field(folder / "a.vtu", "E").values.size == 18
    return {end: (folder / f"a{end}").read_bytes() for end in (".msh", ".vtu")}


@needs_gmsh
@pytest.mark.slow
@pytest.mark.parametrize("end", [".msh", ".vtu"])
def test_a_mutated_file_is_read_or_refused_in_one_sentence(
    end: str, whole: dict[str, bytes], tmp_path: Path
) -> None:
    """Nothing crashes, hangs for a minute, or asks for more than some GiB (`guarded_reading`)."""
    file, refused = tmp_path / f"a{end}", 0

    @settings(SEEDED, max_examples=MUTATIONS)
    @given(changes=CHANGES)
    def read(changes: list[tuple[float, bytes, int]]) -> None:
        nonlocal refused
        file.write_bytes(mutated(whole[end], changes))
        try:
            if end == ".msh":
                mesh_outline(mesh_of(file, 1.0, file.name))
            else:
                read_field(file, "E")
        except InputError as error:
            assert "\n" not in str(error) and len(str(error)) < 600, error
            refused += 1

    read()
    assert refused > MUTATIONS / 4, "most files were as good as before: the test sees little"
    assert [path.name for path in tmp_path.iterdir()] == [file.name]

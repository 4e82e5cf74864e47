"""Page on the architecture: its pictures are those of the code, its files exist, rows are done."""

import ast
import importlib.util
import re
from pathlib import Path
from types import ModuleType

import pytest

from staffa import doctor
from staffa.case import rules
from staffa.case.reading import ready_cases
from staffa.case.reading.read import parse_case
from staffa.case.schema.case import Case
from staffa.errors import InputError
from support.paths import DOCS, ROOT

SOURCE = ROOT / "src" / "staffa"
PAGE = (DOCS / "development" / "architecture.md").read_text(encoding="utf-8")
TABLE = PAGE.split("## To add X, touch Y")[1].split("\n## ")[0]
PAGES = [*sorted(ROOT.glob("*.md")), *sorted(DOCS.rglob("*.md"))]
REPOSITORY = ("src/", "docs/", "tests/", "tools/", "bench/", "verif")


def drawing() -> ModuleType:
    """Load tools/draw_rooms.py, which is no part of the package."""
    spec = importlib.util.spec_from_file_location("draw_rooms", ROOT / "tools" / "draw_rooms.py")
    assert spec and spec.loader
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_picture_shows_the_rooms_and_imports_of_the_code() -> None:
    rooms = drawing().Rooms(SOURCE)
    picture = (DOCS / "pictures" / "rooms.svg").read_text(encoding="utf-8")
    arrows = set(re.findall(r'id="([\w.]+)-&gt;([\w.]+)"', picture))
    assert arrows == rooms.arrows(), "run .venv/bin/python tools/draw_rooms.py"
    drawn = set(re.findall(r">\s*([\w.]+)\s*</text>", picture))
    assert rooms.below.keys() <= drawn, "run .venv/bin/python tools/draw_rooms.py"


def test_the_page_tells_of_every_room() -> None:
    table = PAGE.split("## The rooms")[1].split("\n## ")[0]
    told = set(re.findall(r"`(\w+)`", table))
    rooms = {name.split(".")[-1] for name in drawing().Rooms(SOURCE).below}
    assert rooms <= told, f"docs/development/architecture.md tells nothing of {rooms - told}"


def test_the_picture_of_the_data_names_classes_where_they_are() -> None:
    for what, where, _ in drawing().FLOW:
        if what[0].isupper():
            folder = SOURCE / where.replace(".", "/")
            found = any(what in defined(file) for file in folder.glob("*.py"))
            assert found, f"the room {where} has no class {what}"


def defined(path: Path) -> set[str]:
    """Return the names of the classes, functions, methods, types and constants of a module."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ClassDef | ast.FunctionDef):
            found.add(node.name)
        elif isinstance(node, ast.Assign):
            found |= {target.id for target in node.targets if isinstance(target, ast.Name)}
        elif isinstance(node, ast.AnnAssign) and isinstance(node.target, ast.Name):
            found.add(node.target.id)
        elif isinstance(node, ast.TypeAlias):
            found.add(node.name.id)
    return found


def test_every_name_of_the_table_is_defined_in_its_file() -> None:
    named = re.findall(r"`(\w+)` (?:in|of) `([\w/]+\.py)`", TABLE)
    assert len(named) >= 8, f"only {named}: does the test still see them?"
    for name, path in named:
        assert name in defined(SOURCE / path), f"{path} defines no {name}"


def test_every_file_of_the_table_exists() -> None:
    for path in re.findall(r"`([a-z_]+(?:/[\w.]+)*)`", TABLE):
        found = (SOURCE / path).exists() or (ROOT / path).exists()
        found = found or any((ROOT / "tests").rglob(path))
        # Words in the table that are no path: methods and functions.
        assert found or path in {"form", "readings", "at_points", "coupling_of"}, (
            f"there is no {path}"
        )


def missing(page: Path, path: str) -> bool:
    """Tell if a file that a page names does not exist; tests and tools go by their name alone."""
    if "/" not in path:
        folders = [ROOT / name for name in ("tests", "tools", "bench", "verification")]
        found = any(list(folder.rglob(path)) for folder in folders)
        return not found and not (SOURCE / path).exists()
    return not any((folder / path).exists() for folder in (ROOT, SOURCE, page.parent))


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.name)
def test_every_file_that_a_page_names_exists(page: Path) -> None:
    text = page.read_text(encoding="utf-8")
    if page.name == "CHANGELOG.md":  # older entries name files of their time
        text = text.split("\n## [0.")[0]
    named = set(re.findall(r"`((?:[\w.-]+/)*\w[\w-]*\.py)`", text))
    named |= {
        path
        for path in re.findall(r"`([\w./-]+/[\w-]+\.(?:toml|json|sh|md|slurm))`", text)
        if path.startswith(REPOSITORY) and "NAME" not in path
    }
    gone = sorted(path for path in named if missing(page, path))
    assert not gone, f"{page.name} names {gone}, which do not exist: where did they move?"


def test_the_page_is_one_page() -> None:
    assert len(PAGE.splitlines()) <= 120


# Rows of the table, done as they say.


def test_a_file_among_the_ready_cases_is_one(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    (tmp_path / "mine.toml").write_text((SOURCE / "case" / "ready" / "slab.toml").read_text())
    monkeypatch.setattr(ready_cases, "files", lambda package: tmp_path)
    assert ready_cases.ready_case_names() == ("mine",)
    assert ready_cases.ready_case("mine").domain.size


def test_a_rule_in_its_registry_is_applied(monkeypatch: pytest.MonkeyPatch) -> None:
    def nothing_is_small(case: Case) -> None:
        if case.domain.h < 1.0:
            raise InputError("domain.h is small")

    text = ready_cases.text("slab")
    assert parse_case(text)
    monkeypatch.setattr(rules, "RULES", (*rules.RULES, nothing_is_small))
    with pytest.raises(InputError, match=r"domain\.h is small"):
        parse_case(text)


def test_a_check_in_its_registry_is_made(monkeypatch: pytest.MonkeyPatch) -> None:
    for registry in ("NEEDED", "LAST"):
        monkeypatch.setattr(doctor, registry, {})
    monkeypatch.setattr(doctor, "USEFUL", {"weather": lambda: "fine"})
    (found,) = doctor.checkup()
    assert (found.name, found.verdict, found.said) == ("weather", doctor.OK, "fine")

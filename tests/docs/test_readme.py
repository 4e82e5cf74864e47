"""The README and the documents: what they point to is there, what they tell to type exists."""

import re
from pathlib import Path

import pytest
import typer

from staffa.case.check.preview import preview
from staffa.case.reading import ready_cases
from staffa.case.reading.read import parse_case
from staffa.cli.commands import app
from support.paths import DOCS, ROOT

README = ROOT / "README.md"
DOCUMENTS = [README, *sorted(DOCS.rglob("*.md"))]
POINTER = re.compile(r"!?\[[^\]]*\]\(([^)\s]+)\)")
PLACEHOLDER = re.compile(r"\b(TABLE|PICTURE|TODO|TBD|FIXME|XXX|PLACEHOLDER)\b")


def named(document: Path) -> str:
    """Return the name of a document among tests."""
    return document.relative_to(ROOT).as_posix()


KNOWN = typer.main.get_command(app).commands  # type: ignore[attr-defined]


def pointers(document: Path) -> list[str]:
    """Links and pictures of a document, on this disk."""
    found = POINTER.findall(document.read_text(encoding="utf-8"))
    return [name for name in found if not re.match(r"https?:|mailto:|#", name)]


def commands(document: Path) -> list[list[str]]:
    """The words after `staffa` in what a document tells to type, in blocks and in the text."""
    text = document.read_text(encoding="utf-8")
    blocks = re.findall(r"```sh\n(.*?)```", text, flags=re.DOTALL)
    lines = [line.split("#")[0] for block in blocks for line in block.splitlines()]
    lines += re.findall(r"`((?:mpiexec [^`]* )?staffa [^`]+)`", text)
    called = [
        re.match(r"(?:.*\b(?:mpiexec|srun)\b.*\s)?staffa\s+([a-z].*)", line) for line in lines
    ]
    return [match.group(1).split() for match in called if match]


@pytest.mark.parametrize("document", DOCUMENTS, ids=named)
def test_every_link_and_picture_is_there(document: Path) -> None:
    missing = [
        name for name in pointers(document) if not (document.parent / name.split("#")[0]).exists()
    ]
    assert not missing, f"{document.name} points to {missing}"


def block(page: str) -> str:
    """The first case, or part of one, that a page shows."""
    text = (DOCS / page).read_text(encoding="utf-8")
    found = re.search(r"```toml\n(.*?)```", text, flags=re.DOTALL)
    assert found
    return found.group(1)


def test_nothing_is_off_with_the_first_case_and_its_numbers_are_those_of_check() -> None:
    found = preview(parse_case(block("tutorials/first-case.md")))
    facts = {name: value for name, value, _ in found.facts}
    page = (DOCS / "tutorials" / "first-case.md").read_text(encoding="utf-8")
    assert found.warnings == ()
    assert float(facts["sigma_c"].split()[0]) == pytest.approx(10e6, rel=1e-2)
    assert "here 4 mm" in page and facts["ell0"] == "0.00411 m"
    assert "12 cm after three hours" in page and facts["sqrt(kappa t), last step"] == "0.123 m"
    assert "18 steps or more, about 2 min" in page
    assert (facts["steps"], facts["time"]) == ("18 or more", "about 2 min")
    (note,) = found.notes
    assert "8.7 MPa on average" in page and "a mean stress of about 8.66 MPa" in note


REST = """
[domain]
size = ["20 m", "10 m"]
h = "0.1 m"
[damage]
ell = "0.3 m"
[temperature]
dT = "100 K"
[time]
t = ["1 hour"]
"""
ROCK = 'E = "60 GPa"\nnu = 0.2\nGc = "60 J/m^2"\nexpansion = "8e-6 1/K"\nkappa = "1e-6 m^2/s"\n'


def test_the_stress_of_the_page_on_forces_is_held() -> None:
    text = block("how-to/forces.md").replace("[material]\n", f"[material]\n{ROCK}") + REST
    assert not [said for said in preview(parse_case(text)).warnings if "relaxes" in said]


def test_the_readme_has_links() -> None:
    assert len(pointers(README)) >= 5, f"only {pointers(README)}: does the test still see them?"


@pytest.mark.parametrize("document", DOCUMENTS, ids=named)
def test_no_placeholder_is_left(document: Path) -> None:
    lines = document.read_text(encoding="utf-8").splitlines()
    left = [line for line in lines if PLACEHOLDER.search(line)]
    assert not left, f"{document.name} has {left}"


@pytest.mark.parametrize("document", DOCUMENTS, ids=named)
def test_commands_and_options_that_a_document_tells_to_type_exist(document: Path) -> None:
    for words in commands(document):
        assert words[0] in KNOWN, f"staffa has no {words[0]}; it has {sorted(KNOWN)}"
        options = {name for parameter in KNOWN[words[0]].params for name in parameter.opts}
        given = {word.split("=")[0] for word in words[1:] if word.startswith("--")}
        assert given <= options | {"--help"}, f"staffa {words[0]} has no {given - options}"


def test_every_command_is_told_somewhere() -> None:
    told = {words[0] for document in DOCUMENTS for words in commands(document)}
    assert told == set(KNOWN)


def test_every_case_that_the_readme_names_is_a_ready_one() -> None:
    text = README.read_text(encoding="utf-8")
    named = [words[1] for words in commands(README) if words[0] == "new"]
    named += re.findall(r'ready_case\("([^"]+)"\)', text)
    named += re.findall(r"src/staffa/case/ready/(\w[\w-]*)\.toml", text)
    assert named and set(named) <= set(ready_cases.ready_case_names()), f"{named}"


def test_every_target_of_make_that_the_readme_names_exists() -> None:
    targets = re.findall(r"^([a-z]+):", (ROOT / "Makefile").read_text(), flags=re.MULTILINE)
    named = re.findall(
        r"\bmake ([a-z]+)\b", "\n".join(re.findall(r"`+[^`]+`+", README.read_text()))
    )
    assert named and set(named) <= set(targets), f"make has no {set(named) - set(targets)}"

"""docs/tutorials: each page is a notebook, is in the index, says its time, and ends with links."""

import ast
import importlib.util
import re
from pathlib import Path

import pytest
import yaml

from support.paths import ROOT

FOLDER = ROOT / "docs" / "tutorials"
INDEX = (FOLDER / "index.md").read_text(encoding="utf-8")
NOTEBOOKS = [
    page for page in sorted(FOLDER.glob("*.md")) if "\nfile_format: mystnb\n" in page.read_text()
]
TIME = re.compile(r"(\d+ s|minute)s? .*on (one core|two cores)|takes .*(one core|two cores)")
MAGIC = re.compile(r"^\s*[!%].*$", re.MULTILINE)


def cells(page: Path) -> list[str]:
    """Return the code cells of a notebook."""
    cell = r"```\{code-cell\} ipython3\n(?::tags: .*\n\n)?(.*?)```"
    return re.findall(cell, page.read_text(encoding="utf-8"), flags=re.DOTALL)


def test_there_are_the_tutorials_that_a_new_user_needs() -> None:
    assert {page.stem for page in NOTEBOOKS} == {
        "a-first-crack",
        "a-mesh-from-gmsh",
        "a-quench",
        "a-study",
        "circulation",
        "on-a-cluster",
        "own-law-and-quantity",
        "reading-results",
        "your-own-rock",
    }


@pytest.mark.parametrize("page", NOTEBOOKS, ids=lambda page: page.stem)
def test_a_tutorial_is_a_notebook_of_the_index(page: Path) -> None:
    header = yaml.safe_load(page.read_text(encoding="utf-8").split("---\n")[1])
    assert header["file_format"] == "mystnb" and header["kernelspec"]["name"] == "python3"
    listed = re.findall(r"```\{toctree\}.*?```", INDEX, flags=re.DOTALL)[0].splitlines()
    assert page.stem in listed
    assert INDEX.count(f"]({page.name})") == 1, "the table of the index has each page once"


@pytest.mark.parametrize("page", NOTEBOOKS, ids=lambda page: page.stem)
def test_a_tutorial_begins_with_gain_and_time_and_ends_with_links(page: Path) -> None:
    text = page.read_text(encoding="utf-8").split("---\n", 2)[2].strip()
    title, first = text.split("\n\n")[:2]
    assert title.startswith("# ") and first.startswith("You get "), first
    assert TIME.search(" ".join(first.split())), f"{page.name} does not say how long it takes"
    assert text.split("\n## ")[-1].startswith("Read on\n")


@pytest.mark.parametrize("page", NOTEBOOKS, ids=lambda page: page.stem)
def test_the_cells_of_a_tutorial_are_python(page: Path) -> None:
    found = cells(page)
    assert found, f"{page.name} has no cell"
    for cell in found:
        if not cell.startswith("%%"):
            ast.parse(MAGIC.sub("", cell))


def test_the_times_of_the_notebooks_are_told_with_those_that_take_too_long() -> None:
    path = ROOT / "docs" / "extensions" / "notebook_times.py"
    spec = importlib.util.spec_from_file_location("notebook_times", path)
    assert spec is not None and spec.loader is not None
    extension = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(extension)
    told = extension.table({"tutorials/a": 7.76, "tutorials/b": 61.0}).splitlines()
    assert told[1:] == ["   7.8  tutorials/a", "  61.0  tutorials/b  more than a minute"]


def test_the_measured_time_of_each_notebook_is_on_the_page_of_performance() -> None:
    text = (ROOT / "docs" / "performance.md").read_text(encoding="utf-8")
    titles = {
        re.findall(r"^# (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)[0]
        for page in NOTEBOOKS
    }
    rows = text.split("| tutorial | seconds |")[1].split("\n\n")[0].splitlines()[2:]
    assert {row.split(" | ")[0].removeprefix("| ") for row in rows} == titles

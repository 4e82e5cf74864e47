"""The studies that pages tell to type: the case that is printed before has these keys.

Those of the tutorials are run by `make docs`.
"""

import re
import shlex
from pathlib import Path

import pytest

from support.commands import forked
from support.paths import DOCS

STUDY = re.compile(r"^(staffa study [\w-]+\.toml (?:.*\\\n)*.*)$", re.MULTILINE)


def studies(page: Path) -> list[tuple[str, list[str]]]:
    """Each study of a page: the ready case that was printed last before it, and its words."""
    text = page.read_text(encoding="utf-8")
    found = []
    for study in STUDY.finditer(text):
        printed = re.findall(r"staffa new ([\w-]+) > [\w-]+\.toml", text[: study.start()])
        words = shlex.split(study[1].replace("\\\n", " "), comments=True)
        found.append((printed[-1], words[2:]))
    return found


PAGES = [page for page in sorted((DOCS / "how-to").glob("*.md")) if studies(page)]


def test_pages_are_still_seen() -> None:
    assert sum(len(studies(page)) for page in PAGES) == 4


@pytest.mark.parametrize("page", PAGES, ids=lambda page: page.stem)
def test_the_studies_of_a_page_can_be_planned(page: Path, tmp_path: Path) -> None:
    for place, (case, words) in enumerate(studies(page)):
        folder = tmp_path / str(place)
        folder.mkdir()
        (folder / words[0]).write_text(forked("new", case).stdout, encoding="utf-8")
        if "--slurm" not in words:  # which plans, and runs nothing
            words = re.sub(r" --jobs \d+", "", shlex.join(words))
            words = [*shlex.split(words), "--slurm", "study.sh"]
        planned = forked("study", *words, folder=folder)
        assert planned.returncode == 0, planned.stderr
        assert (folder / "study.sh").exists()

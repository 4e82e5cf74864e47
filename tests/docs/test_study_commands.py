"""The studies that pages tell to type: the case that is printed before has these keys."""

import re
import shlex
from pathlib import Path

import pytest

from support.commands import forked
from support.paths import DOCS

STUDY = re.compile(r"^(staffa study my\.toml (?:.*\\\n)*.*)$", re.MULTILINE)


def studies(page: str) -> list[tuple[str, list[str]]]:
    """Each study of a page: the ready case that was printed last before it, and its words."""
    text = (DOCS / page).read_text(encoding="utf-8")
    found = []
    for study in STUDY.finditer(text):
        printed = re.findall(r"staffa new ([\w-]+) > my\.toml", text[: study.start()])
        words = shlex.split(study[1].replace("\\\n", " "), comments=True)
        found.append((printed[-1], words[2:]))
    return found


@pytest.mark.parametrize(("page", "number"), [("how-to/studies.md", 2), ("how-to/fronts.md", 1)])
def test_the_studies_of_a_page_can_be_planned(page: str, number: int, tmp_path: Path) -> None:
    told = studies(page)
    assert len(told) == number
    for place, (case, words) in enumerate(told):
        folder = tmp_path / str(place)
        folder.mkdir()
        (folder / "my.toml").write_text(forked("new", case).stdout, encoding="utf-8")
        if "--slurm" not in words:  # which plans, and runs nothing
            words = re.sub(r" --jobs \d+", "", shlex.join(words))
            words = [*shlex.split(words), "--slurm", "study.sh"]
        planned = forked("study", *words, folder=folder)
        assert planned.returncode == 0, planned.stderr
        assert (folder / "study.sh").exists()

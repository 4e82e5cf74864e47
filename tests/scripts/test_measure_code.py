"""The script that measures the code finds what it is to find, and nothing else."""

from pathlib import Path

import pytest

import measure_code
from measure_code import MEASURES
from prose import long_sentences, refused
from source_tree import Offender, Tree

ONE = '''"""A module."""


class Twice:
    """Whether a headline is one."""


def three(a, b, cc):
    """Return `a` of b."""


def named(a, b, cc):
    """Return a sum.

    Parameters
    ----------
    a : float
        First term.
    b, cc
        The others.
    """


def _private(a, b, cc): ...
'''
OTHER = '''"""Another one."""

from staffa.cli import main


class Twice:
    """A class that has a crest."""

    def three(self):
        """Return nothing: a method is no public name of the package."""


def three():
    """Return nothing."""
'''


@pytest.fixture
def tree(tmp_path: Path) -> Tree:
    files = {
        "src/staffa/__init__.py": '"""A package."""\n',
        "src/staffa/heat/one.py": ONE,
        "src/staffa/heat/below/one.py": OTHER,
        "src/staffa/model/long.py": '"""A long file."""\n' + "x = 1\n" * 350,
        "src/staffa/model/steps.py": "def long():\n" + "    x = 1\n" * 40,
        "src/staffa/case/ready/bar.toml": "# A bar of its own.\n",
        "README.md": "A short sentence. " + "word " * 41 + ".\n",
    }
    for name, text in files.items():
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)
    return Tree(tmp_path)


EXPECTED = {
    "headlines": ["src/staffa/heat/one.py:4"],
    "idioms": ["src/staffa/heat/below/one.py:7", "src/staffa/case/ready/bar.toml:1"],
    "sentences": ["README.md:1"],
    "parameters": ["src/staffa/heat/one.py:8"],
    "file_names": ["src/staffa/heat/below/one.py:1"],
    "names_without_reason": ["src/staffa/heat/below/one.py:1"],
    "names_in_one_room": ["src/staffa/heat/below/one.py:1", "src/staffa/heat/one.py:1"],
    "classes": ["src/staffa/heat/below/one.py:6"],
    "functions": ["src/staffa/heat/below/one.py:13"],
    "long_files": ["src/staffa/model/long.py:351"],
    "long_functions": ["src/staffa/model/steps.py:1"],
    "imports_up": ["src/staffa/heat/below/one.py:3"],
}


@pytest.mark.parametrize("measure", MEASURES, ids=lambda measure: measure.find.__name__)
def test_a_measure_finds_what_was_planted(measure: measure_code.Measure, tree: Tree) -> None:
    offenders, count = measure.find(tree)
    found = [f"{offender.path}:{offender.line}" for offender in offenders]
    assert found == EXPECTED[measure.find.__name__]
    assert count >= 1
    assert not measure.holds((offenders, count)) or measure.find is measure_code.file_names


def test_six_file_names_may_occur_twice_and_seven_may_not() -> None:
    (measure,) = (m for m in MEASURES if m.find is measure_code.file_names)
    twice = [Offender("one.py", 1, "in heat, model")] * 7
    assert measure.holds((twice[:6], 100)) and not measure.holds((twice, 100))


def test_a_reason_makes_a_second_name_right(tree: Tree, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(measure_code.TWICE, "one.py", "for this test")
    assert measure_code.names_without_reason(tree) == ([], 1)


@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("x\nIt has a file of\n    # its own.", 2),
        ("the cold has come", 1),
        ("Mends it", 1),
        ("class Held:", 1),
    ],
)
def test_refused_words_are_found_across_lines(text: str, line: int) -> None:
    assert [found for found, _, _ in refused(text, markdown=False)] == [line]


@pytest.mark.parametrize("text", ["the cold side", "amend", "outstanding", "held", "effortless"])
def test_other_words_are_left_alone(text: str) -> None:
    assert list(refused(text, markdown=False)) == []


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ("its healing", ["healing"]),
        ("a column `healing`, and of its own", ["of its own"]),
        ("```\nhealing = 0\n```\nno effort", ["effort"]),
    ],
)
def test_docs_may_name_a_record_as_code_alone(text: str, found: list[str]) -> None:
    assert [words for _, words, _ in refused(text, markdown=True)] == found
    assert "healing" not in [words for _, words, _ in refused(text, markdown=False)]


LONG = " ".join(["word"] * 41)


@pytest.mark.parametrize(
    ("markdown", "count"),
    [
        (f"{LONG}.", 1),
        (f"Short.\n{LONG}", 1),
        (f"```\n{LONG}\n```", 0),
        (f"| {LONG} | short |", 1),
        (f"`{LONG}` is code", 0),
        (f"See e.g. {LONG[:150]}. And more of it.", 0),
        (f"{LONG[:120]}\n- {LONG[:120]}\n", 0),
        (f"{LONG[:120]}\n{LONG[:120]}\n", 1),
        (f"{LONG[:120]}. {LONG[:120]}", 0),
        (f"{LONG[:100]} e.g. {LONG[:100]}", 1),
    ],
)
def test_sentences_are_counted_as_a_reader_sees_them(markdown: str, count: int) -> None:
    assert len(list(long_sentences(markdown))) == count

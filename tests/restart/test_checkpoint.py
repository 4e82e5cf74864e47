"""Damage on disk is found: the last good checkpoint is used, and the run says so."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from staffa.errors import InputError
from staffa.io import checkpoint
from staffa.io.checkpoint import DamagedError
from staffa.io.run_directory import CASE, MANIFEST, STEPS, Run, open_run
from staffa.runs.resume import resume, take
from staffa.runs.run import Watcher
from support.restarting import assert_same, small, whole_run


@pytest.fixture(scope="module")
def whole(tmp_path_factory) -> Run:
    return whole_run(small("time.tau=[0.1,0.2,0.3]"), tmp_path_factory.mktemp("whole") / "run")


@pytest.fixture
def copy(whole: Run, tmp_path: Path) -> Path:
    shutil.copytree(whole.path, tmp_path / "run")
    return tmp_path / "run"


def flip(file: Path, where: float = 0.5) -> None:
    """One bit of a file."""
    content = bytearray(file.read_bytes())
    content[int(where * len(content))] ^= 1
    file.write_bytes(content)


def cut(file: Path, keep: float = 0.5) -> None:
    """A part of a file is lost."""
    content = file.read_bytes()
    file.write_bytes(content[: int(keep * len(content))])


def page(run: Path, number: int) -> Path:
    return run / "checkpoint" / f"{number:06d}.json"


def part(run: Path, number: int) -> Path:
    """The file of fields of a checkpoint."""
    name = checkpoint.read_page(run / "checkpoint", number)["state"]
    return run / "checkpoint" / f"{name}.h5"


def spoil_all(run: Path) -> None:
    for number in (2, 3):
        cut(page(run, number))


def spoil_everything(run: Path) -> None:
    """All checkpoints, and the end of the steps."""
    shutil.rmtree(run / "checkpoint")
    last_line(run, lambda s: "")


def last_line(run: Path, change) -> None:
    """Change the last line of the steps."""
    *lines, last = (run / STEPS).read_text().splitlines()
    (run / STEPS).write_text("\n".join([*lines, change(last)]))


DAMAGES = {
    "the format of the page": (
        lambda run: page(run, 3).write_text(page(run, 3).read_text().replace(": 3,", ": 4,", 1)),
        *(2, "its page is not what was written"),
    ),
    "a bit of the fields": (lambda run: flip(part(run, 3)), 2, "is not what was written"),
    "half of the fields": (lambda run: cut(part(run, 3)), 2, "is not what was written"),
    "the fields": (lambda run: part(run, 3).unlink(), 2, "cannot be read"),
    "a bit of the page": (lambda run: flip(page(run, 3)), 2, "its page is not what was written"),
    "half of the page": (lambda run: cut(page(run, 3)), 2, "its page is not what was written"),
    "all of the page": (lambda run: page(run, 3).write_text(""), 2, "its page is not"),
    "half of the last step": (lambda run: last_line(run, lambda s: s[:99]), 2, "steps.jsonl is"),
    "the last step": (lambda run: last_line(run, lambda s: ""), 2, "steps.jsonl is not what"),
    "the last line's end": (lambda run: last_line(run, lambda s: s), 2, "steps.jsonl is not what"),
    "a digit of the first step": (lambda run: flip(run / STEPS, 0.1), 0, "begins again"),
    "both pages": (spoil_all, 0, "begins again with its first step"),
    "everything": (spoil_everything, 0, "no checkpoint can be used"),
}


@pytest.mark.parametrize(("damage", "good", "words"), DAMAGES.values(), ids=DAMAGES)
def test_the_last_good_checkpoint_is_used_and_that_is_said(copy: Path, damage, good, words) -> None:
    damage(copy)
    taken = take(copy)
    assert len(taken.steps) == len(taken.lines) == good
    assert words in "; ".join(taken.said)
    assert all(sentence.isprintable() for sentence in taken.said)


@pytest.mark.long
@pytest.mark.parametrize("name", ["a bit of the fields", "half of the last step", "everything"])
def test_a_damaged_run_comes_to_the_same_end(copy: Path, whole: Run, name: str) -> None:
    DAMAGES[name][0](copy)
    (copy / "fields" / ".step-0007.vtkhdf.staffa-part").write_text("half")
    (copy / "fields" / "mine.pvsm").write_text("a view of somebody's own")
    heard: list[str] = []
    finished = (copy / STEPS).read_text()
    resume(copy, watcher=Watcher(said=heard.append))
    assert any(DAMAGES[name][2] in sentence for sentence in heard), heard
    assert_same(open_run(copy), whole)
    assert take(copy).said == () and len(take(copy).steps) == 3
    assert (copy / "fields" / "mine.pvsm").exists()
    aside = copy / f"{STEPS}.1"
    assert aside.exists() == (DAMAGES[name][1] == 0), "no finished step is lost"
    assert not aside.exists() or aside.read_text() == finished


def test_a_finished_run_without_checkpoints_is_not_started_again(copy: Path, whole: Run) -> None:
    """They were removed to save room, or it is of a staffa that had none."""
    shutil.rmtree(copy / "checkpoint")
    assert resume(copy) == whole.steps
    with pytest.raises(InputError, match="finished, and has no checkpoint to go on from"):
        resume(copy, settings=["time.tau=[0.1,0.2,0.3,0.4]"])
    assert (copy / STEPS).read_bytes() == (whole.path / STEPS).read_bytes()


def test_a_checkpoint_of_the_future_is_refused_and_nothing_older_used(copy: Path) -> None:
    page(copy, 3).write_text(json.dumps({"format": 4, "what": "nobody knows yet"}))
    with pytest.raises(InputError, match="has format 4, this staffa reads 3; use"):
        take(copy)


def test_a_case_that_was_changed_by_hand_is_refused(copy: Path) -> None:
    case = (copy / CASE).read_text()
    (copy / CASE).write_text(re.sub(r"ell = [0-9.]+", "ell = 0.3", case, count=1))
    assert (copy / CASE).read_text() != case
    with pytest.raises(InputError, match=r"case\.toml, or a file that it names, was changed after"):
        resume(copy, settings=["time.tau=[0.1,0.2,0.3,0.4]"])
    (copy / CASE).write_text("# a comment is no change\n" + case)
    assert resume(copy)


def test_a_run_of_the_future_is_refused(copy: Path) -> None:
    record = json.loads((copy / MANIFEST).read_text()) | {"format": 99}
    (copy / MANIFEST).write_text(json.dumps(record))
    with pytest.raises(InputError, match="has format 99, this staffa reads 1"):
        resume(copy)


def test_two_checkpoints_are_kept_and_what_they_name(tmp_path: Path) -> None:
    """A part that both name is there once; what neither names is gone; so are halves of files."""
    folder = tmp_path / "checkpoint"
    mesh = checkpoint.write_part(folder, {"points": np.zeros((4, 3))})
    for number in (1, 2, 5, 9):
        (folder / ".half.json.staffa-part").write_text("half")
        state = checkpoint.write_part(folder, {"u": np.full((4, 2), float(number))})
        checkpoint.write_page(folder, number, {"state": state}, [mesh, state])
    assert checkpoint.checkpoint_numbers(folder) == [9, 5]
    assert len(list(folder.iterdir())) == 2 + 3
    found = checkpoint.read_part(folder, checkpoint.read_page(folder, 5)["state"])
    assert np.array_equal(found["u"], np.full((4, 2), 5.0))
    checkpoint.remove_after(folder, 5)
    assert checkpoint.checkpoint_numbers(folder) == [5] and len(list(folder.iterdir())) == 1 + 2
    with pytest.raises(DamagedError, match="cannot be read"):
        checkpoint.read_part(folder, state)


def test_numbers_come_back_as_they_were(tmp_path: Path) -> None:
    """The page is text: floats keep their last bit in it."""
    numbers = {"time": 0.1 + 0.2, "tiny": 5e-324, "none": None, "list": [1 / 3, 2.0**-60]}
    checkpoint.write_page(tmp_path, 0, numbers, [])
    assert {k: checkpoint.read_page(tmp_path, 0)[k] for k in numbers} == numbers

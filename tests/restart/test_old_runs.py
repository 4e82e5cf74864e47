"""Runs of 0.1.0 are read, reported and resumed, whatever their records are called by now."""

import json
import shutil
from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import staffa
from staffa.cli.commands import app
from staffa.io.run_directory import Run, open_run
from support.pages import without_scripts

DATA = Path(__file__).parents[1] / "data" / "runs-0.1.0"
RUNS = ("slab", "granite", "block", "several/seed-3", "several/seed-4")
# Total energies of all steps, by 0.1.0 itself.
ENDS = json.loads((DATA / "ends.json").read_text(encoding="utf-8"))


def numbers(value: Any) -> Iterator[float]:
    """Yield every number within a value, whatever it is called."""
    if is_dataclass(value) and not isinstance(value, type):
        value = [getattr(value, field.name) for field in fields(value)]
    if isinstance(value, Mapping):
        value = list(value.values())
    if isinstance(value, np.ndarray):
        value = value.tolist()
    if isinstance(value, list | tuple):
        for part in value:
            yield from numbers(part)
    elif isinstance(value, int | float) and not isinstance(value, bool):
        yield float(value)


def lost(raw: Any, read: Any) -> Counter[float]:
    """Return the numbers of a record that are not found in what was read of it."""
    return Counter(numbers(raw)) - Counter(numbers(read))


def records(run: Run) -> dict[int, list[Any]]:
    """Return all steps that were read, by their index."""
    found: dict[int, list[Any]] = {}
    for step in (*run.steps, *run.superseded, *run.rejected):
        found.setdefault(step.index, []).append(step)
    return found


@pytest.mark.parametrize("name", RUNS)
def test_no_number_of_a_record_is_lost(name: str) -> None:
    """A record that is renamed without a translation would come back as its default."""
    run = open_run(DATA / name)
    raw = [json.loads(line) for line in (DATA / name / "steps.jsonl").read_text().splitlines()]
    read = records(run)
    assert sum(map(len, read.values())) == len(raw) >= 2
    for record in raw:
        total = record["energies"].pop("total")  # a sum, which is not read
        assert total in [step.energies.total for step in read[record["index"]]]
        missing = [lost(record, step) for step in read[record["index"]]]
        assert Counter() in missing, f"step {record['index']} lacks {missing}"


@pytest.mark.parametrize("name", RUNS)
def test_no_number_of_a_manifest_is_lost(name: str) -> None:
    raw = json.loads((DATA / name / "manifest.json").read_text(encoding="utf-8"))
    manifest = open_run(DATA / name).manifest
    assert manifest.version == raw["version"] == "0.1.0"
    assert lost(raw, manifest) == Counter()


def copied(name: str, tmp_path: Path) -> Path:
    return Path(shutil.copytree(DATA / name, tmp_path / name))


@pytest.mark.parametrize("name", ["slab", "granite", "block", "several"])
def test_it_is_shown(name: str) -> None:
    done = CliRunner().invoke(app, ["show", str(DATA / name)])
    assert done.exit_code == 0, done.output
    assert "cooled" in done.output and "nan" not in done.output
    if name != "several":
        last = open_run(DATA / name).steps[-1]
        assert f"{sum(step.sweeps for step in open_run(DATA / name).steps)}" in done.output
        assert last.audit.violations == () and "violations" in done.output


@pytest.mark.slow
@pytest.mark.parametrize("name", ["slab", "granite", "block", "several"])
def test_it_is_reported(name: str, tmp_path: Path) -> None:
    run = copied(name, tmp_path)
    done = CliRunner().invoke(app, ["report", str(run)])
    assert done.exit_code == 0, done.output
    page = without_scripts((run / "report.html").read_text(encoding="utf-8"))
    pictures = sorted(path.stem for path in (run / "pictures").iterdir())
    assert len(pictures) >= 2 and page.count("data:image/png;base64,") == len(pictures)
    assert "0.1.0" in page or name == "several"


@pytest.mark.slow
@pytest.mark.parametrize("name", ["slab", "granite"])
def test_it_is_resumed_to_the_end_that_its_own_version_found(name: str, tmp_path: Path) -> None:
    before = open_run(DATA / name)
    assert not before.finished
    steps = staffa.resume(copied(name, tmp_path))
    assert open_run(tmp_path / name).finished
    found = [step.energies.total for step in steps]
    kept = len(before.steps)
    assert found[:kept] == [step.energies.total for step in before.steps]
    # To the tolerance of the minimization: another machine rounds otherwise.
    assert found == pytest.approx(ENDS[name], rel=1e-6)


@pytest.mark.slow
def test_a_finished_run_goes_on_for_longer(tmp_path: Path) -> None:
    run = copied("block", tmp_path)
    steps = staffa.resume(run, settings=["time.tau=[0.1,0.2,0.4,0.5]", "output.at=[]"])
    assert [step.index for step in steps] == [0, 1, 2, 3]
    assert [step.energies for step in steps[:3]] == [
        s.energies for s in open_run(DATA / "block").steps
    ]

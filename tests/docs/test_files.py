"""Page on files: it tells of every file that is written and of every member of its records."""

import json
import re
import shutil
from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any, get_args, get_type_hints

import h5py
import pytest

from staffa.evolution.output_fields import DEFAULT
from staffa.io.run_directory import STEPS, open_run
from staffa.records.manifest import Manifest
from staffa.records.step import Step
from staffa.report.drawing import draw
from staffa.results.summary import summary
from staffa.runs.run import Watcher, run
from support.commands import forked
from support.paths import DOCS
from support.restarting import SMALL, small

PAGES = DOCS / "reference"
PAGE = (PAGES / "files.md").read_text()
SHORT = [
    *("--set", "time.tau=[0.3,0.6]", "--set", "measures.depths=[0.1]"),
    *("--set", 'output.probes=[{name="a",point=[0.5,0.2]}]'),
]


def named(heading: str) -> set[str]:
    """Names in the first column of the tables below a heading."""
    section = PAGE.split(f"\n## {heading}\n")[1].split("\n## ")[0]
    cells = re.findall(r"^\|([^|]*)\|", section, re.MULTILINE)
    return {name for cell in cells for name in re.findall(r"`([^`]+)`", cell)}


def members(record: type, path: str = "") -> Iterator[str]:
    """The members of a record as it is written, those of the records in it with a dot."""
    hints = get_type_hints(record)
    for field in fields(record):
        name = f"{path}{field.name}"
        yield name
        for inner in inside(hints[field.name]):
            yield from members(inner, f"{name}.")


def inside(hint: Any) -> Iterator[type]:
    if is_dataclass(hint):
        yield hint
    for argument in get_args(hint):
        yield from inside(argument)


def test_every_member_of_the_records_is_told_and_no_other() -> None:
    # The shadow has the members of the circulation, which are told once.
    told = {name for name in members(Step) if not name.startswith("heat.shadow.")}
    assert named("`steps.jsonl`") == {*told, "energies.total"}
    assert named("`manifest.json`") == set(members(Manifest))


def pattern(file: Path) -> str:
    """The name of a file as the page has it."""
    name = re.sub(r"[0-9a-f]{64}", "SHA256", file.as_posix())
    name = re.sub(r"\d{6}\.json", "NNNNNN.json", name)
    name = re.sub(r"-\d{4}\.", "-NNNN.", name)
    return re.sub(r"^pictures/[\w-]+\.png", "pictures/*.png", name)


def written(folder: Path) -> set[str]:
    return {pattern(file.relative_to(folder)) for file in folder.rglob("*") if file.is_file()}


@pytest.fixture(scope="module")
def place(tmp_path_factory) -> Path:
    """A folder with an ensemble, a comparison of its members, and the first of them elsewhere,
    with all that a report leaves; the original is gone."""
    folder = tmp_path_factory.mktemp("files")
    (folder / "my.toml").write_text(SMALL)
    many = folder / "all"
    ran("ensemble", folder / "my.toml", "--seeds", "2", "--out", many, *SHORT)
    ran("compare", many / "seed-3", many / "seed-4", "--out", folder / "pair")
    (folder / "shown.txt").write_text(repr(summary(open_run(many / "seed-3"))))
    (folder / "elsewhere").mkdir()
    shutil.move(many / "seed-3", folder / "elsewhere")
    ran("report", folder / "elsewhere" / "seed-3", "--no-movie")
    return folder


def ran(*command: str | Path) -> str:
    done = forked(*command)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    return done.stdout


@pytest.mark.slow
def test_every_file_is_told(place: Path) -> None:
    of_a_run = written(place / "elsewhere" / "seed-3")
    assert of_a_run <= named("A run")
    # Of 3-D, of a damaged run, and of cracks whose damage has a ridge.
    others = {"cells.csv", "pictures/growing.gif", "steps.jsonl.1", "release.csv"}
    others |= {"quantities.csv"}  # of a script
    others |= {  # of a 3-D body
        "network/polygons-NNNN.csv",
        "network/polygons-NNNN.vtp",
        "network/polygon-corners-NNNN.csv",
    }
    others |= {  # of a reservoir
        "production.csv",
        "fields/reservoir-NNNN.vtkhdf",
        "fields/reservoir.vtkhdf.series",
    }
    assert named("A run") - of_a_run <= others
    of_all = {name for name in written(place / "all") if not name.startswith("seed-")}
    assert of_all <= named("An ensemble") and "ensemble.csv" in of_all
    assert written(place / "all" / "seed-4") <= of_a_run
    assert written(place / "pair") == named("A comparison")


@pytest.mark.slow
def test_what_is_in_the_files_is_told(place: Path) -> None:
    directory = place / "elsewhere" / "seed-3"
    for page in (directory / "checkpoint").glob("*.json"):
        content = json.loads(page.read_text())
        assert content.keys() == {"format", "version", "sha256", "checkpoint"}
        assert content["checkpoint"].keys() == named("Checkpoints")
    for part in (directory / "checkpoint").glob("*.h5"):
        with h5py.File(part) as file:
            assert all(f"`{name}`" in PAGE for name in file), list(file)
    for part in (directory / "fields").glob("*.vtkhdf"):
        with h5py.File(part) as file:
            held = {*file["VTKHDF/PointData"], *file["VTKHDF/CellData"]}
        assert held == set(DEFAULT) <= named("Fields")
    results = (PAGES / "results.md").read_text()
    for table in (*directory.glob("*.csv"), *directory.glob("network/*.csv")):
        for column in table.read_text().splitlines()[0].split(","):
            assert re.search(rf"\b{column}\b", results), f"{table.name}: {column}"
    told = {name for name in named("`steps.jsonl`") if "." not in name}
    for line in (directory / STEPS).read_text().splitlines():
        assert json.loads(line).keys() == told


@pytest.mark.slow
def test_a_run_elsewhere_is_shown_and_reported_as_the_original_was(place: Path) -> None:
    directory = place / "elsewhere" / "seed-3"
    assert repr(summary(open_run(directory))) == (place / "shown.txt").read_text()
    texts = [file.read_text() for file in directory.glob("*.*") if file.suffix != ".log"]
    assert len(texts) >= 6 and not any(str(place / "all") in text for text in texts)


@pytest.mark.slow
def test_a_run_is_shown_and_reported_while_it_goes_on(tmp_path: Path) -> None:
    """After its second step, which changes none of its files."""
    said = []

    def look(step: Step) -> None:
        if step.index == 1:
            before = own_files(tmp_path / "run")
            found = open_run(tmp_path / "run")
            said.extend(fact.text for fact in summary(found))
            draw(found)
            assert own_files(tmp_path / "run") == before

    run(small("output.steps=all"), tmp_path / "run", watcher=Watcher(stepped=look))
    assert "2 of 6 steps; still going on, or stopped" in said, said
    assert (tmp_path / "run" / "report.html").exists() and open_run(tmp_path / "run").finished


def own_files(directory: Path) -> dict[str, bytes]:
    """The files that the run itself has written so far."""
    made = ("report.html", "pictures", "network", ".csv")
    files = [file for file in directory.rglob("*") if file.is_file()]
    return {str(f): f.read_bytes() for f in files if not any(name in str(f) for name in made)}

"""A run directory is a research object: RO-Crate 1.1, read back by the rocrate library."""

import hashlib
import json
import os
import shutil
import signal
import time
from pathlib import Path
from zipfile import ZipFile

import pytest
from rocrate.model.file import File
from rocrate.rocrate import ROCrate

from staffa.backend.lock import Lock
from staffa.case.reading.read import parse_case
from staffa.errors import InputError
from staffa.io import crate_archive, research_object
from staffa.io.crate_archive import export_zip
from staffa.io.ensemble_directory import CRATE
from staffa.io.research_object import crate_files, describe_stopped, write_crate
from staffa.io.study_directory import Point, StudyPlan, write_plan
from staffa.records.authorship import people_of
from staffa.runs.resume import resume
from staffa.runs.run import Watcher, run
from support.commands import forked
from support.paths import DATA
from support.restarting import SMALL, After, small, started, stopped

OLD = DATA / "runs-0.1.0"
SHORT = "time.tau=[0.3,0.6]"
ADA = "Ada Lovelace <https://orcid.org/0000-0002-1825-0097>"
ABOUT = f'authors = ["{ADA}", "Charles Babbage"]\nlicense = "CC-BY-4.0"\n'


@pytest.fixture
def granite(tmp_path: Path) -> Path:
    """A run of an earlier version, without a description."""
    return Path(shutil.copytree(OLD / "granite", tmp_path / "a run"))


def require_valid(path: Path) -> ROCrate:
    """Read a description with the rocrate library, and require what RO-Crate 1.1 does.

    Every file of the directory is listed, exists, and has the size and the SHA-256 told.
    """
    crate = ROCrate(path)
    descriptor, root = crate.metadata, crate.root_dataset
    assert descriptor.id == CRATE and descriptor.type == "CreativeWork"
    assert descriptor["about"] is root
    assert descriptor["conformsTo"] == "https://w3id.org/ro/crate/1.1"
    assert root.type == "Dataset" and root.id == "./"
    for key in ("name", "description", "datePublished", "license"):
        assert root[key], f"{key} is missing"
    listed = [entity for entity in crate.data_entities if isinstance(entity, File)]
    assert {entity.id for entity in root["hasPart"]} == {entity.id for entity in listed}
    assert {path / entity.source for entity in listed} == set(crate_files(path))
    for entity in listed:
        content = (path / entity.source).read_bytes()
        assert int(entity["contentSize"]) == len(content), entity.id
        assert entity["sha256"] == hashlib.sha256(content).hexdigest(), entity.id
    for action in root["mentions"]:
        assert action.type == "CreateAction"
        assert action["instrument"]["name"] == "staffa" and action["instrument"]["version"]
        assert action["startTime"] <= action["endTime"]
        parts = [*action["object"], *action["result"]]
        assert all(isinstance(entity, File) for entity in parts)
    used = {entity.id for action in root["mentions"] for entity in action["object"]}
    assert used and all(name.endswith("case.toml") for name in used)
    return crate


def test_a_run_of_an_earlier_version_is_described_when_asked(granite: Path) -> None:
    done = forked("export", granite)
    assert done.stdout.strip() == str(granite / CRATE), done.stderr
    crate = require_valid(granite)
    versions = {entity["name"]: entity["version"] for entity in crate.contextual_entities
                if entity.type == "SoftwareApplication"}  # fmt: skip
    assert versions["staffa"] == "0.1.0" and versions["petsc"] == "3.25.5"
    assert "C compiler flags" not in versions
    assert "ask the authors" in crate.license


def test_authors_and_license_of_the_case_are_those_of_the_object(granite: Path) -> None:
    case = granite / "case.toml"
    case.write_text(ABOUT + case.read_text())
    write_crate(granite)
    crate = require_valid(granite)
    assert crate.root_dataset["license"].id == "https://spdx.org/licenses/CC-BY-4.0"
    ada, charles = crate.root_dataset["author"]
    assert (ada.id, ada["name"]) == ("https://orcid.org/0000-0002-1825-0097", "Ada Lovelace")
    assert (charles.type, charles["name"]) == ("Person", "Charles Babbage")


@pytest.mark.parametrize(
    ("key", "value"),
    [("authors", '["Ada <Lovelace>"]'), ("authors", '["<ada@example.org>"]'),
     ("license", '"all rights"')],
)  # fmt: skip
def test_what_is_no_author_or_license_is_refused(key: str, value: str) -> None:
    with pytest.raises(InputError, match=rf"^{key}.*it must be.*like"):
        parse_case(f"{key} = {value}\n{SMALL}")


def test_an_author_is_told_once_and_no_name_of_a_person_is_one_of_ours() -> None:
    people = people_of(["staffa", "run", "staffa ", ADA, f"A. Lovelace <{ADA.split('<')[1]}"])
    assert [person["name"] for person in people] == ["staffa", "run", "Ada Lovelace"]
    ids = [person["@id"] for person in people]
    assert ids == ["#person-1", "#person-2", "https://orcid.org/0000-0002-1825-0097"]


def test_a_copy_of_a_run_ended_when_the_run_ended(granite: Path, tmp_path: Path) -> None:
    write_crate(granite)
    before = json.loads((granite / CRATE).read_text())
    copy = tmp_path / "copy" / "a run"
    shutil.copytree(granite, copy, copy_function=shutil.copyfile)  # with new times
    write_crate(copy)
    assert json.loads((copy / CRATE).read_text()) == before


def test_an_archive_holds_the_object_and_is_the_same_each_time(
    granite: Path, tmp_path: Path
) -> None:
    before = sorted(file.relative_to(granite) for file in granite.rglob("*"))
    done = forked("export", granite, "--zip")
    archive = tmp_path / "a run.zip"
    assert done.stdout.strip() == str(archive), done.stderr
    assert sorted(file.relative_to(granite) for file in granite.rglob("*")) == before
    with ZipFile(archive) as packed:
        packed.extractall(tmp_path / "unpacked" / "a run")
    require_valid(tmp_path / "unpacked" / "a run")
    assert not (tmp_path / "unpacked" / "a run" / "checkpoint").exists()
    shown = forked("show", tmp_path / "unpacked" / "a run")
    assert (shown.returncode, shown.stdout) == (0, forked("show", granite).stdout)
    again = tmp_path / "again.zip"
    forked("export", granite, "--zip", "--out", again)
    assert again.read_bytes() == archive.read_bytes()


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nothing", "--zip"], "nothing is no run directory"),
        (["a run", "--zip", "--out", "a run/x.zip"], "lies inside the run; name a place outside"),
        (["a run", "--zip", "--out", "there.zip"], "there.zip exists; remove it"),
        (["a run", "--zip", "--out", "no/x.zip"], "no folder that you may write to"),
        (["a run", "--out", "x.zip"], "add --zip, or leave it out"),
    ],
)
def test_what_cannot_be_packed_is_refused(
    arguments: list[str], said: str, granite: Path, tmp_path: Path
) -> None:
    (tmp_path / "there.zip").write_text("of a user")
    before = sorted(tmp_path.rglob("*"))
    done = forked("export", *arguments, folder=tmp_path)
    assert done.returncode == 2 and said in done.stderr and done.stderr.count("\n") == 1
    assert sorted(tmp_path.rglob("*")) == before


def test_a_run_that_goes_on_is_neither_packed_nor_described(granite: Path) -> None:
    """It would be described by files that change."""
    lock = Lock(granite)
    lock.take()
    done = forked("export", granite, "--zip")
    assert done.returncode == 2 and "is being written to" in done.stderr
    assert write_crate(granite) is None and not (granite / CRATE).exists()
    lock.release()
    assert write_crate(granite) == granite / CRATE


def test_a_file_whose_name_is_not_utf8_is_left_out_with_a_sentence(granite: Path) -> None:
    Path(os.fsdecode(os.fsencode(granite) + b"/photo-\xff.png")).write_bytes(b"of a user")
    done = forked("export", granite, "--zip")
    assert done.returncode == 0 and "is left out: rename it" in done.stderr, done.stderr
    assert done.stderr.count("\n") == 1
    write_crate(granite)
    require_valid(granite)


def test_a_stopped_run_with_large_files_is_described_on_request(
    granite: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    describe_stopped(granite)
    require_valid(granite)
    monkeypatch.setattr(research_object, "STOPPED_BYTES", 10)
    describe_stopped(granite)
    assert not (granite / CRATE).exists(), "a description of earlier files"


def test_a_run_in_a_read_only_folder_is_packed_although_it_was_cut(
    granite: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its lock tells who held it, but cannot be opened for writing."""
    (granite / "lock").write_text("process 1 on elsewhere")
    opened = os.open

    def refuse(path: Path, flags: int, *more: int) -> int:
        if flags & (os.O_RDWR | os.O_WRONLY) and granite in Path(path).parents:
            raise PermissionError(13, "Permission denied")
        return opened(path, flags, *more)

    monkeypatch.setattr(os, "open", refuse)
    assert export_zip(granite) == tmp_path / "a run.zip"


def test_an_archive_follows_no_link_and_leaves_no_part(
    granite: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    secret, part = tmp_path / "secret", tmp_path / ".a run.zip.staffa-part"
    secret.write_text("of another")
    part.symlink_to(secret)
    export_zip(granite)
    assert secret.read_text() == "of another" and not part.is_symlink()

    def interrupt(*given: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(crate_archive, "crate_text", interrupt)
    with pytest.raises(KeyboardInterrupt):
        export_zip(granite, tmp_path / "again.zip")
    assert not list(tmp_path.glob("*again*")) and not list(tmp_path.glob(".*"))


def test_no_link_is_followed(granite: Path, tmp_path: Path) -> None:
    (tmp_path / "secret").write_text("of another")
    (granite / "link").symlink_to(tmp_path / "secret")
    write_crate(granite)
    require_valid(granite)
    assert "link" not in (granite / CRATE).read_text()


def test_an_ensemble_is_one_object_with_a_run_for_each_seed(tmp_path: Path) -> None:
    several = Path(shutil.copytree(OLD / "several", tmp_path / "several"))
    forked("export", several, "--zip")
    with ZipFile(tmp_path / "several.zip") as packed:
        packed.extractall(tmp_path / "unpacked")
    crate = require_valid(tmp_path / "unpacked")
    assert [action.id for action in crate.root_dataset["mentions"]] == [
        "#run-seed-3",
        "#run-seed-4",
    ]
    assert crate.dereference("ensemble.csv") is not None


def test_a_change_of_a_member_removes_the_description_of_its_ensemble(tmp_path: Path) -> None:
    several = Path(shutil.copytree(OLD / "several", tmp_path / "several"))
    write_crate(several)
    (several / "seed-3" / "case.toml").open("a").write("# changed")
    write_crate(several / "seed-3")
    assert not (several / CRATE).exists() and (several / "seed-3" / CRATE).exists()
    write_crate(several)
    require_valid(several)


@pytest.mark.parametrize(
    ("command", "said"),
    [(["export", "."], "like point-1, or of its runs"), (["compare", ".", "."], "point-1/seed-3")],
)
def test_a_study_is_refused_with_the_name_of_a_part(
    command: list[str], said: str, tmp_path: Path
) -> None:
    shutil.copytree(OLD / "several", tmp_path / "point-1")
    point = Point(number=1, texts=(), values=())
    write_plan(tmp_path, StudyPlan(version="0", title="", parameters=(), points=(point,)))
    done = forked(*command, folder=tmp_path)
    assert done.returncode == 2 and ". is a study; name one of its" in done.stderr, done.stderr
    assert said in done.stderr


@pytest.mark.slow
def test_a_run_is_described_at_its_stop_at_its_end_and_by_a_report(tmp_path: Path) -> None:
    place = tmp_path / "run"
    stopped(lambda: run(small(SHORT), place, watcher=Watcher(stop=After(4))))
    halfway = require_valid(place)
    (action,) = halfway.root_dataset["mentions"]
    assert "FailedActionStatus" in str(action["actionStatus"])
    seen: list[bool] = []
    resume(place, watcher=Watcher(stepped=lambda step: seen.append((place / CRATE).exists())))
    assert seen and not any(seen), "an old description beside files that change"
    (action,) = require_valid(place).root_dataset["mentions"]
    assert "CompletedActionStatus" in str(action["actionStatus"])
    done = forked("report", place)
    assert done.returncode == 0, done.stderr
    assert require_valid(place).dereference("report.html") is not None


@pytest.mark.slow
def test_a_run_that_a_signal_stops_is_described_with_its_page(tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(SMALL)
    place = tmp_path / "run"
    long = "time.tau={start=0.1, stop=0.6, steps=500}"
    process = started("staffa", "run", tmp_path / "my.toml", "--out", place, "--set", long)
    last = time.monotonic() + 120
    while not (place / "report.html").exists():
        assert process.poll() is None and time.monotonic() < last
        time.sleep(0.1)
    process.send_signal(signal.SIGTERM)
    _, said = process.communicate(timeout=120)
    assert process.returncode == 3, said
    assert require_valid(place).dereference("report.html") is not None
    assert 'id="grows"' not in (place / "report.html").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("quiet", [[], ["--quiet"]])
def test_what_a_command_leaves_is_described(quiet: list[str], tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(ABOUT + SMALL)
    done = forked("run", tmp_path / "my.toml", "--out", tmp_path / "run", "--set", SHORT, *quiet)
    assert done.returncode == 0, done.stderr
    crate = require_valid(tmp_path / "run")
    assert (crate.dereference("report.html") is None) == bool(quiet)
    assert crate.dereference("network.csv") is not None
    ada, _ = crate.root_dataset["author"]
    assert ada["name"] == "Ada Lovelace"

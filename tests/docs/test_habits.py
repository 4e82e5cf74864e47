"""Versions, hooks, workflows and the changelog agree with one another and with the project."""

import json
import re
import tomllib
from collections.abc import Iterator
from itertools import chain, product
from pathlib import Path
from typing import Any

import pytest
import yaml
from packaging.specifiers import SpecifierSet
from packaging.version import Version
from pre_commit.clientlib import load_config

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
CODEMETA = json.loads((ROOT / "codemeta.json").read_text(encoding="utf-8"))
CITATION = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
WORKFLOWS = sorted((ROOT / ".github" / "workflows").glob("*.yml"))


def releases() -> list[tuple[str, str]]:
    """Return version and date of each section of the changelog, newest first."""
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    return re.findall(r"^## \[(\d\S*)\] - (\d{4}-\d\d-\d\d)$", text, re.MULTILINE)


def test_the_last_release_is_the_one_that_is_cited() -> None:
    last, date = releases()[0]
    assert last == CODEMETA["version"] == CITATION["version"]
    assert date == CODEMETA["dateModified"]


def test_the_version_is_the_last_release_or_a_development_of_the_next() -> None:
    version, last = Version(PROJECT["version"]), Version(releases()[0][0])
    assert version == last or (version.is_devrelease and version > last)


def test_sections_of_the_changelog_have_falling_versions_and_dates() -> None:
    text = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert text.index("## [Unreleased]") < text.index(f"## [{releases()[0][0]}]")
    versions = [Version(version) for version, _ in releases()]
    dates = [date for _, date in releases()]
    assert versions == sorted(versions, reverse=True) and dates == sorted(dates, reverse=True)


def test_codemeta_says_what_the_project_and_its_citation_say() -> None:
    assert CODEMETA["name"] == PROJECT["name"]
    assert CODEMETA["description"] == PROJECT["description"]
    assert CODEMETA["keywords"] == PROJECT["keywords"]
    assert CODEMETA["license"].removeprefix("https://spdx.org/licenses/") == PROJECT["license"]
    assert CITATION["license"] == PROJECT["license"]
    assert CODEMETA["programmingLanguage"]["version"] == PROJECT["requires-python"]
    names = [author["name"] for author in CODEMETA["author"]]
    assert names == [author["name"] for author in PROJECT["authors"]]
    assert names == [author["name"] for author in CITATION["authors"]]
    papers = {
        paper["title"]: [(a["given-names"], a["family-names"]) for a in paper["authors"]]
        for paper in CITATION["references"]
    }
    for paper in CODEMETA["referencePublication"]:
        people = [(author["givenName"], author["familyName"]) for author in paper["author"]]
        assert papers[paper["name"]] == people


def test_the_environment_of_conda_has_the_dependencies_of_the_project() -> None:
    """Nothing else is known of it: it has not been made."""
    environment = yaml.safe_load((ROOT / "environment.yml").read_text(encoding="utf-8"))
    listed = {line for line in environment["dependencies"] if isinstance(line, str)}
    other_names = {"matplotlib": "matplotlib-base"}
    for line in PROJECT["dependencies"]:
        name, bound = line.split(">=")
        assert f"{other_names.get(name, name)}>={bound}" in listed


def targets() -> set[str]:
    """Return the targets of the Makefile."""
    text = (ROOT / "Makefile").read_text(encoding="utf-8")
    return set(re.findall(r"^([a-z][\w-]*):(?!=)", text, re.MULTILINE))


def commands(job: dict[str, Any]) -> Iterator[str]:
    """Yield what a job runs, for each choice of its matrix."""
    matrix = job.get("strategy", {}).get("matrix", {})
    for choice in product(*matrix.values()):
        for step in job["steps"]:
            if "run" in step:
                command = step["run"]
                for name, value in zip(matrix, choice, strict=True):
                    command = command.replace(f"${{{{ matrix.{name} }}}}", value)
                yield command


@pytest.mark.parametrize("path", WORKFLOWS, ids=lambda path: path.stem)
def test_a_workflow_runs_targets_that_exist(path: Path) -> None:
    workflow = yaml.safe_load(path.read_text(encoding="utf-8"))
    assert {"name", "permissions", "jobs"} <= set(workflow)
    assert True in workflow, "`on`, which YAML reads as true"
    for job in workflow["jobs"].values():
        assert job["timeout-minutes"] <= 360, "the most that a hosted runner gives"
        made = [command.split() for command in commands(job) if command.startswith("make ")]
        assert made, "each job runs make"
        for command in made:
            assert set(command[1:]) <= targets(), " ".join(command)


def test_the_workflows_cover_every_python_that_is_supported() -> None:
    (path,) = (path for path in WORKFLOWS if path.stem == "checks")
    job = yaml.safe_load(path.read_text(encoding="utf-8"))["jobs"]["checks"]
    pythons = job["strategy"]["matrix"]["python"]
    assert all(python in SpecifierSet(PROJECT["requires-python"]) for python in pythons)
    setup = (ROOT / "tools" / "setup.sh").read_text(encoding="utf-8")
    lowest, beyond = re.findall(r"\((3), (\d+)\)", setup)
    expected = [f"3.{minor}" for minor in range(int(lowest[1]), int(beyond[1]))]
    assert pythons == expected


def test_hooks_run_from_the_environment_of_the_project() -> None:
    (repository,) = load_config(str(ROOT / ".pre-commit-config.yaml"))["repos"]
    assert repository["repo"] == "local"
    hooks = {hook["id"]: hook["entry"] for hook in repository["hooks"]}
    assert set(hooks) == {"whitespace", "ruff-format", "ruff-check", "mypy"}
    for name in set(hooks) - {"whitespace"}:
        assert hooks[name].startswith(".venv/bin/python -m ")


def test_development_tools_have_pins() -> None:
    pinned = re.findall(r"^([\w.-]+)==", (ROOT / "constraints.txt").read_text(), re.MULTILINE)
    known = {re.sub(r"[-_.]+", "-", name).lower() for name in pinned}
    for requirement in chain(PROJECT["dependencies"], *PROJECT["optional-dependencies"].values()):
        name = re.match(r"[\w.-]+", requirement)
        assert name and re.sub(r"[-_.]+", "-", name.group(0)).lower() in known, requirement

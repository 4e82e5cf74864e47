"""The page's split, law and load in the registries pass the generic tests."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

TESTS = Path(__file__).parents[1]
PAGE = TESTS.parent / "docs" / "how-to" / "extending.md"
NAMES = ("sheared", "cubic", "flash")
# Does what the page says: a class and a line in a registry.
PLUGIN = """
import re
from pathlib import Path

from staffa.loads.closed_form import PROFILES
from staffa.physics.damage import LAWS
from staffa.physics.split import SPLITS

known = {{}}
page = Path({page!r}).read_text(encoding="utf-8")
for name in ("Sheared", "Cubic", "Flash"):
    exec(re.search(rf"^class {{name}}:.*?(?=^\\S)", page, re.MULTILINE | re.DOTALL).group(0), known)
{lines}
"""


def _lines_of_registries() -> str:
    """Return the lines that the page gives for the registries, as assignments."""
    found = re.findall(r"`(\w+)`[^`]*`(\"\w+\": [^`]+)`", PAGE.read_text(encoding="utf-8"))
    assert sorted(registry for registry, _ in found) == ["LAWS", "PROFILES", "SPLITS"]
    return "".join(f"{registry}.update(eval('{{{line}}}', known))\n" for registry, line in found)


def _files_with_generic_tests() -> list[str]:
    """Return the test files that name a registry, or explain what a case may hold."""
    registry = re.compile(r"\b(LAWS|PROFILES|SPLITS|explained=True)\b")
    files = sorted(TESTS.rglob("test_*.py"))
    return [str(path) for path in files if registry.search(path.read_text(encoding="utf-8"))]


@pytest.mark.slow
def test_a_class_and_a_line_in_a_registry_pass_the_generic_tests(tmp_path: Path) -> None:
    plugin = PLUGIN.format(page=str(PAGE), lines=_lines_of_registries())
    (tmp_path / "of_the_page.py").write_text(plugin, encoding="utf-8")
    command = [sys.executable, "-m", "pytest", "-p", "of_the_page", "-v", "-p", "no:cacheprovider"]
    selected = ["-k", " or ".join((*NAMES, "explained")), "-m", "not mpi and not long"]
    done = subprocess.run(
        [*command, *selected, *_files_with_generic_tests()],
        cwd=TESTS.parent,
        env={**os.environ, "PYTHONPATH": str(tmp_path)},
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stdout[-5000:]
    passed = [line for line in done.stdout.splitlines() if "PASSED" in line]
    ran = {name: sum(bool(re.search(rf"\[.*{name}", line)) for line in passed) for name in NAMES}
    assert min(ran.values()) >= 1, f"generic tests that ran: {ran}"


def test_the_case_file_offers_what_is_in_the_registries(tmp_path: Path) -> None:
    """Nothing else knows the names."""
    plugin = PLUGIN.format(page=str(PAGE), lines=_lines_of_registries())
    script = """
import staffa

settings = ["damage.law=cubic", "damage.split=sheared", "temperature.profile=flash"]
case = staffa.ready_case("slab", settings)
problem = staffa.problem(case)
print(problem.material.law.name, problem.material.split.name)
print(type(problem.load).__name__)
"""
    done = subprocess.run(
        [sys.executable, "-c", plugin + script], cwd=tmp_path, capture_output=True, text=True
    )
    assert done.stdout.split() == ["cubic", "sheared", "Flash"], done.stderr

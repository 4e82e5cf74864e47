"""The public names have types that tools see, and loading them stays light."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

import staffa

# Each public name with a part of its type, as mypy shows it.
TYPES = {
    "Case": "def (*, ",
    "Pictures": "def (*, ",
    "StepQuantity": "def (*, ",
    "build": "System",
    "crack_effect": "CrackEffect",
    "march": "Iterator[",
    "parse_case": "Case",
    "pictures_of": "Pictures",
    "problem": "Problem",
    "read_case": "Case",
    "open_run": "Run",
    "ready_case": "Case",
    "resume": "Step",
    "run": "Step",
}


def _names_for_tools() -> dict[str, str]:
    """Return the names that type checkers find in the package, and the module of each."""
    tree = ast.parse(Path(staffa.__file__).read_text(encoding="utf-8"))
    (choice,) = (node for node in tree.body if isinstance(node, ast.If))
    found = [node for node in choice.body if isinstance(node, ast.ImportFrom)]
    return {alias.asname or alias.name: str(node.module) for node in found for alias in node.names}


def test_tools_and_python_find_the_same_names() -> None:
    assert _names_for_tools() == staffa._WHERE
    assert staffa.__all__ == sorted(TYPES)
    assert set(staffa.__all__) <= set(dir(staffa))


def test_the_package_says_that_it_has_types() -> None:
    assert (Path(staffa.__file__).parent / "py.typed").is_file()


def test_a_name_that_is_not_there_is_refused_with_those_that_are() -> None:
    with pytest.raises(
        AttributeError, match="staffa has no 'crack'; it has Case, Pictures, StepQuantity, build, "
    ):
        staffa.crack  # noqa: B018


@pytest.mark.slow
def test_no_public_name_is_any(tmp_path: Path) -> None:
    script = tmp_path / "uses.py"
    lines = [f"reveal_type(staffa.{name})" for name in TYPES]
    script.write_text("\n".join(["import staffa", *lines, "staffa.run(1)", "staffa.crack"]))
    root = Path(__file__).parents[2]
    command = [sys.executable, "-m", "mypy", "--config-file", str(root / "pyproject.toml")]
    done = subprocess.run([*command, str(script)], cwd=root, capture_output=True, text=True)
    for number, (name, part) in enumerate(TYPES.items(), start=2):
        (said,) = (line for line in done.stdout.splitlines() if f"uses.py:{number}: " in line)
        assert part in said and 'is "Any"' not in said, f"{name}: {said}"
    assert done.returncode == 1
    assert "[call-arg]" in done.stdout or "[arg-type]" in done.stdout, done.stdout
    assert "[attr-defined]" in done.stdout, done.stdout

"""The archives of a release: a wheel that installs and runs, sources that test themselves.

Needs the package index that pip knows; takes minutes where pip has nothing in its cache.
"""

import os
import subprocess
import sys
import tarfile
from pathlib import Path

import pytest

from support.paths import ROOT

# The smallest case that cracks: two steps of a slab on coarse cells.
SMALL = [
    *("--set", "domain.size=[1.0,0.5]", "--set", "domain.h=0.05", "--set", "damage.ell=0.15"),
    *("--set", "time.tau=[0.1,0.3]", "--set", "output.at=[]", "--set", "measures.depths=[]"),
]
FOR_TESTS = ["pytest", "pytest-timeout", "hypothesis", "pandas"]
OF_THE_REPOSITORY = ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV", "COVERAGE_PROCESS_START")


def ran(*command: str | Path, folder: Path) -> str:
    """Run a command in a folder, with no variable that leads to the repository; give its output."""
    environment = {k: v for k, v in os.environ.items() if k not in OF_THE_REPOSITORY}
    done = subprocess.run(
        [*map(str, command)], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, f"{command}\n{done.stdout[-3000:]}\n{done.stderr[-3000:]}"
    return done.stdout


@pytest.mark.slow
@pytest.mark.timeout(1500)  # seconds: pip may have to fetch 500 MB
def test_the_archives_serve_people_without_the_repository(tmp_path: Path) -> None:
    """Build both, install the wheel in a fresh environment, run a case there to its picture."""
    ran(
        sys.executable, "-m", "build", "--no-isolation", "--outdir", tmp_path, ROOT, folder=tmp_path
    )
    (wheel,), (sources,) = tmp_path.glob("*.whl"), tmp_path.glob("*.tar.gz")
    ran(sys.executable, "-m", "venv", tmp_path / "plain", folder=tmp_path)
    python, constraints = tmp_path / "plain" / "bin" / "python", ROOT / "constraints.txt"
    pip = [python, "-m", "pip", "--disable-pip-version-check", "install", "-q", "-c", constraints]
    ran(*pip, f"{wheel}[wheel,mesh]", folder=tmp_path)

    empty = tmp_path / "empty"
    empty.mkdir()
    place = ran(python, "-c", "import staffa, gmsh; print(staffa.__file__)", folder=empty)
    assert place.startswith(str(tmp_path / "plain")), place
    staffa = python.with_name("staffa")
    (empty / "my.toml").write_text(ran(staffa, "new", "slab", folder=empty), encoding="utf-8")
    ran(staffa, "run", "my.toml", *SMALL, folder=empty)
    picture = empty / "runs" / "my" / "pictures" / "cracks.png"
    assert picture.read_bytes().startswith(b"\x89PNG"), "no picture"
    assert "finished" in ran(staffa, "show", "runs/my", folder=empty)

    with tarfile.open(sources) as archive:
        archive.extractall(tmp_path / "sources", filter="data")
    (unpacked,) = (tmp_path / "sources").iterdir()
    ran(*pip, *FOR_TESTS, folder=tmp_path)
    said = ran(python, "-m", "pytest", "-q", "-p", "no:cacheprovider", "tests/unit",
               "-m", "not slow", folder=unpacked)  # fmt: skip
    assert " passed" in said and "failed" not in said and "skipped" not in said, said[-500:]

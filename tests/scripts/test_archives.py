"""The archives of a release: a wheel that installs and runs, sources that test themselves.

One test also installs all libraries afresh, and alone sees one that pyproject.toml lacks. It needs
the package index that pip knows, and takes minutes: `make verify` runs it.
"""

import os
import subprocess
import sys
import sysconfig
import tarfile
from pathlib import Path

import pytest

from support.paths import ROOT

# The smallest case that cracks: two steps of a slab on coarse cells.
SMALL = [
    *("--set", "domain.size=[1.0,0.5]", "--set", "domain.h=0.05", "--set", "damage.ell=0.15"),
    *("--set", "time.tau=[0.1,0.3]", "--set", "output.at=[]", "--set", "measures.depths=[]"),
]
# Tests of the sources. The repository's own run has the others, of the same files.
TRIED = {"those of the tests": ["tests/unit/test_units.py"], "from the index": ["tests/unit"]}
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


def installed(folder: Path, wheel: Path, extras: str, constraints: Path) -> Path:
    """The Python of a fresh environment with the wheel and all that it needs, from the index."""
    ran(sys.executable, "-m", "venv", folder, folder=folder.parent)
    python = folder / "bin" / "python"
    pip = [python, "-m", "pip", "--disable-pip-version-check", "install", "-q", "-c", constraints]
    ran(*pip, f"{wheel}[{extras}]", *FOR_TESTS, folder=folder.parent)
    return python


def beside(folder: Path, wheel: Path) -> Path:
    """The Python of a fresh environment with the wheel alone, which sees what these tests have."""
    ran(sys.executable, "-m", "venv", "--without-pip", folder, folder=folder.parent)
    (packages,) = folder.glob("lib/python3.*/site-packages")
    # Without the lines of its .pth files, one of which leads to the repository.
    (packages / "libraries.pth").write_text(sysconfig.get_path("purelib") + "\n", encoding="utf-8")
    for library in Path(sys.prefix, "lib").glob("[!p]*"):  # MPI's, beside the folder python3.*
        (folder / "lib" / library.name).symlink_to(library)
    python = folder / "bin" / "python"
    ran(
        *(sys.executable, "-m", "pip", "--disable-pip-version-check", "--python", python),
        *("install", "-q", "--force-reinstall", "--no-deps", "--no-index", wheel),
        folder=folder.parent,
    )
    return python


@pytest.mark.slow
@pytest.mark.timeout(1500)  # seconds: pip may have to fetch 500 MB
@pytest.mark.parametrize(
    "libraries",
    ["those of the tests", pytest.param("from the index", marks=pytest.mark.long)],
)
def test_the_archives_serve_people_without_the_repository(tmp_path: Path, libraries: str) -> None:
    """Build both, install the wheel in a fresh environment, run a case there to its picture."""
    ran(
        sys.executable, "-m", "build", "--no-isolation", "--outdir", tmp_path, ROOT, folder=tmp_path
    )
    (wheel,), (sources,) = tmp_path.glob("*.whl"), tmp_path.glob("*.tar.gz")
    if libraries == "from the index":
        python = installed(tmp_path / "plain", wheel, "wheel,mesh", ROOT / "constraints.txt")
    else:
        python = beside(tmp_path / "plain", wheel)

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
    said = ran(python, "-m", "pytest", "-q", "-p", "no:cacheprovider", *TRIED[libraries],
               "-m", "not slow", folder=unpacked)  # fmt: skip
    assert " passed" in said and "failed" not in said and "skipped" not in said, said[-500:]

"""Attacks: a stranger's folder, case, run directory; a person's files; a terminal that goes away.

Each left a canary before what it attacks was fixed; docs/reference/security.md says who may
give what.
"""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np
import pytest
from matplotlib.figure import Figure

from staffa.backend.guarded_reading import read_apart
from staffa.backend.isolation import elsewhere, isolated_python
from staffa.backend.lock import Lock
from staffa.case.reading.read import read_case
from staffa.cli import commands
from staffa.errors import InputError, StaffaError, StaffaWarning
from staffa.io import own_files
from staffa.io.run_directory import open_run, require_free
from staffa.io.vtkhdf import read_vtkhdf
from staffa.plot.labels import TAU
from staffa.plot.style import write_picture
from staffa.properties.mesh_field import read_field
from staffa.report.embedding import policy
from staffa.results.tables import Table, columns_of
from staffa.runs import provenance
from staffa.runs.ensemble import started_members
from support import meshes
from support.bodies import needs_gmsh
from support.chromium import chromium, needs_chromium
from support.commands import forked
from support.pages import without_scripts
from support.paths import BIN

STAFFA = BIN / "staffa"
BAR = ["--set", "domain.h=0.05", "--set", "time.t=[0.1,0.2]", "--set", "output.at=[]"]


def staffa(
    *words: str | Path,
    folder: Path,
    installed: bool = False,
    out: int | None = None,
    **environment: str,
) -> subprocess.CompletedProcess[str]:
    """The command in a folder; everything that it says, and no traceback.

    installed: as a person starts it; a given environment or stream starts it so too.
    """
    if installed or environment or out is not None:
        done = subprocess.run(
            [STAFFA, *map(str, words)],
            cwd=folder,
            env={**os.environ, **environment},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE if out is None else out,
            stderr=subprocess.PIPE,
            text=True,
            timeout=240,
        )
    else:
        done = forked(*words, folder=folder, timeout=240)
    assert "Traceback" not in done.stderr and "PETSC ERROR" not in done.stderr, done.stderr
    return done


@pytest.fixture(scope="module")
def finished(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A run that a person has, in a folder of theirs."""
    folder = tmp_path_factory.mktemp("finished")
    (folder / "bar.toml").write_text(staffa("new", "bar", folder=folder).stdout)
    assert staffa("run", "bar.toml", "--out", "run", "--quiet", *BAR, folder=folder).returncode == 0
    return folder / "run"


@pytest.fixture
def run(finished: Path, tmp_path: Path) -> Path:
    """A copy of it."""
    return Path(shutil.copytree(finished, tmp_path / "run"))


MODULE = "open({canary!r}, 'w')\n"
TRAPS = {
    ".petscrc": "-log_view ascii:{folder}/canary-petsc",
    "petscrc": "-log_view ascii:{folder}/canary-petsc",
    "petsc.cfg": "PETSC_ARCH = {folder}",
    "ucx.conf": "UCX_LOG_LEVEL=debug\nUCX_LOG_FILE={folder}/canary-ucx\n",
    "dolfinx_jit_options.json": '{{"cache_dir": "{folder}/canary-cache/fenics"}}',
    "ffcx_options.json": '{{"language": "canary", "scalar_type": "canary"}}',
    "matplotlibrc": "text.usetex: True\nbackend: module://canary\nfont.size: nonsense\n",
    **{f"{name}.py": MODULE for name in ("numpy", "pyvista", "matplotlib", "json", "canary")},
}


@pytest.mark.slow
def test_nothing_that_lies_in_the_current_folder_is_read_as_a_setting(tmp_path: Path) -> None:
    """PETSc wrote a log where its file said, forms were taken from a cache there."""
    for name, text in TRAPS.items():
        known = {"folder": str(tmp_path), "canary": str(tmp_path / f"canary-{name}")}
        (tmp_path / name).write_text(text.format(**known))
    made = staffa("new", "bar", folder=tmp_path, installed=True)
    (tmp_path / "bar.toml").write_text(made.stdout)
    done = staffa("run", "bar.toml", "--out", "run", *BAR, folder=tmp_path, installed=True)
    assert done.returncode == 0, done.stderr
    assert (tmp_path / "run/report.html").is_file()
    left = {path.name for path in tmp_path.iterdir()} - {*TRAPS, "bar.toml", "run"}
    assert not left, f"{left} is there now"


def test_another_python_imports_nothing_from_the_current_folder(tmp_path: Path) -> None:
    """Each form of `python` is such a Python; the plain one falls into the trap."""
    canary = tmp_path / "canary"
    (tmp_path / "colorsys.py").write_text(MODULE.format(canary=str(canary)))
    for command in (isolated_python("import colorsys"), isolated_python(module="colorsys")):
        subprocess.run(command, cwd=tmp_path, check=True)
        assert not canary.exists(), command
    subprocess.run([sys.executable, "-c", "import colorsys"], cwd=tmp_path, check=True)
    assert canary.exists(), "the trap is none"


def test_it_knows_staffa_all_the_same(tmp_path: Path) -> None:
    said = subprocess.run(
        isolated_python("import staffa; print(staffa.__file__)"),
        cwd=tmp_path, check=True, capture_output=True, text=True,
    ).stdout  # fmt: skip
    import staffa as here

    assert said.strip() == here.__file__


def test_one_is_back_after_being_elsewhere(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(ValueError), elsewhere():
        assert Path.cwd() == Path("/")
        raise ValueError
    assert Path.cwd() == tmp_path


@pytest.mark.skipif(not shutil.which("git"), reason="there is no git on the path")
def test_a_repository_around_the_installed_package_is_not_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Its settings name a program that git runs, and its commit is not staffa's."""
    source = tmp_path / "lib/python3/site-packages/staffa/cases"
    source.mkdir(parents=True)
    (tmp_path / "a").write_text("a")
    trap = f"core.fsmonitor=touch {tmp_path}/canary; false"
    for words in (["init", "-q"], ["add", "a"], ["config", *trap.split("=", 1)]):
        subprocess.run(["git", *words], cwd=tmp_path, check=True)
    monkeypatch.setattr(provenance, "__file__", str(source / "provenance.py"))
    assert provenance.commit() is None
    assert not (tmp_path / "canary").exists()
    subprocess.run(["git", "status", "-s"], cwd=source, check=True, capture_output=True)
    assert (tmp_path / "canary").exists(), "the trap is none"


PERSONAL = ("manifest.json", "report.html", "tips.csv", "a.part", "checkpoint/thesis.h5")


@pytest.mark.parametrize(
    ("command", "name"), [("ensemble", PERSONAL[0]), *(("run", name) for name in PERSONAL)]
)
def test_a_run_goes_into_no_folder_that_holds_a_persons_files(
    command: str, name: str, tmp_path: Path
) -> None:
    (tmp_path / "bar.toml").write_text(staffa("new", "bar", folder=tmp_path).stdout)
    mine = tmp_path / "mine" / name
    mine.parent.mkdir(parents=True)
    mine.write_text("canary")
    seeds = ["--seeds", "2", "--set", "toughness.amplitude=0.05"]
    more = seeds if command == "ensemble" else []
    done = staffa(command, "bar.toml", "--out", "mine", *more, *BAR, folder=tmp_path)
    assert done.returncode == 2 and "which is of no run" in done.stderr, done.stderr
    assert mine.read_text() == "canary"
    assert [path for path in (tmp_path / "mine").rglob("*") if path.is_file()] == [mine]


def test_a_new_an_empty_and_a_locked_folder_are_free(tmp_path: Path) -> None:
    require_free(tmp_path / "new")
    require_free(tmp_path)
    (tmp_path / "lock").write_text("process 1 on here\n")
    require_free(tmp_path)
    (tmp_path / "lock").write_text("my keys" * 100)
    with pytest.raises(InputError, match="holds lock"):
        require_free(tmp_path)


def test_no_run_goes_through_a_symbolic_link(tmp_path: Path) -> None:
    (tmp_path / "mine").mkdir()
    (tmp_path / "link").symlink_to("mine")
    with pytest.raises(InputError, match="symbolic link"):
        require_free(tmp_path / "link")
    with pytest.raises(InputError, match="symbolic link"):
        own_files.make_folder(tmp_path / "link")


def test_no_member_of_an_ensemble_is_a_link(run: Path, tmp_path: Path) -> None:
    """A run elsewhere, of the same case, would have gone on."""
    (tmp_path / "all").mkdir()
    (tmp_path / "all/seed-0").symlink_to(run)
    case = read_case(run / "case.toml")
    with pytest.raises(InputError, match=r"seed-0 is a symbolic link"):
        started_members(case, range(1), tmp_path / "all")


def test_a_link_in_the_place_of_a_file_is_replaced_and_not_followed(tmp_path: Path) -> None:
    mine = tmp_path / "mine"
    mine.write_text("canary")
    for name in ("page", f".page{own_files.HALF}"):
        (tmp_path / name).symlink_to(mine)
    own_files.write_aside(tmp_path / "page", "ours")
    assert mine.read_text() == "canary"
    assert (tmp_path / "page").read_text() == "ours" and not (tmp_path / "page").is_symlink()
    (tmp_path / "log").symlink_to(mine)
    with pytest.raises(OSError), own_files.to_append(tmp_path / "log") as file:
        file.write("ours")
    assert mine.read_text() == "canary"


def test_a_report_and_a_resumed_run_leave_what_others_put_there(run: Path, tmp_path: Path) -> None:
    """`*.part`, other `.h5`, `.json` and `cracks-*` in folders of the run were deleted."""
    names = ("checkpoint/thesis.h5", "checkpoint/2024.json", "a.part", "fields/step-1.txt")
    mine = [run / name for name in (*names, "network/cracks-mine.csv", "checkpoint/b.part")]
    for path in mine:
        path.parent.mkdir(exist_ok=True)
        path.write_text("canary")
    outside = tmp_path / "outside"
    outside.mkdir()
    (outside / "a.part").write_text("canary")
    (run / "linked").symlink_to(outside)
    longer = ["--set", "time.t=[0.1,0.2,0.25]"]
    for words in (["report", run], ["resume", run, "--quiet", *longer]):
        done = staffa(*words, folder=tmp_path)
        assert done.returncode == 0, done.stderr
    assert [path.read_text() for path in (*mine, outside / "a.part")] == ["canary"] * 7


@pytest.mark.slow
def test_what_a_kill_took_from_the_results_is_made_again(run: Path, tmp_path: Path) -> None:
    """By `report`, and by `resume` of a run that is finished."""

    def files() -> set[Path]:
        return {path.relative_to(run) for path in run.rglob("*") if path.is_file()}

    assert staffa("report", run, folder=tmp_path).returncode == 0
    whole = files()
    assert {Path("report.html"), Path("tips.csv")} & whole and Path("pictures/cracks.png") in whole
    for command in ("report", "resume"):
        for path in (*run.glob("*.csv"), *run.glob("network/*"), *run.glob("pictures/*")):
            path.unlink()
        (run / "report.html").unlink()
        (run / f".report.html{own_files.HALF}").write_text("half")
        assert staffa(command, run, folder=tmp_path).returncode == 0
        assert files() == whole, command


@pytest.mark.parametrize("name", ["pictures", "network"])
def test_a_report_is_not_written_through_a_link(name: str, run: Path, tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    shutil.rmtree(run / name, ignore_errors=True)
    (run / name).symlink_to(outside)
    done = staffa("report", run, folder=tmp_path)
    assert done.returncode == 2 and "symbolic link" in done.stderr, done.stderr
    assert not list(outside.iterdir())


PLATE = """
[domain]
mesh = "plate.msh"
[damage]
ell = 0.9
[temperature]
profile = "none"
[supports]
floor = "rollers"
"the roof" = { y = 0.1 }
[time]
t = [1.0]
[[cracks]]
name = "fault"
[regions.sand]
[regions.shale]
"""


@needs_gmsh
def test_an_options_file_beside_a_mesh_is_not_run(tmp_path: Path) -> None:
    """Gmsh runs it, SystemCall and all, where it opens the mesh itself; here in another place."""
    meshes.written(tmp_path / "plate.msh", meshes.plate, h=0.3)
    (tmp_path / "plate.msh.opt").write_text(f'SystemCall "touch {tmp_path}/canary";')
    (tmp_path / ".gmsh-options").write_text(f'SystemCall "touch {tmp_path}/canary";')
    (tmp_path / "my.toml").write_text(PLATE)
    done = staffa("check", "my.toml", folder=tmp_path, installed=True)
    assert done.returncode == 0, done.stderr
    assert not (tmp_path / "canary").exists()


FIELD = 'material.E={{file="{}",name="E"}}'
ABSURD = (
    "# vtk DataFile Version 3.0\nx\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 99999999999 double\n"
)


@pytest.mark.parametrize(
    ("name", "content"),
    [
        *((f"rock{end}", b"canary") for end in (".pvti", ".case", ".pvd", ".xdmf", ".dem", ".pkl")),
        ("rock.vtk", ABSURD.encode()),
        ("rock.vtu", b"<VTKFile type='UnstructuredGrid'><Piece NumberOfPoints='-1'/>"),
        *((f"rock{end}", bytes(range(256)) * 9) for end in (".vtu", ".vtk", ".vtkhdf", ".vti")),
    ],
)
def test_a_file_of_rock_that_is_none_is_a_sentence(
    name: str, content: bytes, tmp_path: Path
) -> None:
    """Garbage ended in an abort; other formats name files elsewhere, which were read."""
    (tmp_path / name).write_bytes(content)
    (tmp_path / "bar.toml").write_text(staffa("new", "bar", folder=tmp_path).stdout)
    done = staffa("check", "bar.toml", "--set", FIELD.format(name), folder=tmp_path)
    assert done.returncode == 2 and done.stderr.count("\n") == 1 and name in done.stderr, (
        done.stderr
    )


@needs_gmsh
def test_gmsh_starts_without_the_settings_of_the_current_folder(tmp_path: Path) -> None:
    """The PETSc inside of it ran `.petscrc`: it wrote files and loaded libraries named there."""
    trap = f"-history {tmp_path}/canary"
    for name in (".petscrc", "petscrc"):
        (tmp_path / name).write_text(trap)
    code = "from staffa.geometry.gmsh_model import open_gmsh\nwith open_gmsh('a', 'b'): pass"
    subprocess.run(isolated_python(code), cwd=tmp_path, check=True)
    assert not (tmp_path / "canary").exists()


def test_a_field_that_keeps_its_numbers_elsewhere_is_refused(tmp_path: Path) -> None:
    """VTK read them, from any file of the user's, and the run kept them."""
    import pyvista

    grid = pyvista.ImageData(dimensions=(3, 3, 1)).cast_to_unstructured_grid()
    grid.point_data["E"] = np.arange(9.0)
    grid.save(tmp_path / "rock.vtkhdf")
    assert read_field(tmp_path / "rock.vtkhdf", "E").values.tolist() == list(range(9))
    (tmp_path / "mine").write_bytes(np.full(9, 7.0).tobytes())
    with h5py.File(tmp_path / "rock.vtkhdf", "r+") as file:
        del file["VTKHDF/PointData/E"]
        mine = [(str(tmp_path / "mine"), 0, 72)]
        file["VTKHDF/PointData"].create_dataset("E", shape=9, dtype="f8", external=mine)
    with pytest.raises(InputError, match=r"rock.vtkhdf keeps numbers in another file"):
        read_field(tmp_path / "rock.vtkhdf", "E")


@needs_gmsh
@pytest.mark.parametrize(
    "damage",
    [
        lambda text: re.sub(r"\n\S+ (\S+) 0\n", r"\nnan \1 0\n", text),
        lambda text: text.replace("$Nodes\n", "$Nodes\n999999999 ", 1),
        lambda text: text[: len(text) // 2],
        lambda text: "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n" + "$Nodes\n" * 50,
    ],
)
def test_a_mesh_that_is_damaged_is_a_sentence(damage, tmp_path: Path) -> None:
    meshes.written(tmp_path / "whole.msh", meshes.plate, h=0.3)
    damaged = damage((tmp_path / "whole.msh").read_text())
    assert damaged != (tmp_path / "whole.msh").read_text()
    (tmp_path / "plate.msh").write_text(damaged)
    (tmp_path / "my.toml").write_text(PLATE)
    done = staffa("check", "my.toml", folder=tmp_path)
    assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stderr


@dataclass(frozen=True)
class Read:
    """Something that a reader returns."""

    values: np.ndarray


def crashing(path: Path) -> Read:
    """A library that crashes."""
    os.kill(os.getpid(), signal.SIGSEGV)
    raise AssertionError


def hoarding(path: Path) -> Read:
    """A library that asks for memory without end."""
    return Read(values=np.ones(1 << 34))


def busy(path: Path) -> Read:
    """A library that never comes back."""
    time.sleep(600)
    raise AssertionError


@pytest.mark.parametrize(
    ("reader", "said"),
    [
        ("crashing", "was ended by SIGSEGV"),
        ("hoarding", "asked for more than 4 GiB"),
        ("busy", "took more than 1 s"),
    ],
)
def test_a_library_that_fails_while_it_reads_is_a_sentence(
    reader: str, said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("staffa.backend.guarded_reading.SECONDS", 1.0 if reader == "busy" else 60.0)
    with pytest.raises(InputError, match=said):
        read_apart(Read, f"{__name__}:{reader}", tmp_path / "a", [], where="domain.mesh")


ESCAPE = "\x1b[2J\x1b]0;canary\x07"


def test_sequences_that_rewrite_the_screen_are_spelled_out(run: Path, tmp_path: Path) -> None:
    """In the path of a run, in its title, and in what a log says."""
    there = run.rename(tmp_path / f"run{ESCAPE}")
    manifest = json.loads((there / "manifest.json").read_text())
    (there / "manifest.json").write_text(json.dumps(manifest | {"title": f"a {ESCAPE} bar"}))
    for words in (["show", there], ["report", there], ["show", tmp_path / f"no{ESCAPE}"]):
        done = staffa(*words, folder=tmp_path)
        said = done.stdout + done.stderr
        assert "\x1b" not in said and "\x07" not in said, repr(said)
        assert "canary" in said


def test_a_warning_that_would_rewrite_the_screen_is_spelled_out(
    capsys: pytest.CaptureFixture[str],
) -> None:
    commands._warn(StaffaWarning(f"a {ESCAPE} name"), StaffaWarning)
    said = capsys.readouterr().err
    assert "canary" in said and "\x1b" not in said and "\x07" not in said


def test_a_name_with_dollars_in_it_is_drawn_as_it_is(tmp_path: Path) -> None:
    """Matplotlib took it for a formula, and ended in a traceback."""

    def draw() -> Figure:
        figure = Figure()
        axes = figure.subplots()
        axes.plot([0, 1], label=r"face $\frac{$")
        axes.set_xlabel(TAU, parse_math=True)
        axes.legend()
        return figure

    write_picture(tmp_path / "a.png", draw)
    assert (tmp_path / "a.png").read_bytes().startswith(b"\x89PNG")


def test_a_cell_that_a_spreadsheet_would_compute_is_a_text() -> None:
    rows = (("=cmd()", "+1", "-1", "@x", "a", -1.5, None),)
    written = Table(columns=columns_of(*"xxxxxxx"), rows=rows).csv()
    assert written == "x,x,x,x,x,x,x\n'=cmd(),'+1,'-1,'@x,a,-1.5,\n"


def test_nothing_but_scripts_of_staffa_can_run_on_a_page(run: Path, tmp_path: Path) -> None:
    manifest = json.loads((run / "manifest.json").read_text())
    script = "<script>document.title = 'canary'</script>"
    (run / "manifest.json").write_text(json.dumps(manifest | {"title": script}))
    assert staffa("report", run, folder=tmp_path).returncode == 0
    text = (run / "report.html").read_text()
    assert f'http-equiv="Content-Security-Policy" content="{policy()}"' in text
    assert "&lt;script&gt;" in text
    left = re.findall(r"<script[^>]*>", without_scripts(text))
    assert left and all('type="application/json"' in tag for tag in left), "data, that does not run"
    assert policy().startswith("default-src 'none'") and "unsafe-eval" not in policy()
    allowed = policy().split("script-src ")[1].split()
    assert len(allowed) == 2 and all(one.startswith("'sha256-") for one in allowed)


SCRIPT = "<script>document.title='canary'</script>"
IMAGE = "<img src=x onerror=document.title='canary'>"


def shown_title(page: Path) -> str:
    """The title of a page once Chromium has shown it."""
    command = [str(chromium()), "--headless", "--no-sandbox", "--disable-gpu", "--dump-dom"]
    shown = subprocess.run(
        [*command, f"--user-data-dir={page.parent / 'profile'}", page.as_uri()],
        capture_output=True, text=True, timeout=120,
    ).stdout  # fmt: skip
    return shown.split("<title>")[1].split("</title>")[0]


@pytest.mark.slow
@needs_chromium
def test_a_browser_runs_no_script_that_finds_its_way_onto_a_page(run: Path, tmp_path: Path) -> None:
    """Without the policy it would: the same page, with that taken away."""
    assert staffa("report", run, folder=tmp_path).returncode == 0
    page = (run / "report.html").read_text()
    held = page.replace("<h1>", f"{SCRIPT}{IMAGE}<h1>", 1)
    titles = {}
    for name, text in {"held": held, "open": held.replace(policy(), "")}.items():
        (tmp_path / f"{name}.html").write_text(text)
        titles[name] = shown_title(tmp_path / f"{name}.html")
    assert titles["open"] == "canary", "the trap is none"
    assert titles["held"] != "canary"


@pytest.mark.slow
@needs_gmsh
@needs_chromium
def test_names_of_a_mesh_run_nothing_on_a_page(tmp_path: Path) -> None:
    """Try names of the file, a face, a region and a crack; also without the policy."""
    meshes.written(tmp_path / "plate.msh", meshes.plate, h=0.3)
    text, case = (tmp_path / "plate.msh").read_text(), PLATE
    for name, trap in {"the roof": SCRIPT, "sand": IMAGE, "fault": SCRIPT + IMAGE}.items():
        text, case = text.replace(f'"{name}"', f'"{trap}"'), case.replace(f'"{name}"', f'"{trap}"')
    case = case.replace("[regions.sand]", f'[regions."{IMAGE}"]')
    (tmp_path / f"{IMAGE}.msh").write_text(text)
    (tmp_path / "my.toml").write_text(case.replace("plate.msh", f"{IMAGE}.msh"))
    done = staffa("run", "my.toml", "--out", "run", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    page = (tmp_path / "run/report.html").read_text()
    assert "&lt;script" in page and "&lt;img src=x" in page
    (tmp_path / "open.html").write_text(page.replace(policy(), ""))
    assert shown_title(tmp_path / "open.html") != "canary"


BROKEN = {
    "times": [],
    "taus": [],
    "requested": [],
    "size": [1.0],
    "h": 0.0,
    "ell": -1.0,
    "unknowns": 0,
    "toughness_factor": 0.0,
    "lower": [0.0],
}


@pytest.mark.parametrize("name", BROKEN)
def test_a_manifest_of_no_run_is_a_sentence(name: str, run: Path) -> None:
    """Reports ended in tracebacks: an index out of range, a division by zero."""
    manifest = json.loads((run / "manifest.json").read_text())
    (run / "manifest.json").write_text(json.dumps(manifest | {name: BROKEN[name]}))
    with pytest.raises(StaffaError, match=rf"damaged: .*\b{name}\b"):
        open_run(run)


def spoiled(name: str, value) -> Callable[[h5py.Group], None]:
    """Put numbers in the place of others in a file of fields."""

    def spoil(root: h5py.Group) -> None:
        where = root[name]
        shape = where.shape
        del root[name]
        root[name] = np.full(shape, value) if np.isscalar(value) else value

    return spoil


def without_end(root: h5py.Group) -> None:
    del root["Points"]
    root.create_dataset("Points", shape=(10**11, 3), dtype="f8", chunks=(1000, 3))


def elsewhere_kept(root: h5py.Group) -> None:
    size = root["PointData/alpha"].size
    del root["PointData/alpha"]
    kept = [("/dev/zero", 0, 8 * size)]
    root["PointData"].create_dataset("alpha", shape=size, dtype="f8", external=kept)


@pytest.mark.parametrize(
    ("spoil", "said"),
    [
        (spoiled("Connectivity", 2**40), "corners that are not there"),
        (spoiled("Connectivity", -7), "corners that are not there"),
        (spoiled("Points", np.nan), "no points with three coordinates"),
        (spoiled("PointData/alpha", np.zeros(3)), "not one value at each place"),
        (spoiled("PointData/alpha", b"a text"), "other things than numbers"),
        (spoiled("Types", 99), "99"),
        (without_end, "more numbers than it can hold"),
        (elsewhere_kept, "keeps numbers in another file"),
    ],
)
def test_damaged_fields_of_a_run_are_left_out(spoil, said: str, run: Path, tmp_path: Path) -> None:
    """They ended in tracebacks as they were drawn, or asked for all memory."""
    file = next((run / "fields").glob("*.vtkhdf"))
    with h5py.File(file, "r+") as fields:
        spoil(fields["VTKHDF"])
    with pytest.raises((KeyError, ValueError), match=said):
        read_vtkhdf(file)
    done = staffa("report", run, folder=tmp_path)
    assert done.returncode == 0 and "not drawn: fields/" in done.stdout, done.stdout


@pytest.mark.parametrize("name", ["case.toml", "steps.jsonl", "fields", "checkpoint"])
def test_a_pipe_in_the_place_of_a_file_is_not_waited_for(
    name: str, run: Path, tmp_path: Path
) -> None:
    """Reports and resumed runs hung."""
    files = list((run / name).iterdir()) if (run / name).is_dir() else [run / name]
    for file in files:
        file.unlink()
        os.mkfifo(file)
    command = "resume" if name == "checkpoint" else "report"
    done = staffa(command, run, folder=tmp_path)
    assert done.returncode in (0, 1, 2), done.stderr
    assert done.returncode == 0 or "ordinary file" in done.stderr, done.stderr


@pytest.mark.parametrize("name", ["lock", "run.log"])
def test_a_pipe_in_the_place_of_a_lock_or_a_log_is_not_waited_for(name: str, run: Path) -> None:
    (run / name).unlink(missing_ok=True)
    os.mkfifo(run / name)
    if name == "lock":
        with pytest.raises(InputError, match="lock is no ordinary file"):
            Lock(run).take()
    else:
        with pytest.raises(OSError):
            own_files.to_append(run / name)


DEEP = "[" * 100_000 + "]" * 100_000


def test_brackets_without_end_are_a_sentence(run: Path, tmp_path: Path) -> None:
    (run / "steps.jsonl").write_text(DEEP + "\n")
    with pytest.raises(StaffaError, match=r"line 1 is damaged .*nested too deeply"):
        open_run(run)
    for page in (run / "checkpoint").glob("*.json"):
        page.write_text(DEEP)
    done = staffa("resume", run, "--quiet", folder=tmp_path)
    assert done.returncode == 0, "it begins again, with what it had put aside"
    (run / "manifest.json").write_text(DEEP)
    with pytest.raises(StaffaError, match="nested too deeply"):
        open_run(run)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (f"h = 0x{'f' * 4000}", "a whole number of more than 3,900 digits"),
        ("[material]\nE = 1e-320", "material.E = 1e-320"),
    ],
)
def test_numbers_beyond_sense_are_sentences(text: str, said: str, tmp_path: Path) -> None:
    (tmp_path / "my.toml").write_text(f"[domain]\nsize = [1.0, 1.0]\n{text}\n")
    done = staffa("check", "my.toml", folder=tmp_path)
    assert done.returncode == 2 and said in done.stderr.replace("\n", " "), done.stderr


def test_a_name_too_long_for_any_disk_is_a_sentence(tmp_path: Path) -> None:
    (tmp_path / "bar.toml").write_text(staffa("new", "bar", folder=tmp_path).stdout)
    done = staffa("run", "bar.toml", "--out", "x" * 300, *BAR, folder=tmp_path)
    assert done.returncode == 2 and "too long a name" in done.stderr


def test_a_reader_that_goes_away_is_no_failure(run: Path, tmp_path: Path) -> None:
    """PETSc ended with 26 lines, or Python with a traceback."""
    for command in ("show run | head -1", "show run >&-", "new slab | head -1"):
        line = f"set -o pipefail; {STAFFA} {command}"
        done = subprocess.run(
            ["bash", "-c", line], cwd=tmp_path, capture_output=True, text=True, timeout=60
        )
        assert done.returncode == 0 and done.stderr == "", (command, done)


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="there is no /dev/full here")
def test_what_a_full_disk_loses_is_said(run: Path, tmp_path: Path) -> None:
    with open("/dev/full", "w") as full:
        done = staffa("show", run, folder=tmp_path, out=full.fileno())
    assert done.returncode == 1 and "was lost (No space left on device)" in done.stderr


@pytest.mark.parametrize(
    ("environment", "code", "said"),
    [
        ({"MPLBACKEND": "canary"}, 0, ""),
        ({"PYTHONOPTIMIZE": "2"}, 2, "PYTHONOPTIMIZE = 2"),
    ],
)
def test_an_environment_that_asks_for_what_is_not_there(
    environment: dict[str, str], code: int, said: str, run: Path, tmp_path: Path
) -> None:
    done = staffa("report", run, folder=tmp_path, **environment)
    assert done.returncode == code and said in done.stderr, done.stderr


@pytest.mark.parametrize("asked", ["-options_file nowhere", "-u_direct_ksp_rtol canary"])
def test_options_that_petsc_cannot_take_are_a_sentence(asked: str, tmp_path: Path) -> None:
    (tmp_path / "bar.toml").write_text(staffa("new", "bar", folder=tmp_path).stdout)
    done = staffa("run", "bar.toml", "--out", "run", *BAR, folder=tmp_path, PETSC_OPTIONS=asked)
    assert done.returncode in (1, 2) and "PETSC_OPTIONS" in done.stderr, done.stderr
    assert not (tmp_path / "run/steps.jsonl").exists()


@pytest.mark.slow
def test_a_cache_that_cannot_be_written_to_is_replaced_and_named(tmp_path: Path) -> None:
    """As on a computer whose home folders are read-only, or whose cache is another's."""
    (tmp_path / "bar.toml").write_text(staffa("new", "bar", folder=tmp_path).stdout)
    (tmp_path / "tmp").mkdir()
    for place, cache in {"a": "/proc/nowhere", "b": str(tmp_path / "open")}.items():
        if place == "b":
            (tmp_path / "open/staffa").mkdir(parents=True)
            (tmp_path / "open/staffa").chmod(0o777)
        known = {"XDG_CACHE_HOME": cache, "TMPDIR": str(tmp_path / "tmp"), "STAFFA_CFLAGS": "-O0"}
        done = staffa("run", "bar.toml", "--out", place, *BAR, folder=tmp_path, **known)
        assert done.returncode == 0, done.stderr
        assert f"cannot be kept in {cache}/staffa" in done.stderr
        own = tmp_path / "tmp" / f"staffa-{os.getuid()}"
        assert own.stat().st_mode & 0o777 == 0o700 and list(own.glob("*/*.so"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "number", [signal.SIGHUP, pytest.param(signal.SIGQUIT, marks=pytest.mark.long)]
)
def test_a_run_whose_terminal_is_closed_is_saved(number: signal.Signals, tmp_path: Path) -> None:
    (tmp_path / "bar.toml").write_text(staffa("new", "bar", folder=tmp_path).stdout)
    many = ["--set", "time.t={start=0.001,stop=0.2,steps=2000}"]
    process = subprocess.Popen(
        [STAFFA, "run", "bar.toml", "--out", "run", "--quiet", *BAR, *many], cwd=tmp_path,
        stderr=subprocess.PIPE, text=True,
    )  # fmt: skip
    steps, until = tmp_path / "run/steps.jsonl", time.monotonic() + 120
    while not (steps.exists() and steps.stat().st_size) and time.monotonic() < until:
        time.sleep(0.1)
    process.send_signal(number)
    assert process.wait(timeout=60) == 3
    assert process.stderr is not None and f"{number.name} asked for it" in process.stderr.read()
    assert list((tmp_path / "run/checkpoint").glob("*.json"))


def test_other_compiler_flags_are_told_where_a_run_goes_on(run: Path, tmp_path: Path) -> None:
    """They change the last digits of energies."""
    flags = json.loads((run / "manifest.json").read_text())["versions"]["C compiler flags"]
    assert flags == os.environ.get("STAFFA_CFLAGS", flags)
    longer = ["--set", "time.t=[0.1,0.2,0.25]"]
    done = staffa("resume", run, *longer, folder=tmp_path, STAFFA_CFLAGS="-O0")
    assert done.returncode == 0 and f"C compiler flags {flags} and now -O0" in done.stdout

"""Whole runs whose mesh follows the cracks, with all that must know of it."""

from collections.abc import Mapping
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
import pytest

from staffa.case.reading.read import parse_case, read_case
from staffa.io.run_directory import Run, open_run
from staffa.io.vtkhdf import read_vtkhdf
from staffa.runs.run import run
from staffa.setup.build import body_of
from support.bodies import needs_gmsh
from support.commands import forked
from support.meshes import plate, written
from support.refining import REFINED, cells_of, mean_edge_of_crossed, refining
from support.restarting import whole_run

FINEST = mean_edge_of_crossed(1 / 32)
SHORT = "time.tau=[0.002,0.05]"
CRACK = "cracks=[{start=[0.5,0.0],end=[0.5,0.2]}]"
# What the small case becomes.
CASES: Mapping[str, tuple[str, ...]] = {
    "quadratic elements": ("domain.elements=quadratic",),
    "crack set": ("damage.irreversibility='crack set'",),
    "contact": ("damage.split=contact",),
    "friction": ("damage.split=contact", "damage.friction=0.3"),
    "an initial crack": (CRACK,),
    "fluid of a given volume": (CRACK, "forces.crack_volume={t=[0.0,0.000625],value=[0.02,0.04]}",
        "temperature.severity=1.0",
                                "material.plane=strain"),
    "prestress": ("forces.prestress={xx=-1.0,yy=-1.0}", "supports.left=rollers",
                  "supports.right=rollers"),
    "regions": ("regions.clay={lower=[0.0,0.4],upper=[1.0,0.6],E=0.3}",),
    "random stiffness": ("material.E={mean=1.0,variation=0.2,length=0.2,seed=1}",),
    "exact second order": ("solver.stability=report",),
    "adaptive steps": ("time.tau={start=0.002,stop=0.05,shortest=0.002,longest=0.02}",),
    "an axis": ("domain.symmetry=axis",),
}  # fmt: skip


def assert_fine(found: Run) -> None:
    """Cells were split in it, no coarse cell is damaged, and the audit has nothing to say."""
    assert found.finished
    assert sum(step.mesh.changes for step in found.steps) > 0
    for step in found.steps:
        assert step.mesh.coarse_damage <= 0.01
        assert not step.audit.violations, step.audit.violations
        grid, values = read_vtkhdf(found.path / step.fields)
        assert len(grid.cells) == step.mesh.cells and len(values["alpha"]) == len(grid.points)


@pytest.mark.slow
@pytest.mark.parametrize("name", CASES)
def test_it_goes_with_all_that_a_case_can_ask_for(name: str, tmp_path: Path) -> None:
    found = whole_run(refining(SHORT, *CASES[name]), tmp_path / "run")
    assert_fine(found)
    last = found.steps[-1]
    worst = max(
        cells.alpha[cells.coarse].max(initial=0.0)
        for cells in (cells_of(found, step.fields, FINEST) for step in found.steps)
    )
    assert worst <= 0.01 and last.mesh.cells < 4096
    if "volume" in name:
        assert last.measures.fluid.volume == pytest.approx(0.04, rel=1e-6)
    if name in ("an initial crack", "fluid of a given volume"):
        assert found.steps[0].released and last.released, "tips are found on each mesh"


@pytest.mark.slow
def test_the_heat_equation_is_as_conservative_as_on_one_mesh(tmp_path: Path) -> None:
    heat = ("temperature={profile='heat'}", "heat={initial=0.0,bottom={T=-10.0}}")
    found = whole_run(refining(*heat, "time={t=[0.002,0.01,0.05]}"), tmp_path / "run")
    assert_fine(found)
    assert sum(step.mesh.changes > 0 for step in found.steps) > 1
    for step in found.steps:
        assert step.heat.imbalance < 1e-8
        assert step.heat.stored == pytest.approx(sum(step.heat.entered.values()), rel=1e-8)


@pytest.mark.slow
def test_tetrahedra_follow_the_cracks(tmp_path: Path) -> None:
    solid = ("domain.size=[0.5,0.5,1.0]", "domain.cells=tetrahedron", "domain.h=0.0625")
    start = ('domain.refine={coarsest="4 h",ahead="0.5 ell"}', "damage.ell=0.2")
    case = refining("time.tau=[0.02,0.2]", *solid, *start, "temperature.severity=8.0")
    found = whole_run(case, tmp_path / "run")
    assert_fine(found)
    assert found.steps[-1].energies.surface > 0.05, "damage has come"
    assert body_of(case, MPI.COMM_WORLD).mesh.topology.index_map(3).size_global == 96
    assert 500 < found.steps[-1].mesh.cells < 6144, "of a uniform mesh"


@needs_gmsh
@pytest.mark.slow
@pytest.mark.parametrize(
    "body",
    [
        'cells = "unstructured"\nsize = [1.0, 1.0]',
        'shape = { kind = "layers", base = [1.0], layers = ['
        '{ region = "clay", thickness = 0.4 }, { region = "sand", thickness = 0.6 }] }',
    ],
    ids=["block", "layers"],
)
def test_a_body_that_gmsh_meshes(body: str, tmp_path: Path) -> None:
    text = REFINED.replace("size = [1.0, 1.0]\n", "").replace('cells = "triangle"', body)
    text += "[regions.clay]\nE = 0.5\n[regions.sand]\n" if "layers" in body else ""
    assert_fine(whole_run(parse_case(text, (SHORT,)), tmp_path / "run"))


@needs_gmsh
@pytest.mark.slow
def test_a_mesh_from_a_file_with_a_crack_and_regions(tmp_path: Path) -> None:
    """Names stay with the parts of what had them, and the crack is fine from the start."""
    written(tmp_path / "plate.msh", plate, h=0.2)
    body = 'mesh = "plate.msh"\nh = 0.04\nrefine = { ahead = "1 ell" }\n'
    text = REFINED[: REFINED.index("[domain]")] + "[domain]\n" + body
    text += REFINED[REFINED.index("[damage]") :].replace("[time]", "[regions.sand]\n[time]")
    text = text.replace("[time]", '[regions.shale]\nE = 0.5\n[[cracks]]\nname = "fault"\n[time]')
    text = text.replace('profile = "half-space"', 'profile = "half-space"\nface = "floor"')
    (tmp_path / "my.toml").write_text(text)
    case = read_case(tmp_path / "my.toml", (SHORT,))
    run(case, tmp_path / "run")
    found = open_run(tmp_path / "run")
    assert_fine(found)
    first = body_of(case, MPI.COMM_WORLD)
    assert found.steps[0].mesh.cells > 2 * first.mesh.topology.index_map(2).size_global
    grid, values = read_vtkhdf(found.path / found.steps[0].fields)
    on_fault = np.abs(grid.points[:, 0] - 2.0) < 1e-9
    on_fault &= (grid.points[:, 1] > 2.5 + 0.06) & (grid.points[:, 1] < 3.0 - 0.06)
    assert on_fault.sum() > 8 and values["alpha"][on_fault].min() > 0.9


@pytest.mark.slow
def test_a_refined_run_beside_a_uniform_one(tmp_path: Path) -> None:
    """Compared at the times of both, in tables and pictures; each has its own page."""
    held = ("supports.left=rollers", "supports.right=rollers", "time.tau=[0.2,0.4]")
    settings = (CRACK, *held, "toughness.amplitude=0.0", "temperature.severity=2.0")
    one = whole_run(refining(*settings), tmp_path / "refined")
    other = whole_run(refining(*settings, "domain.refine=false"), tmp_path / "uniform")
    for here, there in zip(one.steps, other.steps, strict=True):
        assert here.energies.total == pytest.approx(there.energies.total, rel=1e-2)
    done = forked("compare", "refined", "uniform", "--out", "pair", folder=tmp_path)
    assert done.returncode == 0, done.stderr
    assert "domain.refine" in done.stdout, done.stdout
    assert list((tmp_path / "pair").rglob("*.png"))
    for name in ("refined", "uniform"):
        done = forked("report", name, folder=tmp_path)
        assert done.returncode == 0, done.stderr
        assert (tmp_path / name / "report.html").stat().st_size > 10_000
        assert (tmp_path / name / "network.csv").read_text().count("\n") > 1

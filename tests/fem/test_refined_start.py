"""A mesh that begins coarse has the initial cracks, regions and energies at rest of a fine one."""

from staffa.backend.stack import MPI

import numpy as np
import pytest

from staffa.evolution.march import march_session
from staffa.evolution.session import Session
from staffa.evolution.system import build, initially_broken
from staffa.measure.coarse import local
from staffa.model.domain import block
from staffa.model.fields import spaces_on
from staffa.model.refinement import Wanted, refined
from staffa.setup.build import problem
from support.refining import refining

UNIFORM = "domain.refine=false"
BAND = "toughness.bands=[{lower=[0.0,0.4],upper=[1.0,0.43],factor=0.1}]"
PRESSED = "forces.prestress={xx=-1.0,yy=-1.0}"
UNEVEN = "material.E={mean=1.0,variation=0.2,length=0.2,seed=1}"


@pytest.mark.parametrize(
    "ends",
    [
        "start=[0.45,0.0],end=[0.45,0.3]",
        "start=[0.0,0.33],end=[1.0,0.33]",
        "start=[0.1,0.2],end=[0.9,0.55]",
        "start=[0.41,0.33],end=[0.47,0.33]",
    ],
)
def test_an_initial_crack_breaks_as_many_vertices_wherever_it_lies(ends: str) -> None:
    """Coarse vertices may all be far from it."""
    counts = []
    for settings in ((), (UNIFORM,)):
        setup = problem(refining(f"cracks=[{{{ends}}}]", *settings))
        counts.append(int(initially_broken(setup, spaces_on(setup.domain).alpha).sum()))
    assert counts[0] == counts[1] > 4


@pytest.mark.parametrize(("lower", "upper"), [(0.4, 0.43), (0.26, 0.29), (0.13, 0.16)])
def test_a_thin_region_has_its_area_wherever_it_lies(lower: float, upper: float) -> None:
    """It may lie between the corners of all coarse cells."""
    box = f"{{lower=[0.0,{lower}],upper=[1.0,{upper}],E=0.5}}"
    domain = problem(refining(f"regions={{clay={box}}}")).domain
    mesh = domain.mesh
    corners = mesh.geometry.x[mesh.geometry.dofmaps[0][domain.cells("clay")], :2]
    area = np.abs(np.linalg.det(corners[:, 1:] - corners[:, :1])).sum() / 2
    assert area == pytest.approx(upper - lower, rel=0.15)


def test_a_thin_weak_band_is_fine_from_the_start() -> None:
    domain = problem(refining(BAND)).domain
    geometry = domain.mesh.geometry
    corners = geometry.x[geometry.dofmaps[0], :2]
    in_band = np.abs(corners.mean(axis=1)[:, 1] - 0.415) < 0.015
    assert in_band.sum() > 60
    assert np.ptp(corners[in_band], axis=1).max() <= 1 / 32 + 1e-12


@pytest.mark.parametrize(
    "load",
    [
        ("forces.gravity=[0.0,-0.5]", "material.rho=1.0", "supports.bottom=rollers"),
        (PRESSED, UNEVEN),
    ],
    ids=["weight", "prestress"],
)
def test_energies_at_rest_are_those_of_the_mesh_at_hand(load: tuple[str, ...]) -> None:
    """Energies count from rest: what a finer mesh does to rest itself is no change."""
    held = ("supports.left=rollers", "supports.right=rollers", "time.tau=[0.01]")
    case = (*held, *load, "toughness.amplitude=0.0", "temperature.severity=0.001")
    found = []
    for settings in ((), (UNIFORM,)):
        setup = problem(refining(*case, *settings))
        session = Session(setup, build(setup))
        (step,) = march_session(session)
        session.destroy()
        found.append(step)
    one, other = found
    assert one.mesh.changes > 0 and abs(one.mesh.energy) < 1e-9
    assert one.energies.total == pytest.approx(other.energies.total, rel=0.3)


@pytest.mark.parametrize(("dim", "cells"), [(2, "triangle"), (3, "tetrahedron")])
def test_the_finest_cells_of_a_block_count_as_cells_of_h(dim: int, cells: str) -> None:
    """Their mean edge is .8 h (2-D) or 1.26 h (3-D): a crack in them costs what was measured."""
    domain = block(MPI.COMM_SELF, size=(1.0,) * dim, h=1 / 8, cells=cells, halvings=1)
    wanted = Wanted.nothing(domain.mesh.topology.index_map(domain.dim).size_local)
    wanted.edge[:] = domain.source.finest
    fine, _ = refined(domain, wanted, ahead=0.0)
    found = local(fine, 1.12)
    assert found.edge.mean() == pytest.approx(fine.h, rel=0.01)
    assert found.toughness.mean() == pytest.approx(1.12, rel=0.002)

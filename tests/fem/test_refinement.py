"""A mesh that follows the cracks under the time loop: fine in time, and of the same energy."""

from dataclasses import replace
from itertools import pairwise
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
import pytest

from staffa.case.schema.case import Case
from staffa.evolution.carry import refined_at_cracks
from staffa.evolution.march import march_session
from staffa.evolution.problem import Backtracking, Problem, Refinement
from staffa.evolution.session import Session
from staffa.evolution.system import build
from staffa.io.run_directory import Run
from staffa.model.domain import block, local_edges
from staffa.model.refinement import Wanted
from staffa.model.supports import SideSupport, no_displacement
from staffa.records.step import Step, kept
from staffa.setup.build import problem
from support.bodies import body, rock
from support.refining import cells_of, largest_drive, mean_edge_of_crossed, refining
from support.restarting import whole_run

FINEST = mean_edge_of_crossed(1 / 32)
UNIFORM = "domain.refine=false"
AT2 = "damage.law=AT2"
WELL = (0.53, 0.06)


@pytest.fixture(scope="module")
def refined(tmp_path_factory) -> Run:
    """The small run whose mesh follows the cracks."""
    probe = f'output.probes=[{{name="well",point={list(WELL)}}}]'
    return whole_run(refining(probe), tmp_path_factory.mktemp("refined") / "run")


def test_no_coarse_cell_is_damaged_in_any_step(refined: Run) -> None:
    """As the record says, and counted in the files of fields; and it is not fine all over."""
    assert refined.finished
    for step in refined.steps:
        cells = cells_of(refined, step.fields, FINEST)
        worst = cells.alpha[cells.coarse].max()
        assert worst <= 0.01, f"step {step.index}: damage {worst} in a coarse cell"
        assert step.mesh.coarse_damage == pytest.approx(worst, abs=1e-12)
        assert step.mesh.cells == len(cells.coarse) < 3500
        assert not step.audit.violations, step.audit.violations
    assert cells.alpha.max() > 0.9, "cracks have grown"


def test_the_damage_of_a_try_on_coarser_cells_is_a_first_guess_of_the_next(tmp_path: Path) -> None:
    """Steps end at the same minimum as from their own start, in fewer sweeps of the last try."""
    late = "domain.refine.drive=0.9"  # cells are split once cracks have run into them
    steps = whole_run(refining(late), tmp_path / "guessed").steps
    alone = whole_run(refining(late, "solver.guess=none"), tmp_path / "alone").steps
    assert steps[-1].effort.guesses == 1 and all(step.effort.guesses == 0 for step in alone)
    assert steps[-1].sweeps < alone[-1].sweeps / 2
    for step, other in zip(steps, alone, strict=True):
        assert step.energies.total == pytest.approx(other.energies.total, rel=1e-5)
        assert step.sweeps <= other.sweeps and step.mesh.cells == other.mesh.cells
        assert not step.audit.violations


def test_each_file_has_its_mesh_which_grows_alone(refined: Run) -> None:
    """All vertices before are vertices after, and new ones come; a probe reads each of them."""
    sizes = [step.mesh.cells for step in refined.steps]
    assert sizes == sorted(sizes) and len(set(sizes)) > 1, sizes
    places = [
        set(map(tuple, cells_of(refined, step.fields, FINEST).points)) for step in refined.steps
    ]
    for before, after in pairwise(places):
        assert before <= after, "old vertices stay"
    assert [step.mesh.vertices for step in refined.steps] == [len(at) for at in places]
    changed = [step for step in refined.steps if step.mesh.changes]
    assert len(changed) > 1 and all(step.mesh.energy <= 1e-12 for step in changed)
    for step in refined.steps:
        expected = cells_of(refined, step.fields, FINEST).damage_at(WELL)
        assert step.probed[0][-1] == pytest.approx(expected, abs=1e-9)
    assert expected > 0.1, "there is something to read"


def marched(case_or_problem: Case | Problem) -> list[tuple[Step, float, float]]:
    """Each step, the largest damage and the largest drive."""
    setup = case_or_problem
    if isinstance(setup, Case):
        setup = problem(setup)
    session = Session(setup, build(setup))
    try:
        return [
            (step, float(session.state.alpha.x.array.max()), largest_drive(session.system))
            for step in march_session(session)
        ]
    finally:
        session.destroy()


SLAB = (
    "supports.left=rollers",
    "supports.right=rollers",
    "domain.h=0.015625",
    "toughness.amplitude=0.0",
    "time.tau=[0.35,0.5]",
    "solver.stability=none",
)


@pytest.mark.slow
@pytest.mark.parametrize("severity", [0.5, 1.7], ids=["far from damage", "near to damage"])
def test_before_any_damage_energy_and_drive_are_those_of_fine_cells(severity: float) -> None:
    """A slab with a cold front that the finest cells resolve: 2.5 % of the drop over each."""
    case, start = (*SLAB, f"temperature.severity={severity}"), 'domain.refine={coarsest="16 h"}'
    found, expected = marched(refining(*case, start)), marched(refining(*case, UNIFORM))
    for (one, damage, drive), (other, _, exact) in zip(found, expected, strict=True):
        assert damage == 0.0 < exact < 1.0
        assert one.mesh.cells < 10_000, "of 16,384"
        assert one.energies.elastic == pytest.approx(other.energies.elastic, rel=1e-3)
        assert drive == pytest.approx(exact, rel=1e-2)


@pytest.mark.slow
def test_a_body_that_bends_freely_is_too_stiff_by_what_the_docs_say() -> None:
    """By less than 1 % in energy; its drive is as near as the uniform mesh's to that of h/2."""
    case = (
        "domain.h=0.015625",
        "damage.ell=0.05",
        "temperature.severity=0.5",
        "time.tau=[0.2,0.4]",
        "toughness.amplitude=0.0",
    )
    found = marched(refining(*case, "domain.refine=true"))
    uniform = marched(refining(*case, UNIFORM))
    halved = marched(refining(*case, UNIFORM, "domain.h=0.0078125"))
    for (one, damage, drive), (other, _, theirs), (_, _, near) in zip(
        found, uniform, halved, strict=True
    ):
        assert damage == 0.0
        assert 1e-3 < one.energies.elastic / other.energies.elastic - 1 < 0.01, "as the docs say"
        assert abs(drive - near) < abs(theirs - near)


@pytest.mark.slow
def test_without_a_threshold_damage_and_slope_are_resolved(tmp_path: Path) -> None:
    """AT2 has some damage everywhere; its energy is that of fine cells within .1 %."""
    case, start = (*SLAB, AT2, "temperature.severity=2.5"), 'domain.refine={coarsest="16 h"}'
    found = whole_run(refining(*case, start), tmp_path / "refined")
    expected = whole_run(refining(*case, UNIFORM), tmp_path / "uniform")
    for one, other in zip(found.steps, expected.steps, strict=True):
        cells = cells_of(found, one.fields, mean_edge_of_crossed(1 / 64))
        assert cells.alpha.max() > 0.2, "damage that counts"
        assert 0.0 < cells.alpha[cells.coarse].max() <= 0.1
        assert 0.1 * cells.slope[cells.coarse].max() <= 0.05
        assert one.mesh.cells < 14_000, "of 16,384"
        assert one.energies.total == pytest.approx(other.energies.total, rel=1e-3)
        assert not one.audit.violations


# Refining with nothing else changed.


def pulled(displacement, times, *, refine: bool = True, **more) -> Problem:
    """A bar with a weak place, pulled, on triangles."""
    sides = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="right", components={0: displacement}),
    )
    material = rock(
        ell=0.1, nu=0.0, toughness=lambda x: 1 - 0.02 * np.exp(-(((x[0] - 0.4) / 0.1) ** 2))
    )
    setup = body(
        (1.0, 0.25), 1 / 32, cells="triangle", material=material, times=tuple(times),
        sides=sides, backtracking=Backtracking(), **more,
    )  # fmt: skip
    if not refine:
        return setup
    domain = block(MPI.COMM_WORLD, size=(1.0, 0.25), h=1 / 32, cells="triangle", halvings=2)
    return refined_at_cracks(replace(setup, domain=domain, refinement=Refinement(ahead=0.1)))


HELD = (
    "cracks=[{start=[0.0,0.5],end=[0.2,0.5]}]",
    "temperature={profile='none'}",
    "supports.bottom=clamped",
    "supports.top={x=0.0,y={t=[0.0,1.0,9.0],u=[0.0,0.4,0.4]}}",
    "time={t=[1.0,2.0,3.0,4.0]}",
    "solver.backtracking=true",
    "solver.backtracking_tolerance=1e-6",
)


def test_refining_with_nothing_else_changed_returns_nowhere_and_violates_nothing() -> None:
    """A plate with a crack is held as it is, while a part after the other becomes fine."""
    setup, steps = problem(refining(*HELD)), []
    session = Session(setup, build(setup))
    try:
        for step in march_session(session):
            steps.append(step)
            edges, geometry = local_edges(session.domain), session.domain.mesh.geometry
            below = geometry.x[geometry.dofmaps[0][: len(edges)], 1].mean(axis=1) < len(steps) / 3
            wanted = Wanted.nothing(len(edges))
            wanted.edge[below] = session.domain.source.finest
            session.refine(wanted)
    finally:
        session.destroy()
    assert [step.index for step in steps] == list(range(4)), "no return"
    assert not [step.audit.violations for step in steps if step.audit.violations]
    sizes = [step.mesh.cells for step in steps]
    assert sizes[0] < sizes[1] < sizes[2] < sizes[3], sizes
    for before, step in pairwise(steps):
        change = step.energies.total - before.energies.total
        assert step.mesh.changes == 1
        assert change == pytest.approx(step.mesh.energy, abs=1e-6 * before.energies.total)
    least = min(step.mesh.energy for step in steps)
    assert least < -1e-5 * steps[0].energies.total, "ten times what would count as better"


@pytest.mark.slow
def test_a_real_return_on_a_mesh_that_was_refined_since() -> None:
    """The bar breaks by strength, and returns to where that was better, as on fine cells."""
    times = np.arange(0.2, 3.01, 0.2)
    found = [step for step, _, _ in marched(pulled(lambda x, t: t, times))]
    expected = [step for step, _, _ in marched(pulled(lambda x, t: t, times, refine=False))]
    back = [step for step in found if step.returned]
    assert back and any(step.mesh.changes for step in found)
    assert not [step.audit.violations for step in found if step.audit.violations]
    assert back[0].index == next(step for step in expected if step.returned).index
    for one, other in zip(kept(found), kept(expected), strict=True):
        assert one.energies.total == pytest.approx(other.energies.total, rel=5e-3)
    assert max(step.mesh.coarse_damage for step in kept(found)) <= 0.01

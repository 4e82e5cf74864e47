"""First guesses from a coarser mesh: what they may do and save, and that they change no result."""

from dataclasses import replace

from staffa.backend.stack import MPI

import numpy as np
import pytest

from staffa.errors import InputError, SolveError, StaffaError, StoppedError
from staffa.evolution import equilibrate
from staffa.evolution.apply_loads import change_loads
from staffa.evolution.effective_toughness import effective_gc
from staffa.evolution.march import Observers, march
from staffa.evolution.problem import Problem, Solvers, coarser
from staffa.evolution.system import build
from staffa.minimize.alternate import equilibrium
from staffa.model.domain import block
from staffa.model.fields import Transfer, linear_spaces, vertices
from staffa.model.supports import SideSupport, clamped, no_displacement
from staffa.physics.damage import LAWS
from staffa.records.step import SolverStatistics, Stop
from support.bodies import body, quench, rock, run

TIGHT = Stop(change=1e-6, residual=1e-4)


def uneven(x: np.ndarray) -> np.ndarray:
    """A toughness that favors some places, so that no round-off decides."""
    return 1 + 0.1 * np.cos(7 * x[0] + 1)


def plate(
    guess: str = "coarser",
    *,
    dT: float = 30.0,
    h: float = 0.0125,
    acceleration: str = "newton",
    **changes,
) -> Problem:
    """A plate with ell = 8 h that cracks all along its cooled face in one step."""
    material = rock(ell=0.1, toughness=uneven)
    fields = {"load": quench(dT), "times": (0.002,), "material": material, **changes}
    solvers = Solvers(guess=guess, acceleration=acceleration, stop=TIGHT)
    return replace(body((1.0, 0.5), h, **fields), solvers=solvers)


@pytest.mark.slow
def test_nucleation_takes_fewer_sweeps_and_ends_within_a_thousandth() -> None:
    (alone,), (guided,) = run(plate("none", h=0.008)), run(plate(h=0.008))
    assert alone.effort.guesses == 0 and guided.effort.guesses == 1
    assert guided.effort.coarse_sweeps > 0 and guided.audit.violations == ()
    assert guided.energies.surface > 0.5, "there must be cracks"
    assert guided.energies.total <= 1.001 * alone.energies.total
    assert guided.sweeps < 0.75 * alone.sweeps, f"{guided.sweeps} against {alone.sweeps} sweeps"


@pytest.mark.parametrize("acceleration", ["newton", "none"])
def test_same_energies_with_and_without_where_the_path_is_unique(acceleration: str) -> None:
    """The face is damaged, and nothing cracks."""
    found = {}
    for guess in ("none", "coarser"):
        problem = plate(guess, dT=6.0, times=(0.002, 0.006))
        solvers = replace(problem.solvers, acceleration=acceleration)
        found[guess] = run(replace(problem, solvers=solvers))
    expected = [step.energies.total for step in found["none"]]
    assert sum(step.effort.guesses for step in found["coarser"]) > 0
    assert found["none"][-1].energies.surface > 1e-3, "there must be damage"
    assert [s.energies.total for s in found["coarser"]] == pytest.approx(expected, rel=1e-5)


def test_a_step_that_does_not_overwhelm_the_state_makes_no_guess() -> None:
    first, second = run(plate(times=(0.002, 0.0021)))
    assert first.effort.guesses == 1
    assert second.effort.guesses == second.effort.coarse_sweeps == second.effort.refused == 0


def notched(guess: str = "coarser", pull: float = 1.5, **solvers: str) -> Problem:
    """A plate with a crack to its middle, pulled at once until the rest breaks; ell = 8 h."""
    h = 0.0125

    def cracked(x):
        across = x[1] - 0.25
        return (across > -0.1 * h) & (across < 1.1 * h) & (x[0] <= 0.25 + 1e-9)

    problem = body((0.5, 0.5), h, material=rock(ell=0.1, cracked=cracked), times=(0.1, pull))
    sides = (
        clamped(problem.domain, "bottom"),
        SideSupport(side="top", components={0: no_displacement, 1: lambda x, t: t}),
    )
    choice = Solvers(guess=guess, stop=TIGHT, **solvers)
    return replace(problem, sides=sides, solvers=choice)


@pytest.mark.slow
@pytest.mark.parametrize(
    "pull",
    [pytest.param(1.2, marks=pytest.mark.long), 1.5, pytest.param(1.8, marks=pytest.mark.long)],
)
def test_a_plate_that_has_a_crack_breaks_at_the_same_cost(pull: float) -> None:
    alone, guided = run(notched("none", pull))[-1], run(notched("coarser", pull))[-1]
    assert guided.effort.guesses == 1 and guided.audit.violations == ()
    assert guided.energies.total <= 1.001 * alone.energies.total


def test_a_crack_is_one_layer_of_broken_cells_on_the_coarser_mesh() -> None:
    """Its elasticity is that of the fine mesh but for its end, half a coarse cell off: 5 %."""
    problem = notched(pull=0.3)
    system = build(problem)
    list(march(problem, system))
    below = system.coarser
    state = system.state
    equilibrate._coarse_gain(below, state, 0.3)
    alpha = below.system.state.alpha.x.array
    cells = alpha[below.system.spaces.alpha.dofmap.list].min(axis=1) > 0.99
    assert cells.sum() == pytest.approx(0.25 / 0.025, abs=1)
    elastic = below.system.energy.energies().elastic
    assert elastic == pytest.approx(system.energy.energies().elastic, rel=0.05)
    system.destroy()


def test_a_guess_heals_nothing(monkeypatch) -> None:
    real = equilibrate._coarse_gain

    def healing(coarser, fine, *loads):
        gain, effort = real(coarser, fine, *loads)
        return gain - 2.0 * fine.alpha.x.array, effort

    monkeypatch.setattr(equilibrate, "_coarse_gain", healing)
    steps = run(notched())
    assert steps[-1].effort.guesses == 1
    assert all(step.audit.healing <= 1e-12 for step in steps)


@pytest.mark.slow
@pytest.mark.parametrize("acceleration", ["newton", "none"])
def test_a_step_that_fails_after_a_guess_is_done_without_one(acceleration, monkeypatch) -> None:
    guessed, real = [], equilibrate.descend

    def fails_after_a_guess(problem, system, *rest):
        if guessed and system.coarser:
            guessed.clear()
            raise SolveError("no")
        return real(problem, system, *rest)

    def noting(*arguments):
        found = first(*arguments)
        guessed.append(found)
        return found

    first = equilibrate._first_guess
    monkeypatch.setattr(equilibrate, "_first_guess", noting)
    monkeypatch.setattr(equilibrate, "descend", fails_after_a_guess)
    (step,) = run(plate(dT=9.0, h=0.016, acceleration=acceleration))
    assert step.effort.plain == 1 and step.effort.guesses == 0 and step.effort.halvings == 0


def test_a_coarser_mesh_whose_solver_failed_guesses_again() -> None:
    system = build(plate())
    below = system.coarser
    thermal, _ = system.coupling.advance(system.thermal.read(), system.cracks, 0.0, 0.002)
    system.thermal.put(thermal)
    expected, _ = equilibrate._coarse_gain(below, system.state, 0.002)
    for vector in (below.system.alternation.u, below.system.state.u.x.petsc_vec):
        vector.set(np.inf)
    found, _ = equilibrate._coarse_gain(below, system.state, 0.002)
    assert np.abs(expected).max() > 0.1 and found == pytest.approx(expected, abs=1e-4)
    system.destroy()


def test_a_run_can_be_stopped_within_a_guess() -> None:
    """Work on the coarser mesh is no sweep of the step."""
    problem, seen = plate(dT=9.0, h=0.016), []

    def stop() -> None:
        if len(seen) == 0 and len(asked) == 3:
            raise StoppedError("enough")
        asked.append(1)

    asked: list[int] = []
    system = build(problem)
    looks = Observers(watch=lambda moment, sweep: seen.append(sweep), pause=stop)
    with pytest.raises(StoppedError):
        list(march(problem, system, looks))
    assert not seen and len(asked) == 3
    system.destroy()


def test_a_refused_guess_leaves_displacement_and_damage() -> None:
    problem = plate(dT=9.0)
    system = build(problem)
    x = vertices(system.spaces.alpha)

    def half():
        return np.where(x[:, 1] > 0.2, 1.0, 0.0), SolverStatistics(coarse_sweeps=3)

    start = equilibrate.Loads(time=0.0, values=system.supports.values(0.0))
    equilibrium(system.alternation, start.values)
    change_loads(problem, system, start, equilibrate.Loads(time=0.002, values=start.values))
    fields = (system.state.u, system.state.alpha)
    before = [field.x.array.copy() for field in fields]
    effort = equilibrate._first_guess(system, replace(start, time=0.002), half)
    assert effort == SolverStatistics(refused=1, coarse_sweeps=3)
    for field, vector, values in zip(
        fields, (system.alternation.u, system.alternation.alpha), before, strict=True
    ):
        assert np.array_equal(field.x.array, values)
        assert vector is system.alternation.alpha or np.array_equal(vector.array_r, values)
    system.destroy()


@pytest.mark.slow
@pytest.mark.parametrize("fault", ["breaks everything", "not finite", "fails"])
def test_a_bad_guess_is_refused_and_leaves_the_state(fault: str, monkeypatch) -> None:
    def bad(coarser, fine, *loads):
        if fault == "fails":
            raise SolveError("no")
        gain = np.full_like(fine.alpha.x.array, 1.0 if fault == "breaks everything" else np.nan)
        return gain, SolverStatistics(coarse_sweeps=3)

    (expected,) = run(plate("none", dT=9.0))
    monkeypatch.setattr(equilibrate, "_coarse_gain", bad)
    (step,) = run(plate(dT=9.0))
    assert step.effort.guesses == 0
    assert step.effort.refused == expected.effort.refused + 1
    assert step.sweeps == expected.sweeps
    assert step.energies.total == pytest.approx(expected.energies.total, rel=1e-12)


def test_a_guess_is_made_where_the_coarser_mesh_resolves_ell() -> None:
    assert coarser(plate()) is not None
    assert coarser(plate("none")) is None
    assert coarser(plate(material=rock(ell=5.9 * 0.0125))) is None
    assert coarser(replace(plate(), domain=replace(plate().domain, coarser=None))) is None
    assert coarser(plate(material=rock(ell=0.6), h=0.1)) is not None, "round-off decides nothing"
    assert coarser(body((1.0, 1.0), 1.0, material=rock(ell=10.0))) is None, "one cell is the end"
    assert coarser(body((0.4, 0.4, 0.4), 0.05, material=rock(ell=0.4, state="solid"))) is None


def test_a_misspelled_guess_is_refused() -> None:
    with pytest.raises(InputError, match="no first guess 'corser'"):
        build(plate("corser"))


def test_loads_that_drive_no_damage_make_no_guess() -> None:
    """However much they raise the energy."""
    steps = run(replace(notched(pull=0.2), material=rock(ell=0.1)))
    assert steps[-1].energies.total > 1.5 * steps[-2].energies.total
    assert steps[-1].effort.guesses == steps[-1].effort.refused == 0


def test_levels_go_on_while_they_resolve_ell() -> None:
    system = build(plate(h=0.00625))
    spacings, below = [], system.coarser
    while below:
        spacings.append(below.problem.domain.h)
        below = below.system.coarser
    system.destroy()
    assert spacings == pytest.approx([0.0125, 0.025])


@pytest.mark.parametrize("law", LAWS)
def test_a_crack_costs_the_same_on_the_coarser_mesh(law: str) -> None:
    problem = plate(material=rock(ell=0.1, law=LAWS[law]))
    below = coarser(problem)
    assert below is not None
    fine, coarse = (
        p.material.Gc * effective_gc(p.material, dim=2, h=p.domain.h, cells="quadrilateral")
        for p in (problem, below)
    )
    assert coarse == pytest.approx(fine, rel=0.01), "1 + h/(4 c_w ell) holds to second order"


@pytest.mark.parametrize("cells", ["quadrilateral", "triangle"])
def test_a_linear_field_survives_the_way_down_and_up(cells: str) -> None:
    """Also where the cells of one mesh do not nest in those of the other."""
    fine = block(MPI.COMM_WORLD, size=(1.0, 0.5), h=0.03, cells=cells)
    assert fine.coarser is not None
    a, b = linear_spaces(fine).alpha, linear_spaces(fine.coarser()).alpha

    def linear(space):
        return vertices(space) @ [2.0, -3.0, 0.0] + 1

    assert Transfer(a, b, h=0.03)(linear(a)) == pytest.approx(linear(b), abs=1e-9)
    assert Transfer(b, a, h=0.06)(linear(b)) == pytest.approx(linear(a), abs=1e-9)


def test_meshes_of_two_bodies_are_not_taken_for_one() -> None:
    a, b = (
        linear_spaces(block(MPI.COMM_WORLD, size=size, h=0.1, cells="quadrilateral")).alpha
        for size in [(1.0, 0.5), (1.2, 0.5)]
    )
    with pytest.raises(StaffaError, match="not of the same body"):
        Transfer(a, b, h=0.1)

"""A load that cannot be carried any more ends a run in a sentence, never in its displacements."""

from pathlib import Path

import numpy as np
import pytest

from staffa.case.check import water_pressure
from staffa.case.reading.read import parse_case
from staffa.errors import PartedError, SolveError
from staffa.evolution.loose_parts import SHARE, loose_part, number_parts
from staffa.evolution.march import march
from staffa.evolution.problem import Problem
from staffa.evolution.system import build
from staffa.io.run_directory import open_run
from staffa.loads.forces import Forces, Traction
from staffa.model.initial_cracks import FlatCrack
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.damage import AT1, cohesive
from staffa.physics.split import SPLITS, EnergySplit
from staffa.physics.strength_surface import StrengthSurface
from staffa.records.status import Status
from staffa.runs.run import run
from support.bodies import body, rock

BAR = """
title = "A bar pulled by a dead load beyond its strength"
[domain]
size = [1.0, 0.4]
h = 0.02
[material]
E = 100.0
nu = 0.0
Gc = 1.0
[damage]
ell = 0.1
[toughness]
amplitude = 0.05
seed = 1
[temperature]
profile = "none"
[forces]
right = { x = { t = [0.0, 1.0], value = [0.0, 30.0] } }
[supports]
left = "rollers"
[time]
t = { start = 0.1, stop = 1.0, steps = 10 }
[output]
at = [1.0]
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "setting",
    [
        "",
        pytest.param("damage.residual_stiffness=1e-4", marks=pytest.mark.long),
        pytest.param("damage.split=none", marks=pytest.mark.long),
    ],
    ids=["default", "more residual stiffness", "no split"],
)
def test_a_dead_load_beyond_the_strength_ends_the_run(tmp_path: Path, setting: str) -> None:
    """Steps below the strength, sigma_c = sqrt(3 E Gc/(8 ell)) = 19.4, stand."""
    settings = ["time.t=[0.3,0.6,0.7]", "output.at=[0.7]", *filter(None, [setting])]
    with pytest.raises(PartedError, match=r"step 2 .*cannot be carried any more.*'right'") as ended:
        run(parse_case(BAR, settings), tmp_path / "run")
    assert ended.value.exit_code == 4
    left = open_run(tmp_path / "run")
    assert [step.status for step in left.steps] == ["converged", "converged"]
    last = left.unreached
    assert last is not None and last.status == "failed" and last.energies.elastic < 1
    assert "in two" in last.reason and (tmp_path / "run" / last.fields).is_file()
    assert any((tmp_path / "run" / "checkpoint").iterdir()), "it can go on, in shorter steps"


LEFT = SideSupport(side="left", components={0: no_displacement, 1: no_displacement})
SHARP = {"ell": 0.1, "Gc": 1e3, "residual_stiffness": 1e-6}


def cut_bar(**changes) -> Problem:
    """A bar that is cut through, held on its left."""

    def cut(x: np.ndarray) -> np.ndarray:
        return np.abs(x[0] - 0.525) < 0.03

    split = changes.pop("split", SPLITS["none"])
    law = cohesive(irwin=0.3, ell=SHARP["ell"]) if isinstance(split, StrengthSurface) else AT1()
    material = rock(cracked=cut, split=split, law=law, rho=1.0, **SHARP)
    fields = {"material": material, "sides": (LEFT,), "times": (1.0,)}
    return body((1.0, 0.2), 0.05, **{**fields, **changes})


def pull(sign: float) -> Forces:
    def force(x: np.ndarray, t: float) -> np.ndarray:
        return np.array([np.full(x.shape[1], sign * 1e-2 * t), np.zeros(x.shape[1])])

    return Forces(sides=(Traction(side="right", force=force),))


def ends(problem: Problem) -> str:
    """The sentence with which a march ends, empty if it does not."""
    system = build(problem)
    try:
        list(march(problem, system))
    except PartedError as error:
        return str(error)
    finally:
        system.destroy()
    return ""


STRENGTHS = [StrengthSurface(), StrengthSurface(compressive=10.0)]


@pytest.mark.parametrize(
    "split",
    [SPLITS["none"], SPLITS["no-tension"], *STRENGTHS],
    ids=["none", "no-tension", "strengths", "compressive strength"],
)
def test_a_part_that_is_pulled_off_is_told_of(split: EnergySplit) -> None:
    """With the place of it, and what pulls: issue 64 of peridigm (github.com/peridigm/peridigm)
    has such a bar, which ends in errors of the linear solver."""
    said = ends(cut_bar(split=split, forces=pull(1.0)))
    assert "around (0.775, 0.1), 48% of the body, against what acts on 'right'" in said, said


@pytest.mark.parametrize("split", STRENGTHS, ids=["strengths", "compressive strength"])
def test_strengths_have_an_energy_without_the_residual_stiffness(split: StrengthSurface) -> None:
    """A pulled crack stores less than 1 % of what it stores with it."""
    right = SideSupport(side="right", components={0: lambda x, t: 0.1 * t})
    system = build(problem := cut_bar(split=split, sides=(LEFT, right)))
    (step,) = march(problem, system)
    assert step.status is Status.CONVERGED
    with system.energy.without_residual_stiffness():
        assert 0 <= system.energy.stored() < 0.01 * step.energies.elastic
    system.destroy()


def test_what_is_no_number_holds_no_body_together() -> None:
    """It is refused where each comparison with it is False."""
    system = build(problem := cut_bar(split=STRENGTHS[0], forces=pull(1.0)))
    system.state.u.x.array[:] = np.nan
    with pytest.raises(SolveError, match="no number"):
        loose_part(problem, system)
    system.destroy()


def test_a_part_that_falls_is_told_of() -> None:
    """Plates without a support move as they like in issue 413 of idaholab/virtual_test_bed."""
    said = ends(cut_bar(forces=Forces(gravity=(0.0, -0.1))))
    assert "against its weight" in said, said


def test_a_part_that_is_pressed_on_stays_where_faces_carry() -> None:
    assert ends(cut_bar(split=SPLITS["no-tension"], forces=pull(-1.0))) == ""
    assert ends(cut_bar(split=StrengthSurface(), forces=pull(-1.0))) == ""
    assert ends(cut_bar(forces=pull(-1.0))) != "", "without a split nothing carries it"


@pytest.mark.parametrize("u", [0.1, 10.0])
def test_a_part_without_a_load_floats_free(u: float) -> None:
    """Moved by its own supports, or by none: nothing has to be carried."""
    right = SideSupport(side="right", components={0: lambda x, t: u * t})
    assert ends(cut_bar(sides=(LEFT, right))) == ""


def test_parts_are_counted() -> None:
    system = build(problem := cut_bar(forces=pull(1.0)))
    labels, number = number_parts(system.state.alpha, 0.95)
    x = system.state.alpha.function_space.tabulate_dof_coordinates()[:, 0]
    assert number == 2
    for side in (x < 0.51, x > 0.54):
        assert len(set(labels[side])) == 1 and labels[side][0] >= 0
    system.energy.external.at(1.0)
    assert loose_part(problem, system, solved=False) is not None
    system.state.alpha.x.array[:] = 1.0
    assert number_parts(system.state.alpha, 0.95)[1] == 0
    system.destroy()


def test_wide_cracks_are_no_load_that_nothing_carries() -> None:
    """Cooled between two walls, a plate that is broken through opens wide; a fluid that hardly
    presses moves nothing, though broken rock alone feels it."""

    class Cold:
        def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
            return np.full(x.shape[1], -t)

    cracks = tuple(  # three columns of cells side by side: rock between them is broken all through
        FlatCrack(center=(x, 0.25, 0.0), normal=(1.0, 0.0, 0.0), radius=1.0)
        for x in (0.4875, 0.5125, 0.5375)
    )
    walls = tuple(
        SideSupport(side=side, components={0: no_displacement}) for side in ("left", "right")
    )
    problem = body(
        (1.0, 0.5),
        0.025,
        sides=walls,
        material=rock(ell=0.1, Gc=100.0, cracks=cracks),
        load=Cold(),
        forces=Forces(crack_field=lambda x, t: 1e-9 * t * x[0]),
        times=(1.0,),
    )
    system = build(problem)
    (step,) = march(problem, system)
    assert step.status is Status.CONVERGED
    whole = system.energy.stored()
    with system.energy.without_residual_stiffness():
        assert whole > 1.01 * system.energy.stored(), "cracks must be wide"
    system.destroy()


def test_a_check_counts_what_residual_stiffness_may_carry_as_a_run_does() -> None:
    assert water_pressure.CARRIED == SHARE

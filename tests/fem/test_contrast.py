"""Stiff rock beside soft: what is called solved is in equilibrium, or its run says it is not."""

from pathlib import Path

import numpy as np
import pytest

from staffa.case.reading.read import parse_case
from staffa.evolution import audit
from staffa.evolution.march import march
from staffa.evolution.system import build
from staffa.io.run_directory import open_run
from staffa.loads.forces import Forces
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.split import SPLITS
from staffa.results.summary import summary
from staffa.runs.run import run
from support.bodies import body, rock
from support.restarting import launch

LAYERS = """
title = "Stiff and soft layers, pulled across"
[domain]
size = [0.5, 0.5, 1.0]
h = 0.0625
[material]
E = 1.0
nu = 0.0
Gc = 1e6
[regions.soft]
lower = [0.0, 0.0, 0.25]
upper = [0.5, 0.5, 0.5]
E = 1e-6
[regions.hard]
lower = [0.0, 0.0, 0.75]
upper = [0.5, 0.5, 1.0]
E = 1e4
[damage]
ell = 0.125
[temperature]
profile = "none"
[supports]
bottom = "clamped"
top = { z = { t = [0.0, 1.0], u = [0.0, 0.1] } }
[time]
t = [1.0]
[output]
at = [1.0]
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "displacement", ["iterative", pytest.param("direct", marks=pytest.mark.long)]
)
def test_layers_in_series_carry_one_force(tmp_path: Path, displacement: str) -> None:
    """A = 1/4, the soft layer 1/4 thick takes all of the stretch: 1e-6 * 0.1/(1/4)/4 = 1e-7."""
    case = parse_case(LAYERS, [f"solver.displacement={displacement}"])
    (step,) = run(case, tmp_path / "run")
    assert step.audit.violations == (), step.audit
    for side, sign in (("top", 1), ("bottom", -1)):
        assert step.reactions[side][2] == pytest.approx(sign * 1e-7, rel=1e-3)
    assert step.energies.elastic == pytest.approx(5e-9, rel=1e-3)


SOFT = 1e-8


def layered(x: np.ndarray) -> np.ndarray:
    """The modulus: a soft layer between stiff ones."""
    return np.where((x[1] > 0.2) & (x[1] < 0.4), SOFT, 1.0)


@pytest.mark.parametrize("displacement", ["iterative", "direct"])
@pytest.mark.parametrize("split", ["none", "no-tension"])
def test_what_a_soft_layer_carries_is_found(displacement: str, split: str) -> None:
    """A residual that is small beside the forces of stiff rock is not small beside those there:
    issue 192 of mkofler96/KoFEM has a solver that takes such for solved."""
    sides = (
        SideSupport(side="bottom", components={1: no_displacement}),
        SideSupport(side="top", components={1: lambda x, t: 0.1 * t}),
    )
    material = rock(E=layered, nu=0.0, Gc=1e6, ell=0.3, split=SPLITS[split])
    problem = body((0.5, 1.0), 0.1, sides=sides, material=material, displacement=displacement)
    system = build(problem)
    (step,) = march(problem, system)
    assert step.audit.violations == ()
    assert step.reactions["top"][1] == pytest.approx(SOFT * 0.1 / 0.2 * 0.5, rel=1e-3)
    assert step.reactions["bottom"][1] == pytest.approx(-step.reactions["top"][1], rel=1e-3)
    system.destroy()


@pytest.mark.parametrize("displacement", ["iterative", "direct"])
def test_a_weight_does_not_hide_what_else_acts(displacement: str) -> None:
    """With a weight of a million times the pull, which the supports carry: a right-hand side that
    is large made ASPECT's solver stop too early (geodynamics/aspect, pull request 109)."""
    pulled = SideSupport(side="right", components={0: lambda x, t: 1e-6 * t})
    sides = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="bottom", components={1: no_displacement}),
        SideSupport(side="top", components={1: no_displacement}),
        pulled,
    )
    material = rock(nu=0.0, Gc=1e9, ell=0.3, rho=1.0)
    options = {"sides": sides, "material": material, "displacement": displacement}
    system = build(problem := body((1.0, 0.5), 0.1, forces=Forces(gravity=(0.0, -1.0)), **options))
    (step,) = march(problem, system)
    assert step.audit.violations == ()
    # Of the weight, 1e-8 may be left; the pull is 1e-6 of it.
    assert step.reactions["right"][0] == pytest.approx(0.5e-6, rel=1e-3)
    system.destroy()


VIOLATED = """
import sys
from staffa.evolution import audit
from staffa.cli.commands import main
audit.GAP_ALLOWED = audit.HEALING_ALLOWED = -1.0
main()
"""


@pytest.mark.slow
@pytest.mark.parametrize("command", ["run", pytest.param("ensemble", marks=pytest.mark.long)])
def test_a_violated_audit_has_an_exit_code_of_its_own(tmp_path: Path, command: str) -> None:
    """It is told of on the terminal, also with --quiet, and in red on the page."""
    text = LAYERS.replace("0.0625", "0.25").replace(
        "ell = 0.125", "ell = 0.25\nallow_coarse = true"
    )
    text += "[toughness]\namplitude = 0.01\n"
    (tmp_path / "my.toml").write_text(text)
    out = tmp_path / "out"
    more = ["--seeds", "2"] if command == "ensemble" else []
    given = [command, tmp_path / "my.toml", "--out", out, "--quiet", *more]
    done = launch("python", "-c", VIOLATED, *given)
    assert done.returncode == 5, done
    assert "staffa: step 0, audit: irreversibility is violated by" in done.stderr
    assert "is finished, but its audit is violated: step 0: " in done.stderr
    place = out if command == "run" else out / "seed-0"
    facts = {fact.name: fact for fact in summary(open_run(place))}
    assert facts["status"].alarm and facts["violation"].alarm
    assert "but the audit is violated" in facts["status"].text
    assert audit.GAP_ALLOWED > 0


def test_help_tells_the_exit_codes() -> None:
    done = launch("staffa", "run", "--help")
    assert "5 finished" in " ".join(done.stdout.split()), done.stdout

"""staffa with its defaults on a case of the yardstick, started from any state."""

from dataclasses import asdict, replace

from staffa.backend.stack import MPI

import numpy as np

from bench.common.cases import BenchCase
from staffa.evolution.advance import advance_to
from staffa.evolution.equilibrate import Loads, settle
from staffa.evolution.problem import Material, Problem, Solvers
from staffa.evolution.schedule import schedule
from staffa.evolution.system import build
from staffa.loads.closed_form import Load, NoLoad
from staffa.minimize.alternate import equilibrium
from staffa.model.domain import Domain, block
from staffa.model.supports import SideSupport, clamped, rollers
from staffa.physics.damage import AT1, AT2
from staffa.records.step import Stop


class Cooled:
    """The case's temperature as a load of staffa's."""

    def __init__(self, case: BenchCase) -> None:
        self.case = case

    def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
        """See `staffa.loads.closed_form.Load`; t is tau."""
        return self.case.temperature(x, t)


def mesh(case: BenchCase, comm: MPI.Comm) -> Domain:
    """The script's mesh. Collective."""
    cells = "quadrilateral" if case.dim == 2 else "hexahedron"
    return block(comm, size=case.size, h=case.h, cells=cells)


def problem(case: BenchCase, domain: Domain, **presets: str) -> Problem:
    """The case on a mesh as staffa's own objects; presets: names for `Solvers`. Collective."""
    load: Load = Cooled(case) if case.severity else NoLoad()
    return Problem(
        domain=domain,
        material=Material(
            E=1.0,
            nu=case.nu,
            Gc=1.0,
            expansion=1.0,
            ell=case.ell,
            law=AT1() if case.law == "AT1" else AT2(),
            state=case.state,
            residual_stiffness=case.residual_stiffness,
            toughness=case.toughness,
            cracked=case.cracked,
        ),
        load=load,
        schedule=schedule(case.times),
        sides=_sides(case, domain),
        anchor="top",
        solvers=replace(
            Solvers(
                displacement="direct" if case.dim == 2 else "iterative",
                stop=Stop(change=case.tolerance),
            ),
            **presets,
        ),
    )


def _sides(case: BenchCase, domain: Domain) -> tuple[SideSupport, ...]:
    if case.severity:
        names = ("left", "right") if case.dim == 2 else ("left", "right", "front", "back")
        return tuple(rollers(domain, name) for name in names)
    pulled = SideSupport(side="top", components={0: lambda x, t: 0.0, 1: lambda x, t: t})
    return (clamped(domain, "bottom"), pulled)


class Ours:
    """One built system; `put` a state, then `step` from it. Collective."""

    def __init__(self, case: BenchCase, comm: MPI.Comm, **presets: str) -> None:
        self.problem = problem(case, mesh(case, comm), **presets)
        self.system = build(self.problem)
        self.loads = self._loads(None)

    def _loads(self, time: float | None) -> Loads:
        values = self.system.supports.values(time or 0.0)
        return Loads(time=time or 0.0, values=values if time else np.zeros(len(values)))

    def put_at_rest(self) -> None:
        """Start from the very start."""
        self.loads = self._loads(None)
        equilibrium(self.system.alternation, self.loads.values)

    def put(self, state: dict[str, np.ndarray], time: float | None) -> None:
        """Start from a state reached at a time, or from the very start at None."""
        ours, parts = self.system.state, self.system.alternation
        if not np.allclose(state["x"], ours.T.function_space.tabulate_dof_coordinates().T):
            raise RuntimeError("the two sides number the vertices differently")
        ours.u.x.array[:], ours.alpha.x.array[:] = state["u"], state["alpha"]
        if time is not None:
            x = ours.T.function_space.tabulate_dof_coordinates().T
            ours.T.x.array[:] = self.problem.load.temperature(x, time)
        self.loads = self._loads(time)
        equilibrium(parts, self.loads.values)

    def fields(self) -> dict[str, np.ndarray]:
        """Return a copy of the state, as `put` takes it."""
        state = self.system.state
        u, alpha = state.u.x.array.copy(), state.alpha.x.array.copy()
        return {"u": u, "alpha": alpha, "x": state.T.function_space.tabulate_dof_coordinates().T}

    def step(self, time: float) -> dict:
        """Put on the loads of a time and minimize."""
        loads = self._loads(time)
        outcome = advance_to(self.problem, self.system, self.loads, loads).outcome
        self.loads = loads
        if not outcome.converged:
            raise RuntimeError(outcome.reason)
        effort = asdict(outcome.effort)
        return {"sweeps": outcome.sweeps, "energy": lambda: outcome.energies.total, **effort}

    def basin(self, state: dict[str, np.ndarray], time: float, damage: np.ndarray) -> dict:
        """Minimize at a time from some damage, above that of a state; energy and sweeps."""
        self.put(state, time)
        outcome, _ = settle(self.problem, self.system, self.loads, damage=damage)
        return {"energy": outcome.energies.total, "sweeps_to_it": outcome.sweeps}

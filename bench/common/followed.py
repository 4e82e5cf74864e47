"""staffa on a mesh that follows the cracks, started from any state on the script's mesh."""

from dataclasses import asdict, replace

from staffa.backend.stack import MPI

import numpy as np
from dolfinx import fem

from bench.common.cases import BenchCase
from bench.common.ours import mesh, problem
from staffa.evolution.equilibrate import BROKEN
from staffa.evolution.march import Observers, march_session
from staffa.evolution.problem import Problem, Refinement
from staffa.evolution.resolution import TooCoarseError
from staffa.evolution.restart_state import Loop
from staffa.evolution.schedule import AdaptiveSteps
from staffa.evolution.session import Session
from staffa.evolution.system import build
from staffa.minimize.alternate import equilibrium
from staffa.model.domain import block, cell_count
from staffa.model.fields import Transfer, corners
from staffa.records.step import Moment, Step

# Distance around damage within which cells are the finest, in ell: the default of a case.
AHEAD = 2.0


class Damage:
    """The way of the damage from one mesh to another of the same body. Collective.

    Values are interpolated at vertices. A crack is a layer of broken cells, which that may miss: a
    cell breaks if the damage in its center says so, as in a first guess from a coarser mesh.
    """

    def __init__(self, source: fem.FunctionSpace, target: fem.FunctionSpace, *, h: float) -> None:
        """Relate two spaces of linear scalars; h: mesh size of the source (m)."""
        self._target = target
        centers = fem.functionspace(target.mesh, ("Discontinuous Lagrange", 0))
        self._at_vertices = Transfer(source, target, h=h)
        self._at_centers = Transfer(source, centers, h=h)

    def __call__(self, values: np.ndarray) -> np.ndarray:
        """Return the damage at the target's vertices, ghosts included."""
        topology = self._target.mesh.topology
        own = topology.index_map(topology.dim).size_local
        found = np.clip(self._at_vertices(values), 0.0, 1.0)
        broken = np.flatnonzero(self._at_centers(values)[:own] >= BROKEN)
        found[corners(self._target, broken)] = 1.0
        return found


def followed_problem(case: BenchCase, comm: MPI.Comm) -> Problem:
    """The case on a coarse mesh of simplices that is to be refined. Collective."""
    cells = "triangle" if case.dim == 2 else "tetrahedron"
    domain = block(comm, size=case.size, h=case.longest, cells=cells, halvings=case.halvings)
    return replace(
        problem(case, domain),
        refinement=Refinement(ahead=AHEAD * case.ell),
        second_order=None,  # as in `ours.Ours`, which only minimizes
    )


class Followed:
    """A session whose mesh follows the cracks; `put` a state, then `step` from it. Collective."""

    def __init__(self, case: BenchCase, comm: MPI.Comm) -> None:
        """Build the case on its coarse mesh."""
        self.case, self.theirs = case, fem.functionspace(mesh(case, comm).mesh, ("Lagrange", 1))
        whole = followed_problem(case, comm)
        self.session, self.sweeps = Session(whole, build(whole)), 0
        # Compiled before the first step, as all other forms of all sides are.
        assert self.session.system.pressed_growth
        self.time: float | None = None

    def put(self, state: dict[str, np.ndarray], time: float | None) -> None:
        """Take over a state reached at a time, or that of the very start at None.

        The mesh is refined where it is too coarse for that state.
        """
        if not np.allclose(state["x"], self.theirs.tabulate_dof_coordinates().T):
            raise RuntimeError("the two sides number the vertices differently")
        self.time = time
        while True:
            self._take_over(state["alpha"])
            try:
                resolution = self.session.system.resolution
                assert resolution is not None
                resolution.require()
                return
            except TooCoarseError as error:
                self.session.refine(error.wanted)

    def _take_over(self, damage: np.ndarray) -> None:
        """Interpolate damage of the script's mesh to the present one, and find equilibrium."""
        system, time = self.session.system, self.time
        state, space = system.state, system.spaces.alpha
        state.alpha.x.array[:] = Damage(self.theirs, space, h=self.case.h)(damage)
        values = np.zeros(len(system.supports.fixed))
        if time is not None:
            x = space.tabulate_dof_coordinates().T
            state.T.x.array[:] = self.session.problem.load.temperature(x, time)
            values = system.supports.values(time)
        equilibrium(system.alternation, values)

    def step(self, time: float) -> dict:
        """Take the next step as the time loop does, on a mesh that becomes fine enough for it."""
        session, self.sweeps = self.session, 0
        walk = AdaptiveSteps(session.problem.schedule, self.time)
        total = session.system.energy.total()
        loop = Loop(session=session, walk=walk, total=total, changes=session.changes)
        found = next(
            march_session(
                session, Observers(measure=no_measures, watch=self._count), loop.restart()
            )
        )
        if found.time != time or found.status != "converged" or found.mesh is None:
            raise RuntimeError(f"step to {time}: {found}")
        return self._record(found)

    def _count(self, moment: Moment, sweep: object) -> None:
        self.sweeps += 1

    def _record(self, step: Step) -> dict:
        """Return the record of a step."""
        assert step.mesh is not None
        return {
            "sweeps": step.sweeps,
            "sweeps_of_all_tries": self.sweeps,
            "wall_s_without_audit": step.seconds,
            "changes_of_mesh": step.mesh.changes,
            "cells": step.mesh.cells,
            "unknowns": self.case.dim * step.mesh.vertices,
            "coarse_damage": step.mesh.coarse_damage,
            "energy": lambda: step.energies.total,
            **asdict(step.effort),
        }

    def damage(self) -> np.ndarray:
        """Return the damage at the vertices of the script's mesh."""
        alpha = self.session.state.alpha
        way = Damage(alpha.function_space, self.theirs, h=self.session.domain.h)
        return way(alpha.x.array)

    def mesh_facts(self) -> dict:
        """Return edges and cells of the meshes."""
        domain, case = self.session.domain, self.case
        return {
            "h": case.h,
            "longest_h": case.longest,
            "finest_h": domain.h,
            "coarsest_h": 2**case.halvings * domain.h,
            "edge_halvings": case.halvings,
            "cells": cell_count(domain),
        }


def no_measures(session: Session, moment: Moment) -> None:
    """Measure nothing: the script does not either."""

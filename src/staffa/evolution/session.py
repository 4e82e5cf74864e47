"""Owner of all that is built for one mesh, under the time loop: other meshes can take its place."""

from collections.abc import Callable, Hashable
from dataclasses import replace
from functools import partial
from typing import Any

from staffa.backend.stack import MPI

import numpy as np
import ufl
from dolfinx import fem

from staffa.backend import jit
from staffa.evolution.backtrack import StepHistory
from staffa.evolution.carry import Across, Lift, carried, interpolation
from staffa.evolution.circulated import Circulated
from staffa.evolution.effective_toughness import effective_gc_ratio
from staffa.evolution.problem import Problem
from staffa.evolution.system import System, build
from staffa.geometry.simplices import Simplices
from staffa.model.domain import Domain, finer
from staffa.model.fields import State, at_vertices, owned
from staffa.model.quadrature import cell_middle
from staffa.model.refinement import Wanted, refined


class Session:
    """The problem and the system on the current mesh, and every tool built for them.

    The time loop and its observers hold the session alone, and ask it at each step for what they
    need. So `replace` can change the mesh between two steps.

    Attributes
    ----------
    problem : body, rock and loads, with the current mesh.
    system : forms, matrices, solvers and the state, on the current mesh.
    history : earlier states, on the current mesh; None without backtracking.
    changes : number of times that the mesh was changed.
    """

    def __init__(
        self, problem: Problem, system: System, *, toughness_factor: float | None = None
    ) -> None:
        """Take ownership of the system.

        Parameters
        ----------
        problem : problem whose mesh comes first.
        system : system of that problem, which the session frees.
        toughness_factor : effective Gc over Gc on these cells; None: it is measured.
        """
        self.problem, self.system = problem, system
        self.history: StepHistory | None = None
        self.changes = 0
        self._toughness_factor = toughness_factor
        self._tools: dict[tuple[Hashable, ...], Any] = {}

    @property
    def comm(self) -> MPI.Comm:
        """Ranks that share the mesh."""
        return self.problem.domain.comm

    @property
    def domain(self) -> Domain:
        """Current mesh with its named sides."""
        return self.problem.domain

    @property
    def state(self) -> State:
        """Displacement, damage and temperature on the current mesh."""
        return self.system.state

    @property
    def circulated(self) -> Circulated | None:
        """Coupling to a reservoir simulator; None without one."""
        coupling = self.system.coupling
        return coupling if isinstance(coupling, Circulated) else None

    @property
    def toughness_factor(self) -> float:
        """Effective Gc over Gc on the current cells. Collective."""
        if self._toughness_factor is None:
            self._toughness_factor = effective_gc_ratio(self.problem)
        return self._toughness_factor

    def tool[T](self, make: Callable[..., T], *arguments: Hashable) -> T:
        """Return what ``make(session, *arguments)`` builds, built once for each mesh.

        Collective where `make` is. A tool with a method `destroy` is freed with its mesh.

        Parameters
        ----------
        make : function by which the tool is found again, so that it must not be a new lambda.
        arguments : further arguments of `make`.
        """
        key = (make, *arguments)
        if key not in self._tools:
            self._tools[key] = make(self, *arguments)
        found: T = self._tools[key]
        return found

    def vertex_values(self, field: fem.Function) -> np.ndarray:
        """Return a field at the vertices that this rank owns.

        Parameters
        ----------
        field : damage or temperature, or the displacement (m) on any nodes.

        Returns
        -------
        np.ndarray
            Shape (n,) of a scalar, (n, 3) of a displacement.
        """
        if field is not self.state.u:
            return owned(field).copy()
        u = at_vertices(field, self.system.spaces)
        return np.pad(u, ((0, 0), (0, 3 - u.shape[1])))

    def cell_values(self, value: ufl.core.expr.Expr) -> np.ndarray:
        """Return an expression in the middle of each cell that this rank owns. Collective.

        Parameters
        ----------
        value : scalar, or tensor of 2 x 2 or 3 x 3 components.

        Returns
        -------
        np.ndarray
            Shape (n,) of a scalar, (n, 9) of a tensor; components across a plane are 0.
        """
        mesh = self.domain.mesh
        cells = np.arange(mesh.topology.index_map(mesh.topology.dim).size_local, dtype=np.int32)
        found = self.tool(_in_the_middle, value).eval(mesh, cells)
        if not value.ufl_shape:
            return np.asarray(found).reshape(len(cells))
        size = value.ufl_shape[0]
        tensor = np.zeros((len(cells), 3, 3))
        tensor[:, :size, :size] = found.reshape(len(cells), size, size)
        return tensor.reshape(-1, 9)

    def refine(self, wanted: Wanted, damage: np.ndarray | None = None) -> np.ndarray | None:
        """Split cells, and put the finer mesh in place of the current one. Collective.

        The state and earlier states are carried over exactly. Between two steps alone.

        Parameters
        ----------
        wanted : what the cells that this rank owns should become.
        damage : another damage to carry over, ghosts included, shape (n_local,); None for none.

        Returns
        -------
        np.ndarray | None
            That damage on the finer mesh.
        """
        rules, before, factor = self.problem.refinement, self.domain, self._toughness_factor
        assert rules is not None
        domain, nested = refined(before, wanted, ahead=rules.ahead)
        problem, lift = replace(self.problem, domain=domain), Lift(before, nested)
        new = carried(self.system, problem, lift)
        lifted = None if damage is None else lift(self.state.alpha, new.state.alpha, damage)
        self.replace(problem, new, lift)
        self._toughness_factor = factor  # of the finest cells, which are those of before
        return lifted

    def take_up(self, whole: Simplices | None) -> None:
        """Put a finer mesh in place of the first one, with the state that it starts with.
        Collective.

        Parameters
        ----------
        whole : the finer mesh, on rank 0; None elsewhere.
        """
        problem = replace(self.problem, domain=finer(self.domain, whole))
        factor = self._toughness_factor
        self.replace(problem, build(problem))
        self._toughness_factor = factor

    def replace(self, problem: Problem, system: System, across: Across | None = None) -> None:
        """Put another mesh in place of the current one, whose system and tools are freed.

        Between two steps alone. The new state is the caller's, see `interpolated`; earlier states
        are carried over here. Collective.

        Parameters
        ----------
        problem : the same problem on the other mesh of the same body.
        system : its system, which holds the state that the next step begins with.
        across : the way from the current mesh to the other; None to interpolate.
        """
        if self.history:
            way = across or interpolation(self.domain.h)
            at_vertices = partial(way, self.state.alpha, system.state.alpha)
            self.history.move(at_vertices, system.supports.values)
        self.destroy()
        self.problem, self.system = problem, system
        self._toughness_factor = None
        self.changes += 1

    def destroy(self) -> None:
        """Free the system and the tools of the current mesh. Collective."""
        for tool in self._tools.values():
            if hasattr(tool, "destroy"):
                tool.destroy()
        self._tools.clear()
        self.system.destroy()


def _in_the_middle(session: Session, value: ufl.core.expr.Expr) -> fem.Expression:
    return jit.expression(value, cell_middle(session.domain.mesh), session.comm)


def interpolated(session: Session, problem: Problem) -> System:
    """Build a problem on another mesh of the same body, with the state interpolated. Collective.

    Parameters
    ----------
    session : its state is read, and stays as it is.
    problem : the problem on the other mesh.

    Returns
    -------
    System
        For `Session.replace`.
    """
    return carried(session.system, problem, interpolation(session.domain.h))

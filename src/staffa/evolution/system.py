"""System of a problem: forms, matrices and solvers, built once and used at every step."""

from dataclasses import dataclass
from functools import cached_property

from staffa.backend.stack import PETSc

import numpy as np
from dolfinx import fem

from staffa.arguments import require
from staffa.backend.petsc_options import ACCELERATION, DAMAGE, DISPLACEMENT, NEWTON
from staffa.evolution.coefficients import energy_of
from staffa.evolution.coupling import Cracks, ThermalCoupling, ThermalFields, coupling_of
from staffa.evolution.pressed_growth import PressedGrowth
from staffa.evolution.problem import Problem, coarser
from staffa.evolution.resolution import Resolution
from staffa.measure.hoop import Hoop
from staffa.minimize.alternate import Alternation
from staffa.minimize.bounded import SOLVERS, BoundedEnergy, BoundedSolver
from staffa.minimize.convex import ConvexEnergy, LinearCondition
from staffa.minimize.coupled import CoupledModel, Coupling
from staffa.minimize.elastic import ElasticSolver, QuadraticEnergy
from staffa.minimize.newton import CoupledNewton
from staffa.model.energy import Energy
from staffa.model.fields import (
    Bounds,
    Spaces,
    State,
    Transfer,
    corners,
    spaces_on,
    unit_bounds,
    vertices,
    write_vector,
    zero_state,
)
from staffa.model.initial_cracks import broken
from staffa.model.supports import Supports, build_supports, rigid_modes

# Tolerance of the damage's minimization over that of the whole problem.
INNER = 1e-2


@dataclass(frozen=True, kw_only=True)
class Coarser:
    """Problem on cells twice as long, and the transfer of values between both meshes.

    Attributes
    ----------
    problem, system : the problem on that mesh, and its system.
    down : from the vertices to those of the coarser mesh.
    middles : from the vertices to the cell centers of the coarser mesh.
    up : from the vertices of the coarser mesh back.
    """

    problem: Problem
    system: "System"
    down: Transfer
    middles: Transfer
    up: Transfer


@dataclass(frozen=True, kw_only=True)
class System:
    """Objects on which `march` works; it owns them, and `destroy` frees them.

    Attributes
    ----------
    spaces : function spaces.
    state : the fields.
    bounds : bounds of the damage.
    energy : the energy.
    supports : degrees of freedom that are not free.
    coupling : source of the temperature.
    thermal : thermal state that the body has now.
    alternation : both halves of the minimization.
    coarser : system for first guesses; None without.
    tried : damage that a try of this step on coarser cells came to, ghosts included, shape
        (n_local,); None without.
    hoop : share of damage that hoop tension drives; None but for a body of revolution.
    resolution : test whether the mesh is fine enough; None for a mesh that stays as it is.
    """

    spaces: Spaces
    state: State
    bounds: Bounds
    energy: Energy
    supports: Supports
    coupling: ThermalCoupling
    thermal: ThermalFields
    alternation: Alternation
    coarser: Coarser | None
    tried: np.ndarray | None = None
    hoop: Hoop | None = None
    resolution: Resolution | None = None

    @cached_property
    def pressed_growth(self) -> PressedGrowth:
        """Growth of damage in compression. Collective at its first use."""
        return PressedGrowth(self.energy)

    @property
    def cracks(self) -> Cracks:
        """The cracks as they are, for the coupling; a view."""
        return Cracks(
            alpha=self.state.alpha.x.array,
            u=self.state.u.x.array,
            volumes=lambda: self.energy.openings.volumes(),
        )

    def require_fine(self) -> None:
        """Require that a mesh that may be refined is fine enough for the state. Collective.

        Raises
        ------
        TooCoarseError
            Cells must be split.
        """
        if self.resolution:
            self.resolution.require()

    def begin(self) -> None:
        """Start a time step with the solvers that were asked for."""
        self.alternation.elastic.linear.begin()
        if self.coarser:
            self.coarser.system.begin()

    def destroy(self) -> None:
        """Free the PETSc objects."""
        if self.coarser:
            self.coarser.system.destroy()
        if self.resolution:
            self.resolution.destroy()
        self.coupling.destroy()
        parts = self.alternation
        parts.elastic.destroy()
        for solver in parts.bounded:
            solver.destroy()
        if parts.newton:
            parts.newton.destroy()
        if parts.model:
            parts.model.destroy()
        for thing in (parts.damage.matrix, parts.damage.unit):
            thing.destroy()
        for vector in (parts.u, parts.alpha, parts.before, parts.work):
            vector.destroy()


def build(problem: Problem) -> System:
    """Compile, allocate, and set up the system of a problem. Collective."""
    require(problem, Problem, "problem", "give a Problem, as staffa.problem(case) makes one")
    domain = problem.domain
    spaces = spaces_on(domain, problem.elements)
    state, bounds = zero_state(spaces), unit_bounds(spaces)
    _start_cracked(problem, state, bounds)
    coupling = coupling_of(problem.load, domain, spaces)
    thermal = ThermalFields(state, coupling.start())
    energy = energy_of(problem, spaces, state)
    supports = build_supports(
        domain, spaces, problem.sides, section=problem.section, anchor=problem.anchor
    )
    alternation = _alternation(problem, spaces, state, energy, supports)
    return System(
        spaces=spaces,
        state=state,
        bounds=bounds,
        energy=energy,
        supports=supports,
        coupling=coupling,
        thermal=thermal,
        alternation=alternation,
        coarser=_coarser(problem, spaces, energy.external.p_at_rest.x.array),
        hoop=Hoop(domain, energy) if domain.axial else None,
        resolution=Resolution(problem, state, alternation.damage) if problem.refinement else None,
    )


def _coarser(problem: Problem, spaces: Spaces, at_rest: np.ndarray) -> Coarser | None:
    """Return the system for first guesses; `at_rest` is the pressure (Pa) before the first step."""
    below = coarser(problem)
    if below is None:
        return None
    system = build(below)
    fine, coarse = spaces.alpha, system.spaces.alpha
    down = Transfer(fine, coarse, h=problem.domain.h)
    rest = system.energy.external.p_at_rest
    rest.x.array[:] = down(at_rest)
    return Coarser(
        problem=below,
        system=system,
        down=down,
        middles=Transfer(fine, system.spaces.cell, h=problem.domain.h),
        up=Transfer(coarse, fine, h=below.domain.h),
    )


def _start_cracked(problem: Problem, state: State, bounds: Bounds) -> None:
    cracked = initially_broken(problem, state.alpha.function_space)
    state.alpha.x.array[cracked] = 1.0
    bounds.lower.x.array[cracked] = 1.0


def initially_broken(problem: Problem, space: fem.FunctionSpace) -> np.ndarray:
    """Mark the vertices of initial cracks, ghosts included, shape (n_local,). Collective.

    Parameters
    ----------
    problem : the problem.
    space : linear scalars on its mesh.
    """
    material = problem.material
    cracked = material.cracked(vertices(space).T)
    for crack in material.cracks:
        cracked |= broken(space, crack, h=problem.domain.h)
    for layer in problem.domain.cracks.values():
        cracked |= corners(space, layer)
    return np.asarray(cracked)


def bounded_energy(energy: Energy) -> BoundedEnergy:
    """Return the energy as a function of the damage. The caller owns its matrix and vector."""
    matrix = energy.new_hessian()
    unit = matrix.createVecRight()
    energy.resistance(unit)
    return BoundedEnergy(
        move_to=lambda x: write_vector(x, energy.state.alpha),
        value=energy.total,
        gradient=energy.gradient,
        hessian=energy.hessian,
        matrix=matrix,
        unit=unit,
        quadratic=energy.quadratic,
    )


def bounded_solver(
    name: str, damage: BoundedEnergy, tolerance: float, *, of: str = "alpha"
) -> BoundedSolver:
    """Return a solver of the damage. The caller destroys it.

    Parameters
    ----------
    name : name of its preset.
    damage : the energy.
    tolerance : 2-norm of the projected gradient, over the smallest entry of its scale.
    of : start of its option prefix.
    """
    return SOLVERS[name](damage, tolerance=tolerance, preset=DAMAGE[name], prefix=f"{of}_{name}_")


def _alternation(
    problem: Problem, spaces: Spaces, state: State, energy: Energy, supports: Supports
) -> Alternation:
    solvers = problem.solvers
    n_owned = spaces.u.dofmap.index_map.size_local * problem.domain.dim
    matrix = energy.new_stiffness()
    u = matrix.createVecRight()
    convex = _convex(energy, matrix, max(problem.domain.size))
    linear = QuadraticEnergy(matrix=matrix, stiffness=energy.stiffness, load=energy.load)
    elastic = ElasticSolver(
        convex.model(u) if convex else linear,
        fixed=supports.fixed,
        moved=supports.moved,
        modes=supports.modes,
        near_null=rigid_modes(problem.domain, spaces)[:n_owned],
        preset=DISPLACEMENT[solvers.displacement],
        prefix=f"u_{solvers.displacement}_",
    )
    damage = bounded_energy(energy)
    order = sorted(SOLVERS, key=lambda name: name != solvers.damage)
    tolerance = INNER * solvers.stop.residual
    held = _held(energy)
    # A move at a given pressure changes the volume.
    model = None if held else _model(energy, elastic, damage)
    newton = CoupledNewton(model) if model and ACCELERATION[solvers.acceleration] else None
    return Alternation(
        elastic=elastic,
        damage=damage,
        bounded=[bounded_solver(name, damage, tolerance) for name in order],
        newton=newton,
        model=model,
        convex=convex,
        held=held,
        energies=energy.energies,
        keep_u=lambda u: write_vector(u, state.u),
        forces=energy.residual,
        u=u,
        alpha=damage.unit.duplicate(),
        before=damage.unit.duplicate(),
        work=damage.unit.duplicate(),
    )


def _convex(energy: Energy, matrix: PETSc.Mat, length: float) -> ConvexEnergy | None:
    """Return the energy of the displacement; None if the problem is linear; `length` in m."""
    if energy.linear and not energy.external.controlled:
        return None
    return ConvexEnergy(
        matrix=matrix,
        move_to=lambda u: write_vector(u, energy.state.u),
        stored=energy.stored,
        forces=energy.residual,
        stiffness=energy.stiffness,
        quadratic=energy.linear,
        length=length,
    )


def _held(energy: Energy) -> LinearCondition | None:
    external = energy.external
    if not external.controlled:
        return None

    def press(pressure: float) -> None:
        external.pressure.value = pressure

    return LinearCondition(
        widening=energy.widening,
        offset=energy.crack_swelling,
        target=lambda: external.volume,
        pressure=lambda: float(external.pressure.value),
        press=press,
    )


def _model(energy: Energy, elastic: ElasticSolver, damage: BoundedEnergy) -> CoupledModel:
    coupling = Coupling(forces=energy.residual, mixed=energy.mixed, matrix=energy.new_mixed())
    return CoupledModel(elastic, damage, coupling, preset=NEWTON, prefix="alpha_newton_")

"""Records of steps, read off the state that they leave."""

from staffa.backend.vectors import readable
from staffa.evolution.advanced_step import Advance
from staffa.evolution.observers import Observers
from staffa.evolution.restart_state import Loop
from staffa.evolution.session import Session
from staffa.evolution.system import System
from staffa.measure.reactions import reactions
from staffa.model.domain import cell_count
from staffa.records.status import Status
from staffa.records.step import Audit, Moment, RefinedMesh, Stability, Step


def accepted(
    session: Session,
    moment: Moment,
    observers: Observers,
    advance: Advance,
    audited: Audit,
    stability: Stability | None,
    seconds: float,
) -> Step:
    """Return the record of a kept step, converged or not, after measuring and saving its state.

    Parameters
    ----------
    session : holds the state.
    moment : index and time of the step.
    observers : functions called at each step.
    advance : how the state was reached.
    audited : checks of the step.
    stability : its second-order test; None without.
    seconds : computing time.
    """
    outcome = advance.outcome
    quantities = observers.quantities(session)  # first: where one is none, nothing is written
    fields = observers.save(session, moment, outcome.converged)
    return Step(
        **vars(moment),
        energies=outcome.energies,
        sweeps=outcome.sweeps,
        status=outcome.status,
        reason=outcome.reason,
        audit=audited,
        measures=observers.measure(session, moment),
        effort=outcome.effort,
        fields=fields,
        released=observers.release(session) if fields and outcome.converged else (),
        seconds=seconds,
        returned=advance.returned,
        stability=stability,
        curvature=advance.curvature,
        heat=advance.all_heat,
        reactions=_reactions(session.system),
        probed=observers.probe(session),
        quantities=quantities,
    )


def mesh_record(session: Session, loop: Loop) -> RefinedMesh:
    """Return the record of a mesh that follows the cracks. Collective.

    Parameters
    ----------
    session : holds the mesh and the state on it.
    loop : knows what changed since the step before.
    """
    assert session.system.resolution is not None
    vertices = session.domain.mesh.topology.index_map(0)
    return RefinedMesh(
        cells=cell_count(session.domain),
        vertices=vertices.size_global,
        changes=loop.finer.changes,
        energy=loop.finer.energy,
        coarse_damage=session.system.resolution.worst(),
    )


def _reactions(system: System) -> dict[str, tuple[float, ...]]:
    """Return the reactions of the supports. Collective."""
    forces = system.alternation.u.duplicate()
    system.energy.residual(forces)
    mesh = system.state.u.function_space.mesh
    found = reactions(mesh.comm, system.supports, readable(forces), dim=mesh.geometry.dim)
    forces.destroy()
    return found


def failed(session: Session, moment: Moment, observers: Observers, reason: str) -> Step:
    """Return the record of a step in which all solvers failed, after saving the state before it.

    Parameters
    ----------
    session : holds the state before the step.
    moment : index and time of the step.
    observers : functions called at each step.
    reason : why it failed.
    """
    return Step(
        **vars(moment),
        energies=session.system.energy.energies(),
        sweeps=0,
        status=Status.FAILED,
        reason=reason,
        fields=observers.save(session, moment, False),
    )

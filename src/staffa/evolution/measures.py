"""Measures of a problem's states, with settings from the problem."""

from collections.abc import Callable

import numpy as np

from staffa.backend.parallel import gather, on_root
from staffa.evolution.session import Session
from staffa.measure.coarse import local
from staffa.measure.crack import Gauge, measures, planes
from staffa.measure.energy_release import EnergyRelease, body_surface
from staffa.measure.fronts import Front, fronts
from staffa.measure.starting_faces import cooled_faces
from staffa.measure.tip import damage_at_tip, falls
from staffa.measure.tracing import network
from staffa.model.fields import owned
from staffa.records.step import Measures, Moment
from staffa.records.tip_release import Release


def measured(
    session: Session, moment: Moment | None = None, before: Measures | None = None
) -> Measures:
    """Return the measures of the session's state. Collective.

    Parameters
    ----------
    session : holds the state.
    moment : index and time of its step, which nothing here depends on.
    before : measures of the step before; None without one.
    """
    return session.tool(measuring)(before)


def measuring(session: Session) -> Callable[[Measures | None], Measures]:
    """Return the function that measures the state of the current mesh. Collective."""
    problem, system, factor = session.problem, session.system, session.toughness_factor
    gauge = Gauge(
        face=problem.face,
        depths=problem.measuring.depths,
        threshold=problem.measuring.threshold,
        prominence=problem.material.ell,
        h=problem.domain.h,
        toughness_factor=factor,
        local=local(problem.domain, factor),
        others=cooled_faces(problem.domain, problem.measuring.cooled),
        cools=problem.measuring.cools,
    )
    below = planes(problem.domain, gauge, problem.material.ell)
    return lambda before: measures(
        problem.domain, system.state, system.energy, gauge, below, before
    )


def releasing(
    session: Session, *, mesh: tuple[np.ndarray, np.ndarray] | None
) -> Callable[[], tuple[Release, ...]]:
    """Return the function that finds G at the tips of the state of the current mesh. Collective, as
    that function.

    Parameters
    ----------
    session : owner of the mesh.
    mesh : points, shape (n, 3), those of the ranks one after the other, and cells, shape (m,
        vertices), in VTK's order, on rank 0; None elsewhere.
    """
    domain, material, system = session.domain, session.problem.material, session.system
    factor = session.toughness_factor
    threshold, law = session.problem.measuring.threshold, material.law.name
    around = body_surface(domain)
    rates: list[EnergyRelease] = []  # compiled where there is a tip

    def found() -> tuple[Release, ...]:
        parts = gather(domain.comm, owned(system.state.alpha).copy())

        def tips() -> tuple[Front, ...]:
            assert mesh is not None and around is not None
            cracks = network(
                *mesh, alpha=np.concatenate(parts or []), strains=None, dim=domain.dim,
                h=domain.h, ell=material.ell, crack=threshold,
                tip=damage_at_tip(law, threshold=threshold), falls=falls(law),
            )  # fmt: skip
            return fronts(cracks, around, ell=material.ell, h=domain.h)

        at = on_root(domain.comm, tips)
        if at and not rates:
            rates.append(EnergyRelease(domain, system.energy, factor=factor))
        return rates[0](at) if at else ()

    return found

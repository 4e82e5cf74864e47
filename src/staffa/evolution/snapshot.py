"""A copy of all that a step changes, and the way back to it."""

from dataclasses import dataclass

import numpy as np

from staffa.evolution.coupling import ThermalState
from staffa.evolution.system import System
from staffa.model.fields import read_vector


@dataclass(frozen=True, kw_only=True)
class Snapshot:
    """A copy of the state, of the damage's bound and of the loads. Fields with ghosts.

    Attributes
    ----------
    u : displacement (m), shape (n_nodes * dim,).
    alpha, lower : damage and its lower bound, shape (n_local,).
    thermal : temperature, and what its source goes on from.
    frozen : `Energy.frozen`, field by field.
    spent : damage up to which the energy of cracks is booked, shape (n_local,), where that is
        counted; None: all of it, as in a checkpoint.
    loads : `External.kept`, then the booked energy (J) where that is counted.
    """

    u: np.ndarray
    alpha: np.ndarray
    lower: np.ndarray
    thermal: ThermalState
    frozen: tuple[np.ndarray, ...]
    spent: np.ndarray | None = None
    loads: np.ndarray


def snapshot(system: System) -> Snapshot:
    """Copy the state, the damage's lower bound and the external loads, for `restore`.

    What comes then depends on these alone, so that it can be repeated to the last bit.
    """
    system.alternation.elastic.forget()
    return copied(system)


def copied(system: System) -> Snapshot:
    """Return the same copy, after which solvers go on with what they have."""
    state, spent = system.state, system.energy.spent
    loads = system.energy.external.kept()
    return Snapshot(
        u=state.u.x.array.copy(),
        alpha=state.alpha.x.array.copy(),
        lower=system.bounds.lower.x.array.copy(),
        thermal=system.thermal.read(),
        frozen=tuple(field.x.array.copy() for field in system.energy.frozen),
        spent=spent.alpha.x.array.copy() if spent else None,
        loads=np.append(loads, spent.energy) if spent else loads,
    )


def restore(system: System, kept: Snapshot) -> None:
    """Put back what `snapshot` kept, or a checkpoint, in which all that cracks cost is booked."""
    state, parts, spent = system.state, system.alternation, system.energy.spent
    state.u.x.array[:] = kept.u
    state.alpha.x.array[:] = kept.alpha
    system.bounds.lower.x.array[:] = kept.lower
    system.thermal.put(kept.thermal)
    for field, values in zip(system.energy.frozen, kept.frozen, strict=False):
        field.x.array[:] = values
    if spent:
        spent.alpha.x.array[:] = kept.alpha if kept.spent is None else kept.spent
        spent.energy = float(kept.loads[-1])
    system.energy.external.put_back(kept.loads)
    read_vector(state.u, parts.u)
    read_vector(state.alpha, parts.alpha)
    parts.elastic.forget()

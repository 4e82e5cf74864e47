"""Numbers of the time loop, as a checkpoint keeps them."""

from dataclasses import dataclass, field

from staffa.evolution.backtrack import Better
from staffa.records.energies import Energies
from staffa.records.step import Heat


@dataclass(frozen=True, kw_only=True)
class PastNumbers:
    """A step of `StepHistory`, as a checkpoint keeps it.

    Attributes
    ----------
    loads
        Time (s) of its loads, which tells the displacements prescribed then.
    total
        Its total energy, see `Energies`; so are `scale`, `loaded`, `work` and `imbalance`.
    scale
        Scale of its energy.
    loaded
        Energy on frozen cracks that it started with.
    work
        Work of the loads on the way there.
    imbalance
        Error in the account of that work.
    heat
        Account of the heat equation; None without one.
    moved
        True if the mesh was changed since its energy was computed.
    """

    loads: float
    total: float
    scale: float
    loaded: float
    work: float
    imbalance: float
    heat: Heat | None = None
    moved: bool = False


@dataclass(frozen=True, kw_only=True)
class Finer:
    """Effect of other meshes since the step before.

    Attributes
    ----------
    changes
        Number of changes of the mesh.
    energy
        Change of the total energy by them alone.
    """

    changes: int = 0
    energy: float = 0.0


@dataclass(frozen=True, kw_only=True)
class LoopNumbers:
    """Numbers of a checkpoint: all of a `RestartState` but its fields.

    Attributes
    ----------
    index
        Index of the next step, unless `better` is an earlier one to go back to.
    start
        Time (s) that `AdaptiveSteps` has come to; None before the first step.
    length
        Length of its next step (s).
    loads
        Numbers of the external loads, the last part of `snapshot`.
    rest
        Energies that others count from.
    total
        Energy that the step before ended with; None in checkpoints of older versions.
    better
        Earlier step that is gone back to next; None for going on.
    past
        Steps of the history; empty without backtracking.
    returns
        Number of returns to each step, by its index.
    failed
        Indices of steps that could not be returned to.
    due
        True if the last step is still to be looked back from.
    finer
        What other meshes changed since the step before.
    tried
        Time (s) of the step whose try on coarser cells came to the damage that is kept; None
        without.
    """

    index: int
    start: float | None
    length: float
    loads: tuple[float, ...]
    rest: Energies
    total: float | None = None
    better: Better | None = None
    past: tuple[PastNumbers, ...] = ()
    returns: dict[int, int] = field(default_factory=dict)
    failed: tuple[int, ...] = ()
    due: bool = False
    finer: Finer = field(default_factory=Finer)
    tried: float | None = None

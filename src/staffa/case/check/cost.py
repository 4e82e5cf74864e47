"""The cost of a run before it runs: steps, memory and time, from measured runs."""

from dataclasses import dataclass

from staffa.case.check.refined_cells import MeshSize, mesh_growth
from staffa.case.scales.case_scales import Numbers
from staffa.case.scales.pace import plan
from staffa.case.schema.case import Case
from staffa.case.values.elements import unknowns_on
from staffa.evolution.schedule import AdaptiveSteps

# Measured with one step of the slab at 20k to 101k displacement unknowns (direct), and of the
# brick at 11k to 105k (iterative), one rank, as `/usr/bin/time -v staffa run CASE --quiet --set
# "time.tau=[0.1]" --set "output.at=[]"` says it, with --set domain.size or domain.h for the size:
# largest resident memory = base + per unknown, in bytes.
BASE = 3.2e8
PER_UNKNOWN = {"direct": 2.1e3, "iterative": 4.1e3}

# Seconds of a sweep per displacement unknown, and the power by which that grows beyond SMALL of
# them: of the slabs of bench/yardstick and verification/slabs (direct), of bench/scaling.
A_SWEEP = {"direct": (8e-6, 0.3), "iterative": (40e-6, 0.08)}
SMALL = 1e5
MOST_STEPS = 20_000  # are counted
LEAST = 0.006  # seconds of the smallest sweep: what does not depend on the size
# Sweeps of a step, over a whole run: 2-D and 3-D.
SWEEPS = {2: 20.0, 3: 10.0}
# A split's displacement takes several factorizations.
SPLIT = 4.0
# The kept runs of bench/ and verification/ lie within this factor of what is said
# (`tests/scripts/test_cost.py`): a step in which cracks run far takes ten times the sweeps of one
# in which they stand.
WITHIN = 4.0


@dataclass(frozen=True, kw_only=True)
class Steps:
    """Number of time steps of a case.

    Attributes
    ----------
    number : number of time steps.
    open : True if steps adapt, so that cracks make more of them.
    """

    number: int
    open: bool


def steps(case: Case, derived: Numbers) -> Steps:
    """Return the number of steps of a run; of adaptive steps the number without cracks."""
    times = plan(case, derived)
    walk, number = AdaptiveSteps(times), 0
    while number < MOST_STEPS and (time := walk.next()) is not None:
        walk.onward(time, 0.0)
        number += 1
    return Steps(number=number, open=times.pace is not None)


def memory(case: Case) -> float:
    """Estimate the memory of a run at its end, over all its ranks (bytes)."""
    coarser = case.dim == 2 and float(case.damage.ell) >= 6 * case.outline.h
    levels = 4 / 3 if coarser and not case.domain.halvings else 1.0
    n = unknowns_of(case, mesh_growth(case).end)
    return BASE + levels * PER_UNKNOWN[case.solver.displacement] * n


def unknowns_of(case: Case, size: MeshSize) -> int:
    """Estimate the number of displacement unknowns on a mesh of a size."""
    return unknowns_on(case, size.cells, size.vertices)


def coarser_for(case: Case, available: float) -> float:
    """Return the cell edge with which a run needs no more than this (bytes; m)."""
    share = (memory(case) - BASE) / max(available - BASE, 0.1 * BASE)
    return float(float(case.outline.h) * share ** (1 / case.dim))


def duration(case: Case, number: int) -> float:
    """Estimate the time of a number of steps on one core (s), within a factor of WITHIN.

    All of them count as if they were on the mesh of the end.
    """
    n = unknowns_of(case, mesh_growth(case).end)
    each, power = A_SWEEP[case.solver.displacement]
    sweep = LEAST + each * n * max(1.0, n / SMALL) ** power
    split = 1.0 if case.damage.split == "none" else SPLIT
    return float(number * SWEEPS[case.dim] * sweep * split)

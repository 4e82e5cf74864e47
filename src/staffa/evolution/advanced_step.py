"""Account of a step from the loads of one time to those of the next."""

from dataclasses import dataclass, replace

from staffa.evolution.apply_loads import Loading
from staffa.evolution.coupling import ThermalState
from staffa.evolution.energy_gaps import gap_at_start, gap_between_parts
from staffa.records.step import CANCELED, Curvature, Heat, Outcome, Return, SolverStatistics


@dataclass(frozen=True, kw_only=True)
class Origin:
    """Time (s) at which a step, or its last part, begins, and the `thermal` state then."""

    time: float
    thermal: ThermalState


@dataclass(frozen=True, kw_only=True)
class Advance:
    """Step from the loads of one time to the next ones.

    Attributes
    ----------
    outcome : result of the minimization.
    healing : how far the damage sank below its bound.
    work, released : work of the loads on frozen cracks, and energy that the minimization released.
    imbalance : error of the energy balance over the energy.
    origin : start of the last part of the step.
    renewed : change of the energy by new normals and new friction of faces that touch.
    began : energy before; None after backtracking.
    gap : largest difference between the energies that one part ended and the next began with, over
        the energy.
    returned : how backtracking came here, if it did.
    heat : account of heat of the last part; None where the coupling keeps none.
    earlier : account of heat of the parts before it.
    curvature : second-order test of the state, if it was made.
    """

    outcome: Outcome
    healing: float
    work: float
    released: float
    imbalance: float
    origin: Origin
    renewed: float = 0.0
    began: float | None = None
    gap: float = 0.0
    returned: Return | None = None
    heat: Heat | None = None
    earlier: Heat | None = None
    curvature: Curvature | None = None

    @property
    def all_heat(self) -> Heat | None:
        """Heat balance of all parts of a step that was cut."""
        return _together(self.earlier, self.heat)

    def after(self, tried: SolverStatistics) -> "Advance":
        """Return the same with the solver statistics of earlier attempts added."""
        effort = tried + self.outcome.effort
        return replace(self, outcome=replace(self.outcome, effort=effort))

    def then(self, other: "Advance") -> "Advance":
        """Return this advance and the next as one step that was cut in two."""
        both = self.outcome.then(other.outcome)
        outcome = replace(
            both,
            reason=f"{both.reason}, in the second half of a step cut in two",
            effort=both.effort + SolverStatistics(halvings=1),
        )
        return Advance(
            outcome=outcome,
            healing=max(self.healing, other.healing),
            work=self.work + other.work,
            released=self.released + other.released,
            renewed=self.renewed + other.renewed,
            imbalance=max(self.imbalance, other.imbalance),
            began=self.began,
            gap=max(self.gap, other.gap, gap_between_parts(self.outcome, other.began)),
            heat=other.heat,
            earlier=_together(self.all_heat, other.earlier),
            origin=other.origin,
        )

    def again(
        self, outcome: Outcome, healing: float, loading: Loading, heat: Heat | None
    ) -> "Advance":
        """Return the same step after one more change of temperature and minimization.

        Parameters
        ----------
        outcome : outcome of that minimization.
        healing : its irreversibility violation.
        loading : the change of loads before it.
        heat : heat balance of the step.
        """
        heat, seconds = heat or Heat(), self.heat.seconds if self.heat else 0.0
        return replace(
            self,
            outcome=self.outcome.then(outcome),
            healing=max(self.healing, healing),
            work=self.work + loading.work,
            released=self.released + loading.end - outcome.energies.total,
            imbalance=max(self.imbalance, imbalance(loading, outcome)),
            gap=max(
                self.gap,
                gap_between_parts(self.outcome, loading.start),
                gap_at_start(loading, outcome),
            ),
            heat=replace(heat, seconds=heat.seconds + seconds),
        )


def _together(one: Heat | None, other: Heat | None) -> Heat | None:
    """Return the sum of two heat balances, or the one that is given."""
    return one.then(other) if one and other else one or other


def imbalance(loading: Loading, outcome: Outcome) -> float:
    """Return the error of the energy balance on frozen cracks, over the energy."""
    scale = max(abs(loading.start), abs(loading.end), outcome.scale, CANCELED * loading.spread)
    return abs(loading.end - loading.start - loading.work) / scale

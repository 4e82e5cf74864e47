"""Case -> the load of a body that a reservoir simulator cools."""

from functools import partial

from staffa.case.schema.case import Case
from staffa.case.values.reservoir_model import reservoir_model
from staffa.case.values.reservoir_places import crack_rule, reservoir_keys
from staffa.properties.field_series import FieldSeries
from staffa.reservoir.darts import Darts
from staffa.reservoir.interpreter import simulator_python
from staffa.reservoir.reservoir_load import Feedback, ReservoirLoad
from staffa.reservoir.simulator import ReservoirModel, Simulator
from staffa.reservoir.single import SingleFracture

# The closed form is exact, and its balance tells how well cells resolve it: at first not at all.
UNRESOLVED = 1.0


def reservoir_load(case: Case) -> ReservoirLoad | FieldSeries:
    """Return the load of a case with a reservoir: files, or a simulator, which starts when the load
    is opened."""
    keys = reservoir_keys(case)
    if keys.fields is not None:
        return keys.fields.series.reaching(case.outline.h)
    model = reservoir_model(case)
    opened = partial(_opened, keys.simulator, model, keys.interpreter)
    if keys.simulator == "single":
        return ReservoirLoad(model=model, open=opened, balance=UNRESOLVED)
    return ReservoirLoad(model=model, open=opened, feedback=_feedback(case))


def _feedback(case: Case) -> Feedback | None:
    """Return the rule by which cracks change the flow; None where they do not."""
    keys, rule = reservoir_keys(case), crack_rule(case)
    if rule is None:
        return None
    agreement = keys.agreement or keys.tolerance if keys.coupling == "iterated" else None
    return Feedback(rule=rule, agreement=agreement, shadow=keys.shadow)


def _opened(simulator: str, model: ReservoirModel, python: str | None) -> Simulator:
    """Return the simulator of a case, by its key.

    Parameters
    ----------
    simulator : "darts" or "single".
    model : rock, water and wells.
    python : Python that the case names for it, None for a search.
    """
    if simulator == "single":
        return SingleFracture(model)
    return Darts(model, simulator_python(python))

"""Curves of a study: its results over each parameter, and its production over time."""

from collections.abc import Sequence

from staffa.io.study_directory import Study
from staffa.plot.study_production import PointProduction, point_production
from staffa.plot.study_responses import Abscissa, Response
from staffa.plot.style import GENERATIONS as COLORS
from staffa.results.study_table import groups
from staffa.results.tables import number

# Names of numbers on the axes of pictures, which have no room for a definition.
LABELS = {
    "p": "spacing",
    "a0": "nucleation depth",
    "front": "deepest crack",
    "length": "length of cracks",
    "area": "area of cracks",
    "T": "production temperature",
}
# Numbers that follow from others in a picture: times of arrests, parts of the energy.
NOT_DRAWN = ("t", "tau", "elastic_energy", "load_energy")
MOST_PANELS = 16


def responses(study: Study) -> list[Response]:
    """Return the results that can be drawn over a parameter: those that are not zero throughout."""
    points = [point for point, _ in study.started]
    found = []
    for group in groups(study):
        by_point = [group.of_point(point) for point in points]
        for k, column in enumerate(group.columns):
            values = [[column.unit.of(value) for value in of[k]] for of in by_point]
            known = [value for one in values for value in one]
            if column.name.rstrip("0123456789") in NOT_DRAWN or not any(known):
                continue  # zeros alone are no response
            label = LABELS.get(column.name) or column.label or _arrest(column.name)
            has_unit = study.first.manifest.scaled and not label.startswith("cracks")
            label = column.unit.label(label) if has_unit else column.unit.header(label)
            found.append(Response(label=label, values=values))
    return found[:MOST_PANELS]


def _arrest(name: str) -> str:
    """Return the name of the depth of an arrest in words; another name as it is."""
    generation = name[1:] if name.startswith("a") and name[1:].isdecimal() else ""
    return f"arrest depth {generation}" if generation else name


def abscissa(study: Study, k: int) -> Abscissa:
    """Return a parameter as the axis of a picture, with a curve for each choice of the others.

    Points that have no choice of the others in common, as those of a Latin hypercube, and more
    curves than there are colors, are drawn as points alone.

    Parameters
    ----------
    study : the study.
    k : number of the parameter, from 0.
    """
    parameters = study.plan.parameters
    points = [point for point, _ in study.started]
    others = [j for j in range(len(parameters)) if j != k]
    curves: dict[str, list[int]] = {}
    for place, point in enumerate(points):
        words = (f"{number(point.values[j])}{parameters[j].shown.behind}" for j in others)
        curves.setdefault(", ".join(words), []).append(place)
    if len(curves) > len(COLORS) or (others and max(map(len, curves.values())) < 2):
        curves = {"": list(range(len(points)))}
    return Abscissa(
        label=parameters[k].shown.header(parameters[k].key),
        values=[point.values[k] for point in points],
        curves=list(curves.items()),
        others=", ".join(parameters[j].key for j in others),
    )


def productions(study: Study) -> Sequence[PointProduction]:
    """Return the production of each point over time; empty without water."""
    found = []
    for point, ensemble in study.started:
        pairs = zip(study.plan.parameters, point.values, strict=True)
        words = ", ".join(f"{number(value)}{one.shown.behind}" for one, value in pairs)
        value = point.values[0]
        place = value if isinstance(value, float) else float(point.number)
        found.append(point_production(words, place, list(ensemble.finished.values())))
    return [one for one in found if one is not None]

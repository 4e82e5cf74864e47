"""Choice of the pictures that a run and an ensemble have numbers for."""

from collections.abc import Callable, Sequence
from functools import partial

from matplotlib.figure import Figure

from staffa.io.ensemble_directory import Ensemble
from staffa.io.production_rows import production
from staffa.io.run_directory import Run
from staffa.io.study_directory import Study
from staffa.plot.cell_planes import sections_figure, size_figure
from staffa.plot.cracks import cracks_figure
from staffa.plot.curves import energies_figure, lengths_figure
from staffa.plot.ensemble_curves import counts_figure, growth_figure
from staffa.plot.ensemble_production import ensemble_production_figure, production_spreads
from staffa.plot.exchange_curves import exchange_figure
from staffa.plot.frames import Frame, read_frames
from staffa.plot.heat_balance import heat_figure
from staffa.plot.labels import mark_unreached
from staffa.plot.mesh_picture import mesh_figure
from staffa.plot.network_openings import network_figure
from staffa.plot.production_curves import production_figure
from staffa.plot.quantity_curves import quantities_figure
from staffa.plot.reservoir_cells import reservoir_figure, reservoir_moments
from staffa.plot.study_production import study_production_figure
from staffa.plot.study_responses import response_figure
from staffa.plot.support_forces import reactions_figure
from staffa.plot.volume import volume_figure
from staffa.report.page import EXCHANGE, PRODUCTION, PRODUCTION_OF_ALL, RESERVOIR
from staffa.report.study_page import STUDY_PRODUCTION
from staffa.results.columns import by_depth
from staffa.results.crack_network import Drawing
from staffa.results.sections import doubling, planes_of
from staffa.results.study_curves import abscissa, productions, responses

Figures = dict[str, Callable[[], Figure]]


def run_figures(run: Run, found: Sequence[Drawing]) -> tuple[Figures, list[str]]:
    """Return how to draw each picture, by name, and reasons for those that cannot be drawn.

    Parameters
    ----------
    run : the run.
    found : its crack networks.
    """
    manifest, steps = run.manifest, run.steps
    if not steps:
        return {}, ["no pictures: no step is finished yet"]
    figures: Figures = {}
    frames, skipped = read_frames(run)
    if not frames:
        skipped.append("cracks: no step has fields that can be read")
    elif len(manifest.size) == 2:
        figures["cracks"] = partial(cracks_figure, manifest, frames)
    else:
        figures["cracks"] = partial(volume_figure, manifest, frames[-1])
        if found_in := planes_of(manifest, frames[-1]):
            figures["sections"] = partial(sections_figure, manifest, frames[-1].step, found_in)
        figures |= _sizes([run])
    if frames and frames[-1].step.mesh:
        figures["mesh"] = partial(mesh_figure, manifest, frames[-1], steps)
    water, lost = _reservoir(run, frames)
    figures |= _production(run) | water
    shown = {frame.step.index for frame in frames}
    moments = [(d.step, d.network) for d in found if d.step.index in shown and d.network.size]
    if moments:
        figures["network"] = partial(network_figure, manifest, moments, found[-1].outline)
    curves, missing = curve_figures(run)
    return figures | curves, [*skipped, *lost, *missing]


def curve_figures(run: Run) -> tuple[Figures, list[str]]:
    """Return how to draw curves of the steps, which need no fields, and reasons for missing ones.

    Parameters
    ----------
    run : the run.
    """
    manifest, steps = run.manifest, run.steps
    figures, skipped = _production(run), []
    if len(steps) < 2:
        return _marked(run, figures), ["curves: they need two steps"]
    figures["energies"] = partial(energies_figure, manifest, steps)
    if any(step.heat for step in steps):
        figures["heat"] = partial(heat_figure, manifest, steps)
    if any(any(force) for step in steps for force in step.reactions.values()):
        figures["reactions"] = partial(reactions_figure, manifest, steps)
    if sum(bool(step.quantities) for step in steps) > 1:
        figures["quantities"] = partial(quantities_figure, manifest, steps)
    if sum(step.measures is not None for step in steps) < 2:
        skipped.append("lengths: fewer than two steps were measured")
    else:
        figures["lengths"] = partial(lengths_figure, manifest, steps)
    return _marked(run, figures), skipped


def _marked(run: Run, figures: Figures) -> Figures:
    """Return curves with a mark where the run ended before its end."""
    return {name: partial(_with_end, run, draw) for name, draw in figures.items()}


def _with_end(run: Run, draw: Callable[[], Figure]) -> Figure:
    """Draw curves, with a mark where the run ended before its end."""
    figure = draw()
    if run.unreached is None:
        return figure
    return mark_unreached(figure, run.manifest, run.steps, run.unreached)


def ensemble_figures(ensemble: Ensemble) -> tuple[Figures, list[str]]:
    """Return how to draw what finished members have in common, and reasons for what is left out."""
    measured = [
        [step for step in run.steps if step.measures is not None]
        for run in ensemble.finished.values()
    ]
    members = [steps for steps in measured if steps]
    if len(members) < 2:
        return {}, ["no pictures: they need two finished members"]
    manifest, first = ensemble.first.manifest, members[0][0].measures
    figures: Figures = {}
    skipped = []
    if first and first.sections:
        figures["counts"] = partial(counts_figure, manifest, members)
    elif len(manifest.size) == 2:
        skipped.append("counts: the case gives no measures.depths to count cracks at")
    figures["growth"] = partial(growth_figure, manifest, members)
    if produced := production_spreads(list(ensemble.finished.values())):
        figures[PRODUCTION_OF_ALL] = partial(ensemble_production_figure, manifest, produced)
    return figures | _sizes(list(ensemble.finished.values())), skipped


def _production(run: Run) -> Figures:
    """Return how to draw curves of the water; nothing where none flows."""
    facts, found = run.manifest.reservoir, production(run.manifest.reservoir, run.steps)
    if facts is None or not found:
        return {}
    without = production(facts, run.steps, cracks=False)
    figures: Figures = {PRODUCTION: partial(production_figure, run.manifest, found, without)}
    if len(found) > 1:
        figures[EXCHANGE] = partial(exchange_figure, run.manifest, found, without)
    return figures


def _reservoir(run: Run, frames: Sequence[Frame]) -> tuple[Figures, list[str]]:
    """Return how to draw the reservoir, and reasons; nothing where no water flows."""
    facts = run.manifest.reservoir
    if facts is None or not production(facts, run.steps):
        return {}, []
    moments, skipped = reservoir_moments(run, frames)
    if not moments:
        return {}, skipped
    return {RESERVOIR: partial(reservoir_figure, run.manifest, facts, moments)}, skipped


def _sizes(runs: Sequence[Run]) -> Figures:
    """Return how to draw the sizes of the cells by depth, of all runs together, if any."""
    known = by_depth(runs).items()
    found = {depth: seen for depth, seen in known if seen.spacing.value is not None}
    if not found:
        return {}
    manifest = runs[0].manifest
    theory = doubling(manifest, max(found))
    return {"spacing": partial(size_figure, manifest, found, theory)}


def study_figures(study: Study) -> tuple[Figures, list[str]]:
    """Return how to draw responses and production of a study, and reasons for missing ones.

    Parameters
    ----------
    study : the study.
    """
    found = responses(study)
    if not found:
        return {}, ["no pictures: they need finished runs at two points"]
    figures: Figures = {}
    for k in range(len(study.plan.parameters)):
        over = abscissa(study, k)
        if drawn := [response for response in found if over.spans(response)]:
            figures[f"response-{k + 1}"] = partial(response_figure, over, drawn)
    if produced := productions(study):
        names = ", ".join(one.shown.header(one.key) for one in study.plan.parameters)
        figures[STUDY_PRODUCTION] = partial(
            study_production_figure, study.first.manifest, names, produced
        )
    return figures, []

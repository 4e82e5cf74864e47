"""Draws every picture that a run, an ensemble or a pair of runs has numbers for, and its page."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from matplotlib.figure import Figure

from staffa.compare.figures import pair_figures
from staffa.compare.pair import Pair
from staffa.errors import StaffaError
from staffa.io.ensemble_directory import Ensemble
from staffa.io.own_files import PAGE, PICTURES, make_folder, write_aside
from staffa.io.production_rows import production
from staffa.io.run_directory import Run
from staffa.io.study_directory import Study
from staffa.plot.cell_planes import sections_figure, size_figure
from staffa.plot.cracks import cracks_figure
from staffa.plot.curves import energies_figure, lengths_figure
from staffa.plot.ensemble_curves import counts_figure, growth_figure
from staffa.plot.ensemble_production import ensemble_production_figure, production_spreads
from staffa.plot.exchange_curves import exchange_figure
from staffa.plot.frames import Frame, evenly_spread, read_frames, with_fields
from staffa.plot.heat_balance import heat_figure
from staffa.plot.mesh_picture import mesh_figure
from staffa.plot.movie import FEWEST, MOST, write_movie
from staffa.plot.network_openings import network_figure
from staffa.plot.production_curves import production_figure
from staffa.plot.quantity_curves import quantities_figure
from staffa.plot.reservoir_cells import reservoir_figure, reservoir_moments
from staffa.plot.study_production import study_production_figure
from staffa.plot.study_responses import response_figure
from staffa.plot.style import write_picture
from staffa.plot.support_forces import reactions_figure
from staffa.plot.volume import volume_figure
from staffa.report.page import (
    EXCHANGE,
    PRODUCTION,
    PRODUCTION_OF_ALL,
    RESERVOIR,
    ensemble_page,
    page,
    pair_page,
)
from staffa.report.study_page import STUDY_PRODUCTION, study_page
from staffa.results.columns import by_depth
from staffa.results.crack_network import OLDER, Drawing, networks, without_openings
from staffa.results.csv_files import write_pooled, write_study, write_tables, writing
from staffa.results.ensemble_means import write_results
from staffa.results.sections import doubling, planes_of
from staffa.results.study_curves import abscissa, productions, responses

MOVIE = "growing"
Write = Callable[[Path], None]


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """Files that were written, and a sentence on each picture, or part of one, that was not."""

    page: Path
    tables: tuple[Path, ...]
    pictures: tuple[Path, ...]
    skipped: tuple[str, ...]


def draw(
    run: Run, *, movie: bool | None = None, told: Callable[[int, int], None] = lambda done, of: None
) -> Drawn:
    """Write pictures, tables, crack networks and `report.html` into the run, over earlier ones.

    movie: whether to write the animation too; by default in 3-D only. told: called with how many of
    its pictures are done, and how many there will be.

    Raises
    ------
    StaffaError
        The run directory cannot be written to.
    """
    found, unread = networks(run)
    figures, skipped = run_figures(run, found)
    movies: dict[str, Write] = {}
    if movie or (movie is None and len(run.manifest.size) == 3):
        steps = evenly_spread(with_fields(run), MOST)
        if len(steps) >= FEWEST:
            movies[MOVIE] = partial(write_movie, run=run, steps=steps, told=told)
        else:
            skipped.append(f"{MOVIE}: fewer than {FEWEST} steps have fields")
    if without_openings(found):
        skipped.append(OLDER)
    tables = write_tables(run, found)
    text = partial(page, run, found)
    reasons = list(dict.fromkeys([*skipped, *unread]))
    return _written(run.path, figures, reasons, text, tables, movies)


def draw_ensemble(ensemble: Ensemble) -> Drawn:
    """The same for an ensemble, with `ensemble.csv` and, of a 3-D body, `cells.csv`.

    Raises
    ------
    StaffaError
        The directory cannot be written to.
    """
    figures, skipped = _ensemble_figures(ensemble)
    text = partial(ensemble_page, ensemble)
    drawn = _written(ensemble.path, figures, skipped, text, write_pooled(ensemble))
    write_results(ensemble)
    return drawn


def draw_study(study: Study) -> Drawn:
    """Draw response curves and production of a study, with `study.csv` and `study_means.csv`.

    Raises
    ------
    StaffaError
        The directory cannot be written to.
    """
    figures, skipped = _study_figures(study)
    text = partial(study_page, study)
    return _written(study.path, figures, skipped, text, write_study(study))


def draw_pair(pair: Pair, folder: Path) -> Drawn:
    """Draw two runs side by side, into a folder.

    Raises
    ------
    StaffaError
        The folder cannot be written to.
    """
    figures, skipped = pair_figures(pair)
    return _written(folder, figures, skipped, partial(pair_page, pair))


def _written(
    folder: Path,
    figures: dict[str, Callable[[], Figure]],
    skipped: list[str],
    text: Callable[[Sequence[Path], Sequence[str]], str],
    tables: tuple[Path, ...] = (),
    movies: Mapping[str, Write] | None = None,
) -> Drawn:
    pictures: list[Path] = []
    to_write: dict[str, Write] = {
        f"{name}.png": partial(write_picture, draw=figure) for name, figure in figures.items()
    }
    to_write |= {f"{name}.gif": write for name, write in (movies or {}).items()}
    with writing(folder):
        make_folder(folder / PICTURES)
        if f"{MOVIE}.gif" not in to_write:  # the one that is there may be of an earlier state
            (folder / PICTURES / f"{MOVIE}.gif").unlink(missing_ok=True)
        for name, write in to_write.items():
            path = folder / PICTURES / name
            try:
                write(path)
                pictures.append(path)
            except StaffaError as error:
                skipped.append(f"{path.stem}: {error}")
        write_aside(folder / PAGE, text(pictures, skipped))
    return Drawn(
        page=folder / PAGE,
        tables=tables,
        pictures=tuple(pictures),
        skipped=tuple(skipped),
    )


def _ensemble_figures(
    ensemble: Ensemble,
) -> tuple[dict[str, Callable[[], Figure]], list[str]]:
    """Return how to draw what finished members have in common, and reasons for what is left out."""
    measured = [
        [step for step in run.steps if step.measures is not None]
        for run in ensemble.finished.values()
    ]
    members = [steps for steps in measured if steps]
    if len(members) < 2:
        return {}, ["no pictures: they need two finished members"]
    manifest, first = ensemble.first.manifest, members[0][0].measures
    figures: dict[str, Callable[[], Figure]] = {}
    skipped = []
    if first and first.sections:
        figures["counts"] = partial(counts_figure, manifest, members)
    elif len(manifest.size) == 2:
        skipped.append("counts: the case gives no measures.depths to count cracks at")
    figures["growth"] = partial(growth_figure, manifest, members)
    if produced := production_spreads(list(ensemble.finished.values())):
        figures[PRODUCTION_OF_ALL] = partial(ensemble_production_figure, manifest, produced)
    return figures | _sizes(list(ensemble.finished.values())), skipped


def run_figures(
    run: Run, found: Sequence[Drawing]
) -> tuple[dict[str, Callable[[], Figure]], list[str]]:
    """Return how to draw each picture, by name, and reasons for those that cannot be drawn.

    Parameters
    ----------
    run : the run.
    found : its crack networks.
    """
    manifest, steps = run.manifest, run.steps
    if not steps:
        return {}, ["no pictures: no step is finished yet"]
    figures: dict[str, Callable[[], Figure]] = {}
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
    shown = {frame.step.index for frame in frames}
    water, lost = _water(run, frames)
    figures |= water
    skipped += lost
    moments = [(d.step, d.network) for d in found if d.step.index in shown and d.network.size]
    if moments:
        figures["network"] = partial(network_figure, manifest, moments, found[-1].outline)
    if len(steps) < 2:
        return figures, [*skipped, "curves: they need two steps"]
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
    return figures, skipped


def _water(run: Run, frames: Sequence[Frame]) -> tuple[dict[str, Callable[[], Figure]], list[str]]:
    """Return how to draw production and reservoir, and reasons; nothing where no water flows."""
    facts, found = run.manifest.reservoir, production(run.manifest.reservoir, run.steps)
    if facts is None or not found:
        return {}, []
    without = production(facts, run.steps, cracks=False)
    figures: dict[str, Callable[[], Figure]] = {
        PRODUCTION: partial(production_figure, run.manifest, found, without)
    }
    if len(found) > 1:
        figures[EXCHANGE] = partial(exchange_figure, run.manifest, found, without)
    moments, skipped = reservoir_moments(run, frames)
    if moments:
        figures[RESERVOIR] = partial(reservoir_figure, run.manifest, facts, moments)
    return figures, skipped


def _sizes(runs: Sequence[Run]) -> dict[str, Callable[[], Figure]]:
    """Return how to draw the sizes of the cells by depth, of all runs together, if any."""
    known = by_depth(runs).items()
    found = {depth: seen for depth, seen in known if seen.spacing.value is not None}
    if not found:
        return {}
    manifest = runs[0].manifest
    theory = doubling(manifest, max(found))
    return {"spacing": partial(size_figure, manifest, found, theory)}


def _study_figures(study: Study) -> tuple[dict[str, Callable[[], Figure]], list[str]]:
    """Return how to draw responses and production of a study, and reasons for what is left out."""
    found = responses(study)
    if not found:
        return {}, ["no pictures: they need finished runs at two points"]
    figures: dict[str, Callable[[], Figure]] = {}
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

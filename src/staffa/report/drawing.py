"""Pictures, tables and page of a run, an ensemble, a study or a pair of runs, written to files."""

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
from staffa.io.run_directory import Run
from staffa.io.study_directory import Study
from staffa.plot.frames import evenly_spread, with_fields
from staffa.plot.movie import FEWEST, MOST, write_movie
from staffa.plot.style import write_picture
from staffa.report.charts import Chart, charts
from staffa.report.chosen_figures import Figures, ensemble_figures, run_figures, study_figures
from staffa.report.page import Picture, ensemble_page, page, pair_page
from staffa.report.study_page import study_page
from staffa.report.time_slides import SlideMaker
from staffa.report.turnable import turnable
from staffa.results.crack_network import OLDER, Drawing, networks, without_openings
from staffa.results.csv_files import write_ensemble, write_study, write_tables, writing

MOVIE = "growing"
Write = Callable[[Path], Figure | None]


@dataclass(frozen=True, kw_only=True)
class Drawn:
    """Files that were written, and a sentence on each picture, or part of one, that was not."""

    page: Path
    tables: tuple[Path, ...]
    pictures: tuple[Path, ...]
    skipped: tuple[str, ...]


def draw(
    run: Run,
    *,
    movie: bool | None = None,
    told: Callable[[int, int], None] = lambda done, of: None,
    tabled: Callable[[], None] = lambda: None,
) -> Drawn:
    """Write tables, crack networks, pictures and `report.html` into the run, over earlier ones.

    Parameters
    ----------
    run : the run.
    movie : True for an animation; None for one in 3-D only.
    told : called with the number of its pictures that are done, and that of all.
    tabled : called once the tables are written.

    Raises
    ------
    StaffaError
        The run directory cannot be written to.
    """
    found, unread = networks(run)
    tables = write_tables(run, found)
    tabled()
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
    text = partial(page, run, found, slides=SlideMaker().slides(run))
    reasons = list(dict.fromkeys([*skipped, *unread]))
    return _written(run.path, figures, reasons, text, tables, movies, _turned(run, found))


def draw_ensemble(ensemble: Ensemble) -> Drawn:
    """The same for an ensemble, with `ensemble.csv` and, of a 3-D body, `cells.csv`.

    Raises
    ------
    StaffaError
        The directory cannot be written to.
    """
    tables = write_ensemble(ensemble)
    figures, skipped = ensemble_figures(ensemble)
    return _written(ensemble.path, figures, skipped, partial(ensemble_page, ensemble), tables)


def draw_study(study: Study) -> Drawn:
    """Draw response curves and production of a study, with `study.csv` and `study_means.csv`.

    Raises
    ------
    StaffaError
        The directory cannot be written to.
    """
    figures, skipped = study_figures(study)
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
    return _written(folder, figures, skipped, partial(pair_page, pair, folder))


def _written(
    folder: Path,
    figures: Figures,
    skipped: list[str],
    text: Callable[[Sequence[Picture], Sequence[str]], str],
    tables: tuple[Path, ...] = (),
    movies: Mapping[str, Write] | None = None,
    turned: Mapping[str, Chart] | None = None,
) -> Drawn:
    """Write pictures and the page that has them with their curves.

    Parameters
    ----------
    folder : where they go.
    figures : how to draw each picture, by name.
    skipped : a sentence on each picture that cannot be drawn; more are added.
    text : returns the page of pictures and of these sentences.
    tables : tables that were written.
    movies : how to write each movie, by name.
    turned : cracks in 3-D that stand in the place of a picture, by its name.
    """
    pictures: list[Picture] = []
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
                curves = charts(drawn) if (drawn := write(path)) else ()
            except StaffaError as error:
                skipped.append(f"{path.stem}: {error}")
                continue
            live = ((turned or {})[path.stem],) if path.stem in (turned or {}) else curves
            pictures.append(Picture(stem=path.stem, path=path, charts=live))
        write_aside(folder / PAGE, text(pictures, skipped))
    return Drawn(
        page=folder / PAGE,
        tables=tables,
        pictures=tuple(one.path for one in pictures if one.path),
        skipped=tuple(skipped),
    )


def _turned(run: Run, found: Sequence[Drawing]) -> dict[str, Chart]:
    """Return the last cracks of a 3-D body as a surface to turn, in the place of their picture."""
    cracked = [drawn for drawn in found if drawn.network.size]
    if run.manifest.flat or not cracked:
        return {}
    return {"network": turnable(run.manifest, cracked[-1].step, cracked[-1].network)}

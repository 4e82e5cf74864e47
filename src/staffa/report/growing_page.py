"""Pages of what goes on: written again now and then, and read again by the browser."""

import re
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from time import perf_counter

import matplotlib

from staffa.io.ensemble_directory import read_ensemble
from staffa.io.own_files import PAGE, write_aside
from staffa.io.run_directory import Run, open_run
from staffa.io.study_directory import read_study
from staffa.plot.style import RC
from staffa.report.charts import charts
from staffa.report.chosen_figures import Figures, curve_figures, ensemble_figures, study_figures
from staffa.report.page import Picture, ensemble_page
from staffa.report.page import page as run_page
from staffa.report.study_page import study_page
from staffa.report.time_slides import SlideMaker

SECONDS = 10  # after which a browser reads the page again
SHARE = 0.02  # of the time of a run that its page may take, at most
SOONEST = 5.0  # seconds between two pages, at least
NEW_SLIDES = 2  # that are drawn for one page, so that none takes long
LARGEST = 2_000_000  # unknowns; fields of larger runs are not read while these need the memory
LATER = "pictures: they are drawn at the end"
ON_REQUEST = "pictures: `staffa report` draws them"
# Parts of a page that is read again, and what is in their place on one that could not be written.
ONGOING = re.compile(r'<noscript><meta http-equiv="refresh".*?</noscript>')
GOES_ON = re.compile(r'<p id="grows".*?</p>')
ENDED = (
    '<p role="status">The run is over. This page is older: <code>staffa report</code> draws it.</p>'
)
TOO_LARGE = "damage and temperature in time: of a run this large they are drawn at the end"


@dataclass(kw_only=True)
class GrowingPage:
    """Page of what goes on, of curves and tables; it takes 2 % of the time at most.

    An error while it is written ends the page, not the run.

    Attributes
    ----------
    folder : where it stands.
    text : returns it, for the seconds after which it is read again; None for never.
    ended : called with a sentence where it cannot be written; it is not tried again.
    due : time (s) from which it is written again.
    written : True if it was written once.
    broken : True if it cannot be written.
    """

    folder: Path
    text: Callable[[int | None], str]
    ended: Callable[[str], None] = lambda sentence: None
    due: float = 0.0
    written: bool = False
    broken: bool = False

    def grow(self) -> None:
        """Write the page if it is due: not soon after the last one, nor if that took long."""
        if perf_counter() >= self.due:
            self._write(SECONDS)

    def stop(self) -> None:
        """Write a page that was written before a last time, to be read again no more."""
        if self.written:
            self._write(None)
            if self.broken:
                with suppress(Exception):  # a disk that is full: the page is as it was
                    self._end()

    def _end(self) -> None:
        """Let the page be as it is, but not be read again."""
        text = (self.folder / PAGE).read_text(encoding="utf-8")
        write_aside(self.folder / PAGE, ONGOING.sub("", GOES_ON.sub(ENDED, text, 1), 1))

    def _write(self, again: int | None) -> None:
        if self.broken:
            return
        began = perf_counter()
        try:
            write_aside(self.folder / PAGE, self.text(again))
            self.written = True
        except Exception as error:  # of any library: a run is worth more than its page
            self.broken = True
            with suppress(Exception):
                self.ended(f"the page is written at the end only, since it failed: {error}")
        now = perf_counter()
        self.due = now + max(SOONEST, (now - began) / SHARE)


def growing_run(directory: Path, ended: Callable[[str], None]) -> GrowingPage:
    """Return the page of a run that goes on.

    Parameters
    ----------
    directory : the run directory.
    ended : called with a sentence where the page cannot be written.
    """
    return GrowingPage(
        folder=directory,
        text=partial(_run_text, directory, SlideMaker(most_new=NEW_SLIDES)),
        ended=ended,
    )


def growing_ensemble(directory: Path, ended: Callable[[str], None]) -> GrowingPage:
    """Return the page of an ensemble whose members are computed.

    Parameters
    ----------
    directory : directory of the ensemble.
    ended : called with a sentence where the page cannot be written.
    """
    return GrowingPage(folder=directory, text=partial(_ensemble_text, directory), ended=ended)


def growing_study(directory: Path, ended: Callable[[str], None]) -> GrowingPage:
    """Return the page of a study whose members are computed.

    Parameters
    ----------
    directory : directory of the study.
    ended : called with a sentence where the page cannot be written.
    """
    return GrowingPage(folder=directory, text=partial(_study_text, directory), ended=ended)


def _run_text(directory: Path, maker: SlideMaker, grows: int | None) -> str:
    run, skipped = open_run(directory), [LATER if grows else ON_REQUEST]
    if _unknowns(run) > LARGEST:
        run = _without_fields(run)
        skipped.append(TOO_LARGE)
    curves, missing = curve_figures(run)
    slides = maker.slides(run)
    return run_page(run, (), _live(curves), [*skipped, *missing], slides=slides, grows=grows)


def _ensemble_text(directory: Path, grows: int | None) -> str:
    ensemble = read_ensemble(directory)
    curves, missing = ensemble_figures(ensemble)
    return ensemble_page(
        ensemble, _live(curves), [LATER if grows else ON_REQUEST, *missing], grows=grows
    )


def _study_text(directory: Path, grows: int | None) -> str:
    study = read_study(directory)
    curves, missing = study_figures(study)
    return study_page(study, _live(curves), [LATER, *missing], grows=grows)


def _unknowns(run: Run) -> float:
    """Return the number of unknowns, on the largest mesh so far."""
    cells = max((step.mesh.cells for step in run.steps if step.mesh), default=run.manifest.cells)
    return run.manifest.unknowns * cells / run.manifest.cells


def _without_fields(run: Run) -> Run:
    return replace(run, steps=tuple(replace(step, fields=None) for step in run.steps))


def _live(figures: Figures) -> list[Picture]:
    """Return the curves of figures, without their pictures."""
    with matplotlib.rc_context(RC):
        found = {name: charts(figure()) for name, figure in figures.items()}
    return [Picture(stem=name, charts=curves) for name, curves in found.items() if curves]

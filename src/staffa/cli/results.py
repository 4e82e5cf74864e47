"""Output of results: summaries, tables and pictures of a run, an ensemble or a pair."""

from collections.abc import Iterable, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path

from rich.markup import escape
from rich.progress import Progress
from rich.table import Table as Grid

from staffa.cli.terminal import out
from staffa.compare.agreement import agreement
from staffa.compare.differences import case_differences, manifest_differences
from staffa.compare.pair import Pair, pair_title
from staffa.compare.side_by_side import common_times, results
from staffa.errors import AuditError, printable
from staffa.io.ensemble_directory import Ensemble
from staffa.io.own_files import NETWORK
from staffa.io.research_object import write_crate
from staffa.io.run_directory import Run
from staffa.io.study_directory import Study
from staffa.report.drawing import Drawn, draw, draw_ensemble, draw_pair, draw_study
from staffa.results import slab_table
from staffa.results.audit_facts import violations
from staffa.results.columns import columns
from staffa.results.crack_network import networks
from staffa.results.csv_files import write_tables, writing
from staffa.results.ensemble_means import ensemble_title, facts, sheets
from staffa.results.facts import Fact
from staffa.results.production_table import production_numbers_table
from staffa.results.spacing import spacing
from staffa.results.study_table import study_facts, study_sheets, study_title
from staffa.results.summary import summary, title
from staffa.results.tables import Table


def print_summary(run: Run) -> None:
    """Print facts, the comparison with the paper if it has a meaning, and the spacing by depth."""
    _print_facts(title(run), summary(run))
    compared = slab_table.table(run)
    if compared is not None:
        _print_table(compared)
    _print_table(spacing(run), titled=True)
    water = production_numbers_table(run)
    if water.rows:
        _print_table(water, titled=True)


def print_ensemble(ensemble: Ensemble) -> None:
    """Print facts, the numbers of each member, their means and errors, and their definitions."""
    _print_facts(ensemble_title(ensemble), facts(ensemble))
    found = sheets(ensemble)
    for sheet in found:
        _print_table(replace(sheet, notes=()), titled=True)
    together = columns(list(ensemble.finished.values()))
    if together is not None:
        _print_table(together)
    _print_notes(dict.fromkeys(note for sheet in found for note in sheet.notes))


def print_study(study: Study) -> None:
    """Print facts of a study, and means and errors of each point."""
    _print_facts(study_title(study), study_facts(study))
    found = study_sheets(study)
    for sheet in found:
        _print_table(replace(sheet, notes=()), titled=True)
    _print_notes(dict.fromkeys(note for sheet in found for note in sheet.notes))


def print_pair(pair: Pair) -> None:
    """Print the differences of two runs, their agreement, and their results side by side."""
    _print_facts(pair_title(pair), agreement(pair))
    for found in (case_differences(pair), manifest_differences(pair), results(pair)):
        _print_table(found)
    _print_table(common_times(pair))


def print_pictures(run: Run, *, movie: bool | None = None, summed_up: bool = False) -> None:
    """Write the tables, draw the pictures and the page with a progress bar, and print their paths.

    Parameters
    ----------
    run : the run.
    movie : True for an animation; None for one in 3-D only.
    summed_up : True to print the summary too, once there are the tables that it quotes.
    """
    with Progress(console=out, transient=True, disable=not out.is_terminal) as bar:
        task = bar.add_task("drawing", total=None)
        drawn = draw(
            run,
            movie=movie,
            told=lambda done, of: bar.update(task, completed=done, total=of),
            tabled=partial(print_summary, run) if summed_up else lambda: None,
        )
    _print_drawn(drawn)
    describe_results(run.path)


def print_ensemble_pictures(ensemble: Ensemble) -> None:
    """Draw the pictures and the page of an ensemble, and print their paths."""
    _print_drawn(draw_ensemble(ensemble))
    describe_results(ensemble.path)


def leave_tables(run: Run) -> None:
    """Write the tables and networks of a run, and describe all of its files."""
    write_tables(run, networks(run)[0])
    describe_results(run.path)


def leave_missing_tables(runs: Iterable[Run]) -> str:
    """Leave tables and networks of members without them; return a sentence on those that have them.

    A member lacks them if it failed or was killed, or if an earlier version finished it.

    Parameters
    ----------
    runs : runs of the members.
    """
    reached = [run for run in runs if run.steps]
    for run in reached:
        if not (run.path / NETWORK).exists():
            leave_tables(run)
    what = "members with tables, and networks of steps with fields"
    return f"{what}: {len(reached)}, all that reached a step"


def describe_results(path: Path) -> None:
    """Describe a run or an ensemble as a research object, its results included.

    Parameters
    ----------
    path : its directory.
    """
    with writing(path):
        write_crate(path)


def print_study_pictures(study: Study) -> None:
    """Draw the pictures and the page of a study, and print their paths."""
    _print_drawn(draw_study(study))


def print_pair_pictures(pair: Pair, folder: Path) -> None:
    """Draw the pictures and the page of two runs into a folder, and print their paths."""
    _print_drawn(draw_pair(pair, folder))


def _print_facts(heading: str, told: Iterable[Fact]) -> None:
    out.print(f"[bold]{escape(heading)}[/bold]")
    rows = Grid(box=None, show_header=False)
    for fact in told:
        rows.add_row(
            fact.name, f"[red]{escape(fact.text)}[/red]" if fact.alarm else escape(fact.text)
        )
    out.print(rows)


def _print_table(found: Table, *, titled: bool = False) -> None:
    """Print its rows, if there are any, and its notes; titled: with its title."""
    if found.rows:
        if titled:
            out.print(f"[bold]{escape(found.title)}[/bold]")
        if found.lead:
            out.print(escape(found.lead))
        grid = Grid(*map(escape, found.header))
        for lines in (found.lines, found.total_lines):
            for line in lines:
                grid.add_row(*map(escape, line))
            grid.add_section()
        out.print(grid)
    _print_notes(found.notes)


def _print_notes(notes: Iterable[str]) -> None:
    for note in notes:
        out.print(f"[dim]{escape(note)}[/dim]")


def _print_drawn(drawn: Drawn) -> None:
    for reason in drawn.skipped:
        out.print(f"[yellow]not drawn:[/yellow] {escape(reason)}")
    for path in (*drawn.pictures, *drawn.tables, drawn.page):
        print(printable(str(path)))


def require_clean_audit(runs: Sequence[Run]) -> None:
    """Refuse finished runs whose audit is violated.

    Raises
    ------
    AuditError
        The audit of a run is violated; with the steps and the first of its messages.
    """
    for one in runs:
        found = violations(one)
        if found:
            more = f" (and {len(found) - 1} more)" if len(found) > 1 else ""
            raise AuditError(
                f"the run in {one.path} is finished, but its audit is violated: {found[0]}{more}; "
                f"do not use its results before you know why (docs/reference/results.md, What the "
                f"audit checks)"
            )

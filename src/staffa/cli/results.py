"""Prints what a run or an ensemble found: its summary, its tables, its pictures."""

from collections.abc import Iterable

from rich.markup import escape
from rich.table import Table

from staffa.cli.terminal import out
from staffa.io.ensemble_directory import Ensemble
from staffa.io.run_directory import Run
from staffa.report.comparison import table
from staffa.report.drawing import Drawn, draw, draw_ensemble
from staffa.report.ensemble import ensemble_title, facts, sheets
from staffa.report.summary import Fact, summary, title


def print_summary(run: Run) -> None:
    """Facts, the comparison with the paper where it has a meaning, and its notes."""
    _print_facts(title(run), summary(run))
    compared = table(run)
    if compared is None:
        return
    beside = Table(*compared.header)
    for row in compared.rows:
        beside.add_row(*row)
    out.print(beside)
    _print_notes(compared.notes)


def print_ensemble(ensemble: Ensemble) -> None:
    """Facts, then the numbers of each member, with their means and errors, and what they are."""
    _print_facts(ensemble_title(ensemble), facts(ensemble))
    found = sheets(ensemble)
    for sheet in found:
        numbers = Table("seed", *map(escape, sheet.names), title=sheet.title, title_justify="left")
        for line in sheet.member_lines():
            numbers.add_row(*line)
        numbers.add_section()
        for line in sheet.total_lines():
            numbers.add_row(*line)
        out.print(numbers)
    _print_notes(dict.fromkeys(note for sheet in found for note in sheet.notes))


def print_pictures(run: Run) -> None:
    """Draw the pictures and the page, and print where they are."""
    _print_drawn(draw(run))


def print_ensemble_pictures(ensemble: Ensemble) -> None:
    """The same of an ensemble."""
    _print_drawn(draw_ensemble(ensemble))


def _print_facts(heading: str, told: Iterable[Fact]) -> None:
    out.print(f"[bold]{escape(heading)}[/bold]")
    rows = Table(box=None, show_header=False)
    for fact in told:
        rows.add_row(
            fact.name, f"[red]{escape(fact.text)}[/red]" if fact.alarm else escape(fact.text)
        )
    out.print(rows)


def _print_notes(notes: Iterable[str]) -> None:
    for note in notes:
        out.print(f"[dim]{escape(note)}[/dim]")


def _print_drawn(drawn: Drawn) -> None:
    for reason in drawn.skipped:
        out.print(f"[yellow]not drawn:[/yellow] {escape(reason)}")
    for path in (*drawn.pictures, *drawn.tables, drawn.page):
        print(path)

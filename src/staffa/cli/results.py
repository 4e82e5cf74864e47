"""Prints what a run found: its summary, its table beside published ones, its pictures."""

from rich.markup import escape
from rich.table import Table

from staffa.cli.terminal import out
from staffa.io.run_directory import Run
from staffa.report.comparison import table
from staffa.report.drawing import draw
from staffa.report.summary import summary, title


def print_summary(run: Run) -> None:
    """Facts, the comparison with the paper where it has a meaning, and its notes."""
    out.print(f"[bold]{escape(title(run))}[/bold]")
    facts = Table(box=None, show_header=False)
    for fact in summary(run):
        facts.add_row(
            fact.name, f"[red]{escape(fact.text)}[/red]" if fact.alarm else escape(fact.text)
        )
    out.print(facts)
    compared = table(run)
    if compared is None:
        return
    beside = Table(*compared.header)
    for row in compared.rows:
        beside.add_row(*row)
    out.print(beside)
    for note in compared.notes:
        out.print(f"[dim]{escape(note)}[/dim]")


def print_pictures(run: Run) -> None:
    """Draw the pictures and the page, and print where they are."""
    drawn = draw(run)
    for reason in drawn.skipped:
        out.print(f"[yellow]not drawn:[/yellow] {escape(reason)}")
    for path in (*drawn.pictures, drawn.page):
        print(path)

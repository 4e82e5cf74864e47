"""The report of a run, and that of an ensemble, as one self-contained HTML page."""

from collections.abc import Sequence
from pathlib import Path

from staffa.io.ensemble_directory import Ensemble
from staffa.io.run_directory import Run
from staffa.report import comparison, pieces
from staffa.report.ensemble import ensemble_title, facts, sheets
from staffa.report.network import Drawing, lines_of
from staffa.report.summary import summary, title

CAPTIONS = {
    "cracks": "The cracks at chosen times.",
    "network": "The crack network, and how far it is open.",
    "energies": "Energies of each step.",
    "reactions": "What the supports carry: the force of each held side on the body.",
    "heat": "Heat stored since the start, and from where it came (or, negative, went).",
    "lengths": "Length of the cracks, depth of each tip, and how many cross each depth.",
    "counts": "How many cracks cross each depth: the mean of the finished members, its standard "
    "error as a band, and each member as a thin line.",
    "growth": "Growth of the cracks: the mean of the finished members, its standard error as a "
    "band, and each member as a thin line.",
}


def page(
    run: Run, found: Sequence[Drawing], pictures: Sequence[Path], skipped: Sequence[str]
) -> str:
    """A run's page: summary, comparison, networks, pictures, case; the pictures are embedded."""
    parts = [
        pieces.fact_list(summary(run)),
        _compared(run),
        _networks(run, found),
        *_pictures(pictures, skipped),
        pieces.case_text(run.case),
        pieces.footer(_origin(run)),
    ]
    return pieces.document(title(run), parts)


def ensemble_page(ensemble: Ensemble, pictures: Sequence[Path], skipped: Sequence[str]) -> str:
    """An ensemble's page: its members' numbers, their means and errors, pictures, case."""
    tables = [
        pieces.table(
            sheet.title,
            ("seed", *sheet.names),
            sheet.member_lines(),
            totals=sheet.total_lines(),
            under=sheet.notes,
        )
        for sheet in sheets(ensemble)
    ]
    parts = [
        pieces.fact_list(facts(ensemble)),
        *tables,
        *_pictures(pictures, skipped),
        pieces.case_text(ensemble.first.case),
        pieces.footer(f"of the first member: {_origin(ensemble.first)}"),
    ]
    return pieces.document(ensemble_title(ensemble), parts)


def _compared(run: Run) -> str:
    compared = comparison.table(run)
    if compared is None:
        return ""
    heading = "Nucleation and arrests, beside published numbers"
    return pieces.table(heading, compared.header, compared.rows, under=compared.notes)


def _networks(run: Run, found: Sequence[Drawing]) -> str:
    header, rows = lines_of(run, found)
    if not rows:
        return ""
    note = (
        "One row for each moment whose fields were kept; the volume is the integral of the opening."
    )
    return pieces.table("Crack network", header, rows, under=[note])


def _pictures(pictures: Sequence[Path], skipped: Sequence[str]) -> list[str]:
    figures = (pieces.figure(path, CAPTIONS.get(path.stem, path.stem)) for path in pictures)
    return ["<h2>Pictures</h2>", *figures, pieces.notes(skipped)]


def _origin(run: Run) -> str:
    m = run.manifest
    commit = f", commit {m.commit}" if m.commit else ""
    ranks = "1 rank" if m.ranks == 1 else f"{m.ranks} ranks"
    versions = ", ".join(f"{name} {version}" for name, version in m.versions.items())
    return f"staffa {m.version}{commit}, {m.created}, {ranks}, mesh {m.mesh}; {versions}"

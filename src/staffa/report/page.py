"""The report of a run, of an ensemble and of two runs, as one self-contained HTML page."""

from collections.abc import Sequence
from pathlib import Path

from staffa.compare.agreement import agreement
from staffa.compare.differences import case_differences, manifest_differences
from staffa.compare.pair import Pair, pair_title
from staffa.compare.side_by_side import common_times, results
from staffa.io.ensemble_directory import Ensemble
from staffa.io.run_directory import Run
from staffa.records.manifest import Manifest
from staffa.records.step import Step
from staffa.report import html
from staffa.report.captions import caption
from staffa.results import slab_table
from staffa.results.columns import columns
from staffa.results.crack_network import Drawing, lines_of, words_on_openings
from staffa.results.ensemble_means import ensemble_title, facts, sheets
from staffa.results.spacing import TITLE, spacing
from staffa.results.summary import summary, title


def page(
    run: Run, found: Sequence[Drawing], pictures: Sequence[Path], skipped: Sequence[str]
) -> str:
    """A run's page: summary, comparison, cells, networks, pictures, case; pictures are embedded."""
    parts = [
        html.fact_list(summary(run)),
        _compared(run),
        _plain(TITLE, spacing(run)),
        _networks(run, found),
        *_pictures(pictures, skipped, run.manifest, run.steps),
        html.case_text(run.case),
        html.footer(_origin(run)),
    ]
    return html.document(title(run), parts)


def ensemble_page(ensemble: Ensemble, pictures: Sequence[Path], skipped: Sequence[str]) -> str:
    """An ensemble's page: its members' numbers, their means and errors, cells, pictures, case."""
    tables = [
        html.table(
            sheet.title,
            ("seed", *sheet.names),
            sheet.member_lines(),
            totals=sheet.total_lines(),
            under=sheet.notes,
        )
        for sheet in sheets(ensemble)
    ]
    parts = [
        html.fact_list(facts(ensemble)),
        *tables,
        _columns(list(ensemble.finished.values())),
        *_pictures(pictures, skipped, ensemble.first.manifest, ensemble.first.steps),
        html.case_text(ensemble.first.case),
        html.footer(f"of the first member: {_origin(ensemble.first)}"),
    ]
    return html.document(ensemble_title(ensemble), parts)


def pair_page(pair: Pair, pictures: Sequence[Path], skipped: Sequence[str]) -> str:
    """The page of two runs: whether they agree, what differs, results, pictures, cases."""
    parts = [
        html.fact_list(agreement(pair)),
        _plain("What differs in the cases", case_differences(pair)),
        _plain("What differs in the runs", manifest_differences(pair)),
        _plain("Results", results(pair)),
        _plain("At common times", common_times(pair)),
        *_pictures(pictures, skipped, pair.first.run.manifest, pair.first.run.steps),
        *(html.case_text(side.run.case, f"Case of {side.name}") for side in pair.sides),
        *(html.footer(f"{side.name}: {_origin(side.run)}") for side in pair.sides),
    ]
    return html.document(pair_title(pair), parts)


def _plain(heading: str, found: slab_table.Table) -> str:
    return html.table(heading, found.header, found.rows, under=found.notes, plain=True)


def _compared(run: Run) -> str:
    compared = slab_table.table(run)
    if compared is None:
        return ""
    heading = "Nucleation and arrests, beside published numbers"
    return html.table(heading, compared.header, compared.rows, under=compared.notes)


def _columns(runs: Sequence[Run]) -> str:
    found = columns(runs)
    if found is None:
        return ""
    heading = f"Cells at the last step, {len(runs)} runs together"
    return html.table(heading, found.header, found.rows, under=found.notes, plain=True)


def _networks(run: Run, found: Sequence[Drawing]) -> str:
    header, rows = lines_of(run, found)
    if not rows:
        return ""
    note = (
        "One row for each moment whose fields were kept; the volume is the integral of the opening."
    )
    under = [note, *words_on_openings(run, found)]
    return html.table("Crack network", header, rows, under=under)


def _pictures(
    pictures: Sequence[Path], skipped: Sequence[str], manifest: Manifest, steps: Sequence[Step]
) -> list[str]:
    figures = (html.figure(path, caption(path.stem, manifest, steps)) for path in pictures)
    return ["<h2>Pictures</h2>", *figures, html.notes(skipped)]


def _origin(run: Run) -> str:
    m = run.manifest
    commit = f", commit {m.commit}" if m.commit else ""
    ranks = "1 rank" if m.ranks == 1 else f"{m.ranks} ranks"
    versions = ", ".join(f"{name} {version}" for name, version in m.versions.items())
    return f"staffa {m.version}{commit}, {m.created}, {ranks}, mesh {m.mesh}; {versions}"

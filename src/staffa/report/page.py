"""The report of a run, of an ensemble and of two runs, as one self-contained HTML page."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import datetime
from functools import cache
from itertools import chain
from pathlib import Path
from types import MappingProxyType

from jinja2 import Environment, PackageLoader, StrictUndefined

from staffa.compare.agreement import agreement
from staffa.compare.differences import case_differences, manifest_differences
from staffa.compare.pair import Pair, pair_title
from staffa.compare.side_by_side import common_times, results
from staffa.io.ensemble_directory import Ensemble
from staffa.io.own_files import GENERATOR
from staffa.io.run_directory import Run
from staffa.report.captions import caption
from staffa.report.charts import Chart
from staffa.report.embedding import embedded_file, policy, scripts
from staffa.report.provenance_tables import (
    Repeated,
    ensemble_again,
    pair_again,
    run_again,
    versions_table,
)
from staffa.report.time_slides import TimeSlides
from staffa.results import slab_table
from staffa.results.columns import columns
from staffa.results.crack_network import Drawing, network_table
from staffa.results.ensemble_means import PRODUCTION as PRODUCTION_SHEET
from staffa.results.ensemble_means import ensemble_title, facts, sheets
from staffa.results.facts import Fact
from staffa.results.production_table import production_numbers_table
from staffa.results.spacing import spacing
from staffa.results.summary import summary, title
from staffa.results.tables import Table

PLAIN = True  # tables of which no row stands out
# Pictures that stand beside their table, in this order.
PRODUCTION_OF_ALL = "production-of-all"
WATER = PRODUCTION, EXCHANGE, RESERVOIR = "production", "exchange", "reservoir"


@dataclass(frozen=True, kw_only=True)
class Picture:
    """Picture of a page, and its curves, which a reader can hover and zoom.

    Attributes
    ----------
    stem : its name.
    path : its file, which is embedded; None for curves alone.
    charts : its panels of curves, or cracks in 3-D; none of other pictures.
    """

    stem: str
    path: Path | None = None
    charts: tuple[Chart, ...] = ()


def page(
    run: Run,
    found: Sequence[Drawing],
    pictures: Sequence[Picture],
    skipped: Sequence[str],
    *,
    slides: TimeSlides | None = None,
    grows: int | None = None,
) -> str:
    """Return a run's page: summary, comparison, spacing, networks, production, pictures, case.

    Parameters
    ----------
    run : the run.
    found : its networks.
    pictures : pictures with their curves.
    skipped : a sentence on each that could not be drawn.
    slides : pictures of damage and temperature in time; None for none.
    grows : seconds after which the page is read again; None for the page of a run that is over.
    """
    cracked = [drawn for drawn in found if drawn.network.size]
    tables = [(spacing(run), PLAIN)]
    if (compared := slab_table.table(run)) is not None:
        tables.insert(0, (compared, not PLAIN))
    if cracked:
        tables.append((network_table(run, cracked), not PLAIN))
    water = production_numbers_table(run)
    if water.rows:
        tables.append((water, PLAIN))
    shown = {one.stem: one for one in pictures if water.rows}
    beside = [shown[stem] for stem in WATER if stem in shown]
    return rendered_page(
        run,
        pictures,
        beside={water.title: beside},
        title=title(run),
        facts=summary(run),
        tables=tables,
        skipped=skipped,
        cases=[("Case", run.case)],
        origins=[origin(run)],
        slides=slides,
        repeated=run_again(run),
        made_by=versions_table({"version": run}),
        grows=grows,
    )


def ensemble_page(
    ensemble: Ensemble,
    pictures: Sequence[Picture],
    skipped: Sequence[str],
    *,
    grows: int | None = None,
) -> str:
    """Return an ensemble's page: its members' numbers, their means and errors, cells, pictures.

    Parameters
    ----------
    ensemble : the ensemble.
    pictures : pictures with their curves.
    skipped : a sentence on each that could not be drawn.
    grows : seconds after which the page is read again; None for that of an ensemble that is over.
    """
    tables = [(sheet, not PLAIN) for sheet in sheets(ensemble)]
    runs = list(ensemble.finished.values())
    if (cells := columns(runs)) is not None:
        heading = f"Cells at the last step, {len(runs)} runs together"
        tables.append((replace(cells, title=heading), PLAIN))
    beside = [one for one in pictures if one.stem == PRODUCTION_OF_ALL]
    return rendered_page(
        ensemble.first,
        pictures,
        beside={PRODUCTION_SHEET: beside},
        title=ensemble_title(ensemble),
        facts=facts(ensemble),
        tables=tables,
        skipped=skipped,
        cases=[("Case", ensemble.first.case)],
        origins=[f"of the first member: {origin(ensemble.first)}"],
        repeated=ensemble_again(ensemble),
        made_by=versions_table({"version, of the first member": ensemble.first}),
        grows=grows,
    )


def pair_page(pair: Pair, folder: Path, pictures: Sequence[Picture], skipped: Sequence[str]) -> str:
    """Return the page of two runs: whether they agree, what differs, results, pictures, cases.

    Parameters
    ----------
    pair : the two runs.
    folder : folder of the page.
    pictures : pictures with their curves.
    skipped : a sentence on each that could not be drawn.
    """
    tables = (
        case_differences(pair),
        manifest_differences(pair),
        results(pair),
        common_times(pair),
    )
    return rendered_page(
        pair.first.run,
        pictures,
        title=pair_title(pair),
        facts=agreement(pair),
        tables=[(table, PLAIN) for table in tables],
        skipped=skipped,
        cases=[(f"Case of {side.name}", side.run.case) for side in pair.sides],
        origins=[f"{side.name}: {origin(side.run)}" for side in pair.sides],
        repeated=pair_again(pair, folder),
        made_by=versions_table({side.name: side.run for side in pair.sides}),
    )


def rendered_page(
    run: Run,
    pictures: Sequence[Picture],
    beside: Mapping[str, Sequence[Picture]] = MappingProxyType({}),
    *,
    title: str,
    facts: Iterable[Fact],
    tables: Sequence[tuple[Table, bool]],
    skipped: Sequence[str],
    cases: Sequence[tuple[str, str]] = (),
    origins: Sequence[str] = (),
    slides: TimeSlides | None = None,
    repeated: Repeated = (),
    made_by: Table | None = None,
    grows: int | None = None,
) -> str:
    """Return a page of facts, slides, tables, pictures and curves, cases and versions.

    Parameters
    ----------
    run : the run whose captions the pictures have, the first of several.
    pictures : pictures with their curves.
    beside : pictures that stand below a table, by its title.
    title : heading of the page.
    facts : rows of its summary.
    tables : tables, each with `PLAIN` if no row of it stands out.
    skipped : a sentence on each picture that could not be drawn.
    cases : headings and texts of cases.
    origins : lines on when and where the runs were computed.
    slides : pictures of damage and temperature in time; None for none.
    repeated : commands that repeat what the page shows.
    made_by : versions of programs; None for none.
    grows : seconds after which the page is read again; None for a page of what is over.
    """
    live = any(picture.charts for picture in pictures)
    return (
        _templates()
        .get_template("page.html")
        .render(
            generator=GENERATOR,
            policy=policy(),
            scripts=scripts() if live else scripts()[1:],
            pictures=[one for one in pictures if one not in list(chain(*beside.values()))],
            beside=beside,
            captions={one.stem: caption(one.stem, run.manifest, run.steps) for one in pictures},
            title=title,
            facts=facts,
            tables=tables,
            skipped=skipped,
            cases=cases,
            origins=origins,
            slides=slides,
            repeated=repeated,
            versions=made_by,
            grows=grows,
            written=datetime.now().astimezone().strftime("%H:%M:%S"),
        )
    )


@cache
def _templates() -> Environment:
    """Return the templates; what they are given is escaped."""
    found = Environment(
        loader=PackageLoader("staffa.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
    )
    found.filters |= {"embedded": embedded_file, "symbol": _symbol}
    return found


def _symbol(name: str) -> tuple[str, str, str]:
    """Return the name of a column in three parts, the second its index: tau1 is τ, 1."""
    match = re.fullmatch(r"(a|t|tau)(\d+)( \(.+\))?", name)
    return (match[1].replace("tau", "τ"), match[2], match[3] or "") if match else (name, "", "")


def origin(run: Run) -> str:
    """Return when and on what a run was computed, as a line."""
    m = run.manifest
    ranks = "1 rank" if m.ranks == 1 else f"{m.ranks} ranks"
    return f"staffa {m.version}, {m.created}, {ranks}, mesh {m.mesh}"

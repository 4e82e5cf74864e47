"""The report of a run, of an ensemble and of two runs, as one self-contained HTML page."""

import re
from base64 import b64encode
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import chain
from pathlib import Path
from types import MappingProxyType
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

from staffa.compare.agreement import agreement
from staffa.compare.differences import case_differences, manifest_differences
from staffa.compare.pair import Pair, pair_title
from staffa.compare.side_by_side import common_times, results
from staffa.io.ensemble_directory import Ensemble
from staffa.io.own_files import GENERATOR
from staffa.io.run_directory import Run
from staffa.report.captions import caption
from staffa.results import slab_table
from staffa.results.columns import columns
from staffa.results.crack_network import Drawing, network_table
from staffa.results.ensemble_means import PRODUCTION as PRODUCTION_SHEET
from staffa.results.ensemble_means import ensemble_title, facts, sheets
from staffa.results.production_table import production_numbers_table
from staffa.results.spacing import spacing
from staffa.results.summary import summary, title

# Nothing runs on a page, and nothing is loaded: what is on it may come from anyone.
POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"
PLAIN = True  # tables of which no row stands out
# Pictures that stand beside their table, in this order.
PRODUCTION_OF_ALL = "production-of-all"
WATER = PRODUCTION, EXCHANGE, RESERVOIR = "production", "exchange", "reservoir"


def page(
    run: Run, found: Sequence[Drawing], pictures: Sequence[Path], skipped: Sequence[str]
) -> str:
    """Return a run's page: summary, comparison, spacing, networks, production, pictures, case.

    Parameters
    ----------
    run : the run.
    found : its networks.
    pictures : files of pictures, which are embedded.
    skipped : a sentence on each that could not be drawn.
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
    beside = [path for path in pictures if water.rows and path.stem in WATER]
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
    )


def ensemble_page(ensemble: Ensemble, pictures: Sequence[Path], skipped: Sequence[str]) -> str:
    """Return an ensemble's page: its members' numbers, their means and errors, cells, pictures.

    Parameters
    ----------
    ensemble : the ensemble.
    pictures : files of pictures, which are embedded.
    skipped : a sentence on each that could not be drawn.
    """
    tables = [(sheet, not PLAIN) for sheet in sheets(ensemble)]
    runs = list(ensemble.finished.values())
    if (cells := columns(runs)) is not None:
        heading = f"Cells at the last step, {len(runs)} runs together"
        tables.append((replace(cells, title=heading), PLAIN))
    beside = [path for path in pictures if path.stem == PRODUCTION_OF_ALL]
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
    )


def pair_page(pair: Pair, pictures: Sequence[Path], skipped: Sequence[str]) -> str:
    """Return the page of two runs: whether they agree, what differs, results, pictures, cases.

    Parameters
    ----------
    pair : the two runs.
    pictures : files of pictures, which are embedded.
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
    )


def rendered_page(
    run: Run,
    pictures: Sequence[Path],
    beside: Mapping[str, Sequence[Path]] = MappingProxyType({}),
    **parts: Any,
) -> str:
    """Return the page of these parts, with the captions of a run.

    Parameters
    ----------
    run : the run whose captions the pictures have, the first of several.
    pictures : files of pictures.
    beside : pictures that stand below a table, by its title.
    parts : title, facts, tables and others of the template.
    """
    captions = {path.stem: caption(path.stem, run.manifest, run.steps) for path in pictures}
    return (
        _templates()
        .get_template("page.html")
        .render(
            generator=GENERATOR,
            policy=POLICY,
            pictures=[path for path in pictures if path not in chain(*beside.values())],
            beside=beside,
            captions=captions,
            **parts,
        )
    )


def _templates() -> Environment:
    """Return the templates; what they are given is escaped."""
    found = Environment(
        loader=PackageLoader("staffa.report"),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
    )
    found.filters |= {"embedded": _embedded, "symbol": _symbol}
    return found


def _embedded(picture: Path) -> str:
    """Return a picture, a PNG or a GIF, as an address that holds all of it."""
    return f"data:image/{picture.suffix[1:]};base64,{b64encode(picture.read_bytes()).decode()}"


def _symbol(name: str) -> tuple[str, str, str]:
    """Return the name of a column in three parts, the second its index: tau1 is τ, 1."""
    match = re.fullmatch(r"(a|t|tau)(\d+)( \(.+\))?", name)
    return (match[1].replace("tau", "τ"), match[2], match[3] or "") if match else (name, "", "")


def origin(run: Run) -> str:
    """Return when and where a run was computed, with all versions."""
    m = run.manifest
    commit = f", commit {m.commit}" if m.commit else ""
    ranks = "1 rank" if m.ranks == 1 else f"{m.ranks} ranks"
    versions = ", ".join(f"{name} {version}" for name, version in m.versions.items())
    return f"staffa {m.version}{commit}, {m.created}, {ranks}, mesh {m.mesh}; {versions}"

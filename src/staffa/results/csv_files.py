"""Files of tables and crack networks of a run, or an ensemble, for other programs."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from staffa.errors import StaffaError
from staffa.io.ensemble_directory import PRODUCTION_MEANS, Ensemble
from staffa.io.own_files import write_aside
from staffa.io.run_directory import Run
from staffa.io.study_directory import STUDY_MEANS, STUDY_RESULTS, Study
from staffa.results.columns import cells_table, pooled_table
from staffa.results.crack_network import Drawing, write_networks
from staffa.results.ensemble_means import write_results
from staffa.results.members_production import production_means
from staffa.results.production_table import production_table
from staffa.results.release_table import release_table
from staffa.results.series import probes_table, quantities_table, reactions_table
from staffa.results.study_table import study_means, study_table
from staffa.results.tables import Table
from staffa.results.tips import tips_table

CELLS = "cells.csv"
TABLES = {
    "tips.csv": tips_table,
    CELLS: cells_table,
    "release.csv": release_table,
    "reactions.csv": reactions_table,
    "probes.csv": probes_table,
    "quantities.csv": quantities_table,
    "production.csv": production_table,
}


def write_tables(run: Run, found: Sequence[Drawing]) -> tuple[Path, ...]:
    """Write the tables into the run directory, over earlier ones, and return their paths.

    Parameters
    ----------
    run : the run.
    found : its crack networks, see `networks`.

    Raises
    ------
    StaffaError
        The run directory cannot be written to.
    """
    with writing(run.path):
        written = list(write_networks(run, found))
        for name, table in TABLES.items():
            written += _written(run.path / name, table(run))
    return tuple(written)


def write_ensemble(ensemble: Ensemble) -> tuple[Path, ...]:
    """Write the numbers of each member, then tables of all finished ones; return their paths.

    The latter are the polygonal cells, and the means of the production, if they have rows.

    Raises
    ------
    StaffaError
        The directory cannot be written to.
    """
    results = write_results(ensemble)
    with writing(ensemble.path):
        cells = _written(ensemble.path / CELLS, pooled_table(ensemble.finished.values()))
        means = _written(ensemble.path / PRODUCTION_MEANS, production_means(ensemble))
    return (results, *cells, *means)


def write_study(study: Study) -> tuple[Path, ...]:
    """Write the numbers of each run of a study, and means and errors, and return their paths.

    Raises
    ------
    StaffaError
        The directory cannot be written to.
    """
    with writing(study.path):
        runs = _written(study.path / STUDY_RESULTS, study_table(study))
        return runs + _written(study.path / STUDY_MEANS, study_means(study))


def _written(path: Path, table: Table) -> tuple[Path, ...]:
    """Write over an earlier table, or remove that if there are no rows now."""
    if not table.rows:
        path.unlink(missing_ok=True)
        return ()
    write_aside(path, table.csv())
    return (path,)


@contextmanager
def writing(folder: Path) -> Iterator[None]:
    """Turn errors of the disk into one message in this context."""
    try:
        yield
    except OSError as error:
        raise StaffaError(
            f"the report cannot be written into {folder}: {error.strerror}; copy the run to, "
            f"or choose with --out, a folder that you may write to"
        ) from None

"""Writes the tables and crack networks of a run, which other programs read; no pictures."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from staffa.errors import StaffaError
from staffa.io.run_directory import Run, write_aside
from staffa.report.network import Drawing, write_networks
from staffa.report.series import probes_table, reactions_table
from staffa.report.tips import tips_table

TABLES = {"tips.csv": tips_table, "reactions.csv": reactions_table, "probes.csv": probes_table}


def write_tables(run: Run, found: Sequence[Drawing]) -> tuple[Path, ...]:
    """Write them into the run, over earlier ones, and give those that there are.

    found: its networks, see `networks`.

    Raises
    ------
    StaffaError
        The run directory cannot be written to.
    """
    with writing(run.path):
        written = list(write_networks(run, found))
        for name, table in TABLES.items():
            text = table(run)
            if text is None:
                (run.path / name).unlink(missing_ok=True)
                continue
            write_aside(run.path / name, text)
            written.append(run.path / name)
    return tuple(written)


@contextmanager
def writing(folder: Path) -> Iterator[None]:
    """Within it, what the disk refuses is told in one sentence."""
    try:
        yield
    except OSError as error:
        raise StaffaError(
            f"the report cannot be written into {folder}: {error.strerror}; copy the run to, "
            f"or choose with --out, a folder that you may write to"
        ) from None

"""Times of the notebooks of a build, into `notebook-times.txt` beside its pages."""

from pathlib import Path
from typing import Any

from myst_nb.sphinx_ import NbMetadataCollector
from sphinx.application import Sphinx

FILE = "notebook-times.txt"
MOST = 60.0  # s, that a reader waits for a tutorial


def times(app: Sphinx) -> dict[str, float]:
    """Return the seconds that each notebook took when it was last executed, by its page."""
    found = {}
    for page in sorted(app.env.found_docs):
        run = NbMetadataCollector.get_exec_data(app.env, page)
        if run is not None and run["runtime"] is not None:
            found[page] = float(run["runtime"])
    return found


def table(seconds: dict[str, float]) -> str:
    """Return a line for each notebook, with a mark where it took more than a minute."""
    lines = ["seconds that each notebook took, the starts of its kernel and its runs included"]
    lines += [
        f"{time:6.1f}  {page}{'  more than a minute' if time > MOST else ''}"
        for page, time in seconds.items()
    ]
    return "\n".join(lines) + "\n"


def write_times(app: Sphinx, error: Exception | None) -> None:
    """Write the table, if notebooks were executed."""
    seconds = {} if error else times(app)
    if seconds and app.builder.format == "html":
        Path(app.outdir, FILE).write_text(table(seconds), encoding="utf-8")


def setup(app: Sphinx) -> dict[str, Any]:
    """Write the times at the end of a build."""
    app.connect("build-finished", write_times)
    return {"parallel_read_safe": True}

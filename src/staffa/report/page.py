"""The report as one self-contained HTML page: summary, comparison, pictures, case."""

from base64 import b64encode
from collections.abc import Sequence
from html import escape
from pathlib import Path

from staffa.io.run_directory import Run
from staffa.report.comparison import Table, table
from staffa.report.summary import Fact, summary, title

CAPTIONS = {
    "cracks": "The cracks at chosen times.",
    "energies": "Energies of each step.",
    "lengths": "Length of the cracks, depth of each tip, and how many cross each depth.",
}
STYLE = """
:root { color-scheme: light; --ink: #1a1a1a; --soft: #666; --line: #ddd; --alarm: #b3261e; }
* { box-sizing: border-box; }
body { margin: 0 auto; padding: 1.5rem 1rem 3rem; max-width: 58rem; color: var(--ink);
  background: #fff; font: 16px/1.5 system-ui, -apple-system, "Segoe UI", Roboto, sans-serif; }
h1 { font-size: 1.6rem; line-height: 1.25; margin: 0 0 1.2rem; }
h2 { font-size: 1.1rem; margin: 2.2rem 0 .6rem; }
dl { display: grid; grid-template-columns: minmax(7rem, max-content) 1fr; gap: .3rem 1.2rem;
  margin: 0; }
dt { color: var(--soft); }
dd { margin: 0; overflow-wrap: anywhere; }
.alarm { color: var(--alarm); font-weight: 600; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; width: 100%; font-variant-numeric: tabular-nums; }
th, td { padding: .4rem .6rem; text-align: right; white-space: nowrap;
  border-bottom: 1px solid var(--line); }
sub { line-height: 0; }
th:first-child, td:first-child { text-align: left; }
thead th { color: var(--soft); font-weight: 500; }
tbody tr:last-child td { font-weight: 600; background: #f4f7fb; }
ul.notes { color: var(--soft); font-size: .85rem; padding-left: 1.1rem; }
figure { margin: 1rem 0 2rem; }
figcaption { color: var(--soft); font-size: .85rem; }
img { width: 100%; height: auto; display: block; }
pre { overflow-x: auto; background: #f6f6f6; padding: .8rem; font-size: .8rem; }
footer { margin-top: 3rem; color: var(--soft); font-size: .8rem; overflow-wrap: anywhere; }
@media (max-width: 34rem) { dl { grid-template-columns: 1fr; gap: 0; } dd { margin: 0 0 .5rem; } }
"""


def page(run: Run, pictures: Sequence[Path], skipped: Sequence[str]) -> str:
    """The page's text; the pictures are embedded."""
    compared = table(run)
    parts = [
        f"<h1>{escape(title(run))}</h1>",
        _facts(summary(run)),
        _table(compared) if compared else "",
        "<h2>Pictures</h2>",
        *(_figure(picture) for picture in pictures),
        _notes(skipped) if skipped else "",
        f"<h2>Case</h2><details><summary>case.toml</summary><pre>{escape(run.case)}</pre></details>",
        _footer(run),
    ]
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title(run))}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(part for part in parts if part)
        + "\n</body>\n</html>\n"
    )


def _facts(facts: Sequence[Fact]) -> str:
    rows = (
        f"<dt>{escape(fact.name)}</dt><dd{' class="alarm"' if fact.alarm else ''}>"
        f"{escape(fact.text)}</dd>"
        for fact in facts
    )
    return f"<dl>{''.join(rows)}</dl>"


def _table(compared: Table) -> str:
    head = "".join(f"<th>{_symbol(name)}</th>" for name in compared.header)
    rows = ("".join(f"<td>{escape(cell)}</td>" for cell in row) for row in compared.rows)
    body = "".join(f"<tr>{row}</tr>" for row in rows)
    return (
        "<h2>Nucleation and arrests, beside published numbers</h2>"
        f'<div class="wide"><table><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>" + _notes(compared.notes)
    )


def _symbol(name: str) -> str:
    """tau1 as a reader knows it: the Greek letter with its index."""
    letter = name.rstrip("0123456789")
    index = name[len(letter) :]
    return letter.replace("tau", "τ") + (f"<sub>{index}</sub>" if index else "")


def _notes(sentences: Sequence[str]) -> str:
    return f'<ul class="notes">{"".join(f"<li>{escape(s)}</li>" for s in sentences)}</ul>'


def _figure(picture: Path) -> str:
    caption = CAPTIONS.get(picture.stem, picture.stem)
    image = b64encode(picture.read_bytes()).decode("ascii")
    return (
        f'<figure><img alt="{escape(caption)}" src="data:image/png;base64,{image}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def _footer(run: Run) -> str:
    m = run.manifest
    commit = f", commit {m.commit}" if m.commit else ""
    ranks = "1 rank" if m.ranks == 1 else f"{m.ranks} ranks"
    versions = ", ".join(f"{name} {version}" for name, version in m.versions.items())
    text = f"staffa {m.version}{commit}, {m.created}, {ranks}, mesh {m.mesh}; {versions}"
    return f"<footer>{escape(text)}</footer>"

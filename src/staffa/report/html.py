"""The pieces that a page is put together from, as HTML that needs no other file."""

import re
from base64 import b64encode
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

from staffa.io.own_files import GENERATOR
from staffa.results.summary import Fact

# Nothing runs on a page, and nothing is loaded: what is on it may come from anyone.
POLICY = "default-src 'none'; img-src data:; style-src 'unsafe-inline'"

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
table:not(.plain) tbody:last-child tr:last-child td, tfoot td { background: #f4f7fb; }
table:not(.plain) tbody:last-child tr:last-child td, tfoot tr:first-child td { font-weight: 600; }
.plain td { white-space: normal; }
ul.notes { color: var(--soft); font-size: .85rem; padding-left: 1.1rem; }
figure { margin: 1rem 0 2rem; }
figcaption { color: var(--soft); font-size: .85rem; }
img { width: 100%; height: auto; display: block; }
pre { overflow-x: auto; background: #f6f6f6; padding: .8rem; font-size: .8rem; }
footer { margin-top: 3rem; color: var(--soft); font-size: .8rem; overflow-wrap: anywhere; }
@media (max-width: 34rem) { dl { grid-template-columns: 1fr; gap: 0; } dd { margin: 0 0 .5rem; } }
"""


def document(title: str, parts: Iterable[str]) -> str:
    """A whole page of its parts; an empty one is left out."""
    return (
        '<!doctype html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        f'{GENERATOR}\n<meta http-equiv="Content-Security-Policy" content="{POLICY}">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        f"<h1>{escape(title)}</h1>\n"
        + "\n".join(part for part in parts if part)
        + "\n</body>\n</html>\n"
    )


def fact_list(facts: Iterable[Fact]) -> str:
    """Names and texts, alarms in their color."""
    rows = (
        f"<dt>{escape(fact.name)}</dt><dd{' class="alarm"' if fact.alarm else ''}>"
        f"{escape(fact.text)}</dd>"
        for fact in facts
    )
    return f"<dl>{''.join(rows)}</dl>"


def table(
    heading: str,
    header: Sequence[str],
    rows: Iterable[Sequence[str]],
    *,
    totals: Iterable[Sequence[str]] = (),
    under: Sequence[str] = (),
    plain: bool = False,
) -> str:
    """A table with its heading and its notes.

    The totals, or else the last row, stand out, unless it is plain.
    """
    begin = f"<h2>{escape(heading)}</h2>"
    if not (lines := _rows(rows)):
        return begin + notes(under)
    head = "".join(f"<th>{_symbol(name)}</th>" for name in header)
    foot = _rows(totals)
    kind = ' class="plain"' if plain else ""
    return (
        f'{begin}<div class="wide"><table{kind}><thead><tr>{head}</tr></thead>'
        f"<tbody>{lines}</tbody>{f'<tfoot>{foot}</tfoot>' if foot else ''}</table></div>"
        + notes(under)
    )


def _rows(rows: Iterable[Sequence[str]]) -> str:
    cells = ("".join(f"<td>{escape(cell)}</td>" for cell in row) for row in rows)
    return "".join(f"<tr>{row}</tr>" for row in cells)


def _symbol(name: str) -> str:
    """tau1 as a reader knows it: the Greek letter with its index."""
    match = re.fullmatch(r"(a|t|tau)(\d+)( \(.+\))?", name)
    if not match:
        return escape(name)
    return f"{match[1].replace('tau', 'τ')}<sub>{match[2]}</sub>{escape(match[3] or '')}"


def notes(sentences: Sequence[str]) -> str:
    """A list in small type; nothing without sentences."""
    items = "".join(f"<li>{escape(s)}</li>" for s in sentences)
    return f'<ul class="notes">{items}</ul>' if items else ""


def figure(picture: Path, caption: str) -> str:
    """A picture, a PNG or a GIF, embedded."""
    image, kind = b64encode(picture.read_bytes()).decode("ascii"), picture.suffix[1:]
    return (
        f'<figure><img alt="{escape(caption)}" src="data:image/{kind};base64,{image}">'
        f"<figcaption>{escape(caption)}</figcaption></figure>"
    )


def case_text(text: str, heading: str = "Case") -> str:
    """The case file, folded."""
    return (
        f"<h2>{escape(heading)}</h2><details><summary>case.toml</summary>"
        f"<pre>{escape(text)}</pre></details>"
    )


def footer(text: str) -> str:
    """The last line."""
    return f"<footer>{escape(text)}</footer>"

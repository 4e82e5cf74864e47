#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Score the CSV files of any program against the reference tables. Needs Python alone.

    python score.py DIR [--json FILE]

DIR holds a file CASE.csv for each case that was computed, with the columns quantity, at, value.
Ends with exit code 0 if DIR could be read, whatever the scores, and with 2 if it could not.
"""

import argparse
import csv
import json
import math
import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from pathlib import Path

REFERENCE = Path(__file__).parent / "reference"
VERSION = 1  # of cases and tables: scores of two versions are not compared
COLUMNS = ("quantity", "at", "value")
WITHIN, OUTSIDE, MISSING = VERDICTS = ("within", "outside", "missing")
LOW = 0.1  # part of an upper bound by which a value may be below it before it gets a note
NOTE = "below our bound: please tell us"


class SubmissionError(Exception):
    """A submission that cannot be read; the message says what, where, and the way out."""


@dataclass(frozen=True)
class Figure:
    """A number of a case beside its reference.

    at: where on the curve of the quantity, tau say; None for a single number. tolerance: absolute.
    bound: "most" if the reference is an upper bound. value: None where it is missing.
    """

    case: str
    quantity: str
    at: float | None
    reference: float
    tolerance: float
    bound: str
    value: float | None = None

    @property
    def note(self) -> str:
        """A request where a value is so far below an upper bound that one of them may be wrong."""
        low = self.bound and self.value is not None and self.value < (1 - LOW) * self.reference
        return NOTE if low else ""

    @property
    def verdict(self) -> str:
        """Within the tolerance, outside of it, or missing."""
        if self.value is None:
            return MISSING
        over = self.value - self.reference
        return WITHIN if (over if self.bound else abs(over)) <= self.tolerance else OUTSIDE


def reference() -> list[Figure]:
    """Return all figures of the reference tables, without values."""
    figures = []
    for file in sorted(REFERENCE.glob("*.csv")):
        with file.open(newline="", encoding="utf-8") as opened:
            for row in csv.DictReader(opened):
                at = float(row["at"]) if row["at"] else None
                numbers = float(row["value"]), float(row["tolerance"])
                figures.append(Figure(file.stem, row["quantity"], at, *numbers, row["bound"]))
    return figures


# The rows of a case: of each quantity the values by place; a single number is at None.
Curves = dict[str, dict[float | None, float]]


def number(text: str, what: str, where: str) -> float:
    """Return a number of a submission.

    Raises
    ------
    SubmissionError
        It is none.
    """
    try:
        found = float(text)
        if "_" in text:  # Python alone reads 1_000 as a number
            raise ValueError
    except ValueError:
        raise SubmissionError(
            f'{where}: {what} = "{text}" is no number; write one, as 0.1285'
        ) from None
    if math.isnan(found):
        raise SubmissionError(f"{where}: {what} is nan; leave the row out where there is no value")
    return found


def read(file: Path, figures: Sequence[Figure]) -> Curves:
    """Return the rows of a file of a submission.

    Raises
    ------
    SubmissionError
        The file is no CSV file of the case.
    """
    try:
        table = list(csv.reader(file.read_text(encoding="utf-8-sig").splitlines()))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        raise SubmissionError(
            f"{file.name} cannot be read: {error}; write it as UTF-8 text"
        ) from None
    header = tuple(cell.strip() for cell in table[0]) if table else ()
    if header != COLUMNS:
        said = f'begins with "{",".join(header)}"'
        raise SubmissionError(f'{file.name} {said}; its first line must be "{",".join(COLUMNS)}"')
    known = {figure.quantity: figure.at is not None for figure in figures}
    energies = {figure.quantity for figure in figures if figure.bound}
    curves: Curves = {}
    for line, cells in enumerate(table[1:], start=2):
        if not cells:
            continue
        where = f"{file.name}, line {line}"
        if len(cells) != len(COLUMNS):
            said = "write three, and a quantity that has a comma in quotes"
            raise SubmissionError(f"{where}: {len(cells)} cells; {said}")
        quantity, at, value = row(cells, known, where)
        if at in curves.setdefault(quantity, {}):
            raise SubmissionError(
                f'{where}: a second value of "{quantity}" there; leave one of them out'
            )
        if quantity in energies and value <= 0:
            raise SubmissionError(
                f'{where}: value = {cells[2].strip()} of "{quantity}" cannot be, it is above 0; '
                "leave the row out where it was not computed"
            )
        curves[quantity][at] = value
    for quantity, curve in curves.items():
        refuse_twins(curve, f'{file.name}: "{quantity}"')
    return curves


def refuse_twins(curve: dict[float | None, float], what: str) -> None:
    """Raise an error if two rows of a curve stand for one place, but for rounding."""
    places = sorted(place for place in curve if place is not None)
    for one, other in pairwise(places):
        if other - one <= 2 * rounding(one):  # both may stand for the place between them
            said = f"at {one!r} and {other!r}, which are one place; leave one of them out"
            raise SubmissionError(f"{what} has values {said}")


def row(cells: list[str], known: dict[str, bool], where: str) -> tuple[str, float | None, float]:
    """Return quantity, place and value of a row; known: True for quantities that are curves."""
    quantity, at, value = (cell.strip() for cell in cells)
    if quantity not in known:
        raise SubmissionError(
            f'{where}: "{quantity}" is no quantity of this case; it has {names(known)}'
        )
    if known[quantity] and not at:
        raise SubmissionError(
            f'{where}: "{quantity}" is a curve; say in column at where the value holds'
        )
    if at and not known[quantity]:
        raise SubmissionError(f'{where}: "{quantity}" is a single number; leave column at empty')
    found = number(value, "value", where)
    if at and not math.isfinite(place := number(at, "at", where)):
        raise SubmissionError(f"{where}: at = {at} is not finite; leave the row out")
    if at and not math.isfinite(found):
        raise SubmissionError(
            f"{where}: value = {value} of a curve is not finite; leave the row out"
        )
    return quantity, place if at else None, found


def names(known: dict[str, bool]) -> str:
    """Return names as a list for a sentence."""
    return ", ".join(f'"{name}"' for name in known)


def rounding(at: float) -> float:
    """Return the distance below which two places are one, but for rounding."""
    return 1e-9 * max(1.0, abs(at))


def widest_gap(figure: Figure, figures: Sequence[Figure]) -> float:
    """Return how far apart two rows of a submission may be: twice the step of the reference."""
    if figure.at is None:
        return math.inf
    of = figure.case, figure.quantity
    places = {f.at for f in figures if (f.case, f.quantity) == of and f.at is not None}
    return 2 * min((abs(at - figure.at) for at in places - {figure.at}), default=math.inf)


def value_at(
    curve: dict[float | None, float], at: float | None, widest: float = math.inf
) -> float | None:
    """Return the value of a curve, linear between its rows.

    None outside of them, and between two rows that are farther apart than the widest gap.
    """
    if at is None:
        return curve.get(None)
    rows = sorted((place, value) for place, value in curve.items() if place is not None)
    close = rounding(at)
    before = [r for r in rows if r[0] <= at + close]
    after = [r for r in rows if r[0] >= at - close]
    if not before or not after:
        return None
    (a, low), (b, high) = before[-1], after[0]
    if b - a > widest + close:
        return None
    return low if b - a <= close else low + (high - low) * (at - a) / (b - a)


def score(folder: Path) -> list[Figure]:
    """Return all figures with the values of a submission.

    Raises
    ------
    SubmissionError
        The folder or a file of it is none of a submission.
    """
    figures = reference()
    cases = dict.fromkeys(figure.case for figure in figures)
    if not folder.is_dir():
        raise SubmissionError(f"{folder} is no folder; name the one that holds CASE.csv files")
    files = {file.stem: file for file in sorted(folder.glob("*.csv"))}
    if not files:
        raise SubmissionError(
            f"{folder} holds no CSV file; name one after its case: {', '.join(cases)}"
        )
    for name in files:
        if name not in cases:
            raise SubmissionError(
                f"{name}.csv is named after no case; the cases are {', '.join(cases)}"
            )
    read_cases = {
        case: read(file, [figure for figure in figures if figure.case == case])
        for case, file in files.items()
    }
    found = []
    for figure in figures:
        curve = read_cases.get(figure.case, {}).get(figure.quantity, {})
        value = value_at(curve, figure.at, widest_gap(figure, figures))
        found.append(Figure(**{**asdict(figure), "value": value}))
    return found


def by_case(figures: Sequence[Figure]) -> dict[str, dict[str, int | str]]:
    """Return of each case the number of figures by verdict, and the verdict of the case.

    A case is within if all of its figures are, outside if one is, and else missing.
    """
    found: dict[str, dict[str, int | str]] = {}
    for case in dict.fromkeys(figure.case for figure in figures):
        verdicts = [figure.verdict for figure in figures if figure.case == case]
        counts: dict[str, int | str] = {name: verdicts.count(name) for name in VERDICTS}
        whole = OUTSIDE if counts[OUTSIDE] else MISSING if counts[MISSING] else WITHIN
        found[case] = {**counts, "verdict": whole}
    return found


def table(figures: Sequence[Figure]) -> Iterator[str]:
    """Yield the lines of a table of the cases, and of what is not within (Markdown)."""
    yield "| case | within | outside | missing | verdict |"
    yield "| --- | --- | --- | --- | --- |"
    cases = by_case(figures)
    for case, counts in cases.items():
        yield f"| {case} | {' | '.join(str(counts[v]) for v in VERDICTS)} | {counts['verdict']} |"
    sums = [sum(figure.verdict == verdict for figure in figures) for verdict in VERDICTS]
    good = sum(counts["verdict"] == WITHIN for counts in cases.values())
    yield f"| together | {' | '.join(map(str, sums))} | {good} of {len(cases)} within |"
    yield from listed(OUTSIDE, [figure for figure in figures if figure.verdict == OUTSIDE])
    yield from listed(NOTE, [figure for figure in figures if figure.note])


def listed(title: str, figures: Sequence[Figure]) -> Iterator[str]:
    """Yield the lines of a table of figures, none without figures (Markdown)."""
    if figures:
        yield ""
        yield f"| {title} | at | value | reference | tolerance |"
        yield "| --- | --- | --- | --- | --- |"
    for f in figures:
        at, most = "" if f.at is None else f"{f.at:g}", "at most " if f.bound else ""
        numbers = f"{f.value:.4g} | {most}{f.reference:.4g} | {f.tolerance:.2g}"
        yield f"| {f.case}: {f.quantity} | {at} | {numbers} |"


def record(folder: Path, figures: Sequence[Figure]) -> str:
    """Return the scores as JSON; a value that is infinite is the text "inf"."""

    def plain(value: float | None) -> float | str | None:
        return value if value is None or math.isfinite(value) else str(value)

    rows = [
        {**asdict(f), "value": plain(f.value), "verdict": f.verdict, "note": f.note}
        for f in figures
    ]
    found = {"benchmark": VERSION, "submission": folder.resolve().name}
    return json.dumps({**found, "cases": by_case(figures), "figures": rows}, indent=1) + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Score the folder that is named."""
    parser = argparse.ArgumentParser(description="Score a program's CSV files.")
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder with CASE.csv files")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the scores there too")
    options = parser.parse_args(arguments)
    try:
        figures = score(options.folder)
        if options.json:
            options.json.write_text(record(options.folder, figures), encoding="utf-8")
    except (SubmissionError, OSError) as error:
        print(f"score.py: {error}", file=sys.stderr)
        return 2
    print("\n".join(table(figures)))
    return 0


if __name__ == "__main__":
    sys.exit(main())

"""One table of results: for the terminal and pages as text, for programs as CSV."""

import csv
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from io import StringIO

from staffa.display_units import NONE, Unit

Cell = str | int | float | None
ABSENT = "-"
# With these a cell begins that a spreadsheet takes for a formula.
COMPUTED = ("=", "+", "-", "@", "\t", "\r")
DIGITS = {"error": 2}  # of the rows of this name; others have four


@dataclass(frozen=True, kw_only=True)
class Column:
    """A column of a table.

    Attributes
    ----------
    name : heading for programs, without the unit.
    unit : unit in which its numbers are shown.
    label : heading for people, without the unit; empty if that is the name.
    """

    name: str
    unit: Unit = NONE
    label: str = ""

    @property
    def heading(self) -> str:
        """Heading for people: "mean opening (mm)"."""
        return self.unit.header(self.label or self.name)

    def shown(self, cell: Cell) -> Cell:
        """Return a cell in the unit of the column; texts and counts have none."""
        return self.unit.of(cell) if isinstance(cell, float) else cell


@dataclass(frozen=True, kw_only=True)
class Table:
    """Columns and rows, with a title above and notes below.

    Attributes
    ----------
    columns : names and units.
    rows : cells of each row, as many as columns; numbers in SI units, None where unknown.
    totals : rows below these, such as means.
    title : heading of the table, for people.
    lead : paragraph between the title and the rows.
    notes : sentences below it.
    """

    columns: tuple[Column, ...] = ()
    rows: tuple[tuple[Cell, ...], ...] = ()
    totals: tuple[tuple[Cell, ...], ...] = ()
    title: str = ""
    lead: str = ""
    notes: tuple[str, ...] = ()

    @property
    def header(self) -> tuple[str, ...]:
        """Headings for people."""
        return tuple(column.heading for column in self.columns)

    @property
    def lines(self) -> list[tuple[str, ...]]:
        """Rows as text."""
        return self._lines(self.rows)

    @property
    def total_lines(self) -> list[tuple[str, ...]]:
        """Totals as text."""
        return self._lines(self.totals)

    def _lines(self, rows: Iterable[Sequence[Cell]]) -> list[tuple[str, ...]]:
        return [
            tuple(number(cell, DIGITS.get(str(row[0]), 4)) for cell in self._shown(row))
            for row in rows
        ]

    def _shown(self, row: Sequence[Cell]) -> list[Cell]:
        return [column.shown(cell) for column, cell in zip(self.columns, row, strict=True)]

    def csv(self, digits: int | None = None) -> str:
        """Return header, rows and totals as CSV; what is not known is empty.

        Parameters
        ----------
        digits : of each number; None for all that it has.
        """
        text = StringIO()
        writer = csv.writer(text, lineterminator="\n")
        writer.writerow(column.unit.column(column.name) for column in self.columns)
        for row in (*self.rows, *self.totals):
            writer.writerow([_for_programs(cell, digits) for cell in self._shown(row)])
        return text.getvalue()


def _for_programs(cell: Cell, digits: int | None) -> Cell:
    """Return a cell of a CSV file; a quote precedes a text that a spreadsheet would compute."""
    if isinstance(cell, str):
        return f"'{cell}" if cell.startswith(COMPUTED) else cell
    return f"{cell:.{digits}g}" if digits and isinstance(cell, float) else cell


def columns_of(*names: str, unit: Unit = NONE) -> tuple[Column, ...]:
    """Return columns of one unit.

    Parameters
    ----------
    names : name of each.
    unit : unit of all.
    """
    return tuple(Column(name=name, unit=unit) for name in names)


def number(value: Cell, digits: int = 4) -> str:
    """Return a cell as text for people: texts and whole numbers as they are.

    Parameters
    ----------
    value : a text, a number in the unit that is shown, or None.
    digits : of a number that is not whole.
    """
    if value is None:
        return ABSENT
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)


def grouped(value: float, digits: int = 4) -> str:
    """Return a number as text, a large one with commas and without an exponent: "98,830".

    Parameters
    ----------
    value : the number.
    digits : its significant digits.
    """
    text = f"{value:.{digits}g}"
    return f"{float(text):,.0f}" if 10**digits <= abs(float(text)) < 1e9 else text

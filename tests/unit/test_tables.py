"""One table of results: what people read and what programs read have the same numbers."""

import csv
from io import StringIO

import pytest

from staffa.display_units import Unit
from staffa.results.tables import ABSENT, Column, Table, columns_of

MM, HOUR = Unit(name="mm", size=1e-3), Unit(name="h", size=3600.0)
TABLE = Table(
    columns=(
        Column(name="name"),
        Column(name="cracks"),
        Column(name="mean_opening", unit=MM, label="mean opening"),
        Column(name="time", unit=HOUR),
    ),
    rows=(("one", 3, 0.123456, 7200.0), ("=two", 4, None, 1.0)),
    totals=(("mean", 3.5, 0.123456, None), ("error", 0.123456, None, None)),
)


def test_numbers_are_shown_in_the_unit_of_their_column() -> None:
    assert TABLE.header == ("name", "cracks", "mean opening (mm)", "time (h)")
    assert TABLE.lines == [("one", "3", "123.5", "2"), ("=two", "4", ABSENT, "0.0002778")]


def test_an_error_has_two_digits() -> None:
    assert TABLE.total_lines == [
        ("mean", "3.5", "123.5", ABSENT),
        ("error", "0.12", ABSENT, ABSENT),
    ]


def test_programs_read_all_digits_and_the_unit_in_the_name() -> None:
    header, first, second, *totals = csv.reader(StringIO(TABLE.csv()))
    assert header == ["name", "cracks", "mean_opening_mm", "time_h"]
    assert first[:2] == ["one", "3"] and float(first[2]) == pytest.approx(123.456, rel=1e-15)
    assert second == ["'=two", "4", "", repr(1.0 / 3600.0)], "no formula, and empty if unknown"
    assert [row[0] for row in totals] == ["mean", "error"]


def test_digits_cut_numbers_but_no_counts() -> None:
    rows = ((123456789, 1.23456789, "1.23456789"),)
    written = Table(columns=columns_of("n", "x", "said"), rows=rows).csv(digits=3)
    assert written.splitlines()[1] == "123456789,1.23,1.23456789"


def test_a_row_has_as_many_cells_as_there_are_columns() -> None:
    with pytest.raises(ValueError, match="zip"):
        Table(columns=columns_of("n", "x"), rows=((1,),)).csv()

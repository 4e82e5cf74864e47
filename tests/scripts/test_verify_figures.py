"""A figure that had another reference before keeps it beside the new one: on the page, in sums."""

from verification.__main__ import balance, record, row
from verification.common.figures import Figure, Found


def length(measured: float, before: float) -> Figure:
    return Figure(
        what="length",
        source="sharp cracks",
        reference=1.0,
        measured=measured,
        tolerance=0.1,
        before=(before, "an even array"),
    )


def test_a_former_reference_stays_beside_with_its_verdict() -> None:
    (missed, met) = record(Found(figures=[length(1.05, 1.2), length(1.05, 1.1)], text=""))[
        "figures"
    ]
    assert row(missed) == (
        "| length | 1 (sharp cracks); before: 1.2 (an even array), missed | 1.05 | 0.1 | met |"
    )
    assert "before: 1.1 (an even array), met" in row(met)


def test_figures_that_only_their_former_reference_misses_are_counted_apart() -> None:
    figures = [length(1.05, 1.2), length(1.05, 1.1), length(1.5, 1.2)]
    said = balance({"heat": record(Found(figures=figures, text=""))})
    assert "| together | 3 | 1 |" in said
    assert "1 of the figures that are met missed a reference that they had before" in said
    alone = Figure(what="a", source="b", reference=1.0, measured=1.0, tolerance=0.0)
    assert "had before" not in balance({"heat": record(Found(figures=[alone], text=""))})

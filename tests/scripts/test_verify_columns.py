"""Conditions of `make verify ONLY=columns`: no, few, or shrinking cells do not meet them."""

import tomllib

import pytest

from staffa.measure.patterns import pattern
from staffa.records.step import CellSection
from support.paths import ROOT

DEPTHS = (0.2, 0.3, 0.4)


@pytest.fixture
def checks():
    from verification.columns import run

    return run


def section(depth: float, number: int, area: float) -> CellSection:
    """Cells inside, a little unlike."""
    areas = tuple(area * (0.9 + 0.2 * i / number) for i in range(number))
    return CellSection(
        depth=depth, pixel=(0.1, 0.1), areas=areas, perimeters=tuple(4 * a**0.5 for a in areas),
        sides=(6,) * number, ends=(0,) * number, junctions={"T": 1, "Y": 3, "X": 0}, cracked=0.1,
    )  # fmt: skip


def uncracked(depth: float) -> CellSection:
    """One cell as large as the section, which it ends with along both axes."""
    return CellSection(
        depth=depth, pixel=(0.1, 0.1), areas=(6.25,), perimeters=(0.0,), sides=(0,), ends=(2,),
        junctions={"T": 0, "Y": 0, "X": 0}, cracked=0.0,
    )  # fmt: skip


def by_depth(*sections: list[CellSection]) -> dict:
    return {depth: pattern(found) for depth, found in zip(DEPTHS, sections, strict=True)}


def met(figures) -> list[bool]:
    return [figure.met for figure in figures]


def test_cells_that_widen_are_told(checks) -> None:
    areas = (0.4, 0.8, 1.2)
    wide = by_depth(*([section(d, 40, area)] for d, area in zip(DEPTHS, areas, strict=True)))
    assert met(checks.growing(wide)) == [True] * 4
    narrow = by_depth(*([section(d, 40, 1 - d)] for d in DEPTHS))
    assert met(checks.growing(narrow)) == [True, True, False, False]


def test_rock_that_no_crack_reaches_meets_nothing(checks) -> None:
    whole = by_depth([section(0.2, 40, 0.4)], *([uncracked(d)] * 6 for d in DEPTHS[1:]))
    assert met(checks.growing(whole)) == [True, False]
    assert list(checks.spaced(by_depth(*([uncracked(d)] * 6 for d in DEPTHS)), 0.01)) == []
    kept = {
        f"{size}-1": {"area": 1.0, "width": width, "fronts": [0.1, 0.2]}
        for size, width in (("single", 1.0), ("doubled", 1.0))
    }
    few = by_depth(*([section(d, 2, 0.4)] for d in DEPTHS))
    for found in (whole, few):
        depths, *_ = checks.alike(kept, {"single": found, "doubled": found})
        assert not depths.met


def test_cells_that_differ_by_more_than_their_errors_are_not_alike(checks) -> None:
    kept = {
        f"{size}-1": {"area": 1.0, "width": 1.0, "fronts": [0.1, 0.2]}
        for size in ("single", "doubled")
    }
    one = by_depth(*([section(d, 40, 0.4)] for d in DEPTHS))
    two = by_depth(
        *([section(d, 40, area)] for d, area in zip(DEPTHS, (0.42, 0.6, 0.4), strict=True))
    )
    figures = checks.alike(kept, {"single": one, "doubled": two})
    assert met(figures) == [True, True, True, False, False, *[True] * 4]


def test_the_strip_is_cut_from_the_brick() -> None:
    brick, strip = (
        tomllib.loads((ROOT / name).read_text())
        for name in ("verification/columns/case.toml", "verification/opposite_boundary/case.toml")
    )
    for table in ("damage", "toughness", "temperature", "time"):
        assert strip[table] == brick[table], table
    assert strip["domain"]["h"] == brick["domain"]["h"]
    assert strip["supports"].items() <= brick["supports"].items()


def test_depths_that_cracks_are_still_reaching_are_left_out(checks) -> None:
    numbers = {"single-1": ([10, 4], [9, 1]), "doubled-1": ([30, 16], [30, 9])}
    kept = {
        name: {
            "number before": before,
            "cells": [
                {"depth": depth, "areas": [1.0] * n} for depth, n in zip(DEPTHS, now, strict=False)
            ],
        }
        for name, (now, before) in numbers.items()
    }
    assert checks.settled(kept) == [DEPTHS[0]]

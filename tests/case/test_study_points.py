"""Points of a study: grids, lists and Latin hypercubes as texts of the command line give them."""

import numpy as np
import pytest

from case.test_bad_input import check_sentence, sentence_of
from staffa.case.reading.study_points import study_points
from staffa.io.study_directory import Parameter, StudyPlan


def texts(*over: str) -> list[tuple[str, ...]]:
    """The values of each point, as TOML."""
    return [point.texts for point in study_points(over)[1]]


def test_a_range_has_its_ends_and_equal_distances_without_rounding_noise() -> None:
    parameters, points = study_points(["material.Gc=40:100:7 J/m^2"])
    assert parameters == (Parameter(key="material.Gc", unit="J/m²"),)
    assert [point.values[0] for point in points] == [40, 50, 60, 70, 80, 90, 100]
    assert points[0].texts == ('"40 J/m^2"',) and points[-1].number == 7
    assert texts("domain.h=0.1:0.3:3") == [("0.1",), ("0.2",), ("0.3",)]
    assert texts("a.b=-20:1e1:3 °C")[1] == ('"-5 °C"',)


@pytest.mark.parametrize(
    ("over", "expected"),
    [
        ("a.b=40,60, 100 mm", ['"40 mm"', '"60 mm"', '"100 mm"']),
        ("a.b=40 mm, 60 mm", ['"40 mm"', '"60 mm"']),
        ('a.b=["40 mm", "60 mm"]', ['"40 mm"', '"60 mm"']),
        ("a.b=AT1,AT2", ['"AT1"', '"AT2"']),
        ("a.b=.5, 1.", ["0.5", "1.0"]),
        ("a.b=true, false", ["true", "false"]),
        ("a.b=[[1.0, 2.0], [3.0, 4.0]]", ["[1.0, 2.0]", "[3.0, 4.0]"]),
        ('a.b="1:2:2 K"', ['"1 K"', '"2 K"']),
        ('a."x=y".b=1,2', ["1", "2"]),
    ],
)
def test_a_list_may_be_written_in_several_ways(over: str, expected: list[str]) -> None:
    assert texts(over) == [(text,) for text in expected]


def test_several_keys_make_a_grid_whose_last_key_changes_fastest() -> None:
    parameters, points = study_points(["damage.law=AT1,AT2", "a.b=1:3:3 mm"])
    assert [point.values for point in points] == [
        ("AT1", 1), ("AT1", 2), ("AT1", 3), ("AT2", 1), ("AT2", 2), ("AT2", 3),
    ]  # fmt: skip
    plan = StudyPlan(version="", title="", parameters=parameters, points=points)
    assert plan.settings(points[4]) == ('damage.law="AT2"', 'a.b="2 mm"')
    assert plan.named(points[4]) == "damage.law AT2, a.b 2 mm" and plan.short == ("law", "b")


def test_short_names_are_as_long_as_they_must_be_to_differ() -> None:
    parameters, points = study_points(["wells.in.T=1,2", "wells.out.T=1,2", "domain.h=1,2"])
    plan = StudyPlan(version="", title="", parameters=parameters, points=points)
    assert plan.short == ("in.T", "out.T", "domain.h")


def test_a_latin_hypercube_has_one_point_in_each_slice_of_each_range() -> None:
    over = ["material.Gc=40:100 J/m^2", "temperature.dT=-3:5 K"]
    parameters, points = study_points(over, samples=9, seed=4)
    assert [one.unit for one in parameters] == ["J/m²", "K"]
    found = np.array([point.values for point in points], dtype=float)
    slices = np.floor((found - [40, -3]) / [60, 8] * 9).astype(int)
    assert np.array_equal(np.sort(slices, axis=0), np.repeat(np.arange(9), 2).reshape(9, 2))
    assert study_points(over, samples=9, seed=4)[1] == points
    assert study_points(over, samples=9, seed=5)[1] != points


@pytest.mark.parametrize(
    ("over", "samples", "parts"),
    [
        ([], None, ("a study needs keys to vary", "--over material.Gc=")),
        (["domain.h"], None, ("--over domain.h: ", "write it like")),
        (["domain.h="], None, ("--over domain.h=: ", "write it like")),
        (["domain.h=0.1"], None, ("one value", "--set")),
        (["domain.h=0.1,0.2,0.1"], None, ("given twice", "give each once")),
        (["domain.h=0.1,0.2", "domain.h=0.3,0.4"], None, ("--over domain.h is given twice",)),
        (["domain.h=0.1:0.3"], None, ("n values", "write it like")),
        (["domain.h=0.1:0.3:1"], None, ("n at least 2",)),
        (["domain.h=0.1:0.1:3"], None, ("another number than a",)),
        (["domain.h=1 mm, 2 cm"], None, ("in mm and in cm", "one unit")),
        (["domain.h=1:2:2000"], None, ("2,000 points", "at most 1,000")),
        (["a.b=1:2:40", "a.c=1:2:40"], None, ("1,600 points", "--samples")),
        (["toughness.seed=1,2"], None, ("seeds are no parameter", "--seeds 4")),
        (["domain.h=0.1:0.3:4"], 3, ("without a number of values",)),
        (["domain.h=0.3:0.1"], 3, ("smaller end first",)),
        (["domain.h=0.1:0.3"], 1, ("--samples 1: ",)),
        (["domain.h=0.1:0.3"], 2000, ("these are 2,000 points",)),
        (["material.nu=0.25:0.2500001"], 3, ("two points are equal", "6 digits", "wider ranges")),
        (["a.b=1:1.0000000000001:3"], None, ("two points are equal", "12 digits")),
        (["a.b=1,1.0"], None, ("two points are equal", "each value once")),
        (["a.b=1:1e309:3"], None, ("its numbers are too large", "smaller ones")),
        (["a.b=1:1e309 K"], 3, ("its numbers are too large",)),
        (["a.b=-1e308:1e308"], 3, ("its numbers are too large",)),
    ],
)  # fmt: skip
def test_what_makes_no_points_is_refused_in_one_sentence(over, samples, parts) -> None:
    check_sentence(sentence_of(lambda: study_points(over, samples=samples)), *parts)

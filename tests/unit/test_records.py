"""Records are read back as they were written, field by field, those of later versions too."""

import inspect
import json
from collections.abc import Iterator
from dataclasses import MISSING, Field, asdict, dataclass, field, fields, is_dataclass, replace
from enum import Enum
from importlib import import_module
from itertools import count
from math import inf, nan
from pkgutil import iter_modules
from types import NoneType, UnionType
from typing import Any, Literal, Union, get_args, get_origin, get_type_hints

import numpy as np
import pytest
from pydantic_core import PydanticSerializationError

from staffa import records
from staffa.display_units import Unit
from staffa.evolution.backtrack import Better
from staffa.evolution.restart_state import LoopNumbers, PastNumbers
from staffa.records.json_form import json_form, made
from staffa.records.step import CracksAtHeight, Energies, Fluid, Measures, SolverStatistics, Step


def records_of(package: Any) -> Iterator[type]:
    """Every dataclass that a module of a package defines."""
    for found in iter_modules(package.__path__, f"{package.__name__}."):
        for kind in vars(import_module(found.name)).values():
            if is_dataclass(kind) and kind.__module__ == found.name:
                assert isinstance(kind, type)
                yield kind


IN_RECORDS = list(records_of(records))
KINDS = [*IN_RECORDS, Unit, PastNumbers, LoopNumbers, Better]
NAMES = [kind.__name__ for kind in KINDS]
each_kind = pytest.mark.parametrize("kind", KINDS, ids=NAMES)


def filled(kind: Any, numbers: Iterator[int]) -> Any:
    """Return a record in which every field, of records within it too, has a different value."""
    hints = get_type_hints(kind)
    return kind(**{f.name: _value(hints[f.name], f, numbers) for f in fields(kind)})


def _value(hint: Any, of: Field[Any] | None, numbers: Iterator[int]) -> Any:
    parts = get_args(hint)
    if get_origin(hint) in (UnionType, Union):
        hint = next(part for part in parts if part is not NoneType)
        return _value(hint, of, numbers)
    if get_origin(hint) is tuple:
        inside = (parts[0],) * 2 if parts[-1] is Ellipsis else parts
        return tuple(_value(part, None, numbers) for part in inside)
    if get_origin(hint) is dict:
        keys = [_value(parts[0], None, numbers) for _ in range(2)]
        return {key: _value(parts[1], None, numbers) for key in keys}
    if is_dataclass(hint):
        return filled(hint, numbers)
    if isinstance(hint, type) and issubclass(hint, Enum):
        return list(hint)[-1]
    if hint is bool:
        return not (of and of.default is True)
    known = {
        float: lambda: next(numbers) + 1 / 3,
        int: lambda: next(numbers),
        str: lambda: f"µ {next(numbers)}",
    }
    return known[hint]()  # a field of another type has to be thought of here


def usual(of: Field[Any]) -> Any:
    """The default of a field, MISSING without one."""
    return of.default if of.default_factory is MISSING else of.default_factory()


def through_json(record: Any) -> Any:
    """Return a record as it is read back from JSON."""
    return json.loads(json.dumps(json_form(record)))


def same(found: Any, written: Any) -> bool:
    """Return whether two records are equal, with their types and NaN."""
    return type(found) is type(written) and repr(found) == repr(written)


@each_kind
def test_every_field_of_every_record_is_read_back_as_it_was(kind: Any) -> None:
    whole = filled(kind, count(7))
    for one in fields(kind):
        assert getattr(whole, one.name) != usual(one), f"{one.name} is tried at its default"
    found = made(kind, through_json(whole))
    assert found == whole and same(found, whole)


@each_kind
def test_defaults_are_read_back_as_they_were(kind: Any) -> None:
    """None, empty tuples and empty dictionaries among them."""
    whole = filled(kind, count(7))
    plain = {one.name: usual(one) for one in fields(kind) if usual(one) is not MISSING}
    least = replace(whole, **plain)
    assert same(made(kind, through_json(least)), least)


@each_kind
def test_none_is_read_back_as_none_where_it_may_be(kind: Any) -> None:
    hints, whole = get_type_hints(kind), filled(kind, count(7))
    empty = {one.name: None for one in fields(kind) if NoneType in get_args(hints[one.name])}
    assert same(made(kind, through_json(replace(whole, **empty))), replace(whole, **empty))


def with_numbers(value: Any, special: float) -> Any:
    """The same value with a special number in the place of each fraction."""
    if isinstance(value, float):
        return special
    if isinstance(value, tuple):
        return tuple(with_numbers(part, special) for part in value)
    if isinstance(value, dict):
        return {key: with_numbers(part, special) for key, part in value.items()}
    if is_dataclass(value) and not isinstance(value, type):
        parts = {f.name: with_numbers(getattr(value, f.name), special) for f in fields(value)}
        return replace(value, **parts)
    return value


@each_kind
@pytest.mark.parametrize("special", [nan, inf, -inf, -0.0, 5e-324, 1 / 3e17])
def test_every_number_is_read_back_to_the_bit(kind: Any, special: float) -> None:
    whole = with_numbers(filled(kind, count(7)), special)
    assert same(made(kind, through_json(whole)), whole)


@each_kind
def test_a_run_of_before_lacks_fields_and_gets_their_defaults(kind: Any) -> None:
    whole = filled(kind, count(7))
    for one in fields(kind):
        written = through_json(whole)
        del written[one.name]
        if usual(one) is MISSING:
            with pytest.raises(ValueError, match=f"^{one.name}: Field required"):
                made(kind, written)
        else:
            assert same(made(kind, written), replace(whole, **{one.name: usual(one)}))


def with_more(value: Any) -> Any:
    """A record as JSON, with a name more in it and in each record within it."""
    if isinstance(value, tuple):
        return [with_more(part) for part in value]
    if isinstance(value, dict):
        return {str(key): with_more(part) for key, part in value.items()}
    if is_dataclass(value):
        known = {f.name: with_more(getattr(value, f.name)) for f in fields(value)}
        return known | {"weather": {"sky": ["clear"]}}
    return value


@each_kind
def test_what_a_later_version_added_is_left_out(kind: Any) -> None:
    whole = filled(kind, count(7))
    assert same(made(kind, with_more(whole)), whole)


def documented(kind: type) -> list[str]:
    """The names under "Attributes" in the docstring of a class, each with a text below it."""
    lines = (inspect.getdoc(kind) or "").splitlines()
    start = lines.index("Attributes") + 2
    assert lines[start - 1] == "-" * len("Attributes")
    names = [number for number in range(start, len(lines)) if lines[number][:1].strip()]
    assert all(lines[number + 1].startswith("    ") for number in names)
    return [lines[number] for number in names]


@pytest.mark.parametrize("kind", [*IN_RECORDS, PastNumbers, LoopNumbers])
def test_every_field_of_a_record_is_documented_in_its_order(kind: type) -> None:
    assert documented(kind) == [one.name for one in fields(kind)]


class Weather(Enum):
    FAIR = "fair"
    FOUL = "foul"


@dataclass(frozen=True, kw_only=True)
class Anything:
    """Kinds of fields that records may get."""

    number: int | float | str | bool | None
    weather: Weather
    way: Literal["up", "down"]
    pair: tuple[int, str] | None
    sections: dict[str, tuple[CracksAtHeight, ...]]
    table: tuple[dict[str, float | None], ...]


@pytest.mark.parametrize("number", [2, 2.0, "2", True, None, nan, -inf])
def test_fields_of_any_kind_are_read_back_as_they_were(number: Any) -> None:
    """A union gives the member that was written."""
    section = filled(CracksAtHeight, count(3))
    one = Anything(
        number=number,
        weather=Weather.FOUL,
        way="down",
        pair=(3, "x"),
        sections={"a": (section, section), "": ()},
        table=({"b": None, "c": inf}, {}),
    )
    assert same(made(Anything, through_json(one)), one)


@pytest.mark.parametrize("volume", [np.zeros(2), {1.0}, object()])
def test_a_value_that_json_does_not_hold_is_not_written(volume: Any) -> None:
    with pytest.raises((PydanticSerializationError, UserWarning), match="serializ"):
        json.dumps(json_form(Fluid(pressure=1.0, volume=volume)))


def test_a_number_of_numpy_is_written_as_what_it_is() -> None:
    assert json.dumps(json_form(Fluid(pressure=np.float64(1 / 3), volume=2.0))) == (
        '{"pressure": 0.3333333333333333, "volume": 2.0}'
    )


def test_a_field_that_a_later_version_adds_needs_no_reading_of_its_own() -> None:
    """Within measures within a step, as a record within a record."""

    @dataclass(frozen=True, kw_only=True)
    class Gap:
        ends: tuple[tuple[float, ...], ...]
        width: float | None = None

    @dataclass(frozen=True, kw_only=True)
    class LaterMeasures(Measures):
        gaps: tuple[Gap, ...] = ()
        opened: float = 0.0

    @dataclass(frozen=True, kw_only=True)
    class LaterStep(Step):
        measures: LaterMeasures | None = None
        said: dict[str, tuple[int, ...]] = field(default_factory=dict)

    step = filled(LaterStep, count(7))
    assert step.measures.gaps[0].ends and step.said
    written = json.loads(json.dumps(step.to_record()))
    assert LaterStep.from_record(written) == step
    before = Step.from_record(written)  # today's version leaves what it does not know
    assert asdict(before)["audit"] == asdict(step)["audit"]
    assert LaterStep.from_record(before.to_record()).measures.opened == 0.0


def test_a_step_of_version_0_1_0_is_read() -> None:
    """As its `to_record` wrote it: nothing but fall-backs was counted."""
    line = (
        '{"index": 2, "time": 0.25, "tau": null, "energies": {"elastic": 1.5, "surface": 0.5, '
        '"total": 2.0}, "sweeps": 3, "status": "converged", "reason": "", "audit": {"largest_rise":'
        ' 0.0, "healing": 0.0, "optimality": 0.05, "balance": 1e-13, "work": 0.1, "released": 0.0, '
        '"violations": ["one"]}, "measures": {"sections": [{"height": 0.1, "cracks": 2, "spacing": '
        'null, "positions": [0.1, 0.2]}], "tips": [{"position": [0.1, 0.3], "depth": 0.3}], '
        '"front": 0.3, "length_surface": 0.3, "length_geometry": NaN}, "fallbacks": 4, '
        '"seconds": 1.5, "fields": null}'
    )
    step = Step.from_record(json.loads(line))
    assert (
        step.effort == SolverStatistics(fallbacks=4)
        and step.energies.total == 2.0
        and step.tau is None
    )
    assert step.energies == Energies(elastic=1.5, surface=0.5) and step.audit is not None
    assert step.audit.violations == ("one",) and step.measures is not None
    assert step.measures.tips[0].position == (0.1, 0.3) and step.measures.cells == ()
    assert step.measures.sections[0].spacing is None
    assert step.measures.length_geometry != step.measures.length_geometry, "not a number stays so"


def test_a_step_is_written_field_by_field_and_its_total_energy_with_it() -> None:
    step = filled(Step, count(7))
    record = step.to_record()
    assert record["energies"].pop("total") == step.energies.total
    assert record == json.loads(json.dumps(asdict(step)))
    assert json.dumps(step.to_record()).startswith('{"index": 7, "time": 8.333333333333334, "tau":')


def test_what_is_wrong_in_a_record_is_named_in_one_line() -> None:
    with pytest.raises(ValueError, match=r"^volume: ") as caught:
        made(Fluid, {"pressure": 1.0, "volume": [1.0]})
    assert "\n" not in str(caught.value)

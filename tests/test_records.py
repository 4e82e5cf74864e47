"""Records are read back as they were written, field by field, those of later versions too."""

import json
from collections.abc import Iterator
from dataclasses import MISSING, Field, asdict, dataclass, field, fields, is_dataclass
from enum import Enum
from itertools import count
from types import NoneType, UnionType
from typing import Any, Union, get_args, get_origin, get_type_hints

import pytest

from staffa.records import manifest, step
from staffa.records.step import Effort, Energies, Fluid, Measures, Step, made

KINDS = [
    kind
    for module in (step, manifest)
    for kind in vars(module).values()
    if is_dataclass(kind) and isinstance(kind, type) and kind.__module__ == module.__name__
]
WORDS = {kind.__name__: kind for kind in KINDS}


def filled(kind: Any, numbers: Iterator[int]) -> Any:
    """A record in which every field, of records within it too, has a value of its own."""
    hints = get_type_hints(kind)
    return kind(**{f.name: _value(hints[f.name], f, numbers) for f in fields(kind)})


def _value(hint: Any, of: Field[Any] | None, numbers: Iterator[int]) -> Any:
    parts = get_args(hint)
    if get_origin(hint) in (UnionType, Union):
        (hint,) = (part for part in parts if part is not NoneType)
        return _value(hint, of, numbers)
    if get_origin(hint) is tuple:
        inside = (parts[0],) * 2 if parts[-1] is Ellipsis else parts
        return tuple(_value(part, None, numbers) for part in inside)
    if get_origin(hint) is dict:
        return {f"name {next(numbers)}": _value(parts[1], None, numbers) for _ in range(2)}
    if is_dataclass(hint):
        return filled(hint, numbers)
    if isinstance(hint, type) and issubclass(hint, Enum):
        return list(hint)[-1]
    if hint is bool:
        return not (of and of.default is True)
    known = {float: lambda: next(numbers) + 1 / 3, int: lambda: next(numbers), str: lambda: "µ"}
    return known[hint]()  # a field of another type has to be thought of here


def through_json(record: Any) -> Any:
    return json.loads(json.dumps(asdict(record)))


@pytest.mark.parametrize("kind", KINDS, ids=WORDS)
def test_every_field_of_every_record_is_read_back_as_it_was(kind: Any) -> None:
    whole = filled(kind, count(7))
    for one in fields(kind):
        usual = one.default if one.default_factory is MISSING else one.default_factory()
        assert getattr(whole, one.name) != usual, f"{one.name} is tried at its default"
    found = made(kind, through_json(whole))
    assert asdict(found) == asdict(whole) and found == whole
    assert {type(getattr(found, f.name)) for f in fields(kind)} == {
        type(getattr(whole, f.name)) for f in fields(kind)
    }, "tuples come back as tuples, records as records"


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
    assert step.effort == Effort(fallbacks=4) and step.energies.total == 2.0 and step.tau is None
    assert step.energies == Energies(elastic=1.5, surface=0.5) and step.audit is not None
    assert step.audit.violations == ("one",) and step.measures is not None
    assert step.measures.tips[0].position == (0.1, 0.3) and step.measures.cells == ()
    assert step.measures.sections[0].spacing is None
    assert step.measures.length_geometry != step.measures.length_geometry, "not a number stays so"


def test_a_step_is_written_field_by_field_and_its_total_energy_with_it() -> None:
    step = filled(Step, count(7))
    record = step.to_record()
    assert record["energies"].pop("total") == step.energies.total
    assert record == asdict(step)
    assert json.dumps(step.to_record()).startswith('{"index": 7, "time": 8.333333333333334, "tau":')


def test_what_is_wrong_in_a_record_is_named_in_one_line() -> None:
    with pytest.raises(ValueError, match=r"^volume: ") as caught:
        made(Fluid, {"pressure": 1.0, "volume": [1.0]})
    assert "\n" not in str(caught.value)

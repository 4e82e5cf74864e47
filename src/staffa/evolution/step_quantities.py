"""Quantities of a script's own, which a run records at each step: tried, and evaluated."""

import re
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, fields
from typing import Any, Protocol

import numpy as np

from staffa.arguments import py_text, require, told
from staffa.backend.parallel import best_candidate, everywhere
from staffa.errors import InputError, StoppedError
from staffa.evolution.session import Session
from staffa.model.fields import State
from staffa.records.manifest import QuantityRecord
from staffa.records.step import Energies, Measures, Step

NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
LONGEST_UNIT = 20  # characters
MOST = 100  # numbers of one quantity at a step
# Names of numbers that a step has by itself.
TAKEN = {field.name for kind in (Step, Energies, Measures) for field in fields(kind)}
TAKEN |= {"step", "total"}
# Ranks whose numbers are nearer than this part of them agree: sums may differ in their last digit.
ALIKE = 1e-12
WAY_OUT = 'give an object of staffa.StepQuantity, or any function with a name and a unit ("" for 1)'

type Numbers = float | Sequence[float] | np.ndarray


class Recorded(Protocol):
    """A function of the session and its state, with a name and a unit."""

    @property
    def name(self) -> str:
        """Name of the quantity, which its columns bear."""

    @property
    def unit(self) -> str:
        """Unit of its numbers, which is shown as it is; "" for none."""

    def __call__(self, session: Session, state: State) -> Numbers:
        """Return one number, or the same count of numbers at each step; the same on each rank."""


@dataclass(frozen=True, kw_only=True)
class StepQuantity:
    """A quantity of a script's own.

    Attributes
    ----------
    name : letters, digits and underscores; its columns bear it.
    unit : unit of its numbers, shown as it is; "" for none.
    value : function of the session (problem, system, mesh) and its state that returns a number, or
        the same count of numbers at each step. Collective: every rank calls it, and gets the same.
    """

    name: str
    unit: str
    value: Callable[[Session, State], Numbers]

    def __call__(self, session: Session, state: State) -> Numbers:
        """Return its numbers."""
        return self.value(session, state)


def known_quantities(given: Any) -> tuple[Recorded, ...]:
    """Return the quantities that a script hands over, each of the right kind.

    Raises
    ------
    InputError
        One of them has no name or unit that tables can bear, or a name that is taken.
    """
    if isinstance(given, str) or not isinstance(given, Iterable):
        raise InputError(
            f"quantities = {py_text(given)} is {told(given)}; give a list of quantities"
        )
    found = tuple(given)
    names: set[str] = set()
    for quantity in found:
        _require_kind(quantity)
        if quantity.name in TAKEN:
            raise InputError(
                f"quantities: the name '{quantity.name}' is that of a number which every step has; "
                f"choose another name"
            )
        if quantity.name in names:
            raise InputError(f"quantities: two have the name '{quantity.name}'; rename one")
        names.add(quantity.name)
    return found


def _require_kind(quantity: Any) -> None:
    said = f"quantities: {py_text(quantity)}"
    if isinstance(quantity, type):
        raise InputError(f"{said} is a class; give an object of it")
    lacks = [name for name in ("name", "unit") if not hasattr(quantity, name)]
    if lacks:
        raise InputError(f"{said} has no {' and no '.join(lacks)}; {WAY_OUT}")
    require(quantity.name, str, f"{said}, its name", "give a text")
    require(quantity.unit, str, f"{said}, its unit", 'give a text, like "m"; "" for none')
    if not NAME.fullmatch(quantity.name):
        raise InputError(
            f"quantities: the name {py_text(quantity.name)} must have 1 to 40 letters, digits and "
            f"underscores, a letter first; choose another"
        )
    unit = quantity.unit
    if len(unit) > LONGEST_UNIT or not unit.isprintable() or "$" in unit:
        raise InputError(
            f"quantities: the unit {py_text(unit)} of '{quantity.name}' must have at most "
            f"{LONGEST_UNIT} characters that can be printed, and no $; shorten it"
        )
    if not callable(quantity):
        raise InputError(f"{said} is no function; {WAY_OUT}")


def tried_quantities(
    session: Session, quantities: Sequence[Recorded], known: Sequence[QuantityRecord] = ()
) -> tuple[QuantityRecord, ...]:
    """Evaluate quantities at the current state, and describe them for the manifest. Collective.

    Parameters
    ----------
    session : owner of the current mesh and its state.
    quantities : quantities of a script.
    known : their descriptions in the manifest of a run that goes on.

    Raises
    ------
    InputError
        One of them fails, or gives what is no number, or another count of numbers than it did, or
        two have a column of one name.
    """
    counts = {record.name: record.numbers for record in known}
    columns: dict[str, str] = {}
    found = []
    for quantity in quantities:
        values, said = _evaluated(session, quantity)
        said = said or _other_count(len(values), counts.get(quantity.name))
        if said:
            raise InputError(f"the quantity '{quantity.name}' {said}")
        record = QuantityRecord(name=quantity.name, unit=quantity.unit, numbers=len(values))
        for column in record.columns:
            if (other := columns.setdefault(column, record.name)) != record.name:
                raise InputError(
                    f"quantities: '{other}' and '{record.name}' both have the column '{column}'; "
                    f"rename one"
                )
        found.append(record)
    return tuple(found)


def _other_count(count: int, before: int | None) -> str:
    """Return a sentence if a quantity gives another count of numbers than before."""
    if before in (None, count):
        return ""
    return f"gives {count} numbers, and gave {before} before; give always as many"


def evaluated_quantities(
    session: Session, quantities: Sequence[Recorded], records: Sequence[QuantityRecord]
) -> dict[str, tuple[float, ...]]:
    """Return the numbers of each quantity at the current state. Collective.

    Parameters
    ----------
    session : owner of the current mesh and its state.
    quantities : quantities of a script.
    records : their descriptions in the manifest.

    Raises
    ------
    StoppedError
        One of them fails, or gives what is no number, or another count of numbers.
    """
    counts = {record.name: record.numbers for record in records}
    found = {}
    for quantity in quantities:
        values, said = _evaluated(session, quantity)
        said = said or _other_count(len(values), counts[quantity.name])
        if said:
            raise StoppedError(f"the quantity '{quantity.name}' {said}")
        found[quantity.name] = values
    return found


def _evaluated(session: Session, quantity: Recorded) -> tuple[tuple[float, ...], str]:
    """The numbers of a quantity, the same on all ranks, or a sentence on what is wrong."""
    values, said = _numbers(session, quantity)
    worst = best_candidate(session.comm, (said,) if said else None)
    parts = everywhere(session.comm, values)
    if worst:
        return (), worst[0]
    for rank, part in enumerate(parts):
        if part.shape != parts[0].shape or not np.allclose(part, parts[0], rtol=ALIKE, atol=0.0):
            return (), (
                f"gives {_listed(parts[0])} on rank 0 and {_listed(part)} on rank {rank}; add up "
                f"over the ranks, like session.comm.allreduce(part)"
            )
    return tuple(map(float, parts[0])), ""


def _numbers(session: Session, quantity: Recorded) -> tuple[np.ndarray, str]:
    """The numbers on this rank, shape (n,), or a sentence on what is wrong."""
    none = np.zeros(0)
    try:
        found = np.asarray(quantity(session, session.state))
    except Exception as error:  # whatever a user's function raises
        return none, f"fails ({type(error).__name__}: {error}); fix it"
    if found.ndim > 1 or not 0 < found.size <= MOST or found.dtype.kind not in "fiu":
        kind = f"an array of shape {found.shape} and type {found.dtype}"
        return none, f"gives {kind}; give a number, or a list of 1 to {MOST} numbers"
    if not np.all(np.isfinite(found)):
        return none, f"gives {_listed(found.ravel())}; give finite numbers, also before rock cracks"
    return found.ravel().astype(float), ""


def _listed(values: np.ndarray) -> str:
    return ", ".join(f"{value:.6g}" for value in values)


def require_same_quantities(
    quantities: Sequence[Recorded], records: Sequence[QuantityRecord], run: str
) -> None:
    """Require that a run that goes on is given the quantities that it records.

    Parameters
    ----------
    quantities : those that are given.
    records : those of its manifest.
    run : its directory.

    Raises
    ------
    InputError
        One is missing, or too much, or has another unit.
    """
    given, known = (
        {thing.name: thing.unit for thing in things} for things in (quantities, records)
    )
    missing = [name for name in known if name not in given]
    if missing:
        raise InputError(
            f"{run} records the {_named(missing)} of a script at each step; go on from Python, "
            f"with staffa.resume({run!r}, quantities=[...])"
        )
    more = [name for name in given if name not in known]
    if more:
        raise InputError(
            f"{run} does not record the {_named(more)} at its steps; leave it out of quantities, "
            f"or begin a new run with it"
        )
    for name, unit in known.items():
        if given[name] != unit:
            raise InputError(
                f"{run} records the quantity '{name}' in {unit!r}, not in {given[name]!r}; go on "
                f"with the same unit"
            )


def _named(names: Sequence[str]) -> str:
    listed = ", ".join(f"'{name}'" for name in names)
    return f"quantity {listed}" if len(names) == 1 else f"quantities {listed}"

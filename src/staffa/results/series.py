"""Readings of every step as tables: reactions, probes, quantities of a script."""

import numpy as np

from staffa.io.run_directory import Run
from staffa.records.manifest import Manifest
from staffa.records.step import Step
from staffa.results.tables import Cell, Column, Table, columns_of


def reactions_table(run: Run) -> Table:
    """Return the force on the body of each constrained side, a row a step and side."""
    axes, unit = "xyz"[: len(run.manifest.size)], run.manifest.shown.force
    rows = tuple(
        (*time_columns(step), side, *force)
        for step in run.steps
        for side, force in step.reactions.items()
    )
    forces = columns_of(*(f"f{axis}" for axis in axes), unit=unit)
    return Table(columns=(*clock_columns(run.manifest), Column(name="side"), *forces), rows=rows)


def probes_table(run: Run) -> Table:
    """Return the fields at the probes, a row a step, probe and point.

    s: distance from the first point of the probe. T: change of temperature, as in the fields;
    temperature: absolute, where the case has it.
    """
    m, shown = run.manifest, run.manifest.shown
    axes, known = "xyz"[: len(m.size)], m.reference is not None
    places: list[tuple[Cell, ...]] = []
    for probe in m.probes:
        points = np.array(probe.points)
        along = np.linalg.norm(points - points[0], axis=1)
        places += [(probe.name, float(s), *p) for s, p in zip(along, probe.points, strict=True)]
    rows = tuple(
        (*time_columns(step), *place, T, *([(m.reference or 0.0) + T] if known else []), *others)
        for step in run.steps
        for place, (T, *others) in zip(places, step.probed, strict=False)  # none of a failed step
    )
    temperature = columns_of("temperature", unit=shown.temperature) if known else ()
    return Table(
        columns=(
            *clock_columns(m),
            Column(name="name"),
            *columns_of("s", *axes, unit=shown.length),
            Column(name="T", unit=shown.difference),
            *temperature,
            *columns_of(*(f"u{axis}" for axis in axes), unit=shown.length),
            Column(name="alpha"),
        ),
        rows=rows,
    )


def quantities_table(run: Run) -> Table:
    """Return the numbers of a script's quantities, a row a step; no rows without any."""
    known = run.manifest.quantities
    columns = [column for q in known for column in columns_of(*q.columns, unit=q.shown)]
    rows = tuple(
        (*time_columns(step), *(number for q in known for number in step.quantities[q.name]))
        for step in run.steps
        if step.quantities
    )
    return Table(columns=(*clock_columns(run.manifest), *columns), rows=rows)


def clock_columns(manifest: Manifest) -> tuple[Column, ...]:
    """Return the columns that tell when."""
    return (
        Column(name="step"),
        Column(name="time", unit=manifest.shown.time),
        Column(name="tau"),
    )


def time_columns(step: Step) -> tuple[Cell, ...]:
    """Return the cells of these columns; tau is None where nothing diffuses."""
    return (step.index, step.time, step.tau)

"""Spacing of the cracks of a run at each depth, as a table."""

from collections.abc import Sequence
from dataclasses import replace
from math import floor, log10

import numpy as np

from staffa.geometry.block import face_axis
from staffa.io.run_directory import Run
from staffa.measure.cells import cell_section
from staffa.measure.patterns import pattern
from staffa.plot.frames import read_frames, with_fields
from staffa.plot.labels import moment
from staffa.records.manifest import Manifest
from staffa.records.step import CracksAtHeight, Measures
from staffa.results.columns import cells_by_depth, columns
from staffa.results.sections import planes_of
from staffa.results.tables import Cell, Column, Table

ROWS = 5  # depths, where the case gives none
TITLE = "Spacing by depth, at the last step"
BY_TIPS = (
    "The case gives no measures.depths: depths are round ones above the deepest tip, and each "
    "crack counts down to its tip, at the place of its tip."
)
ALONG = "Spacing: mean distance along the face of neighboring cracks at that depth."
RINGS = (
    "The body is one of revolution: these are cracks of its section, each a ring around the axis."
)


def spacing(run: Run) -> Table:
    """Return the table of cracks and their spacing at each depth at the last step.

    It is in the units of the case. In 3-D it is the table of the polygonal cells. Without cracks it
    has no row but a note.
    """
    m, step = run.manifest, run.steps[-1] if run.steps else None
    if step is None or step.measures is None:
        return _without("no step was measured")
    if m.cooled_side is None:
        return _without("the body has no flat cooled face from which depths are measured")
    if not m.flat:
        cells = columns([run]) or by_fields(run)
        none = _without("no crack, or no fields to look at")
        return replace(cells, title=TITLE) if cells else none
    found = step.measures.sections or by_tips(m, step.measures)
    if not found:
        if not step.energies.surface > 0:
            return _without("nothing is damaged")
        return _without(_no_depth(m, step.measures))
    unit = m.shown.length
    rows: list[tuple[Cell, ...]] = [(s.height, s.cracks, s.spacing) for s in found]
    notes = [ALONG, _by_damage(m) if step.measures.sections else BY_TIPS]
    notes += [RINGS] if m.axial else []
    if any(s.elsewhere for s in found):
        there = ", ".join(f"{s.elsewhere} at {unit.text(s.height)}" for s in found if s.elsewhere)
        notes.append(f"Cracks that start on other cooled faces are not counted here: {there}.")
    elif step.measures.others and not step.measures.sections:
        there = _elsewhere(step.measures)
        notes.append(f"Cracks that start on other cooled faces are not counted here: {there}.")
    depth, apart = (Column(name=name, unit=unit) for name in ("depth", "spacing"))
    return Table(
        title=TITLE,
        columns=(depth, Column(name="cracks"), apart),
        rows=tuple(rows),
        notes=tuple(notes),
    )


def _elsewhere(measures: Measures) -> str:
    """Return the numbers of the cracks that start on other cooled faces."""
    return ", ".join(f"{one.cracks} from '{one.face}'" for one in measures.others)


def _no_depth(m: Manifest, measures: Measures) -> str:
    """Return why no crack has a depth below the face."""
    if not measures.others:
        return "no crack goes deeper than the layer at the face that is broken all over"
    which = f"no crack starts on '{m.face}' and leaves the layer there that is broken all over"
    own = which if m.face_cools else f"'{m.face}' is not cooled, so that no crack starts there"
    return f"{own}; there are {_elsewhere(measures)}"


def _by_damage(m: Manifest) -> str:
    """Return a note on counts that differ from the number of cracks and depths of tips."""
    ends = ""
    if m.tip_reach:
        reach = m.shown.length.text(m.tip_reach, 3)
        ends = (
            f" A crack counts down to where that damage ends; its sharp tip, of which the summary "
            f"and tips.csv tell the depth, lies {reach} deeper."
        )
    return (
        f"A band of damage above {m.threshold:.3g} is a crack here.{ends} Within some 2 ell = "
        f"{m.shown.length.text(2 * m.ell, 3)} of the face, bands may be short cracks that have no "
        f"tip in the summary, or neighbors that have run together."
    )


def _without(why: str) -> Table:
    return Table(title=TITLE, notes=(f"No spacing by depth: {why}.",))


def by_tips(manifest: Manifest, measures: Measures) -> list[CracksAtHeight]:
    """Return depth sections of a 2-D body from its tips, at round depths; none without cracks."""
    along = 1 - face_axis(str(manifest.cooled_side), 2)
    tips = [(tip.position[along], manifest.sharp(tip.depth, tip.room)) for tip in measures.tips]
    deepest = max((depth for _, depth in tips), default=0.0)
    sections = []
    unit = manifest.shown.length
    for height in (unit.size * depth for depth in round_depths(unit.of(deepest))):
        places = sorted(place for place, depth in tips if depth > height)
        apart = float(np.diff(places).mean()) if len(places) > 1 else None
        sections.append(
            CracksAtHeight(
                height=height, cracks=len(places), spacing=apart, positions=tuple(places)
            )
        )
    return sections


def by_fields(run: Run) -> Table | None:
    """Return the table of the cells of a 3-D body in its last fields; None without any."""
    frames, _ = read_frames(run, with_fields(run)[-1:])
    if not frames:
        return None
    m, frame = run.manifest, frames[-1]
    pixel = (m.h / 2, m.h / 2)
    found = {
        plane.depth: pattern([cell_section(plane.cells, depth=plane.depth, pixel=pixel)])
        for plane in planes_of(m, frame)
    }
    table = cells_by_depth(found, m.shown.length)
    if table is None:
        return None
    note = (
        f"The case gives no measures.depths: even depths down to the deepest crack, in the fields "
        f"at {moment(m, frame.step)}."
    )
    return replace(table, notes=(note, *table.notes))


def round_depths(deepest: float) -> Sequence[float]:
    """Return at most five round depths above the deepest tip, in the unit of `deepest`.

    They are multiples of a number with one leading digit, 1, 2 or 5.
    """
    if deepest <= 0:
        return []
    power = 10.0 ** floor(log10(deepest / ROWS))
    step = next(power * k for k in (1, 2, 5, 10) if power * k * ROWS >= deepest * (1 - 1e-9))
    return [step * k for k in range(1, ROWS + 1) if step * k < deepest * (1 - 1e-9)] or [
        deepest / 2
    ]

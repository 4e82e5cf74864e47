"""One paragraph on the effect of cracks on the production, made from the numbers of a run alone."""

from collections.abc import Iterator
from dataclasses import dataclass
from enum import StrEnum
from math import isfinite

from staffa.display_units import Shown, prefixed
from staffa.io.production_rows import Production, paired_production, production
from staffa.io.run_directory import Run
from staffa.results.crack_changes import CHANGED, CrackChanges
from staffa.results.tables import grouped

ONE_WAY = (
    "Cracks did not change the flow in this run: the simulator kept the permeability of the case, "
    "so the production is that of rock without cracks. With reservoir.feedback = true they change "
    "it."
)
NO_SHADOW = (
    "Cracks changed the flow in this run. By how much they changed the production cannot be told, "
    "since it was not computed without them as well: take reservoir.shadow = true."
)
UNTOLD = "These numbers alone do not tell why."
SMALL = 5e-5  # relative change that is told as none


class Effect(StrEnum):
    """Kind of effect of cracks on the production."""

    ONE_WAY = "one way"
    NO_SHADOW = "no shadow"
    NO_CRACKS = "no cracks"
    NOTHING = "nothing"
    PRESSURE = "pressure alone"
    WATER = "more or less water"
    MORE_ROCK = "more rock"
    SHORT_CIRCUIT = "short circuit"
    CHANGING = "sign changes"
    UNTOLD = "not told"


WHY = {
    Effect.NOTHING: "This is consistent with dead ends, along which no pressure difference drives "
    "water, or with cracks that are too narrow to take a part of the flow.",
    Effect.MORE_ROCK: "This is consistent with water that goes through more rock: the exchange "
    "area is larger, and cold water comes later.",
    Effect.SHORT_CIRCUIT: "This is consistent with a short circuit, an easier way from injector to "
    "producer past less rock: cold water comes earlier, and at a lower impedance.",
    Effect.UNTOLD: UNTOLD,
}


@dataclass(frozen=True, kw_only=True)
class CrackEffect:
    """Effect of cracks on the production.

    Attributes
    ----------
    kind : kind of effect.
    text : the paragraph: sign, size and a mechanism with which the numbers are consistent.
    """

    kind: Effect
    text: str

    def __str__(self) -> str:
        return self.text


def crack_effect(run: Run) -> CrackEffect | None:
    """Return the effect of cracks on the production of a run; None where no water flows.

    Parameters
    ----------
    run : the run.
    """
    facts = run.manifest.reservoir
    found = production(facts, run.steps)
    if facts is None or not found:
        return None
    pairs = paired_production(facts, run.steps)
    if not pairs:
        one_way = facts.cracks is None and found[-1].cracks is None
        kind, text = (Effect.ONE_WAY, ONE_WAY) if one_way else (Effect.NO_SHADOW, NO_SHADOW)
        return CrackEffect(kind=kind, text=text)
    changes = CrackChanges(pairs=pairs)
    kind = _kind(changes)
    return CrackEffect(kind=kind, text=" ".join(_sentences(kind, changes, run.manifest.shown)))


def _kind(changes: CrackChanges) -> Effect:
    """Return the kind of effect, by the rules of docs/how-to/circulation.md."""
    if changes.warmer and changes.colder:
        return Effect.CHANGING
    if changes.warmer:
        more = changes.area > CHANGED and changes.later
        return Effect.MORE_ROCK if more else Effect.UNTOLD
    easier, less = changes.impedance < -CHANGED, changes.energy < -changes.resolved_energy
    if changes.colder:
        short = changes.earlier and easier and less
        return Effect.SHORT_CIRCUIT if short else Effect.UNTOLD
    if abs(changes.energy) > changes.resolved_energy:
        return Effect.WATER if abs(changes.water) > CHANGED else Effect.UNTOLD
    if abs(changes.impedance) > CHANGED:
        return Effect.PRESSURE
    opened = any(one.cracks and (one.cracks.area or one.cracks.opened) for one, _ in changes.pairs)
    return Effect.NOTHING if opened else Effect.NO_CRACKS


def _sentences(kind: Effect, changes: CrackChanges, shown: Shown) -> Iterator[str]:
    """Yield the sentences of the paragraph: sign, size, what changed besides, cracks, mechanism."""
    if kind is Effect.NO_CRACKS:
        yield (
            "No crack took water in this run: cracks have no area in the reservoir's cells, and "
            f"the production is the same with and without them: {_at_most(changes)}."
        )
        return
    cause, heat = _cause(changes.last[0]), not _at_rest(kind)
    if changes.warmer or changes.colder:
        yield _temperature(cause, changes, shown)
        if changes.error > CHANGED * abs(changes.T).max():
            yield (
                f"Without cracks the simulator is up to {changes.error:.2g} K off the closed form, "
                f"so that no smaller change is told."
            )
        yield _energy(changes)
        yield _breakthrough(changes, shown)
    elif heat:
        yield f"{cause} did not change the production temperature: {_at_most(changes, heat=False)}."
        yield _energy(changes)
    else:
        nothing = "the heat" if kind is Effect.PRESSURE else "anything that the simulator resolves"
        yield f"{cause} did not change {nothing}: {_at_most(changes)}."
    if abs(changes.water) > CHANGED:
        more = "more" if changes.water > 0 else "less"
        yield (
            f"The wells produced {100 * abs(changes.water):.2g} % {more} water than without, which "
            f"has its part in these changes."
        )
    if isfinite(changes.impedance):
        yield _pressure(changes)
    if heat and isfinite(changes.area):
        yield _area(changes)
    yield from _cracks(changes.last[0])
    yield _why(kind, changes)


def _at_rest(kind: Effect) -> bool:
    """Return True if neither temperature nor energy changed."""
    return kind in (Effect.NOTHING, Effect.PRESSURE)


def _cause(last: Production) -> str:
    """Return the subject of the paragraph: what opened."""
    if last.cracks is None or not last.cracks.sides:
        return "Cracks"
    side = "the opening of fractures along sides"
    return f"Cracks and {side}" if last.cracks.area else side.capitalize()


def _temperature(cause: str, changes: CrackChanges, shown: Shown) -> str:
    """Return sign and size of the change of temperature."""
    warmest, coldest = int(changes.T.argmax()), int(changes.T.argmin())
    peaks = {warmest: "warmer"} if changes.warmer else {}
    peaks |= {coldest: "colder"} if changes.colder else {}
    end = len(changes.T) - 1
    when = {k: shown.time.text(changes.time[k]) for k in peaks} | {end: "the end"}
    parts = [
        f"{peaks[k]}, by at most {abs(changes.T[k]):.3g} K at {when[k]}" for k in sorted(peaks)
    ]
    last = "" if end in peaks else f"; at the end the difference is {changes.T[end]:+.3g} K"
    return f"{cause} made the produced water {', and later '.join(parts)}{last}."


def _at_most(changes: CrackChanges, *, heat: bool = True) -> str:
    """Return the size of unresolved changes beside what the simulator resolves."""
    T, energy = float(abs(changes.T).max()), 100 * abs(changes.energy)
    parts = [(f"it differs by at most {T:.2g} K", f"{changes.resolved_T:.2g} K")]
    if heat:
        parts = [
            (f"the production temperature differs by at most {T:.2g} K", parts[0][1]),
            (f"the energy by {energy:.2g} %", f"{100 * changes.resolved_energy:g} %"),
        ]
    found, resolved = (" and ".join(column) for column in zip(*parts, strict=True))
    return f"{found}, and what two runs can differ by is {resolved}"


def _energy(changes: CrackChanges) -> str:
    """Return the energy by the end."""
    one, other = changes.last
    unit = prefixed("J", max(abs(one.heat), abs(other.heat)))
    return (
        f"By the end the surface got {unit.text(one.heat)} with cracks and {unit.text(other.heat)} "
        f"without ({_percent(changes.energy)})."
    )


def _breakthrough(changes: CrackChanges, shown: Shown) -> str:
    """Return the times of a drawdown."""
    when = [
        f"at {shown.time.text(time)}" if isfinite(time) else "not by the end"
        for time in changes.breakthrough
    ]
    name = f"A drawdown of {100 * changes.level:.0f} %"
    if when[0] == when[1] == "not by the end":
        return f"{name} did not come by the end, with cracks or without."
    return f"{name} came {when[0]} with cracks, and {when[1]} without."


def _pressure(changes: CrackChanges) -> str:
    """Return the pressure difference between the wells at the end, with cracks and without."""
    unit = prefixed("Pa", max(abs(found.drop) for found in changes.last))
    one, other = (unit.text(found.drop) for found in changes.last)
    return (
        f"At the end the pressure difference between the wells is {one} with cracks and {other} "
        f"without (impedance {_percent(changes.impedance)})."
    )


def _area(changes: CrackChanges) -> str:
    """Return the exchange area at the end, with cracks and without."""
    one, other = (f"{grouped(found.area)} m²" for found in changes.last)
    return f"The exchange area is {one} with cracks and {other} without ({_percent(changes.area)})."


def _cracks(found: Production) -> Iterator[str]:
    """Yield area, volume and opening of the cracks at the end."""
    cracks = found.cracks
    if cracks is None:
        return
    if cracks.area:
        opening = prefixed("m", cracks.widest).text(cracks.widest, 3)
        yield (
            f"Cracks then have an area of {grouped(cracks.area, 3)} m², a volume of "
            f"{grouped(cracks.volume, 3)} m³ and openings of up to {opening}{_at_most_open(found)}."
        )
    for side, at in cracks.sides.items():
        unit = prefixed("m", max(abs(at.widest), abs(at.narrowest)))
        yield (
            f"The fracture along the side '{side}' is then open by {unit.of(at.narrowest):.3g} to "
            f"{unit.text(at.widest, 3)}."
        )


def _at_most_open(found: Production) -> str:
    """Return the bound that the water sees in place of wider openings."""
    cracks, rule = found.cracks, found.facts.cracks
    if cracks is None or rule is None or cracks.widest <= rule.largest:
        return ""
    return f", of which {prefixed('m', rule.largest).text(rule.largest, 3)} count for the water"


def _why(kind: Effect, changes: CrackChanges) -> str:
    """Return a mechanism with which the numbers are consistent."""
    if kind is Effect.PRESSURE:
        way = "a wider way" if changes.impedance < 0 else "a narrower way"
        return f"This is consistent with {way} for the water, past the same rock."
    if kind is Effect.WATER:
        more = "more" if changes.water > 0 else "less"
        return f"This is consistent with {more} water past the same rock."
    if kind is Effect.CHANGING:
        if changes.T.argmin() < changes.T.argmax():
            return (
                "This is consistent with water that takes a shorter way at first, and leaves heat "
                "in the other rock, which it brings later."
            )
        return (
            "This is consistent with water that goes through more rock at first, and takes heat "
            "earlier that is missing later."
        )
    return WHY[kind]


def _percent(change: float) -> str:
    """Return a relative change in words."""
    if abs(change) < SMALL:
        return "unchanged"
    return f"{100 * change:+.3g} %" if isfinite(change) else "not known"

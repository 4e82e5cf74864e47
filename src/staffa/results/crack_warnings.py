"""Warnings on what the flow in cracks of a run cannot show: spacing, bounds, water in cracks."""

from collections.abc import Iterator, Sequence

from staffa.display_units import Shown
from staffa.io.production_rows import Production, production
from staffa.io.run_directory import Run
from staffa.records.crack_flow import CrackFlow, SideOpening
from staffa.records.reservoir_facts import CrackRule

LEAK = 4.0  # spacing over spread below which neighbors share their water
ACTS = 0.01  # share of the cracks from which a bound is told
DETOUR = 0.1  # of the flow in a fracture, by cubes of openings, beside which a band takes a part
FULL = 0.01  # water in cracks over injected water, from which it counts
Met = tuple[Production, CrackFlow]


def crack_warnings(run: Run) -> list[str]:
    """Return sentences with numbers and the way out; none where cracks do not change the flow.

    Parameters
    ----------
    run : the run.
    """
    facts = run.manifest.reservoir
    rule = facts.cracks if facts else None
    found = [(one, one.cracks) for one in production(facts, run.steps) if one.cracks]
    if rule is None or not found:
        return []
    shown = run.manifest.shown
    return [
        *_near(found, rule, shown),
        *_beside(found, rule, shown),
        *_bounds(found, rule, shown),
        *_water(found, shown),
    ]


def _near(found: Sequence[Met], rule: CrackRule, shown: Shown) -> Iterator[str]:
    """Yield a sentence where cracks are nearer than their spread allows."""
    apart = [(c.spacing, one.time) for one, c in found if c.spacing is not None]
    if not apart or (least := min(apart))[0] >= LEAK * rule.spread:
        return
    spacing, time = least
    unit = shown.length
    last = unit.text(apart[-1][0], 3)
    yield (
        f"Cracks are {unit.text(spacing, 3)} apart at {shown.time.text(time)} ({last} at the end), "
        f"nearer than four times the {unit.text(rule.spread, 3)} over which they are spread: "
        f"oblique neighbors share their water. Take a smaller damage.ell and smaller "
        f"cells, reservoir.h, which bound reservoir.openings.spread."
    )


def _beside(found: Sequence[Met], rule: CrackRule, shown: Shown) -> Iterator[str]:
    """Yield a sentence where the bands of cracks take water of a fracture that they end in."""

    def within(opening: float) -> float:
        return min(max(opening, rule.smallest), rule.largest)

    for one, c in found:
        for side, at in sorted(c.sides.items()):
            crack, fracture = within(c.widest), within(at.narrowest)
            if c.area and (crack / fracture) ** 3 > DETOUR:
                share = f"{1e3 * crack:.2g} mm beside {1e3 * fracture:.2g} mm"
                yield (
                    f"Cracks are about as wide for the water as the fracture along the side "
                    f"'{side}' that they end in, {share} at {shown.time.text(one.time)}. In cells "
                    f"they are bands, and water of the fracture goes around in them, also where "
                    f"they lead nowhere: a change of the production by degrees may be this alone. "
                    f"Cracks along the axes of the cells do not do it (docs/how-to/circulation.md)."
                )
                return


def _bounds(found: Sequence[Met], rule: CrackRule, shown: Shown) -> Iterator[str]:
    """Yield a sentence for each bound that acts, on cracks and on fractures along sides."""
    of_cracks = [(one.time, c, "of the cracks' area") for one, c in found]
    sides = {side for _, c in found for side in c.sides}
    places: list[Sequence[tuple[float, CrackFlow | SideOpening, str]]] = [of_cracks]
    for side in sorted(sides):
        name = f"of the fracture along the side '{side}'"
        places.append([(one.time, c.sides[side], name) for one, c in found if side in c.sides])
    small, large = (f"{1e3 * bound:.3g} mm" for bound in (rule.smallest, rule.largest))
    for seen in places:
        time, most, name = max(seen, key=lambda at: at[1].at_smallest)
        if most.at_smallest >= ACTS:
            those = f"narrower or closed ones let water through as if they were {small} open"
            yield _bound("lower", most.at_smallest, name, shown.time.text(time), those, "smallest")
        time, most, name = max(seen, key=lambda at: at[1].at_largest)
        if most.at_largest >= ACTS:
            widest = f"those of up to {1e3 * most.widest:.3g} mm"
            those = f"{widest} let water through as if they were {large} open"
            yield _bound("upper", most.at_largest, name, shown.time.text(time), those, "largest")


def _bound(end: str, share: float, name: str, when: str, those: str, key: str) -> str:
    """Return the sentence on a bound that acts.

    Parameters
    ----------
    end : the end of the openings that it is at.
    share, name : the share that it acts on, and of what, in words.
    when : time of the largest share, in words.
    those : its effect, in words.
    key : key of the bound.
    """
    other = "smaller" if key == "smallest" else "larger"
    return (
        f"The {end} bound of the opening acts on {share:.0%} {name} at {when}: {those}. See if a "
        f"{other} reservoir.openings.{key} changes the production."
    )


def _water(found: Sequence[Met], shown: Shown) -> Iterator[str]:
    """Yield a sentence where the water in cracks counts beside the injected water."""
    shares = [
        (one.facts.water_rho * (c.volume + c.opened) / one.injected, one)
        for one, c in found
        if one.injected > 0
    ]
    if not shares:
        return
    share, when = max(shares, key=lambda at: at[0])
    if share > FULL:
        yield (
            f"The water in cracks is {share:.2%} of the water injected by "
            f"{shown.time.text(when.time)} ({shares[-1][0]:.2%} at the end). It is not taken from "
            f"the flow, so the production may be off by about as much. Trust it from the time on "
            f"at which this share is small, or take a longer run."
        )

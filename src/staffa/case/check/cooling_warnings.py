"""Warnings about cooling: its cracks, what a run resolves, and the depth that it reaches."""

from collections.abc import Iterator
from math import inf, sqrt

from staffa.case.check.cracking import (
    face_squeeze,
    first_and_last,
    other_causes,
    peak_drop,
    rare_factor,
)
from staffa.case.check.mesh_warnings import WIDTH, cell_edge, widest_ell
from staffa.case.check.strength_advice import key_of_strength
from staffa.case.scales.case_scales import Numbers, least_factor
from staffa.case.scales.squeeze import Squeeze
from staffa.case.scales.surface_cooling import strongest, surface_exchanges
from staffa.case.schema.boxes import product
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount, at_least, at_most, quoted
from staffa.case.values.subdomains import is_uneven
from staffa.physics.damage import COHESIVE
from staffa.physics.material import PLANE_STRESS
from staffa.physics.scales import diffusion_length, tau_of_time
from staffa.units import Quantity

# Nucleation with AT1 (dT/dT_c >= 3): at sqrt(kappa t) of .8 to .95 sqrt(ell ell0), with wavelength
# 10 to 11 sqrt(ell ell0); computed on a uniformly damaged layer.
NUCLEATION_DEPTH, WAVELENGTH = 0.8, 10.5
# With ell over ell0 beyond this the damage of neighboring cracks overlaps on the face.
OVERLAP = (WAVELENGTH / WIDTH) ** 2
# Single cracks then part from the damaged face at sqrt(kappa t) = 0.7 to 1 ell, as measured on a
# granite face at ell = 7 to 45 ell0; before 0.7 ell there was none.
PARTED = 0.7


def cooling_warnings(case: Case, derived: Numbers) -> Iterator[str]:
    """Yield all warnings about cooling."""
    yield from _of_heat(case)
    largest, squeezed = peak_drop(case, derived), face_squeeze(case, derived)
    causes = other_causes(case, forces=squeezed is None)
    share = start_of_damage(derived, largest, squeezed)
    if case.heat is not None and causes and (largest <= 0 or not _exchanges_heat(case)):
        return  # nothing is meant to cool: the body is heated, strained, or evens out
    if derived.dT_c is not None and share < 1:
        yield _no_nucleation(case, derived, derived.dT_c, largest, squeezed, causes)
        if not causes:
            return
    else:
        if derived.dT_c is not None and case.cracks and not case.toughness.bands:
            yield (
                f"more cracks will start on the cooled face between the given ones; to keep to "
                f"these, raise its toughness with toughness.bands, by a factor of "
                f"{at_least(case, share**2, '', digits=2).strip()} or more"
            )
        if derived.ell0 is not None and _cracks_at_face(case, share):
            yield from _of_nucleation(case, derived, derived.ell0 * toughness_at_face(case))
        yield from of_plane_strain(case, derived, largest, squeezed)
    yield from _of_opposite_boundary(case, derived, insulated=False)


def _exchanges_heat(case: Case) -> bool:
    assert case.heat is not None
    return bool(surface_exchanges(case)) or case.heat.source is not None


def cooling_notes(case: Case, derived: Numbers) -> Iterator[str]:
    """Yield notes on cooling: choices that may be intended."""
    share = start_of_damage(derived, peak_drop(case, derived), face_squeeze(case, derived))
    if derived.ell0 is not None and _cracks_at_face(case, share):
        ell0 = derived.ell0 * toughness_at_face(case)
        if derived.dT_c is not None:
            yield from _of_overlap(case, derived, ell0)
        yield from _of_coarse_nucleation(case, derived, ell0)
    if share >= 1 or other_causes(case):
        yield from _of_opposite_boundary(case, derived, insulated=True)


def start_of_damage(derived: Numbers, largest: float, squeezed: Squeeze | None) -> float:
    """Return the load at the largest drop of the face, over the load that starts damage.

    Parameters
    ----------
    derived : scales of the case.
    largest : largest temperature drop of the face (K).
    squeezed : squeeze of the cooled face; None without one.
    """
    if squeezed is not None:
        return squeezed.share
    return largest / derived.dT_c if derived.dT_c is not None else inf


def toughness_at_face(case: Case) -> float:
    """Return the least toughness over Gc that the bands leave on the cooled face."""
    bands = [(band, band.factor) for band in case.toughness.bands]
    places = case.outline.places.on(case.temperature.face)
    return float(product(places, bands, h=case.outline.h).min())


def _cracks_at_face(case: Case, share: float) -> bool:
    """Return whether cooling starts cracks on the face itself, as far apart as ell decides.

    Bands may make the face tougher than the rock below it, for which `share` holds. With a cohesive
    law ell does not decide.
    """
    return case.damage.law != COHESIVE and share >= sqrt(
        toughness_at_face(case) / least_factor(case)
    )


def instant(case: Case, derived: Numbers, time: float, *, up: bool) -> str:
    """Return a time as the case writes it, t or tau, rounded down, or up.

    Parameters
    ----------
    case : the case.
    derived : scales of the case.
    time : the time (s).
    up : True to round up, so that the time is reached; False to round down.
    """
    rounded = at_least if up else at_most
    if case.time.tau is None:
        return f"t = {rounded(case, time, 's', digits=2)}"
    tau = tau_of_time(time, kappa=derived.kappa, L=derived.L)
    return f"tau = {rounded(case, tau, '', digits=2).strip()}"


def _no_nucleation(
    case: Case,
    derived: Numbers,
    dT_c: float,
    largest: float,
    squeezed: Squeeze | None,
    causes: tuple[str, ...],
) -> str:
    """Return a sentence that cooling starts no crack, with what may break the body all the same."""
    what = "cooling starts no new crack" if causes else "nothing will crack"
    needed = squeezed.needed if squeezed else dT_c
    where = " without [forces]" if case.forces and not squeezed else ""
    weakest = squeezed.share if squeezed else largest / dT_c
    if weakest > sqrt(rare_factor(case)):
        what = f"perhaps {what}"
        where += ", or at less where the random toughness is low"
    elif is_uneven(case):
        what = f"perhaps {what}"
        where += ", or at less where the rock differs from its averages"
    elif case.forces and not squeezed:
        what = f"perhaps {what}"
    if squeezed and squeezed.stress < 0:
        why = _outweighed(case, derived, squeezed)
    else:
        start = at_least(case, needed, "K", digits=4)
        why = (
            f"the face drops by {amount(case, largest, 'K')} at most, and damage starts at {start}"
        )
    return (
        f"{what}: {why}{where}; {''.join(f'{cause}; ' for cause in causes)}to start cracks by "
        f"cooling, {_cure(case, needed, largest, dT_c, squeezed)}"
    )


def _outweighed(case: Case, derived: Numbers, squeezed: Squeeze) -> str:
    """Return a clause: the squeeze and the strength are more than the thermal stress."""
    free = "" if derived.state == PLANE_STRESS else "/(1 - nu)"
    bears = squeezed.starts - squeezed.stress
    starts, together = amount(case, squeezed.starts, "Pa"), amount(case, bears, "Pa")
    return (
        f"E expansion dT{free} = {amount(case, squeezed.thermal, 'Pa')} is less than the squeeze "
        f"of {amount(case, -squeezed.stress, 'Pa')}{_beyond(squeezed)} and the {starts} at which "
        f"damage starts, {together} together"
    )


def _beyond(squeezed: Squeeze) -> str:
    """Return a word on a stress that is not the one along the face."""
    return " across the plane" if squeezed.beyond else ""


def _cure(case: Case, needed: float, largest: float, dT_c: float, squeezed: Squeeze | None) -> str:
    """Return the numbers to take so that cooling starts cracks."""
    raised = f"raise the drop of the face to {at_least(case, needed, 'K', digits=4)} or more"
    net, starts = (squeezed.net, squeezed.starts) if squeezed else (largest, dT_c)
    if net > 0:
        wide = float(case.damage.ell) * (starts / net) ** 2 > widest_ell(case)
        if wide and case.damage.law != COHESIVE:
            return raised
        return f"{raised}, or take {key_of_strength(case, net / starts)}"
    if squeezed and squeezed.thermal > starts:
        most = at_most(case, squeezed.thermal - starts, "Pa")
        return f"{raised}, or squeeze it by {most}{_beyond(squeezed)} only"
    return raised


def _of_nucleation(case: Case, derived: Numbers, ell0: float) -> Iterator[str]:
    time, last = first_and_last(derived)
    first, h, ell = diffusion_length(derived.kappa, time), cell_edge(case), float(case.damage.ell)
    mixed = sqrt(ell * ell0)
    at_once = case.heat is None or _cools_at_once(case)  # else depth says little
    earliest = (h / 2) ** 2 / derived.kappa
    if mixed >= h and at_once and first > NUCLEATION_DEPTH * mixed:
        latest = (NUCLEATION_DEPTH * mixed) ** 2 / derived.kappa
        yield (
            f"the first step is too coarse to see nucleation: its diffusion length "
            f"{amount(case, first, 'm')} is past {NUCLEATION_DEPTH:g} sqrt(ell ell0) = "
            f"{amount(case, NUCLEATION_DEPTH * mixed, 'm')}; start at "
            f"{instant(case, derived, latest, up=False)} or before"
        )
    if at_once and first < h / 2 * (1 - 1e-9):
        yield (
            f"at the first step the diffusion length {amount(case, first, 'm')} is under half a "
            f"cell: the mesh does not see that temperature; start at "
            f"{instant(case, derived, earliest, up=True)} or later, or take domain.h <= "
            f"{at_most(case, 2 * first, 'm')}"
        )
    deep = diffusion_length(derived.kappa, last)
    if derived.dT_c is not None and _overlaps(case, ell, ell0) and deep < PARTED * ell:
        parted = instant(case, derived, ell**2 / derived.kappa, up=True)
        yield (
            f"the run ends while the whole face is damaged: single cracks part from it about when "
            f"sqrt(kappa t) is ell, and it is {deep / ell:.2g} ell at the end; go on to {parted}, "
            f"or take damage.ell <= {at_most(case, deep, 'm')}"
        )


def _of_coarse_nucleation(case: Case, derived: Numbers, ell0: float) -> Iterator[str]:
    h, mixed = cell_edge(case), sqrt(case.damage.ell * ell0)
    if mixed < h:
        ell = h * h / ell0
        overlaps = derived.dT_c is not None and _overlaps(case, ell, ell0)
        fits = ell <= widest_ell(case) and not overlaps
        larger = f", or damage.ell >= {at_least(case, ell, 'm')}" if fits else ""
        yield (
            f"sqrt(ell ell0) = {amount(case, mixed, 'm')} is below h = {amount(case, h, 'm')}: "
            f"nucleation is not resolved, so that the first cracks' number and time depend on the "
            f"mesh; later depths and spacings do not; to see it take h <= "
            f"{at_most(case, mixed, 'm')}{larger}"
        )


def _of_overlap(case: Case, derived: Numbers, ell0: float) -> Iterator[str]:
    """Warn of a face that is damaged all over, since ell is large."""
    ell = float(case.damage.ell)
    if not _overlaps(case, ell, ell0):
        return
    apart = WAVELENGTH * sqrt(ell * ell0)
    yield (
        f"the whole face will be damaged at first, not only where cracks are: these would start "
        f"{amount(case, apart, 'm')} apart, and the damage of one is 4 ell = "
        f"{amount(case, WIDTH * ell, 'm')} wide. Cracks part from it deeper, about when "
        f"sqrt(kappa t) is ell ({instant(case, derived, ell**2 / derived.kappa, up=True)}). For "
        f"single cracks from the face on take damage.ell <= {OVERLAP:.2g} ell0 = "
        f"{at_most(case, OVERLAP * ell0, 'm')}"
    )


def _overlaps(case: Case, ell: float, ell0: float) -> bool:
    """Return whether the damage of neighboring first cracks overlaps with this ell (m).

    Rock under [forces] is left out: its cracks start at another stress than that of cooling alone.
    """
    return case.forces is None and ell > OVERLAP * ell0 * (1 + 1e-9)


def of_plane_strain(
    case: Case, derived: Numbers, drop: float, squeezed: Squeeze | None
) -> Iterator[str]:
    """Warn if all rock that is colder by a part of the drop is damaged in plane strain.

    Parameters
    ----------
    case : the case.
    derived : scales of the case.
    drop : largest drop of the rock (K).
    squeezed : squeeze of the cooled face; None without one.
    """
    if derived.dT_c is None or case.material.plane != "strain":
        return
    given = case.forces.prestress.zz if case.forces and case.forces.prestress else None
    if squeezed is None and given is not None:
        return  # what is left across the plane is not told by cooling alone
    across = squeezed.across if squeezed else 0.0
    a_kelvin = derived.rock.E * derived.rock.expansion
    enough = (derived.sigma_c - across) / a_kelvin
    if drop <= enough:
        return
    net = a_kelvin * drop + across
    stronger = key_of_strength(case, net / derived.sigma_c)
    yield (
        f"in plane strain no crack of the plane relieves the stress across it, which alone, once "
        f"cracks have opened, damages all rock that is colder by {amount(case, enough, 'K')} or "
        f"more (of {amount(case, drop, 'K')}); take "
        f'material.plane = "stress", {_squeezed_across(case, given, net - derived.sigma_c)}, if '
        f"the rock is squeezed so, {stronger}, or a 3-D body"
    )


def _squeezed_across(case: Case, given: object, excess: float) -> str:
    """Return the prestress across the plane that takes off an excess (Pa) of the stress there."""
    if not isinstance(given, Quantity | None):
        return f"a forces.prestress.zz that is lower by {at_least(case, excess, 'Pa')}"
    total = float(given or 0.0) - excess
    below = at_least if total < 0 else at_most
    return f"forces.prestress.zz = {quoted(below(case, total, 'Pa'))} or below"


def _of_opposite_boundary(case: Case, derived: Numbers, *, insulated: bool) -> Iterator[str]:
    """Warn if cooling reaches the opposite boundary, which the profile insulates or ignores."""
    if derived.dT <= 0 or insulated != (case.temperature.profile in ("slab", "heat")):
        return
    _, last = first_and_last(derived)
    deep = diffusion_length(derived.kappa, last) / derived.L
    if deep <= 1 / 2 * (1 + 1e-9):
        return
    end = instant(case, derived, derived.L**2 / (4 * derived.kappa), up=False)
    depth = at_least(case, 2 * deep * derived.L, "m")
    reached = f"at the last step the diffusion length is {deep:.2g} of the depth: "
    if insulated:
        yield (
            f"{reached}cooling has passed the opposite boundary, and results after {end} hold "
            f"for this body, no more for deep rock; for deep rock end there, or make the body "
            f"{depth} deep"
        )
    else:
        yield (
            f'{reached}the opposite boundary is felt; take temperature.profile = "slab", '
            f"whose opposite boundary is insulated, end at {end}, or make the body {depth} deep"
        )


def _cools_at_once(case: Case) -> bool:
    coldest = strongest(surface_exchanges(case), case.temperature.face)
    return coldest is not None and coldest.at_once


def _of_heat(case: Case) -> Iterator[str]:
    if case.heat is not None and case.heat.cracks is not None and case.heat.cracks.h is not None:
        yield (
            "heat.cracks: the fluid is in every crack, also in one that it cannot reach; take "
            "what comes out as the strongest cooling, or leave out heat.cracks to see the least"
        )

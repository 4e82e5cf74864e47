"""The supports of a body, and their meaning for its cracks: a fact, a warning and notes."""

from collections.abc import Iterator

import numpy as np

from staffa.case.check.cracking import face_squeeze, first_and_last, is_strained_at_start
from staffa.case.rules.support_rules import is_held_at
from staffa.case.scales.case_scales import Numbers, load
from staffa.case.scales.squeeze import thermal_stress
from staffa.case.scales.surface_cooling import strongest, surface_exchanges
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount
from staffa.case.values.pressing_loads import WARMS, pressing
from staffa.loads.closed_form import Convective, HalfSpace, Load, NoLoad

SECTIONS = {
    "fixed": "left and right stay where they are, as with more rock beside them",
    "stretch": "left and right stay upright: free to shorten, not to bend; no force along the face",
    "free": "left and right stay plane: free to shorten and to bend; no force, no moment",
}
DEPTHS = 200  # places along the depth at which the temperature is averaged


def laterally_held(case: Case) -> bool:
    """Return True if no side beside the cooled face can move inward, at any depth of cooling."""
    if case.supports.section != "none":
        return case.supports.section == "fixed"
    return all(case.supports.on(side) in ("rollers", "clamped") for side in beside(case))


def beside(case: Case) -> list[str]:
    """Return the flat faces beside the cooled one."""
    body = case.outline
    face = case.temperature.face
    cooled = body.axis(face) if face in body.faces else None  # of none, all are beside it
    return [name for name in body.faces if body.axis(name) not in (None, cooled)]


def holding(case: Case) -> tuple[str, str]:
    """Return the supports in words, and what they leave free."""
    section = case.supports.section
    if section != "none":
        return f'section "{section}"', SECTIONS[section]
    found = [f"{name} {_kind(case, name)}" for name in case.outline.faces if is_held_at(case, name)]
    if not found:
        return "none", "it shortens and bends freely"
    shorten = case.temperature.acts and not laterally_held(case)
    return ", ".join(found), "it may shorten along the face" if shorten else "by [supports]"


def hinge_warnings(case: Case) -> Iterator[str]:
    """Warn of parts of a mesh that single points or edges join."""
    found = case.outline.hinges
    if not found:
        return
    first = ", ".join(f"{c:.3g}" for c in found[0])
    more = f" and {len(found) - 1} more" if len(found) > 1 else ""
    what = "single points or edges" if case.dim == 3 else "single points"
    yield (
        f"parts of the mesh share {what} only, at ({first}){more}: a hinge, about which they turn "
        f"freely, and whose stress is the mesh's own. Join them along faces (Gmsh: Coherence, or "
        f"BooleanFragments, before meshing), or leave out all but one; where they are meant, "
        f"support each by [supports]"
    )


def _kind(case: Case, name: str) -> str:
    support = case.supports.on(name)
    return support if isinstance(support, str) else "moved"


def holding_notes(case: Case, derived: Numbers) -> Iterator[str]:
    """Ask if the body is meant to be supported as it is."""
    if derived.face is None or case.supports.section in ("stretch", "free"):
        return
    sides = [name for name in beside(case) if case.outline.sides[name]]
    if sides and laterally_held(case):
        squeezed = face_squeeze(case, derived)
        mean = thermal_stress(derived, mean_drop(case, derived))
        mean += squeezed.along if squeezed else 0.0
        if mean <= 0:
            return
        give = "cooling gives" if squeezed is None else "cooling and [forces] give"
        fixed = case.supports.section == "fixed"
        warms = any(load.startswith(WARMS) for load in pressing(case))
        how_well = "" if case.heat is None else "at most " if warms else "about "
        stress = f"{how_well}{amount(case, mean, 'Pa')}"
        holds = 'supports.section = "fixed"' if fixed else f"supports of {', '.join(sides)}"
        yield (
            f"{holds}: the body is constrained along its face, as by more rock beside it, and at "
            f"the end {give} it, through its whole depth, a mean stress of {stress}, "
            f"{mean / derived.sigma_c:.2g} sigma_c. A plate that is free to shorten has none, and "
            f"its cracks stop earlier; for one {_freed(case)}"
        )
    elif not any(is_held_at(case, name) for name in case.outline.faces):
        around = ", ".join(sides) or "its sides"
        cools = derived.dT > 0 or is_strained_at_start(case)
        changes = (
            "shortens and bends while it cools" if cools else "lengthens and bends as it warms"
        )
        yield (
            f"nothing supports the body: it is loose and {changes}. Rock with more rock around it "
            f"has rollers on {around}, and on the opposite boundary; for a part of a long plate "
            f"{_freed(case)}"
        )


def _freed(case: Case) -> str:
    """Return the supports to take for a part of a plate that may shorten."""
    if case.axial:
        return f"leave {' or '.join(beside(case))} free"
    if case.dim == 3:
        return "leave one of two sides that face each other free, and give rollers to the other"
    return 'take supports.section = "stretch", or "free" if it may bend too, for left and right'


def mean_drop(case: Case, derived: Numbers) -> float:
    """Return the mean temperature drop over the depth of the body at the end (K).

    With the heat equation it is estimated: a half-space meets the strongest cooling at once.
    """
    assert derived.face is not None
    _, last = first_and_last(derived)
    x = np.zeros((3, DEPTHS))
    depth = (np.arange(DEPTHS) + 0.5) / DEPTHS * derived.L
    x[derived.face.axis] = derived.face.position + derived.face.inward * depth
    return float(-_cooling(case, derived).temperature(x, last).mean())


def _cooling(case: Case, derived: Numbers) -> Load:
    """Return the cooling in closed form, of the heat equation as of a half-space."""
    if case.heat is None:
        return load(case, derived)
    coldest = strongest(surface_exchanges(case), case.temperature.face)
    if coldest is None or derived.face is None:
        return NoLoad()
    drop, kappa, face = coldest.drop, derived.kappa, derived.face
    if coldest.film is not None:
        return Convective(dT=drop, kappa=kappa, face=face, h=coldest.film)
    return HalfSpace(dT=drop, kappa=kappa, face=face)

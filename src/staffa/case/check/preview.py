"""Preview of a case: what a run will do and cost; computed without finite elements."""

from dataclasses import dataclass
from math import sqrt

import numpy as np

from staffa.case.check.circulation_facts import circulation_facts
from staffa.case.check.cooling_warnings import WAVELENGTH
from staffa.case.check.cost_facts import cost_facts
from staffa.case.check.cracking import face_squeeze, first_and_last, forced, other_causes, verdict
from staffa.case.check.element_notes import element_facts
from staffa.case.check.front_facts import front_facts
from staffa.case.check.mesh_warnings import cell_edge
from staffa.case.check.support_warnings import holding, laterally_held
from staffa.case.check.temperature_change import formula_facts
from staffa.case.check.warnings import notes, warnings
from staffa.case.rules import require_loaded, unit
from staffa.case.rules.initial_stress import equivalent
from staffa.case.scales.case_scales import Numbers, derived_numbers, least_factor
from staffa.case.scales.surface_cooling import strongest, surface_exchanges
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount, at_least
from staffa.case.values.damage_law import case_irwin_length, damage_law, softening
from staffa.case.values.default_split import given_strengths, is_anisotropic, is_by_default
from staffa.case.values.diffusion_time import conductivities
from staffa.case.values.pressing_loads import pressing
from staffa.case.values.subdomains import (
    has_directions,
    is_uneven,
    subdomain_varies,
    subdomains_of,
    temperature_changes,
)
from staffa.geometry.block import broken_layer_thickness
from staffa.physics.damage import COHESIVE, effective_gc_factor, strength
from staffa.physics.material import PLANE_STRESS
from staffa.physics.scales import diffusion_length, tau_of_time
from staffa.physics.strength_surface import StrengthSurface

Fact = tuple[str, str, str]
TOLD = 1e-3  # part by which a split must add to the strength to be told
NONE = 1e-4  # a stress that drives damage as this part of it in a bar drives none


@dataclass(frozen=True, kw_only=True)
class Preview:
    """Preview of a run.

    Attributes
    ----------
    facts : (name, value, meaning) of each fact.
    warnings : a sentence on each likely mistake.
    notes : a sentence on each choice that may not be intended.
    """

    facts: tuple[Fact, ...]
    warnings: tuple[str, ...]
    notes: tuple[str, ...] = ()

    @property
    def verdict(self) -> str:
        """Return the last line of a check, which counts its warnings and notes."""
        counted = [
            f"{len(said)} {word}{'s' if len(said) > 1 else ''}"
            for word, said in (("warning", self.warnings), ("note", self.notes))
            if said
        ]
        if not self.warnings:
            counted = ["no warning", *counted] if counted else ["nothing is off"]
        return ", ".join(counted)


def preview(case: Case) -> Preview:
    """Return the preview of a case; raise InputError if nothing loads the body."""
    require_loaded(case)
    derived = derived_numbers(case)
    facts = [*_body_facts(case), *_mesh_facts(case), *_strength_facts(case, derived)]
    facts += [*element_facts(case), ("supports", *holding(case)), *split_facts(case, derived)]
    facts += _friction_facts(case) + formula_facts(case, derived) + front_facts(case, derived)
    if derived.cooled or case.reservoir is not None:
        facts += _heat_facts(case, derived) + _cooling_facts(case, derived)
        facts += _length_facts(case, derived)
    if case.reservoir is not None:
        facts += circulation_facts(case, derived)
    return Preview(
        facts=tuple([*facts, *cost_facts(case, derived)]),
        warnings=tuple(warnings(case, derived)),
        notes=tuple(notes(case, derived)),
    )


def _body_facts(case: Case) -> list[Fact]:
    """Return size, cells and names of a body that has a shape or a mesh."""
    if case.domain.is_block:
        return _axis_facts(case)
    body, metre = case.outline, unit(case, "m")
    size = " x ".join(f"{length:.4g}" for length in body.size)
    begins = ", ".join(f"{c:.4g}" for c in body.lower)
    flat = ", ".join(name for name, plane in body.faces.items() if plane) or "none"
    finer = case.domain.mesh is not None and case.domain.h is not None
    edge = "edge where cracks run, domain.h" if finer else "mean edge of the cells"
    named = {
        "faces": (
            body.faces,
            f"names for [supports], [heat], [forces], temperature.face; flat: {flat}",
        ),
        "regions": (body.regions, "parts of the body"),
        "cracks": (body.cracks, "that are there from the start"),
    }
    return [
        *_axis_facts(case),
        ("body", f"{size}{metre}", f"the box around it, which begins at ({begins})"),
        ("h", f"{body.h:.3g}{metre}", edge),
        *((what, ", ".join(names), meaning) for what, (names, meaning) in named.items() if names),
    ]


def _axis_facts(case: Case) -> list[Fact]:
    """Return the meaning of x and y in a body of revolution."""
    if not case.axial:
        return []
    low, high = (f"{r:.4g}" for r in (case.outline.lower[0], case.outline.upper[0]))
    meaning = "x is the distance r from the axis, y is z; energies and areas are of the whole body"
    return [("body of revolution", f"r = {low} to {high}{unit(case, 'm')}", meaning)]


def _mesh_facts(case: Case) -> list[Fact]:
    ell, h = float(case.damage.ell), cell_edge(case)
    layer = h * broken_layer_thickness(case.dim, str(case.domain.cells))
    factor = effective_gc_factor(damage_law(case), h=layer, ell=ell)
    return [
        ("ell/h", f"{ell / h:.3g}", "cells in a regularization length; 3 or more resolve a crack"),
        (
            "effective Gc",
            f"about {factor:.3f} Gc",
            "1 + h/(4 c_w ell): what the mesh adds; a run measures it",
        ),
    ]


def _rock_facts(case: Case, derived: Numbers) -> list[Fact]:
    """Return the averages that stand for rock whose properties vary."""
    body, *regions = subdomains_of(case)
    other = any(subdomain.keys != body.keys for subdomain in regions)
    others = ["differs by region"] if other else []
    if any(subdomain_varies(subdomain) for subdomain in subdomains_of(case)):
        others.append("varies from place to place")
    changing = temperature_changes(case)
    if changing:
        others.append(f"changes with temperature ({', '.join(changing)})")
    if any(has_directions(subdomain.keys) for subdomain in subdomains_of(case)):
        others.append("has directions")
    if not others:
        return []
    m, one = derived.rock, "averages of [material]"
    value = f"E {m.E:.4g}, nu {m.nu:.3g}, Gc {m.Gc:.4g}, expansion {m.expansion:.4g}"
    return [("rock", value, f"{one}, from which these scales follow: the rock {', '.join(others)}")]


def _strength_facts(case: Case, derived: Numbers) -> list[Fact]:
    sigma = f"{derived.sigma_c:.4g}{unit(case, 'Pa')}"
    facts = _rock_facts(case, derived)
    if case.damage.law == COHESIVE:
        irwin = case_irwin_length(case)
        told = f"strength of a bar at any ell, with {softening(case)} softening"
        facts.append(("sigma_c", sigma, told + _of_split(case, derived)))
        told = f"Irwin's length E Gc/sigma_c^2, {irwin / float(case.damage.ell):.3g} ell"
        facts.append(("l_ch", amount(case, irwin, "m"), told))
        facts += _other_strengths(case, derived)
    else:
        told = f"strength of a bar with {derived.law.name} and this ell"
        facts.append(("sigma_c", sigma, told + _of_split(case, derived)))
    if not case.temperature.acts:
        strain = derived.sigma_c / derived.rock.E
        sooner = ["the given cracks may grow sooner"] if case.cracks else []
        told = "; ".join(["sigma_c/E", *sooner, *forced(case)])
        facts.append(("will it crack", f"at a strain of {strain:.3g}", told))
    return facts


def _of_split(case: Case, derived: Numbers) -> str:
    """Return what the energy split adds to the strength; empty if nothing."""
    rock, ell = derived.rock, float(case.damage.ell)
    plain = strength(derived.law, E=rock.E, Gc=rock.Gc, ell=ell)
    if derived.sigma_c < (1 + TOLD) * plain:
        return ""
    key = "damage.strength, " if case.damage.law == COHESIVE else ""
    return (
        f"; {key}{amount(case, plain, 'Pa', digits=4)}, is that without a split: "
        f"{case.damage.split} keeps the energy of the lateral contraction from the damage"
    )


def _other_strengths(case: Case, derived: Numbers) -> list[Fact]:
    """Return the strengths under two equal tensions and under pressure, of isotropic rock."""
    if is_anisotropic(case):
        return []
    states = {
        "two tensions": ((1.0, 1.0, 0.0), "strength along each of two directions", "biaxial"),
        "compression": ((-1.0, 0.0, 0.0), "pressure that a bar bears", "compressive"),
    }
    facts, given = [], given_strengths(case)
    for name, (stress, told, key) in states.items():
        if case.damage.split == StrengthSurface.name:
            told += ", as asked for" if key in given else f", by default, without damage.{key}"
        else:
            told += ", by the energy split"
        bar = float(equivalent(case, np.array(stress)[:, None])[0])  # of a unit stress
        value = amount(case, derived.sigma_c / bar, "Pa") if bar > NONE else "any"
        facts.append((name, value, told))
    return facts


def split_facts(case: Case, derived: Numbers) -> list[Fact]:
    """Return the energy split, by default or not, and the loads that may press rock."""
    split, reasons = str(case.damage.split), pressing(case)
    if split == StrengthSurface.name:
        return [("energy split", split, "its strengths are above")]
    chosen = "by default, as" if is_by_default(case) else "asked for;"
    if not reasons:
        though = "asked for, though" if split != "none" else chosen
        why = f"{though} only cooling acts: cracks need no stiffness against pressure"
        return [("energy split", split, why)]
    though = "asked for, though" if split == "none" else chosen
    why = f"{though} {' and '.join(reasons)} may press cracks shut"
    if case.forces is not None:
        told = "sigma_c and dT_c do" if derived.cooled and derived.dT_c else "sigma_c does"
        why += f"; {told} not count {'them' if len(reasons) == 1 else 'the forces'}"
    return [("energy split", split, why)]


def _friction_facts(case: Case) -> list[Fact]:
    """Return the fact on friction between the faces of cracks, where they may slide."""
    if case.damage.split != "contact":
        return []
    if not case.damage.friction:
        return [("friction", "0", "between the faces of closed cracks, which slide freely")]
    told = "Coulomb's, between the faces of closed cracks; no second-order test, which it has not"
    return [("friction", f"{case.damage.friction:g}", told)]


def _heat_facts(case: Case, derived: Numbers) -> list[Fact]:
    if not case.conducts:
        return []
    k, face = conductivities(case), case.temperature.face
    where = f", across {face}" if face in case.outline.faces else ""
    along = "" if len(set(k)) == 1 else f", along {', '.join('xyz'[: case.dim])}"
    shown = " ".join(f"{c:.4g}" for c in (k if along else k[:1]))
    facts = [
        ("k", f"{shown}{unit(case, 'W/(m K)')}", f"conductivity{along}"),
        ("kappa", f"{derived.kappa:.4g}{unit(case, 'm^2/s')}", f"k/(rho c){where}"),
    ]
    for exchange in surface_exchanges(case) if case.heat is not None else ():
        if exchange.where == face and exchange.film is not None:
            biot = f"{exchange.film * derived.L:.3g}"
            facts.append(("Biot number", biot, "h L/k: well above 1, the film hardly hinders"))
    return facts


def _what_drops(case: Case) -> str:
    """Return in words where the temperature drop dT occurs."""
    if case.reservoir is not None:
        return "largest drop: of the warmest rock to the coldest water, which no rock passes"
    if case.heat is None:
        return "temperature drop of the face"
    coldest = strongest(surface_exchanges(case), case.temperature.face)
    if coldest is None:
        return "no side and no fluid is colder than the body was"
    what = "temperature drop" if coldest.film is None else "how much colder the bath is"
    return f"{what}, {coldest.where}"


def _cooling_facts(case: Case, derived: Numbers) -> list[Fact]:
    assert derived.severity is not None
    K = unit(case, "K")
    facts = [
        ("severity", f"{derived.severity:.4g}", "expansion dT sqrt(E L/Gc); 54 in the paper"),
        ("dT", f"{derived.dT:.4g}{K}", _what_drops(case)),
    ]
    if derived.dT_c is None:
        return [
            *facts,
            ("dT/dT_c", "none", f"{derived.law.name} has no threshold: any drop damages"),
            ("will it crack", *verdict(case, derived)),
        ]
    relaxed = (
        "" if laterally_held(case) else "; less strain if the cooled depth lets the body contract"
    )
    nothing = "cooling starts no crack" if other_causes(case) else "nothing is damaged"
    below = f"below 1 {nothing}{', but for [forces]' if case.forces else ''}"
    return [
        *facts,
        ("dT_c", f"{derived.dT_c:.4g}{K}", f"drop at which damage starts, {_where(case, derived)}"),
        ("dT/dT_c", f"{derived.dT / derived.dT_c:.3g}", f"{below}{relaxed}"),
        *_force_facts(case, derived),
        ("will it crack", *verdict(case, derived)),
    ]


def _where(case: Case, derived: Numbers) -> str:
    """Return in words the strain state and the rock for which dT_c holds."""
    blocked = "plane stress" if derived.state == PLANE_STRESS else "both lateral strains blocked"
    factor = least_factor(case)
    weak = "" if factor == 1 else f", where the toughness is {factor:.3g} Gc"
    region = "" if derived.weakest == "material" else f", in {derived.weakest}"
    noise = "; less where the random toughness is low" if case.toughness.amplitude else ""
    varied = "; more or less where the rock differs" if is_uneven(case) else ""
    return f"{blocked}{region}{weak}{noise}{varied}"


def _force_facts(case: Case, derived: Numbers) -> list[Fact]:
    """Return facts on the squeeze of the cooled face and on the tension by cooling."""
    squeezed = face_squeeze(case, derived)
    if squeezed is None:
        return []
    free = "" if derived.state == PLANE_STRESS else "/(1 - nu)"
    rest, thermal = amount(case, squeezed.along, "Pa"), amount(case, squeezed.thermal, "Pa")
    net = amount(case, squeezed.along + squeezed.thermal, "Pa")
    starts, there = "damage starts", amount(case, squeezed.starts, "Pa")
    starts += f" across the plane, at {there} there" if squeezed.beyond else f" at {there}"
    least = "along the face before cooling, where it is squeezed least; tension counts positive"
    return [
        ("initial stress", rest, least),
        ("thermal stress", thermal, f"E expansion dT{free}, dT the largest drop of the face"),
        ("net tension", net, f"the sum of both; {starts}"),
        (
            "drop it takes",
            at_least(case, squeezed.needed, "K", digits=4),
            "of the face, for damage to start",
        ),
    ]


def _length_facts(case: Case, derived: Numbers) -> list[Fact]:
    metre, kappa = unit(case, "m"), derived.kappa
    ell, h = float(case.damage.ell), cell_edge(case)
    facts, ell0 = [], derived.ell0
    if ell0 is not None:
        meaning = "Gc over thermal stress squared: unit of spacing"
        facts.append(("ell0", f"{ell0:.3g}{metre}", meaning))
    if ell0 is not None and derived.dT_c is not None and case.damage.law != COHESIVE:
        mixed, apart = sqrt(ell0 * ell), f"cracks start about {WAVELENGTH:g} of these apart"
        value = f"{mixed:.3g}{metre}"
        facts.append(("sqrt(ell ell0)", value, f"{apart}, if dT/dT_c is 3 or more"))
    for which, time in zip(("first", "last"), first_and_last(derived), strict=True):
        length, tau = diffusion_length(kappa, time), tau_of_time(time, kappa=kappa, L=derived.L)
        against = f"{length / h:.2g} h, {length / ell:.2g} ell (tau = {tau:.3g})"
        facts.append((f"sqrt(kappa t), {which} step", f"{length:.3g}{metre}", against))
    return facts

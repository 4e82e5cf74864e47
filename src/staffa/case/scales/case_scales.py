"""The derived numbers of a case: depth, drop, times, strengths; no finite elements."""

from dataclasses import dataclass
from math import sqrt

import numpy as np

from staffa.case.rules import times_given
from staffa.case.scales.reservoir_drop import reservoir_drop
from staffa.case.scales.surface_cooling import strongest, surface_exchanges
from staffa.case.schema.case import Case
from staffa.case.schema.cooling_keys import FORMULA
from staffa.case.values.damage_law import damage_law
from staffa.case.values.default_split import energy_split
from staffa.case.values.diffusion_time import depth, diffusivity, times_in
from staffa.case.values.subdomains import Averages, averages, subdomains_of
from staffa.case.values.temperature_formula import temperature_change
from staffa.errors import InputError
from staffa.geometry.places import SAME
from staffa.loads.closed_form import PROFILES, AnyTemperature, CooledFace, Face, Load, NoLoad
from staffa.physics import scales
from staffa.physics.damage import DamageLaw, strength
from staffa.physics.material import AXIAL, PLANE_STRAIN, PLANE_STRESS, SOLID
from staffa.physics.split import NO_SPLIT, EnergySplit, driven_share
from staffa.units import LARGEST, SMALLEST


@dataclass(frozen=True, kw_only=True)
class Numbers:
    """Scales that follow from a case, in SI or scaled as the case is.

    Attributes
    ----------
    state : strain state across the body: plane strain, plane stress, axial or solid.
    law : the damage law.
    rock : averages of the rock in [material], from which the scales follow.
    weakest : the part of the body whose damage starts at the least drop.
    cooled : True if a face is cooled, by a drop that is known.
    face : flat side from which depths are measured, None without one.
    L : depth of the body below the cooled face (m).
    kappa : diffusivity across the cooled face (m^2/s).
    dT : temperature drop (K), 0 without cooling.
    severity : severity of the cooling (dimensionless), None without cooling.
    sigma_c : strength at which damage starts (Pa).
    dT_c : drop at which damage starts in `weakest`, where the toughness is least (K); None for a
        law without threshold.
    ell0 : thermal fracture length (m), None without cooling.
    times : ends of the steps (s).
    requested : times whose fields are kept (s).
    """

    state: str
    law: DamageLaw
    rock: Averages
    weakest: str
    cooled: bool
    face: Face | None
    L: float
    kappa: float
    dT: float
    severity: float | None
    sigma_c: float
    dT_c: float | None
    ell0: float | None
    times: tuple[float, ...]
    requested: tuple[float, ...]

    def table(self) -> dict[str, float | None]:
        """Return the scales, for the record."""
        return {
            "L": self.L,
            "dT": self.dT,
            "severity": self.severity,
            "sigma_c": self.sigma_c,
            "dT_c": self.dT_c,
            "ell0": self.ell0,
        }


def derived_numbers(
    case: Case,
    *,
    law: DamageLaw | None = None,
    split: EnergySplit | None = None,
    own_load: bool = False,
) -> Numbers:
    """Return the scales of a case.

    Parameters
    ----------
    case : the case.
    law : damage law of a script, in place of the case's.
    split : energy split of a script, in place of the case's.
    own_load : True if a script gives the temperature, so that drops are unknown.
    """
    ell = float(case.damage.ell)
    law, split = law or damage_law(case), split or energy_split(case)
    state = _state(case)
    rocks = {subdomain.name: averages(subdomain) for subdomain in subdomains_of(case)}
    m = rocks["material"]
    cooled = case.temperature.cools_a_face
    L = depth(case)
    dT, severity = (0.0, None) if own_load else drop(case, m, L)
    least = least_factor(case)
    drops = {name: _critical_drop(law, split, r, least, ell, state) for name, r in rocks.items()}
    weakest = min(rocks, key=lambda name: drops[name] or 0.0)
    return Numbers(
        state=state,
        law=law,
        rock=m,
        weakest=weakest,
        cooled=cooled,
        face=cooled_face(case),
        L=L,
        kappa=diffusivity(case),
        dT=dT,
        severity=severity,
        sigma_c=strength(law, E=m.E, Gc=m.Gc, ell=ell) / sqrt(_of_a_bar(split, m.nu, state)),
        dT_c=drops[weakest] if case.temperature.acts else None,
        ell0=scales.ell0(**vars(m), dT=dT, state=state) if dT else None,
        times=tuple(times_in(case, times_given(case))),
        requested=tuple(times_in(case, np.array(case.output.at, dtype=float))),
    )


def _state(case: Case) -> str:
    """Return the strain state across the body."""
    if case.dim == 3:
        return SOLID
    if case.axial:
        return AXIAL
    return PLANE_STRESS if case.plane_stress else PLANE_STRAIN


def _of_a_bar(split: EnergySplit, nu: float, state: str) -> float:
    """Return the part of a pulled bar's energy that drives damage."""
    across = (-nu,) if state == PLANE_STRESS else (-nu, -nu)
    return 1.0 if split is NO_SPLIT else driven_share(split, (1.0, *across), nu)


def _critical_drop(
    law: DamageLaw, split: EnergySplit, rock: Averages, least: float, ell: float, state: str
) -> float | None:
    """Return the drop at which damage starts in a rock whose bands leave this much toughness."""
    numbers = vars(rock) | {"Gc": rock.Gc * least}
    drop = scales.critical_drop(law, **numbers, ell=ell, state=state)
    if drop is None or split is NO_SPLIT:
        return drop
    if state == PLANE_STRESS:
        return drop / sqrt(_of_a_bar(split, rock.nu, state))
    blocked = (1.0, 1.0, -2 * rock.nu / (1 - rock.nu))  # along the face, and free across it
    return drop / sqrt(driven_share(split, blocked, rock.nu))


def cooled_face(case: Case) -> Face | None:
    """Return the side from which depths count as a plane; None without one, or of no flat one."""
    if not case.temperature.has_face or case.outline.sides[case.temperature.face] is None:
        return None
    plane = case.outline.faces[case.temperature.face]
    assert plane is not None
    return Face(axis=plane.axis, position=plane.position, inward=-plane.out)


def least_factor(case: Case) -> float:
    """Return the least toughness over Gc that the bands leave in the body, 1 without bands.

    The bands' edges cut the body into boxes, in each of which the factors of all bands that cover
    it are multiplied.

    Raises
    ------
    InputError
        They leave so little or so much that it cannot be computed with.
    """
    cuts = [
        _apart(np.unique(np.clip([low, high, *lows, *highs], low, high)), case.outline.h)
        for low, high, lows, highs in zip(
            case.outline.lower,
            case.outline.upper,
            _corners(case, "lower"),
            _corners(case, "upper"),
            strict=True,
        )
    ]
    middles = [(cut[1:] + cut[:-1]) / 2 for cut in cuts]
    factors = np.ones([len(middle) for middle in middles])
    for band in case.toughness.bands:
        ends = zip(middles, band.lower, band.upper, strict=True)
        covered = np.ix_(*((low < middle) & (middle < high) for middle, low, high in ends))
        with np.errstate(over="ignore", invalid="ignore"):  # which is refused below
            factors[covered] *= band.factor
    for extreme in (float(factors.min()), float(factors.max())):
        if not SMALLEST <= extreme <= LARGEST:
            raise InputError(
                f"toughness.bands: where they overlap, the toughness is {extreme:.3g} times "
                f"material.Gc; their factors are multiplied there, so take others"
            )
    return float(factors.min())


def _apart(cut: np.ndarray, h: float) -> np.ndarray:
    """Return edges in order, without those that differ from the one before by round-off."""
    return cut[np.diff(cut, prepend=-np.inf) > SAME * h]


def _corners(case: Case, name: str) -> list[list[float]]:
    """Return one coordinate of this corner of all bands, for each axis."""
    return [
        [float(getattr(band, name)[axis]) for band in case.toughness.bands]
        for axis in range(case.dim)
    ]


def drop(case: Case, m: Averages, L: float) -> tuple[float, float | None]:
    """Return temperature drop dT (K) and severity; with [heat] those of its strongest cooling,
    with [reservoir] those of its coldest water.

    Parameters
    ----------
    case : the case, which gives one of the two.
    m : averages of the rock.
    L : depth of the body below the cooled face (m).
    """
    keys = case.temperature
    if not keys.cools_a_face and case.reservoir is None:
        return 0.0, None
    sizes = {"expansion": m.expansion, "E": m.E, "L": L, "Gc": m.Gc}
    if case.reservoir is not None:
        dT = reservoir_drop(case)
        return dT, scales.severity(dT=dT, **sizes)
    if case.heat is not None:
        coldest = strongest(surface_exchanges(case), keys.face)
        dT = coldest.drop if coldest else 0.0
        return dT, scales.severity(dT=dT, **sizes)
    if keys.severity is not None:
        return scales.dT_of_severity(severity=keys.severity, **sizes), keys.severity
    assert keys.dT is not None
    return float(keys.dT), scales.severity(dT=keys.dT, **sizes)


def load(case: Case, derived: Numbers) -> Load:
    """Return the temperature of a case in closed form.

    The heat equation and a reservoir count as a half-space; without a flat cooled face nothing is
    cooled.
    """
    keys, face = case.temperature, derived.face
    if keys.profile == FORMULA:
        return AnyTemperature(change=temperature_change(case))
    if face is None:
        return NoLoad()
    cooled = CooledFace(dT=derived.dT, kappa=derived.kappa, face=face, L=derived.L, biot=keys.biot)
    return PROFILES.get(keys.profile, PROFILES["half-space"])(cooled)

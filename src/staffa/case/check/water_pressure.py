"""Warnings about the pressure of circulating water, where it would damage rock by itself."""

from collections.abc import Iterator
from math import e, log, pi

from staffa.case.scales.breakthrough import Doublet, doublet, water_heat
from staffa.case.scales.case_scales import Numbers
from staffa.case.scales.reservoir_drop import coldest_water
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount, at_least, at_most
from staffa.case.schema.reservoir_keys import WaterKeys
from staffa.case.schema.toml_text import inline
from staffa.case.values.applied_forces import forces
from staffa.case.values.pressing_loads import WATER, pressing
from staffa.case.values.property_functions import in_space
from staffa.case.values.reservoir_places import fractured_sides, reservoir_keys, thickness
from staffa.physics.damage import slope
from staffa.physics.water import COMPRESSIBILITY, EXPANSION, viscosity
from staffa.reservoir.permeability import WIDEST

# Part of the strength that presses no crack shut which cooling opens.
SLIGHT = 0.02
# Part of the elastic energy up to which residual stiffness may carry a load; that of
# `evolution.loose_parts`.
CARRIED = 1e-2


def pressure_warnings(case: Case, derived: Numbers) -> Iterator[str]:
    """Warn of a pressure that damages cooled rock as a whole.

    The fluid of damaged rock takes up its thermal shrinkage, so a pressure p in it gains p times
    the free strain, dim expansion dT, which the law resists with w'(0) Gc/(4 c_w ell): 3 Gc/(8 ell)
    with AT1.
    """
    acting, rock = forces(case), derived.rock
    free_strain = case.dim * rock.expansion * derived.dT
    if not (acting.fluid and acting.balanced) or derived.dT_c is None or free_strain <= 0:
        return
    share = (1 - acting.biot) * free_strain  # pores carry the rest, cracked or not
    law, ell = derived.law, float(case.damage.ell)
    resisted = float(slope(law.w, 0.0)) * rock.Gc / (4 * law.c_w * ell)
    if share <= 0:
        return
    told = list(_of_flow(case, resisted / share))
    yield from told or _of_broken_rock(case, derived)
    yield from _of_cooled_pores(case, derived, resisted / share)


def presses_slightly(case: Case, derived: Numbers) -> bool:
    """Return True if only circulating water presses, by a small part of the strength.

    Known of one fracture along a side of the body, whose wells drive the water.

    Parameters
    ----------
    case : the case.
    derived : its scales.
    """
    wells, sides = doublet(case), fractured_sides(case)
    if wells is None or len(sides) != 1 or pressing(case) != (WATER,):
        return False
    (fracture,) = sides.values()
    return _rise(case, wells, float(fracture.opening)) < SLIGHT * derived.sigma_c


def _of_flow(case: Case, allowed: float) -> Iterator[str]:
    """Warn of the pressure that drives water along the fracture of a 2-D body.

    Parameters
    ----------
    case : the case.
    allowed : pressure (Pa) above which cooled rock is damaged by it.
    """
    wells, sides = doublet(case), fractured_sides(case)
    if case.dim != 2 or wells is None or len(sides) != 1:
        return
    ((side, fracture),) = sides.items()
    rise = _rise(case, wells, float(fracture.opening))
    if rise <= allowed:
        return
    over = rise / allowed
    wider = at_least(case, float(fracture.opening) * over ** (1 / 3), "m")
    rate = wells.rate * thickness(case) / over
    yield (
        f"reservoir.fractures, side = {inline(side)}: the water rises in pressure by up to "
        f"{amount(case, rise, 'Pa')} from the producer to the injector, and above "
        f"{amount(case, allowed, 'Pa')}, 3 Gc/(8 ell) over the free strain of cooled rock, it "
        f"damages all of this rock; take opening >= {wider}, damage.ell <= "
        f"{at_most(case, float(case.damage.ell) / over, 'm')}, or a rate <= "
        f"{at_most(case, rate, 'kg/s')}"
    )


def _of_broken_rock(case: Case, derived: Numbers) -> Iterator[str]:
    """Warn of a pressure that rock broken all through, at a cooled wall, does not bear.

    Residual stiffness eta E alone supports it. Under a pressure p it stores p^2/(2 eta E), and the
    rock beside it up to sigma_c^2/(2 E); a run ends where the former is more than CARRIED of all.
    So p may be sqrt(CARRIED eta) sigma_c. With feedback the fracture opens, and p falls.
    """
    wells, sides = doublet(case), fractured_sides(case)
    if case.dim != 2 or wells is None or len(sides) != 1 or reservoir_keys(case).feedback:
        return
    if derived.dT_c is None or derived.dT <= derived.dT_c:
        return
    ((side, fracture),) = sides.items()
    left, rise = case.damage.residual_stiffness, _rise(case, wells, float(fracture.opening))
    borne = (CARRIED * left) ** 0.5 * derived.sigma_c
    if rise <= borne:
        return
    wider = at_least(case, float(fracture.opening) * (rise / borne) ** (1 / 3), "m")
    rate = wells.rate * thickness(case) * borne / rise
    yield (
        f"reservoir.fractures, side = {inline(side)}: the water rises in pressure by up to "
        f"{amount(case, rise, 'Pa')} from the producer to the injector, and above about "
        f"{amount(case, borne, 'Pa')} rock at the wall that is broken all through does not bear "
        f"it, so that the run may end with the body in two: damage.residual_stiffness = {left:g} "
        f"alone supports it; take opening >= {wider}, or a rate <= {at_most(case, rate, 'kg/s')}"
    )


def _rise(case: Case, wells: Doublet, opening: float) -> float:
    """Return the pressure drop along a fracture, full of the coldest water (Pa).

    In 2-D it is 12 mu q L/w^3. Two wells in a plane without end have 12 mu q/(pi w^3) ln(L/r), and
    four times that in the corners of a body; this is the upper bound for 3-D.

    Parameters
    ----------
    case : the case.
    wells : its wells; their rate is that of half of the fracture.
    opening : opening w of the fracture (m).
    """
    water = reservoir_keys(case).water
    mu = float(water.mu) if isinstance(water, WaterKeys) else viscosity(coldest_water(case))
    rho, _ = water_heat(case)
    way = wells.distance
    if case.dim == 3:
        radius = float(wells.injector.radius)
        way = 4 / pi * log(max(wells.distance / radius, e))
    return 12 * mu * 2 * wells.rate / rho * way / min(opening, WIDEST) ** 3


def _of_cooled_pores(case: Case, derived: Numbers, allowed: float) -> Iterator[str]:
    """Warn of pores so tight that their water loses pressure as it cools.

    A wall of constant pressure that is cooled by dT: the pressure falls by about Lambda dT/(1 + r),
    r: hydraulic over thermal diffusivity (Delaney 1982), Lambda: expansion over compressibility.

    Parameters
    ----------
    case : the case.
    derived : its scales.
    allowed : change of pressure (Pa) that acts on cooled rock as much as its strength does.
    """
    keys, x = reservoir_keys(case), case.outline.places.within()
    if keys.simulator != "darts" or isinstance(keys.water, WaterKeys):
        return
    k, porosity = (
        x.mean(in_space(value, case.dim)(x.x)) for value in (keys.permeability, keys.porosity)
    )
    diffusivity = k / (porosity * viscosity(coldest_water(case)) * COMPRESSIBILITY)
    undrained = EXPANSION / COMPRESSIBILITY * derived.dT
    fall = undrained / (1 + diffusivity / derived.kappa)
    if fall <= allowed:
        return
    needed = k * (undrained / allowed - 1) * derived.kappa / diffusivity
    yield (
        f"reservoir.permeability = {inline(keys.permeability)}: pores are so tight that their "
        f"water loses some {amount(case, fall, 'Pa')} as it cools, which acts in cracks "
        f"too and decides where they go; take reservoir.permeability >= "
        f"{at_least(case, needed, 'm^2', digits=1)}, or water of constant properties"
    )

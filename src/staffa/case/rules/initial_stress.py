"""The stress of even rock before cooling begins, and the rule that the rock bears it."""

import numpy as np

from staffa.case.rules.support_rules import is_held_at, is_moved
from staffa.case.schema.case import Case
from staffa.case.schema.field_types import ONE
from staffa.case.schema.quantity_text import amount, key
from staffa.case.schema.shape_keys import Layers
from staffa.case.schema.toml_text import inline
from staffa.case.values.applied_forces import forces, pore_pressure_at_rest
from staffa.case.values.damage_law import damage_law
from staffa.case.values.default_split import energy_split, is_anisotropic, presses
from staffa.case.values.subdomains import averages, is_uneven, subdomains_of
from staffa.errors import InputError
from staffa.loads.forces import Forces
from staffa.physics.damage import COHESIVE, strength
from staffa.physics.split import NO_SPLIT, driven_density
from staffa.physics.strained import of_principal


def initial_normal_stresses(case: Case, x: np.ndarray, t: float = 0.0) -> np.ndarray | None:
    """Return the normal stresses along x, y, z of the uncracked rock under [forces] alone.

    Along an axis whose two ends are constrained nothing moves; along another the stress is what
    acts on its free end, and weight. What pores carry is taken off: a tension counts positive.

    Parameters
    ----------
    case : the case.
    x : points, shape (3, n) (m).
    t : time (s) at which what acts on the faces is taken.

    Returns
    -------
    Stresses (Pa), shape (3, n); None where even rock does not tell them: with shear, with rock that
    has directions, with moved sides, of a body of revolution, and of one without flat ends along
    an axis.
    """
    acting = forces(case)
    if is_anisotropic(case) or is_moved(case) or case.axial:
        return None
    start = np.zeros((6, x.shape[1])) if acting.prestress is None else acting.prestress(x)
    if np.any(start[3:] != 0):
        return None
    pores = acting.biot * pore_pressure_at_rest(case)(x)
    before, after = start[:3] + pores, start[:3] + pores
    loaded = []
    if case.plane_stress:
        after[2], loaded = np.zeros(x.shape[1]), [2]
    for axis in range(case.dim):
        sides = case.outline.sides
        ends = [name for name in sides if sides[name] and case.outline.axis(name) == axis]
        free = [name for name in ends if "xyz"[axis] not in is_held_at(case, name)]
        if len({sides[name] for name in ends}) < 2:
            return None
        if free:
            given = _acting_on(case, acting, free[0], x, t)
            if given is None:
                return None
            after[axis] = given + pores
            loaded.append(axis)
    return _with_fixed_strains(before, after, loaded, averages(subdomains_of(case)[0]).nu)


def _acting_on(case: Case, acting: Forces, face: str, x: np.ndarray, t: float) -> np.ndarray | None:
    """Return the normal stress by a face and the weight beyond at points (Pa); None with shear."""
    plane = case.outline.faces[face]
    assert plane is not None
    on_face = x.copy()
    on_face[plane.axis] = plane.position
    stress = np.zeros(x.shape[1])
    if face in acting.fluid_sides and not acting.balanced:
        stress -= pore_pressure_at_rest(case)(on_face)
    for traction in acting.sides:
        if traction.side != face:
            continue
        if traction.pressure is not None:
            stress -= traction.pressure(on_face, t)
        if traction.force is not None:
            force = np.asarray(traction.force(on_face, t))
            if np.any(np.delete(force, plane.axis, axis=0) != 0):
                return None
            stress += plane.out * force[plane.axis]
    if acting.gravity is not None:
        body = subdomains_of(case)[0]
        weight = body.average(body.keys.rho or ONE) * acting.gravity[plane.axis]
        stress += weight * (plane.position - x[plane.axis])
    return stress


def _with_fixed_strains(
    before: np.ndarray, after: np.ndarray, loaded: list[int], nu: float
) -> np.ndarray:
    """Return stresses, shape (3, n), after a change of those along the loaded axes.

    Nothing moves along the other axes.
    """
    fixed = [axis for axis in range(3) if axis not in loaded]
    if not loaded or not fixed:
        return after
    compliance = (1 + nu) * np.eye(3) - nu
    change = compliance[np.ix_(fixed, loaded)] @ (after[loaded] - before[loaded])
    after[fixed] = before[fixed] - np.linalg.solve(compliance[np.ix_(fixed, fixed)], change)
    return after


def equivalent(case: Case, stress: np.ndarray) -> np.ndarray:
    """Return the tension of a bar that drives damage as much as a stress (Pa), shape (n,).

    The bar has no energy split and the rock of [material].

    Parameters
    ----------
    case : the case.
    stress : normal stresses along x, y, z (Pa), shape (3, n).
    """
    rock, split = averages(subdomains_of(case)[0]), energy_split(case)
    strains = ((1 + rock.nu) * stress - rock.nu * stress.sum(axis=0)) / rock.E
    if case.plane_stress:
        strains = strains[:2]
    principal = tuple(-np.sort(-strains, axis=0))
    e = of_principal(principal, E=rock.E, nu=min(rock.nu, 0.4999))
    driving = e.psi if split is NO_SPLIT else driven_density(split, e)
    return np.asarray(np.sqrt(np.maximum(2 * rock.E * driving, 0.0)))


def rest_is_borne(case: Case) -> None:
    """Require that the forces before cooling do not break all of the rock, if it is uniform."""
    even = case.domain.is_block or isinstance(case.domain.shape, Layers)
    if case.forces is None or not even or is_uneven(case):
        return
    stress = initial_normal_stresses(case, case.outline.places.within().x)
    if stress is None:
        return
    rock = averages(subdomains_of(case)[0])
    factor = np.prod([max(band.factor, 1.0) for band in case.toughness.bands])
    toughest = max(averages(subdomain).Gc for subdomain in subdomains_of(case)) * float(factor)
    bears = strength(damage_law(case), E=rock.E, Gc=toughest, ell=float(case.damage.ell))
    share = equivalent(case, stress) / bears
    if share.min() > 1:
        raise InputError(_broken(case, stress[:, share.argmin()], float(share.min())))


def _broken(case: Case, stress: np.ndarray, share: float) -> str:
    """Return a sentence: a stress (Pa), shape (3,), is `share` times as large as the rock bears."""
    axis = int(np.abs(stress).argmax())
    carried, name = float(stress[axis]), "xyz"[axis]
    assert case.forces is not None
    given = getattr(case.forces.prestress, 2 * name, None)
    if carried < 0:
        pressed = f"{amount(case, -carried, 'Pa')} of pressure along {name}"
        return (
            f"[forces] ({presses(case)}): before cooling begins the rock would carry {pressed}, "
            f"and with this damage.split it breaks at {amount(case, -carried / share, 'Pa')}; "
            f"{_stronger(case)}"
        )
    where = f"forces.prestress.{2 * name}" if given else f"[forces] ({presses(case)})"
    value = f" = {inline(given)}" if given and not hasattr(given, "gradient") else ""
    squeezed = key(case, -carried, "Pa")
    return (
        f"{where}{value}: before cooling begins the rock would carry {amount(case, carried, 'Pa')} "
        f"of tension along {name}, and it breaks at {amount(case, carried / share, 'Pa')}; "
        f"stresses count positive in tension, so that squeezed rock has {squeezed}"
    )


def _stronger(case: Case) -> str:
    """Return what makes rock bear more pressure, as the end of a sentence."""
    keys = case.damage
    if keys.compressive is not None:
        return f"take a larger damage.compressive than {inline(keys.compressive)}, or leave it out"
    if keys.split:
        return "leave damage.split out"
    return f"take a {higher_strength(case)}"


def higher_strength(case: Case) -> str:
    """Return the change of a key that raises all strengths of a case."""
    return "larger damage.strength" if case.damage.law == COHESIVE else "smaller damage.ell"

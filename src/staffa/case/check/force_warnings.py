"""Warnings about the forces of a case and its energy split: a sentence each."""

from collections.abc import Iterator
from math import sqrt

import numpy as np

from staffa.case.check.water_pressure import presses_slightly
from staffa.case.rules.initial_stress import equivalent, higher_strength
from staffa.case.scales.case_scales import Numbers, least_factor
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount, key
from staffa.case.schema.toml_text import inline
from staffa.case.values.applied_forces import forces, pore_pressure_at_rest
from staffa.case.values.default_split import is_anisotropic, safest_split
from staffa.case.values.pressing_loads import only_pulled, pressing
from staffa.case.values.property_functions import in_space
from staffa.physics.damage import COHESIVE, strength

FREE = 0.01  # parts of the strength: a stress across a face that is less counts as none
SAMPLES = 25  # times at which what acts is looked at


def force_warnings(case: Case, derived: Numbers) -> Iterator[str]:
    """Yield all warnings about forces."""
    yield from _of_split(case, derived)
    yield from _of_shut_cracks(case)
    if case.forces is None:
        return
    yield from _of_signs(case, derived)
    yield from _of_shear(case, derived)
    yield from _of_free_faces(case, derived.sigma_c)
    if case.temperature.cools_a_face:
        yield from _of_fluid(case)


def _of_signs(case: Case, derived: Numbers) -> Iterator[str]:
    """Warn of stresses and pressures whose sign may be that of another convention."""
    keys, least = case.forces, FREE * derived.sigma_c
    assert keys is not None
    body = case.outline.places.within().x
    for name in ("xx", "yy", "zz"):
        value = getattr(keys.prestress, name, None)
        most = 0.0 if value is None else float(in_space(value, case.dim)(body).max())
        if most > least:
            yield (
                f"forces.prestress.{name} reaches {amount(case, most, 'Pa')} of tension: stresses "
                f"count positive in tension; is that meant? Rock that is squeezed so has "
                f"{key(case, -most, 'Pa')}"
            )
    for where, lowest in _lowest_pressures(case, derived):
        if lowest < -least:
            yield (
                f"{where} reaches {amount(case, lowest, 'Pa')}, which pulls: a pressure counts "
                f"positive where it presses; is that meant? One that presses so has "
                f"{key(case, -lowest, 'Pa')}"
            )
    if keys.gravity is not None and keys.gravity[-1] > 0:
        up = "xyz"[case.dim - 1]
        yield (
            f"forces.gravity = {inline(keys.gravity)} points up, along {up}: is that meant? Weight "
            f"has a negative {up} component"
        )


def _lowest_pressures(case: Case, derived: Numbers) -> Iterator[tuple[str, float]]:
    """Yield the lowest value of each pressure of [forces] over the run (Pa), by its key."""
    acting, times = forces(case), np.linspace(0.0, derived.times[-1], SAMPLES)
    for side in acting.sides:
        if side.pressure is not None:
            on_face = case.outline.places.on(side.side)
            lowest = min(float(side.pressure(on_face, t).min()) for t in times)
            yield f"forces.{side.side}.pressure", lowest
    if acting.pore_pressure is not None:
        body = case.outline.places.within().x
        yield "forces.pore_pressure", min(acting.pore_pressure(body, t).min() for t in times)
    if acting.crack_field is not None:
        body = case.outline.places.within().x
        yield "forces.crack_pressure", min(acting.crack_field(body, t).min() for t in times)
    if acting.crack_pressure is not None:
        yield "forces.crack_pressure", min(acting.crack_pressure(t) for t in times)


def _of_split(case: Case, derived: Numbers) -> Iterator[str]:
    """Warn of a split under which pressed rock breaks, where something may press it."""
    reasons = ", ".join(pressing(case))
    if not reasons:
        return
    safest = safest_split(case)
    slight = only_pulled(case) or (case.reservoir is not None and presses_slightly(case, derived))
    if case.damage.split == "none" and not slight:
        yield (
            f'damage.split = "none": rock under pressure ({reasons}) breaks as easily as under '
            f"tension, and its cracks close without resistance; leave damage.split out"
        )
    if case.damage.split == "volumetric-deviatoric":
        kind = "anisotropic" if is_anisotropic(case) else "with nu < 0"
        none = f", and rock that is {kind} takes no split that prevents it"
        stronger = "no-tension" if safest == "no-tension" else "star-convex"
        m, ell = derived.rock, float(case.damage.ell)
        pulled = strength(derived.law, E=m.E, Gc=m.Gc, ell=ell)  # without a split
        shear = pulled * sqrt(1.5 / (1 + m.nu))  # of a bar pressed
        finer = "" if case.damage.law == COHESIVE else ", or a smaller damage.ell"
        yield (
            f'damage.split = "volumetric-deviatoric": under pressure rock breaks by shear'
            f"{none if stronger != safest else ''}: a pressed bar at "
            f"{amount(case, shear, 'Pa')} where a pulled one does at "
            f'{amount(case, derived.sigma_c, "Pa")}; take "{stronger}"{finer}'
        )


def _of_shut_cracks(case: Case) -> Iterator[str]:
    """Warn of a strength under pressure, which a crack that is pressed shut has not."""
    may_shut = (pressing(case) or case.cracks) and not only_pulled(case)
    if case.damage.compressive is None or not may_shut:
        return
    left = (
        "carries nothing in plane stress, and its faces overlap"
        if case.plane_stress
        else "keeps its bulk modulus alone, and its faces slide"
    )
    instead = f', with damage.split = "{case.damage.split}"' if case.damage.biaxial is None else ""
    yield (
        f"damage.compressive = {inline(case.damage.compressive)} is that of rock without cracks: a "
        f"crack that is pressed shut {left}, so that a body with such cracks breaks far below it; "
        f"where cracks may be pressed shut leave damage.compressive out{instead}: they then carry "
        f"all that rock without tension would, and pressure breaks no rock"
    )


def _of_shear(case: Case, derived: Numbers) -> Iterator[str]:
    """Warn of a prestress whose shear gives more tension than the rock bears."""
    acting = forces(case)
    if acting.prestress is None or is_anisotropic(case):
        return
    x = case.outline.places.within().x
    start = acting.prestress(x)
    if not np.any(start[3:]):
        return
    pores = acting.biot * pore_pressure_at_rest(case)(x)
    principal = _principal(case, start) + pores
    m, ell = derived.rock, float(case.damage.ell)
    bar = strength(derived.law, E=m.E, Gc=m.Gc * least_factor(case), ell=ell)
    share = equivalent(case, principal) / bar
    worst = int(share.argmax())
    tension = float(principal[:, worst].max())
    if share[worst] > 1 and tension > 0:
        pulls, bears = (amount(case, s, "Pa") for s in (tension, tension / float(share[worst])))
        yield (
            f"forces.prestress: its shear makes it a tension of {pulls} along a slanting "
            f"direction, and the rock breaks at {bears}: unless free sides relieve it, it cracks "
            f"the rock before cooling begins, and the run is refused; take a smaller shear, more "
            f"pressure, or a {higher_strength(case)} (a higher strength)"
        )


def _principal(case: Case, stress: np.ndarray) -> np.ndarray:
    """Return the principal values (Pa), shape (3, n), of stresses xx, yy, zz, yz, xz, xy.

    The stresses have shape (6, n). The last value of a 2-D body is the one across the plane.
    """
    xx, yy, zz, yz, xz, xy = stress
    if case.dim == 3:
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        return np.asarray(np.linalg.eigvalsh(tensor.transpose(2, 0, 1)).T)
    tensor = np.array([[xx, xy], [xy, yy]])
    return np.vstack([np.linalg.eigvalsh(tensor.transpose(2, 0, 1)).T, zz])


def _of_free_faces(case: Case, sigma_c: float) -> Iterator[str]:
    """Warn of a prestress that presses on a face, or pulls at it, where nothing balances it."""
    assert case.forces is not None
    if case.forces.prestress is None:
        return
    held = set() if case.supports.section == "none" else {"left", "right"}
    for name, plane in case.outline.faces.items():
        loaded = name in held or case.forces.on(name) is not None
        if plane is None or loaded or case.supports.on(name) not in (None, "free"):
            continue
        across = 2 * "xyz"[plane.axis]
        value = getattr(case.forces.prestress, across)
        if value is None:
            continue
        there = in_space(value, case.dim)(case.outline.places.on(name))
        if np.abs(there).max() > FREE * sigma_c:
            pressure = key(case, -float(there.mean()), "Pa")
            about = "" if np.ptp(there) <= FREE * sigma_c else ", on the mean"
            yield (
                f"forces.prestress.{across}: {name} is free, so that this stress relaxes there "
                f"before cooling begins; hold it, or give what acts on it: forces.{name} = "
                f"{{ pressure = {pressure} }}{about}"
            )


def _of_fluid(case: Case) -> Iterator[str]:
    assert case.forces is not None
    for name in ("crack_pressure", "crack_volume"):
        if getattr(case.forces, name) is not None and not case.toughness.bands:
            yield (
                f"forces.{name}: the fluid is in all damage, so also in the layer that cooling "
                f"damages along the face before cracks part; to keep it to given cracks, raise the "
                f"face's toughness with toughness.bands"
            )

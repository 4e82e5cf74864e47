"""Rules on bodies of revolution: the section, its axis, and the rock that fits around it."""

import numpy as np

from staffa.case.schema.case import Case, Prescribed, Segment
from staffa.case.schema.material_keys import is_isotropic
from staffa.case.schema.shape_keys import Layers
from staffa.case.schema.support_keys import DisplacementHistory
from staffa.case.schema.toml_text import inline
from staffa.case.values.stiffness import elasticity, structural_tensor, tensor
from staffa.case.values.subdomains import Subdomain, conductivity, has_directions, subdomains_of
from staffa.errors import InputError
from staffa.geometry.outline import on_axis
from staffa.loads.closed_form import PROFILES
from staffa.physics.elasticity import turned
from staffa.units import Quantity

AXIS = 'domain.symmetry = "axis"'
SECTION = "the section of the body from its axis outward, x = r and y = z"
# An angle (radians) around the axis under which symmetric rock stays the same; no special one.
TURN = 0.7
# Part of a tensor by which rounding may change it in such a turn.
ROUND_OFF = 1e-9


def section_is_possible(case: Case) -> None:
    """Require that a body of revolution is given by a section in 2-D on one side of its axis."""
    keys = case.domain
    if keys.symmetry is None:
        if keys.hole is not None:
            raise InputError(
                f"domain.hole = {inline(keys.hole)} is a hole along an axis; it goes with {AXIS}"
            )
        return
    if case.dim == 3:
        raise InputError(f"{AXIS}: the body is 3-D; give {SECTION}, or leave symmetry out")
    if keys.shape is not None and not isinstance(keys.shape, Layers):
        raise InputError(
            f'{AXIS}: the shape "{keys.shape.kind}" would be a ring; give {SECTION} by size, by '
            f"layers or by a mesh (a disc has size = [radius, thickness])"
        )
    if keys.hole is not None and keys.size is None:
        raise InputError(
            f"domain.hole = {inline(keys.hole)} is for domain.size; a mesh or a shape begins where "
            f"it begins"
        )
    least = case.outline.lower[0]
    if not on_axis(np.array([-least]), case.outline.size)[0]:
        raise InputError(
            f"{AXIS}: the body reaches to x = {least:.4g}, and x is the distance from the axis; "
            f"give one half of the section, x >= 0"
        )
    _is_no_plane(case)


def _is_no_plane(case: Case) -> None:
    if case.material.plane is not None:
        raise InputError(
            f'material.plane = "{case.material.plane}" is for flat bodies, and {AXIS} makes this '
            f"one a body of revolution; leave one of them out"
        )
    if case.supports.section != "none":
        raise InputError(
            f'supports.section = "{case.supports.section}" is for flat bodies, and with {AXIS} '
            f"nothing moves across the axis; leave it out"
        )


def axis_is_no_face(case: Case) -> None:
    """Refuse keys of the axis, along which no displacement is free and no load acts."""
    for face in case.domain.axis_faces:
        given = [
            f"{name}.{face}"
            for name in ("supports", "heat", "forces")
            if (table := getattr(case, name)) is not None
            and face in table.model_fields_set
            and table.on(face) is not None
        ]
        if case.temperature.face == face and case.temperature.has_face:
            given.append("temperature.face")
        if given:
            raise InputError(
                f"{given[0]}: '{face}' is the axis of the body ({AXIS}), which is constrained by "
                f"itself and has no area; leave it out"
            )


def loads_fit_the_axis(case: Case) -> None:
    """Require that cooling in closed form and gravity are along the axis, and stress symmetric to
    it."""
    if not case.axial:
        return
    keys = case.temperature
    flat = keys.profile in PROFILES
    if flat and keys.face in case.outline.faces and case.outline.axis(keys.face) == 0:
        raise InputError(
            f"temperature.profile = \"{keys.profile}\" is of a flat face, and '{keys.face}' runs "
            f'around the axis; take temperature.profile = "heat", which cools any face'
        )
    _moves_nothing_at_the_axis(case)
    for number, crack in enumerate(case.cracks, start=1):
        if isinstance(crack, Segment) and _at_axis(case, crack.start[0], crack.end[0]):
            raise InputError(
                f"cracks, entry {number}: it lies on the axis, around which it has no area; move "
                f"an end away from it"
            )
    if case.forces is None:
        return
    gravity = case.forces.gravity
    if gravity is not None and float(gravity[0]) != 0:
        raise InputError(
            f"forces.gravity = {inline(gravity)}: it acts across the axis, so that the body would "
            f"not stay one of revolution; give its x component as 0, or take a 3-D body"
        )
    _prestress_fits(case)


def _at_axis(case: Case, *r: float) -> bool:
    return bool(on_axis(np.array(r, dtype=float), case.outline.size).all())


def _moves_nothing_at_the_axis(case: Case) -> None:
    for side in case.outline.faces:
        support = case.supports.on(side)
        if not isinstance(support, Prescribed) or support.x is None:
            continue
        moved = any(support.x.u) if isinstance(support.x, DisplacementHistory) else bool(support.x)
        if moved and _at_axis(case, float(case.outline.places.on(side)[0].min())):
            raise InputError(
                f"supports.{side}.x = {inline(support.x)}: the face meets the axis, where nothing "
                f"moves along x; leave x out"
            )


def _prestress_fits(case: Case) -> None:
    """Require that a uniform stress is the same along r and around the axis, without shear."""
    given = case.forces.prestress if case.forces else None
    if given is None:
        return
    even = (Quantity, int, float, type(None))
    if isinstance(given.xx, even) and isinstance(given.zz, even):
        radial, around = float(given.xx or 0.0), float(given.zz or 0.0)
        if abs(radial - around) > ROUND_OFF * max(abs(radial), abs(around)):
            raise InputError(
                f"forces.prestress: xx = {inline(given.xx or 0.0)} acts along r and zz = "
                f"{inline(given.zz or 0.0)} around the axis, and an even stress has both alike; "
                f"give zz = {inline(given.xx or 0.0)}, or a formula for each"
            )
    if isinstance(given.xy, Quantity | int | float) and float(given.xy) != 0:
        raise InputError(
            f"forces.prestress.xy = {inline(given.xy)}: around the axis there is no even shear of "
            f"r and z; leave it out, or give a formula that is 0 at x = 0"
        )


def rock_fits_the_axis(case: Case) -> None:
    """Require rock with directions to be the same all around the axis."""
    if not case.axial:
        return
    for subdomain in subdomains_of(case):
        if has_directions(subdomain.keys):
            _is_the_same_around(subdomain)


def _is_the_same_around(subdomain: Subdomain) -> None:
    keys, turn = subdomain.keys, _around(TURN)
    wrong = []
    if not is_isotropic(keys):
        C = elasticity(keys, subdomain.average).stiffness(np.zeros((3, 1)))
        wrong += [] if _alike(turned(C, turn), C) else ["stiffness"]
    if isinstance(keys.expansion, tuple):
        expansion = tensor(keys, keys.expansion)
        wrong += [] if _alike(turn @ expansion @ turn.T, expansion) else ["expansion"]
    flat = {"Gc": structural_tensor(keys)}
    if isinstance(keys.k, tuple):
        flat["k"] = conductivity(subdomain)
    wrong += [
        name
        for name, A in flat.items()
        if A is not None and abs(A[0, 1]) > ROUND_OFF * np.abs(A).max()
    ]
    if wrong:
        raise InputError(
            f"{subdomain.where}: its {wrong[0]} is not the same all around the axis y of the body "
            f"({AXIS}); give a bedding across it, axis = [0.0, 1.0], or lists along r, z and "
            f"around the axis whose first and third numbers are alike, without an angle; of other "
            f"rock take a 3-D body"
        )


def _around(angle: float) -> np.ndarray:
    """Return axes turned about y, as rows, shape (3, 3)."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def _alike(one: np.ndarray, other: np.ndarray) -> bool:
    return bool(np.abs(one - other).max() <= ROUND_OFF * np.abs(other).max())

"""What is off about the forces of a case and its energy split: a sentence each."""

from collections.abc import Iterator

import numpy as np

from staffa.cases.model import Case
from staffa.cases.properties import point_property
from staffa.cases.split import presses, takes_principal_strains
from staffa.physics.elasticity import values

FREE = 0.01  # parts of the strength: a stress across a face that is less counts as none


def force_cautions(case: Case, sigma_c: float) -> Iterator[str]:
    """All of them; sigma_c: the strength of the rock (Pa)."""
    if case.forces is None:
        return
    yield from _of_split(case)
    yield from _of_free_faces(case, sigma_c)
    if case.temperature.profile != "none":
        yield from _of_fluid(case)


def _of_split(case: Case) -> Iterator[str]:
    if case.damage.split == "none":
        yield (
            f'damage.split = "none": rock under pressure ({presses(case)}) breaks as easily as '
            f"under tension, and its cracks close without resistance; leave damage.split out"
        )
    if case.damage.split == "volumetric-deviatoric":
        stronger = "no-tension" if takes_principal_strains(case) else "star-convex"
        yield (
            f'damage.split = "volumetric-deviatoric": under pressure rock breaks by shear at '
            f'little more than its strength in tension; take "{stronger}", or a smaller damage.ell'
        )


def _of_free_faces(case: Case, sigma_c: float) -> Iterator[str]:
    """A prestress that presses on a face, or pulls at it, where nothing holds against it."""
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
        there = values(point_property(value, case.dim), case.outline.places.on(name))
        if np.abs(there).max() > FREE * sigma_c:
            yield (
                f"forces.prestress.{across}: {name} is free, so that this stress relaxes there "
                f"before cooling begins; hold it, or give what acts on it, like forces.{name} = "
                f'{{ pressure = "10 MPa" }}'
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

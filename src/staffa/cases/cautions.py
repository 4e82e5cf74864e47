"""What is off about a case although it can run: a sentence each, with the way out."""

import os
from collections.abc import Iterator
from importlib.util import find_spec
from math import inf, sqrt
from typing import Any

import numpy as np

from staffa.cases.exchange import exchanges, strongest
from staffa.cases.force_cautions import force_cautions
from staffa.cases.model import Case
from staffa.cases.numbers import Numbers, load
from staffa.cases.pieces import Piece, averages, box_of, has_directions, pieces
from staffa.cases.properties import varies
from staffa.cases.property_keys import RandomField
from staffa.cases.rules import is_moved, unit
from staffa.cases.rules.supports import held
from staffa.cases.shape_keys import Layers, PlateWithHole, Wellbore
from staffa.cases.split import presses
from staffa.cases.writing import inline
from staffa.geometry.gmsh_model import missing
from staffa.geometry.msh import WAY_OUT
from staffa.physics.scales import diffusion_length
from staffa.units import Quantity
from staffa.unstructured import MISSING

# Nucleation with AT1 (dT/dT_c >= 3): at sqrt(kappa t) of .8 to .95 sqrt(ell ell0), with wavelength
# 10 to 11 sqrt(ell ell0); computed on a uniformly damaged layer.
NUCLEATION_DEPTH, WAVELENGTH = 0.8, 10.5
# Of places a correlation length apart, one in 700 is further below the mean of a random field.
RARE = 3.0
LOCKING = 0.49  # above it linear elements are too stiff where the volume is constrained


def cautions(case: Case, derived: Numbers, memory: float) -> list[str]:
    """All of them; memory: what the run will need (bytes)."""
    found = [*_of_mesh(case), *_of_rock(case), *_of_loads(case), *_of_memory(memory)]
    found += force_cautions(case, derived.sigma_c)
    if derived.cooled:
        found += [*_of_cooling(case, derived), *_of_heat(case)]
    return found


def cell_edge(case: Case) -> float:
    """The longest cell edge, domain.h or a little less; the mean of unstructured cells."""
    return case.outline.h


def _length(case: Case, value: float) -> str:
    return f"{value:.3g}{unit(case, 'm')}"


def first_and_last(derived: Numbers) -> tuple[float, float]:
    """The first time after zero, and the last."""
    times = [t for t in (*derived.times, *derived.requested) if t > 0] or [0.0]
    return min(times), max(times)


def peak_drop(case: Case, derived: Numbers) -> float:
    """Largest drop of the cooled face by the end of the run."""
    if case.heat is not None:
        coldest = strongest(exchanges(case), case.temperature.face)
        return coldest.reached if coldest else 0.0
    assert derived.face is not None
    on_face = np.zeros((3, 1))
    on_face[derived.face.axis] = derived.face.position
    _, last = first_and_last(derived)
    return float(-load(case, derived).temperature(on_face, last)[0])


def rare_factor(case: Case) -> float:
    """Toughness over its mean at the weak places of a lognormal field, 1 without one."""
    variance = np.log1p(case.toughness.amplitude**2)
    return float(np.exp(-RARE * np.sqrt(variance) - variance / 2)) if variance else 1.0


def uneven(case: Case) -> bool:
    """True if places of the rock may break sooner than its averages tell, beyond [toughness]: it
    varies, has directions, or strains otherwise in a region than around it."""
    body, *regions = (_strained_by(piece) for piece in pieces(case))
    kinds = any(piece_varies(piece) or has_directions(piece.keys) for piece in pieces(case))
    return kinds or any(region != body for region in regions)


def _strained_by(piece: Piece) -> tuple[float, ...]:
    rock = averages(piece)
    return rock.E, rock.nu, rock.expansion


def piece_varies(piece: Piece) -> bool:
    """Whether what a rock breaks by differs from place to place."""
    of_heat = ("k", "rho", "c")
    return any(varies(value) and name not in of_heat for name, _, value in piece.properties())


def other_causes(case: Case) -> tuple[str, ...]:
    """What may break the body besides nucleation by cooling."""
    given = ("the given cracks may grow",) if case.cracks else ()
    moved = ("the moved sides load it too",) if is_moved(case) else ()
    return (*given, *moved, *forced(case), *_causes_of_heat(case))


def forced(case: Case) -> tuple[str, ...]:
    """That [forces] act, if they do."""
    return (f"[forces] act too ({presses(case)})",) if case.forces else ()


def _causes_of_heat(case: Case) -> Iterator[str]:
    """What else the heat equation may do than cool the face."""
    if case.heat is None:
        return
    found = exchanges(case)
    coldest = strongest(found, case.temperature.face)
    if case.heat.source is not None or any(e.rise > 0 for e in found):
        yield "heated parts may pull others apart"
    if any(e.drop > 0 and e is not coldest for e in found):
        yield "other places are cooled too"
    if case.heat.stress_free is not None:
        yield "the body is strained from the start"
    if not isinstance(case.heat.initial, Quantity):
        yield "the initial temperature may even out"


def _of_mesh(case: Case) -> Iterator[str]:
    ell, h, smallest = float(case.damage.ell), cell_edge(case), min(case.outline.size)
    if case.domain.has_simplices and find_spec("gmsh") is None:
        yield MISSING if case.domain.is_block else missing("domain.shape", WAY_OUT)
    if ell / h < 1 - 1e-9:
        yield (
            f"ell/h = {ell / h:.2g}: the mesh steers the cracks and adds to the toughness "
            f"(damage.allow_coarse is set); take h <= ell/3 to be free of it"
        )
    elif ell / h < 3 * (1 - 1e-9):
        yield f"ell/h = {ell / h:.3g} < 3: a crack is not resolved; take h <= ell/3"
    if smallest < 4 * ell * (1 - 1e-9):
        yield (
            f"the smallest extent is {smallest / ell:.2g} ell: a crack's damage is as wide as the "
            f"body; take a smaller damage.ell"
        )
    length = case.toughness.correlation_length
    if case.toughness.amplitude and length is not None and length < h:
        yield (
            f"toughness.correlation_length = {inline(length)} is less than a cell: the mesh sees "
            f"noise that depends on it; take {_length(case, 2 * ell)}, which is 2 ell, or more"
        )


def _of_rock(case: Case) -> Iterator[str]:
    constrained = case.dim == 3 or case.material.plane == "strain"
    locking: set[float] = set()
    for piece in pieces(case):
        nu = averages(piece).nu
        if nu > LOCKING and constrained and nu not in locking:
            locking.add(nu)
            yield (
                f"{piece.where}.nu = {nu:g}: above {LOCKING} the elements lock, and the body is "
                f"too stiff; take {LOCKING} or less"
            )
    for where, value in _written(case):
        lengths = value.length if isinstance(value, RandomField) else ()
        shortest = min(lengths if isinstance(lengths, tuple) else (lengths,), default=np.inf)
        if shortest < cell_edge(case):
            yield (
                f"{where}.length = {inline(shortest)} is less than a cell: the mesh sees noise "
                f"that depends on it; take {_length(case, 2 * case.damage.ell)}, which is 2 ell, "
                f"or more"
            )
    yield from _of_regions(case)
    yield from _of_shape(case)


def _of_loads(case: Case) -> Iterator[str]:
    """Loads on a face that is held against them."""
    for side, table in case.forces.by_side().items() if case.forces else ():
        axis, every = case.outline.axis(side), "xyz"[: case.dim]
        moved = {"pressure": every if axis is None else every[axis], "x": "x", "y": "y", "z": "z"}
        for key in table.model_fields_set:
            if set(moved[key]) <= held(case, side).keys():
                own = case.supports.on(side) not in (None, "free")
                holds = f"supports.{side}" if own else "supports.section"
                yield (
                    f"forces.{side}.{key} moves nothing: {holds} holds the face against it; leave "
                    f"one of them out"
                )


def _written(case: Case) -> Iterator[tuple[str, Any]]:
    """The values of properties, those that a region takes from the body only once."""
    seen: set[int] = set()
    for piece in pieces(case):
        for _, where, value in piece.properties():
            if id(value) not in seen:
                yield where, value
            seen.add(id(value))


def _of_shape(case: Case) -> Iterator[str]:
    """Parts of a shape that are smaller than a cell."""
    keys, h = case.domain.shape, cell_edge(case) * (1 - 1e-9)
    if isinstance(keys, PlateWithHole | Wellbore) and keys.radius < h:
        yield (
            f"domain.shape.radius = {inline(keys.radius)} is less than a cell: the hole is not "
            f"round; take a smaller domain.h"
        )
    for number, layer in enumerate(keys.layers if isinstance(keys, Layers) else (), start=1):
        if layer.thickness < h:
            yield (
                f"domain.shape.layers, entry {number}, thickness = {inline(layer.thickness)} is "
                f"less than a cell; make it thicker, or take a smaller domain.h"
            )


def _of_regions(case: Case) -> Iterator[str]:
    for name, region in case.regions.items():
        box = box_of(case, region)
        thinnest = min(b - a for a, b in zip(*box, strict=True)) if box else inf
        if thinnest < cell_edge(case) * (1 - 1e-9):
            yield (
                f"regions.{name} is {_length(case, thinnest)} thin, less than a cell, and may hold "
                f"none; make it thicker, or take a smaller domain.h"
            )


def _of_memory(needed: float) -> Iterator[str]:
    here = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    if needed > here:
        yield (
            f"about {needed / 1e9:.2g} GB of memory are needed and this machine has "
            f"{here / 1e9:.2g} GB; run it on a larger one, or take a larger domain.h"
        )


def _of_cooling(case: Case, derived: Numbers) -> Iterator[str]:
    causes, largest = other_causes(case), peak_drop(case, derived)
    if derived.dT_c is not None and largest < derived.dT_c:
        yield _no_nucleation(case, derived.dT_c, largest, causes)
        if not causes:
            return
    else:
        if case.cracks and not case.toughness.bands and derived.dT_c is not None:
            yield (
                "more cracks will start on the cooled face between the given ones; to keep to "
                "these, raise its toughness with toughness.bands"
            )
        if derived.ell0 is not None:
            yield from _of_nucleation(case, derived, derived.ell0)
        yield from _of_plane_strain(case, derived, largest)
    _, last = first_and_last(derived)
    deep = diffusion_length(derived.kappa, last) / derived.L
    if deep > 1 / 2 and case.temperature.profile not in ("slab", "heat"):
        yield (
            f"at the last step the diffusion length is {deep:.2g} of the depth: the far side is "
            f'felt; take temperature.profile = "slab", whose far side is insulated, or end earlier'
        )


def _of_plane_strain(case: Case, derived: Numbers, drop: float) -> Iterator[str]:
    enough = derived.sigma_c / (derived.rock.E * derived.rock.expansion)
    if case.forces and case.forces.prestress and case.forces.prestress.zz is not None:
        return  # the stress across the plane is not of cold alone
    if derived.dT_c is not None and case.material.plane == "strain" and drop > enough:
        yield (
            f"in plane strain no crack of the plane relieves the stress across it, which alone "
            f"damages all rock that is colder by {enough:.3g}{unit(case, 'K')} or more; take "
            f'material.plane = "stress", a smaller damage.ell (a higher strength), or a 3-D body'
        )


def _no_nucleation(case: Case, dT_c: float, largest: float, causes: tuple[str, ...]) -> str:
    """That cooling starts no crack, and what may break the body all the same."""
    kelvin = unit(case, "K")
    what = "cooling starts no new crack" if causes else "nothing will crack"
    where = " without [forces]" if case.forces else ""
    if largest > dT_c * sqrt(rare_factor(case)):
        what = f"perhaps {what}"
        where += ", or at less where the random toughness is low"
    elif uneven(case):
        what = f"perhaps {what}"
        where += ", or at less where the rock differs from its averages"
    elif case.forces:
        what = f"perhaps {what}"
    return (
        f"{what}: the face drops by {largest:.3g}{kelvin} at most, and damage starts at "
        f"{dT_c:.3g}{kelvin}{where}; "
        f"{''.join(f'{cause}; ' for cause in causes)}to start cracks by cooling, raise the drop, "
        f"or take a larger damage.ell (a lower strength)"
    )


def _of_nucleation(case: Case, derived: Numbers, ell0: float) -> Iterator[str]:
    time, _ = first_and_last(derived)
    first, h = diffusion_length(derived.kappa, time), cell_edge(case)
    mixed = sqrt(case.damage.ell * ell0)
    at_once = case.heat is None or _cools_at_once(case)  # else how deep the cold is says little
    if mixed < h:
        yield (
            f"sqrt(ell ell0) = {_length(case, mixed)} is below h = {_length(case, h)}: nucleation "
            f"is not resolved, so that the first cracks' number and time depend on the mesh; later "
            f"depths and spacings do not"
        )
    elif at_once and first > NUCLEATION_DEPTH * mixed:
        yield (
            f"the first step is too coarse to see nucleation: its diffusion length "
            f"{_length(case, first)} is past {NUCLEATION_DEPTH:g} sqrt(ell ell0) = "
            f"{_length(case, NUCLEATION_DEPTH * mixed)}; start earlier"
        )
    if at_once and first < h / 2:
        yield (
            f"at the first step the diffusion length {_length(case, first)} is under half a "
            f"cell: the mesh does not see that temperature; start later or take a smaller domain.h"
        )


def _cools_at_once(case: Case) -> bool:
    coldest = strongest(exchanges(case), case.temperature.face)
    return coldest is not None and coldest.at_once


def _of_heat(case: Case) -> Iterator[str]:
    if case.heat is not None and case.heat.cracks is not None and case.heat.cracks.h is not None:
        yield (
            "heat.cracks: the fluid is in every crack, also in one that it cannot reach; take "
            "what comes out as the strongest cooling, or leave out heat.cracks to see the least"
        )

"""Subdomains of a body, each of one rock: the body and its regions; no finite elements."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from staffa.case.schema.case import Case
from staffa.case.schema.field_types import ONE
from staffa.case.schema.material_keys import (
    MaterialKeys,
    RegionKeys,
    RockKeys,
    is_isotropic,
    rock_of,
)
from staffa.case.schema.temperature_keys import depends_on_place, of_temperature, with_reference
from staffa.case.values.property_functions import in_space, mean_value, varies
from staffa.case.values.stiffness import elasticity, tensor
from staffa.geometry.places import Bounds, BoxGrid, Sample
from staffa.physics.elasticity import isotropic_average


@dataclass(frozen=True, kw_only=True)
class Averages:
    """Averages of a rock's properties, from which scales follow; in SI or scaled as the case is.

    A property that varies in space counts by its mean. A property with directions counts by its
    average over all directions, but the toughness by its least value. A property of temperature
    counts by its value at `reference_temperature`.

    Attributes
    ----------
    E : Young's modulus (Pa).
    nu : Poisson's ratio.
    Gc : toughness (J/m^2).
    expansion : coefficient of linear thermal expansion (1/K).
    """

    E: float
    nu: float
    Gc: float
    expansion: float


@dataclass(frozen=True, kw_only=True)
class Subdomain:
    """The body or a region of it.

    Attributes
    ----------
    where : name of its table, "material" or "regions.clay".
    keys : its rock: the region's keys over the body's, properties of temperature with their
        reference.
    dim : dimension of the body.
    places : returns the places at which its values are sampled before there is a mesh.
    """

    where: str
    keys: MaterialKeys
    dim: int
    places: Callable[[], Sample]

    @property
    def name(self) -> str:
        """Return the name for messages: "material", or "region 'clay'"."""
        _, _, region = self.where.partition(".")
        return f"region '{region}'" if region else self.where

    def average(self, value: Any) -> float:
        """Return the mean of one of its properties."""
        return mean_value(value, self.dim, self.places)

    def properties(self) -> Iterator[tuple[str, str, Any]]:
        """Yield each value of the rock that may vary: name of its key, its place in the file,
        itself."""
        for name in RockKeys.model_fields:
            value = getattr(self.keys, name)
            if name in ("stiffness", "axis", "angle", "axes") or value is None:
                continue
            several = value if isinstance(value, tuple) else (value,)
            for number, one in enumerate(several, start=1):
                entry = f", entry {number}" if isinstance(value, tuple) else ""
                yield name, f"{self.where}.{name}{entry}", one
                factor = getattr(one, "factor", None)  # by place, of a table of temperature
                if factor is not None:
                    yield f"{name}.factor", f"{self.where}.{name}{entry}.factor", factor


def subdomains_of(case: Case) -> tuple[Subdomain, ...]:
    """Return the body first, then its regions."""
    places = case.outline.places
    T = reference_temperature(case)

    def known(keys: MaterialKeys) -> MaterialKeys:
        return with_reference(keys, RockKeys.model_fields, T)

    body = known(case.material)
    found = [Subdomain(where="material", keys=body, dim=case.dim, places=places.within)]
    for name, region in case.regions.items():
        box = box_of(case, region)
        where = partial(places.within, name)
        if box is not None:
            where = partial(BoxGrid(boxes=((name, box),), flat={}).within, name)
        keys = known(rock_of(case.material, region))
        found.append(Subdomain(where=f"regions.{name}", keys=keys, dim=case.dim, places=where))
    return tuple(found)


def reference_temperature(case: Case) -> float:
    """Return the mean temperature (K) at the start, at which scales are computed.

    0 where no temperature is known, or none is needed.
    """
    tables = (case.material, *case.regions.values())
    names = RockKeys.model_fields
    if case.heat is None or not any(of_temperature(getattr(t, n)) for t in tables for n in names):
        return 0.0
    there = case.outline.places.within()
    return there.mean(in_space(case.heat.initial, case.dim)(there.x))


def box_of(case: Case, region: RegionKeys) -> Bounds | None:
    """Corners of the part of the body in the box of a region (m), None of one without a box."""
    if region.lower is None or region.upper is None:
        return None
    body = case.outline
    lower = tuple(max(a, float(b)) for a, b in zip(body.lower, region.lower, strict=True))
    upper = tuple(min(a, float(b)) for a, b in zip(body.upper, region.upper, strict=True))
    return lower, upper


def averages(subdomain: Subdomain) -> Averages:
    """Return the numbers that stand for its rock."""
    keys = subdomain.keys
    if is_isotropic(keys):
        E, nu = subdomain.average(keys.E), subdomain.average(keys.nu)
    else:
        stiffness = elasticity(keys, subdomain.average).stiffness(np.zeros((3, 1)))
        E, nu = isotropic_average(stiffness[0])
    Gc = min(keys.Gc) if isinstance(keys.Gc, tuple) else subdomain.average(keys.Gc)
    expansion = keys.expansion
    if isinstance(expansion, tuple):
        mean = float(np.trace(tensor(keys, expansion))) / 3
    else:
        mean = subdomain.average(expansion)
    return Averages(E=E, nu=nu, Gc=float(Gc), expansion=mean)


def conductivity(subdomain: Subdomain) -> np.ndarray:
    """Return the conductivity averaged over places: a tensor, shape (dim, dim)."""
    k = subdomain.keys.k or ONE
    if isinstance(k, tuple):
        return tensor(subdomain.keys, k)[: subdomain.dim, : subdomain.dim]
    return subdomain.average(k) * np.eye(subdomain.dim)


def has_directions(keys: MaterialKeys) -> bool:
    """Return whether any property of the rock depends on direction."""
    lists = any(isinstance(getattr(keys, name), tuple) for name in ("Gc", "expansion", "k"))
    return lists or not is_isotropic(keys)


def is_uneven(case: Case) -> bool:
    """Return whether rock may break sooner than its averages tell, [toughness] left aside.

    The rock varies, has directions, or strains otherwise in a region than around it.
    """
    body, *regions = (_strained_by(subdomain) for subdomain in subdomains_of(case))
    kinds = any(
        subdomain_varies(subdomain) or has_directions(subdomain.keys)
        for subdomain in subdomains_of(case)
    )
    others = any(region != body for region in regions)
    return kinds or others or bool(temperature_changes(case))


def _strained_by(subdomain: Subdomain) -> tuple[float, ...]:
    rock = averages(subdomain)
    return rock.E, rock.nu, rock.expansion


def subdomain_varies(subdomain: Subdomain) -> bool:
    """Return True if a property by which rock breaks differs from place to place."""
    of_heat = ("k", "rho", "c")
    return any(
        varies(value) and depends_on_place(value) and name.partition(".")[0] not in of_heat
        for name, _, value in subdomain.properties()
    )


def temperature_changes(case: Case) -> tuple[str, ...]:
    """Return the names of the properties that temperature changes in some rock."""
    found = {
        name: None
        for subdomain in subdomains_of(case)
        for name, _, value in subdomain.properties()
        if of_temperature(value)
    }
    return tuple(found)

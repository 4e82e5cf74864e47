"""Case -> what the heat equation needs to know of the body."""

from typing import Any

import numpy as np

from staffa.case.schema.boxes import product
from staffa.case.schema.case import Case
from staffa.case.schema.field_types import ONE, Formula
from staffa.case.schema.heat_keys import FilmFormula, FilmInTemperature, HeatBand, HeatKeys, InTime
from staffa.case.schema.property_keys import FieldFile
from staffa.case.schema.temperature_keys import OF_T, law_of
from staffa.case.values.given_files import in_body
from staffa.case.values.property_functions import in_space, point_property, product_of
from staffa.case.values.subdomains import Subdomain, conductivity, subdomains_of
from staffa.heat.thermal_body import (
    Conduction,
    Conductor,
    Dirichlet,
    FluidFilledCrack,
    Insulating,
    Neumann,
    OfSurface,
    PointValues,
    Robin,
    Values,
    everywhere_one,
    nothing,
)
from staffa.physics.elasticity import Property
from staffa.physics.temperature import ARRAYS
from staffa.properties.formula import formula, formula_variables, generic, known


def conduction(case: Case) -> Conduction:
    """Return the heat equation of a case with profile "heat"."""
    keys, dim = case.heat, case.dim
    assert keys is not None
    body, *regions = (
        _conductor(subdomain, keys.bands, case.outline.h) for subdomain in subdomains_of(case)
    )
    return Conduction(
        **vars(body),
        regions=dict(zip(case.regions, regions, strict=True)),
        initial=start(case, keys.initial),
        stress_free=None if keys.stress_free is None else start(case, keys.stress_free),
        sides=_sides(case),
        source=nothing if keys.source is None else in_time(keys.source, dim),
        cracks=_cracks(keys, dim),
        kinks=_kinks(case),
        tolerance=keys.tolerance,
        agreement=keys.agreement,
    )


def start(case: Case, value: Any) -> PointValues:
    """Return the temperature of a body before its first step, or free of stress."""
    return in_body(case, value) if isinstance(value, FieldFile) else in_space(value, case.dim)


def _kinks(case: Case) -> tuple[float, ...]:
    """Return the times of all tables."""
    keys = case.heat
    assert keys is not None
    surfaces = [*(keys.on(side) for side in case.outline.faces), keys.cracks]
    given = [getattr(surface, name, None) for surface in surfaces for name in ("h", "T", "flux")]
    tables = [value for value in (keys.source, *given) if isinstance(value, InTime)]
    return tuple(sorted({float(t) for table in tables for t in table.t}))


def _conductor(subdomain: Subdomain, bands: tuple[HeatBand, ...], h: float) -> Conductor:
    """Return conductivity and heat capacity of the rock of a subdomain."""
    keys, dim = subdomain.keys, subdomain.dim
    k, rho, c = keys.k or ONE, keys.rho or ONE, keys.c or ONE
    rho_c = subdomain.average(rho) * subdomain.average(c)
    own_k = 1.0 if isinstance(k, tuple) else _over(point_property(k, dim), subdomain.average(k))
    own_rho_c = product_of(point_property(rho, dim), point_property(c, dim))
    return Conductor(
        k=tuple(tuple(row) for row in conductivity(subdomain).tolist()),
        rho_c=rho_c,
        k_factor=_times(own_k, _factor(bands, "k", h)),
        rho_c_factor=_times(_over(own_rho_c, rho_c), _factor(bands, "capacity", h)),
        k_law=law_of(k, dim),
        c_law=law_of(c, dim),
    )


def _over(value: Property, mean: float) -> Property:
    return product_of(value, 1 / mean) if callable(value) else 1.0


def _times(value: Property, factor: PointValues) -> PointValues:
    if not callable(value):
        return factor
    return lambda x: value(x) * factor(x)


def _factor(bands: tuple[HeatBand, ...], name: str, h: float) -> PointValues:
    if not bands:
        return everywhere_one
    return lambda x: product(x, ((band, getattr(band, name)) for band in bands), h=h)


def _sides(case: Case) -> tuple[Dirichlet | Neumann | Robin, ...]:
    keys, dim = case.heat, case.dim
    assert keys is not None
    found: list[Dirichlet | Neumann | Robin] = []
    for side in case.outline.faces:
        given = keys.on(side)
        if given is None:
            continue
        if given.flux is not None:
            found.append(Neumann(side=side, q=in_time(given.flux, dim)))
        elif given.h is not None:
            h, T = film(given.h, dim), temperature(case, given.T)
            found.append(Robin(side=side, h=h, T=T))
        else:
            found.append(Dirichlet(side=side, T=temperature(case, given.T)))
    return tuple(found)


def temperature(case: Case, value: Any) -> Values:
    """Return the temperature of a side, or beyond its film."""
    if isinstance(value, FieldFile):
        field = in_body(case, value)
        return lambda x, time: field(x)
    return in_time(value, case.dim)


def _cracks(keys: HeatKeys, dim: int) -> Insulating | FluidFilledCrack | None:
    given = keys.cracks
    if given is None:
        return None
    if given.conductivity is not None:
        return Insulating(residual=given.conductivity)
    assert given.h is not None and given.T is not None
    return FluidFilledCrack(h=film(given.h, dim), T=in_time(given.T, dim))


def film(value: Any, dim: int) -> Values | OfSurface:
    """Return a film coefficient of points and time, and its dependence on the surface's
    temperature."""
    if isinstance(value, FilmInTemperature):
        return OfSurface(at=lambda x, time, T: value.values_at(T))
    if isinstance(value, FilmFormula) and value.of_temperature:
        evaluated = generic(value.formula, (*formula_variables(dim), OF_T))
        return OfSurface(
            at=lambda x, time, T: evaluated({**known(x, time), OF_T: T}, ARRAYS.functions)
        )
    return in_time(value, dim)


def in_time(value: float | InTime | Formula, dim: int) -> Values:
    """Return a value of the table [heat] as a function of points and time."""
    if isinstance(value, Formula):
        return formula(value.formula, formula_variables(dim))
    if isinstance(value, InTime):
        t, values = np.array(value.t, dtype=float), np.array(value.value, dtype=float)
        return lambda x, time: float(np.interp(time, t, values))
    constant = float(value)
    return lambda x, time: constant

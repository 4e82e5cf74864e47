"""Rules on properties that depend on temperature."""

from collections.abc import Iterator
from itertools import pairwise
from typing import Any

import numpy as np

from staffa.case.rules.temperature_range import temperature_range
from staffa.case.schema.case import Case
from staffa.case.schema.heat_keys import FilmFormula, FilmInTemperature
from staffa.case.schema.material_keys import RATIOS, is_isotropic
from staffa.case.schema.quantity_text import is_scaled
from staffa.case.schema.temperature_keys import InTemperature, PropertyFormula, of_temperature
from staffa.case.schema.toml_text import as_toml, inline
from staffa.case.values.heat_equation import film as film_of
from staffa.case.values.subdomains import Subdomain, subdomains_of
from staffa.errors import InputError
from staffa.heat.thermal_body import OfSurface

# Properties that temperature may change.
CHANGING = ("E", "nu", "Gc", "expansion", "k", "c")
TRIED = 41  # temperatures at which a formula is tried


def temperature_is_known(case: Case) -> None:
    """Require the heat equation, which gives a temperature, for properties of temperature."""
    if case.temperature.profile == "heat":
        return
    tables = [("material", case.material), *((f"regions.{n}", r) for n, r in case.regions.items())]
    for where, table in tables:
        for name in type(table).model_fields:
            if of_temperature(value := getattr(table, name)):
                raise InputError(
                    f"{where}.{name} = {as_toml(value)} depends on temperature, and "
                    f"temperature.profile = {inline(case.temperature.profile)} knows changes "
                    f'alone; take temperature.profile = "heat" with [heat], or give one value'
                )


def laws_fit_the_rock(case: Case) -> None:
    """Require properties that temperature can change, in rock without directions."""
    for subdomain in subdomains_of(case):
        for name, where, value in _of_temperature(subdomain):
            said = f"{where} = {as_toml(value)}"
            if name not in CHANGING or where.endswith(tuple("0123456789")):
                hint = "put what changes into c" if name == "rho" else "give one value"
                raise InputError(
                    f"{said}: temperature may change {', '.join(CHANGING)} alone, each one for all "
                    f"directions; {hint}"
                )
            if name in ("E", "nu") and not all(is_isotropic(p.keys) for p in subdomains_of(case)):
                raise InputError(
                    f"{said} depends on temperature, and some rock of the body has directions, "
                    f"whose stiffness does not; give one value"
                )
            if name == "Gc":
                _can_be_booked(case, said)


def _can_be_booked(case: Case, said: str) -> None:
    """Refuse cases in which spent surface energy would not count at the toughness of its time."""
    if case.solver.backtracking:
        raise InputError(
            f"{said} depends on temperature, and solver.backtracking tries cracks at times at "
            f"which they would have cost another energy; leave one of them out"
        )
    if case.damage.irreversibility != "damage":
        raise InputError(
            f'{said} depends on temperature, and with damage.irreversibility = "crack set" damage '
            f"heals, which cannot give back what it cost at another temperature; take "
            f'irreversibility = "damage", or one value'
        )


def tables_of_temperature_agree(case: Case) -> None:
    """Require as many values as temperatures, which increase, and possible Poisson's ratios."""
    found = [(where, value) for p in subdomains_of(case) for _, where, value in _of_temperature(p)]
    for where, table in (*found, *films(case)):
        if isinstance(table, InTemperature):
            _agrees(where, table)
            if where.split(".")[-1] in RATIOS and not all(-1 < nu < 0.5 for nu in table.value):
                raise InputError(
                    f"{where} = {as_toml(table)}: Poisson's ratio must lie between -1 and 0.5 at "
                    f"every temperature"
                )


def _agrees(where: str, table: InTemperature) -> None:
    if not table.T or len(table.T) != len(table.value):
        raise InputError(
            f"{where}: T has {len(table.T)} numbers and value has {len(table.value)}; give as many "
            f"of each, and at least one"
        )
    for before, after in pairwise(table.T):
        if after <= before:
            raise InputError(
                f"{where}.T: {inline(after)} comes after {inline(before)}; put the temperatures in "
                f"increasing order, no two of them equal"
            )


def formulas_of_temperature_give_numbers(case: Case) -> None:
    """Require possible values of formulas of T, at the temperatures that the case names."""
    for subdomain in subdomains_of(case):
        for name, where, value in _of_temperature(subdomain):
            if isinstance(value, PropertyFormula):
                _is_possible(case, subdomain, name, where, value)
    for where, film in films(case):
        if isinstance(film, FilmFormula):
            _film_is_possible(case, where, film)


def _is_possible(
    case: Case, subdomain: Subdomain, name: str, where: str, value: PropertyFormula
) -> None:
    x, said = subdomain.places().x, f"{where}.formula = {as_toml(value.formula)}"
    for T in np.linspace(*temperature_range(case), TRIED):
        found = _tried(said, lambda T=T: value.values_at(np.full(x.shape[1], T), x))
        least, most = (-1.0, 0.5) if name in RATIOS else (0.0, np.inf)
        if not np.all((found > least) & (found < most)):
            rule = "between -1 and 0.5" if name in RATIOS else "finite and larger than zero"
            raise InputError(
                f"{said}: it is {float(found.min()):.4g} at {_kelvin(case, T)} and must be {rule} "
                f"at all temperatures of the case; fix it, or give a table"
            )


def _film_is_possible(case: Case, where: str, film: FilmFormula) -> None:
    said, x = f"{where}.formula = {as_toml(film.formula)}", case.outline.places.within().x
    try:
        law = film_of(film, case.dim)
    except InputError as error:
        raise InputError(f"{said}: {error}") from None
    if not isinstance(law, OfSurface):
        return
    for T in np.linspace(*temperature_range(case), TRIED):
        found = np.asarray(_tried(said, lambda T=T: law.at(x, 0.0, np.full(x.shape[1], T))))
        if not np.all(np.isfinite(found) & (found >= 0)):
            raise InputError(
                f"{said}: it is {float(np.min(found)):.4g} at {_kelvin(case, T)}; a film "
                f"coefficient must be finite and not negative; fix it, or give a table"
            )


def _tried(said: str, value: Any) -> np.ndarray:
    """Return the values of a formula, if they can be computed."""
    try:
        with np.errstate(all="ignore"):
            return np.asarray(value(), dtype=float)
    except InputError as error:
        raise InputError(f"{said}: {error}") from None
    except Exception:  # a function of the formula is given what it does not take
        raise InputError(
            f"{said}: it cannot be computed; check what its functions are given"
        ) from None


def _kelvin(case: Case, T: float) -> str:
    return f"T = {T:.4g}{'' if is_scaled(case) else ' K'}"


def _of_temperature(subdomain: Subdomain) -> Iterator[tuple[str, str, Any]]:
    """Yield the properties that depend on temperature, see `Subdomain.properties`."""
    return (item for item in subdomain.properties() if of_temperature(item[-1]))


def films(case: Case) -> Iterator[tuple[str, Any]]:
    """Yield the film coefficients that depend on the surface's temperature, with their keys."""
    keys = case.heat
    if keys is None:
        return
    given = {f"heat.{side}.h": getattr(keys.on(side), "h", None) for side in case.outline.faces}
    given["heat.cracks.h"] = getattr(keys.cracks, "h", None)
    for where, film in given.items():
        if isinstance(film, FilmInTemperature) or getattr(film, "of_temperature", False):
            yield where, film

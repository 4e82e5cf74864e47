"""Warnings about tables by temperature that do not span the temperatures of the case."""

from collections.abc import Iterator

from staffa.case.rules.temperature_range import temperature_range
from staffa.case.rules.temperature_rules import films
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import is_scaled
from staffa.case.schema.temperature_keys import InTemperature
from staffa.case.schema.toml_text import inline
from staffa.case.values.subdomains import subdomains_of

# Part of a temperature that is round-off.
SAME = 1e-9


def temperature_warnings(case: Case) -> Iterator[str]:
    """Yield all warnings about tables by temperature."""
    if case.heat is None:
        return
    found = dict(films(case))
    for subdomain in subdomains_of(case):
        found |= {where: value for _, where, value in subdomain.properties()}
    for where, table in found.items():
        if isinstance(table, InTemperature):
            yield from _of_ends(case, where, table)


def _of_ends(case: Case, where: str, table: InTemperature) -> Iterator[str]:
    """Warn of a table that ends, while its value changes, before the temperatures do."""
    least, most = temperature_range(case)
    ends = []
    if len(table.T) > 1 and table.value[0] != table.value[1] and least < table.T[0] * (1 - SAME):
        ends.append(f"begins at {_told(table.T[0])}, and temperatures at {_kelvin(case, least)}")
    if len(table.T) > 1 and table.value[-1] != table.value[-2] and most > table.T[-1] * (1 + SAME):
        ends.append(f"ends at {_told(table.T[-1])}, and temperatures at {_kelvin(case, most)}")
    if ends:
        yield (
            f"{where}: the table {'; it '.join(ends)}: beyond it the value stays what it is at its "
            f"end; give the value at that temperature too"
        )


def _told(T: float) -> str:
    return inline(T).strip('"')


def _kelvin(case: Case, T: float) -> str:
    """Return a temperature in the unit that people write."""
    return f"{T:.4g}" if is_scaled(case) else f"{T - 273.15:.4g} °C"

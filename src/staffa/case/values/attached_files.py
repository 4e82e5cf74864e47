"""The files that a case names: they are kept with a run, each by its own name."""

import json
import tomllib
from collections.abc import Iterable
from hashlib import sha256
from os.path import abspath
from pathlib import Path

from staffa.case.schema.case import Case
from staffa.case.schema.property_keys import FieldFile
from staffa.case.values.given_files import given_files
from staffa.case.values.subdomains import subdomains_of
from staffa.records.case_about import ABOUT

# Tables of a case that decide what is done next, and not what has been.
CHANGEABLE = ("time", "output", "solver")


def attached(case: Case) -> tuple[Path, ...]:
    """Return the mesh of a case, and the files of its fields and its reservoir, each once."""
    values = [value for subdomain in subdomains_of(case) for _, _, value in subdomain.properties()]
    fields = [value.path for value in values if isinstance(value, FieldFile)]
    fields += [value.path for _, value, _ in given_files(case)]
    fields += _of_reservoir(case)
    mesh = [] if case.domain.file is None else [Path(abspath(case.domain.file))]
    return tuple(dict.fromkeys([*mesh, *fields]))


def _of_reservoir(case: Case) -> list[Path]:
    """Return the files of the rock and of the water of a reservoir."""
    keys = case.reservoir
    if keys is None:
        return []
    rock = [v.path for v in (keys.permeability, keys.porosity) if isinstance(v, FieldFile)]
    return rock if keys.fields is None else [*rock, *keys.fields.series.paths]


def case_identity(text: str, files: Iterable[Path]) -> str:
    """Return the SHA-256 of all keys that must stay while a run goes on, and of the files.

    Parameters
    ----------
    text : the case as TOML, as it was given, so that a later default changes nothing.
    files : the files that the case names.
    """
    tables = tomllib.loads(text)
    fixed = {name: table for name, table in tables.items() if name not in (*CHANGEABLE, *ABOUT)}
    found = sha256(json.dumps(fixed, sort_keys=True).encode())
    for file in files:
        found.update(file.read_bytes())
    return found.hexdigest()

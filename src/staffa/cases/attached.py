"""The files that a case names: they are kept with a run, each by its own name."""

from os.path import abspath
from pathlib import Path

from staffa.cases.model import Case
from staffa.cases.pieces import pieces
from staffa.cases.property_keys import FieldFile


def attached(case: Case) -> tuple[Path, ...]:
    """Its mesh, and the files of its rock's fields, each once."""
    values = [value for piece in pieces(case) for _, _, value in piece.properties()]
    fields = [value.path for value in values if isinstance(value, FieldFile)]
    mesh = [] if case.domain.file is None else [Path(abspath(case.domain.file))]
    return tuple(dict.fromkeys([*mesh, *fields]))

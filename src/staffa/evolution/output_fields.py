"""Registry of the fields that can be written for ParaView; light, so that a case knows the names.

A new field is one more `OutputField` here, and a row of the table in docs/reference/files.md.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

if TYPE_CHECKING:
    from ufl.core.expr import Expr

    from staffa.evolution.session import Session


@dataclass(frozen=True, kw_only=True)
class OutputField:
    """A field that can be written.

    Attributes
    ----------
    name : name in `output.fields` and in the file.
    unit : SI unit, "1" for none; values of a scaled case are scaled.
    at : where its values are: at vertices, or in the middle of cells.
    values : function of the session that returns the values of this rank, shape (n,) of a scalar,
        (n, 3) of a vector, (n, 9) of a tensor, row by row. Collective.
    isotropic : True if only rock with E and nu has it.
    """

    name: str
    unit: str
    at: Literal["vertices", "cells"]
    values: Callable[["Session"], np.ndarray]
    isotropic: bool = False


def _young(session: "Session") -> "Expr":
    """Young's modulus in forms; a rule of cases asks for isotropic rock."""
    elasticity = session.system.energy.elasticity
    assert hasattr(elasticity, "E")
    return elasticity.E


FIELDS = {
    field.name: field
    for field in (
        OutputField(
            name="u",
            unit="m",
            at="vertices",
            values=lambda session: session.vertex_values(session.state.u),
        ),
        OutputField(
            name="alpha",
            unit="1",
            at="vertices",
            values=lambda session: session.vertex_values(session.state.alpha),
        ),
        OutputField(
            name="T",
            unit="K",
            at="vertices",
            values=lambda session: session.vertex_values(session.state.T),
        ),
        OutputField(
            name="p",
            unit="Pa",
            at="vertices",
            values=lambda session: session.vertex_values(session.state.p),
        ),
        OutputField(
            name="stress",
            unit="Pa",
            at="cells",
            values=lambda session: session.system.energy.stress().reshape(-1, 9),
        ),
        OutputField(
            name="opening_strain",
            unit="1",
            at="cells",
            values=lambda session: session.system.energy.openings.strains()["opening_strain"],
        ),
        OutputField(
            name="intact_strain",
            unit="1",
            at="cells",
            values=lambda session: session.system.energy.openings.strains()["intact_strain"],
        ),
        OutputField(
            name="strain",
            unit="1",
            at="cells",
            values=lambda session: session.cell_values(session.system.energy.total_strain),
        ),
        OutputField(
            name="energy_density",
            unit="J/m^3",
            at="cells",
            values=lambda session: session.cell_values(session.system.energy.elastic_density),
        ),
        OutputField(
            name="E",
            unit="Pa",
            at="cells",
            values=lambda session: session.cell_values(_young(session)),
            isotropic=True,
        ),
        OutputField(
            name="Gc",
            unit="J/m^2",
            at="cells",
            values=lambda session: session.cell_values(session.system.energy.Gc),
        ),
    )
}
# Written unless a case says otherwise.
DEFAULT = ("u", "alpha", "T", "stress", "opening_strain", "intact_strain")
# Pictures and crack networks are drawn from these.
NEEDED = ("alpha", "T")


def field_values(
    session: "Session", names: Iterable[str] = DEFAULT
) -> tuple[dict[str, np.ndarray], dict[str, np.ndarray]]:
    """Return the values of fields at this rank's vertices, and those in its cells. Collective.

    Parameters
    ----------
    session : owner of the current mesh and its state.
    names : names of the fields.
    """
    found: dict[str, dict[str, np.ndarray]] = {"vertices": {}, "cells": {}}
    for name in names:
        field = FIELDS[name]
        found[field.at][name] = field.values(session)
    return found["vertices"], found["cells"]

"""Holds fields in files against the mesh of the body: they are there at all of its vertices."""

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
from dolfinx.mesh import entities_to_geometry

from staffa.backend.parallel import any_over_ranks
from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import as_toml
from staffa.case.values.given_files import given_files, in_body
from staffa.errors import InputError
from staffa.model.domain import Domain


def check_files(case: Case, domain: Domain) -> None:
    """Refuse a field that is missing at a vertex of the body, or of its side. Collective.

    Raises
    ------
    InputError
        It is so.
    """
    for where, value, side in given_files(case):
        found = in_body(case, value)(_vertices(domain, side))
        if any_over_ranks(domain.comm, not np.all(np.isfinite(found))):
            raise InputError(
                f"{where} = {as_toml(value)}: its mesh does not reach every vertex of the body's; "
                f"take a file whose mesh covers it"
            )
    _check_series(case, domain)


def _check_series(case: Case, domain: Domain) -> None:
    """Refuse files of a simulator that miss a vertex, which one rank would meet alone later."""
    keys = None if case.reservoir is None else case.reservoir.fields
    if keys is None:
        return
    there = keys.series.reaching(case.outline.h).reaches(_vertices(domain, None))
    if any_over_ranks(domain.comm, not np.all(there)):
        raise InputError(
            "reservoir.fields: the mesh of a file does not reach every vertex of the body's; take "
            "files whose meshes cover it, without holes"
        )


def _vertices(domain: Domain, side: str | None) -> np.ndarray:
    """Return vertices of this rank, of the body or of a side (m), shape (3, n)."""
    x = domain.mesh.geometry.x
    if side is not None:
        facets = domain.facets(side)
        x = x[np.unique(entities_to_geometry(domain.mesh, domain.dim - 1, facets))]
    return np.asarray(x.T)

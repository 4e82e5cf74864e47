"""The elements that the displacement of a case takes, and why; no finite elements."""

from typing import Any

import numpy as np

from staffa.case.schema.case import Case
from staffa.case.schema.domain_keys import BLOCKS
from staffa.case.schema.material_keys import is_isotropic
from staffa.case.schema.temperature_keys import NumberInTemperature
from staffa.case.values.property_functions import in_space, point_property
from staffa.case.values.stiffness import elasticity
from staffa.case.values.subdomains import Subdomain, subdomains_of
from staffa.geometry.block import UNSTRUCTURED
from staffa.physics.elasticity import effective_nu
from staffa.physics.locking import FROM, LINEAR, QUADRATIC, cures


def cells_of(case: Case) -> str:
    """Return the shape of its cells, "unstructured" for triangles or tetrahedra of Gmsh."""
    given = case.domain.cells
    return given or (BLOCKS[case.dim] if case.domain.is_block else UNSTRUCTURED)


def is_constrained(case: Case) -> bool:
    """Return whether the volume can only change with the elements'.

    In plane stress it can change otherwise: the body is free to grow thicker.
    """
    return case.dim == 3 or case.axial or case.material.plane == "strain"


def default_elements(case: Case) -> str:
    """Return linear elements, but for nearly incompressible rock those that do not lock."""
    if not is_constrained(case) or case.damage.friction:  # see `rules.contact_rules`
        return LINEAR
    largest, _ = largest_nu(case)
    return LINEAR if largest < FROM else cures(cells_of(case))


def elements_of(case: Case) -> str:
    """Give the elements that are asked for, or the default."""
    return case.domain.elements or default_elements(case)


def displacement_unknowns(case: Case) -> int:
    """Estimate the number of displacement unknowns; if the mesh is refined, at most."""
    return unknowns_on(case, case.outline.n_cells, case.outline.n_vertices)


def unknowns_on(case: Case, n_cells: int, n_vertices: int) -> int:
    """Estimate the number of displacement unknowns on a mesh.

    Quadratic elements have nodes in the middles of edges too, of which there are about as many as
    vertices and cells together (Euler).

    Parameters
    ----------
    case : the case.
    n_cells, n_vertices : numbers of cells and vertices of the mesh.
    """
    edges = n_vertices + n_cells if elements_of(case) == QUADRATIC else 0
    return case.dim * (n_vertices + edges)


def largest_nu(case: Case) -> tuple[float, Subdomain]:
    """Return the largest sampled Poisson's ratio of the rock, and the subdomain that has it."""
    found = [(_largest(subdomain), subdomain) for subdomain in subdomains_of(case)]
    return max(found, key=lambda one: one[0])


def _largest(subdomain: Subdomain) -> float:
    """Return the largest Poisson's ratio; with directions, that of equally stiff isotropic rock."""
    keys = subdomain.keys
    if is_isotropic(keys):
        if isinstance(keys.nu, int | float):
            return float(keys.nu)
        if isinstance(keys.nu, NumberInTemperature):
            return max(keys.nu.value)  # at the temperature at which it locks the most
        return float(np.max(in_space(keys.nu, subdomain.dim)(subdomain.places().x)))

    def read(value: Any) -> Any:
        return point_property(value, subdomain.dim)

    return float(np.max(effective_nu(elasticity(keys, read).stiffness(subdomain.places().x))))

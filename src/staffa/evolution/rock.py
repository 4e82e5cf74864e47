"""From the numbers of a problem to the coefficients of its energy, place by place."""

from collections.abc import Callable, Mapping

from staffa.stack import MPI  # noqa: F401

import numpy as np
from dolfinx import fem

from staffa.domain import Domain, middles
from staffa.energy import Energy, Rock
from staffa.errors import InputError
from staffa.evolution.problem import Material, Problem
from staffa.external import External
from staffa.fields import Spaces, State
from staffa.loads.forces import Forces
from staffa.physics.elasticity import Isotropic, Property, values
from staffa.strain import AnisotropicRock, Coefficient, IsotropicRock, reduced

Values = Callable[[Material, np.ndarray], np.ndarray]


def energy_of(problem: Problem, spaces: Spaces, state: State) -> Energy:
    """The energy of a problem at a state on these spaces. Collective."""
    places = Places(problem.domain, problem.material, problem.regions)
    external = External(
        problem.domain, spaces, problem.forces, places.number(lambda m: m.rho, "density")
    )
    return Energy(
        domain=problem.domain,
        spaces=spaces,
        state=state,
        rock=rock(places, problem.forces),
        external=external,
    )


class Places:
    """Numbers of the rock by cell: those of the body, and of each region its own. Collective."""

    def __init__(self, domain: Domain, material: Material, regions: Mapping[str, Material]) -> None:
        self.domain, self.material = domain, material
        self._x = middles(domain.mesh)
        self._regions = [(domain.cells(name), rock) for name, rock in regions.items()]

    def values(self, of: Values) -> np.ndarray:
        """Numbers of each cell, ghosts included, shape (n, ...)."""
        found = np.array(of(self.material, self._x), dtype=float)
        for cells, rock in self._regions:
            found[cells] = of(rock, self._x[:, cells])
        return found

    def field(self, values: np.ndarray, name: str) -> fem.Function:
        """Values of each cell, ghosts included, as a function that is constant in each."""
        element = ("Discontinuous Lagrange", 0, values.shape[1:] or None)
        field = fem.Function(fem.functionspace(self.domain.mesh, element), name=name)
        cells = field.function_space.dofmap.list[:, 0]
        width = int(np.prod(values.shape[1:]))  # said, for a rank may own nothing
        field.x.array.reshape(-1, width)[cells] = values.reshape(-1, width)
        return field

    def number(self, get: Callable[[Material], Property], name: str) -> Coefficient:
        """A number of the rock: a constant if it is one everywhere, else one a cell."""
        everywhere = get(self.material)
        others = [get(rock) for _, rock in self._regions]
        if not callable(everywhere) and all(other == everywhere for other in others):
            return fem.Constant(self.domain.mesh, float(everywhere))
        return self.field(self.values(lambda m, x: values(get(m), x)), name)

    def any(self, of: Callable[[Material], bool]) -> bool:
        """Whether something is true of some rock."""
        return any(of(rock) for rock in (self.material, *(rock for _, rock in self._regions)))


def rock(places: Places, forces: Forces | None = None) -> Rock:
    """The rock of a body, its properties evaluated at the middle of each cell.

    Raises
    ------
    InputError
        The split is for isotropic rock, and this is not.
    """
    material = places.material
    return Rock(
        elasticity=_elasticity(places),
        expansion=_expansion(places),
        Gc=places.field(places.values(lambda m, x: m.Gc * m.toughness(x)), "Gc"),
        ell=material.ell,
        law=material.law,
        state=material.state,
        split=material.split,
        roughness=_roughness(places),
        prestress=None if forces is None else _prestress(places.domain, forces),
        residual_stiffness=material.residual_stiffness,
        given=(*material.given, *material.cracks),
    )


def _elasticity(places: Places) -> IsotropicRock | AnisotropicRock:
    material = places.material
    if not places.any(lambda m: m.elasticity is not None):
        E, nu = places.number(lambda m: m.E, "E"), places.number(lambda m: m.nu, "nu")
        return IsotropicRock(E=E, nu=nu, state=material.state)
    if material.split.isotropic:
        raise InputError(
            f'damage.split = "{material.split.name}" needs isotropic rock, and this one is not; '
            f'take "volumetric-deviatoric" or "none"'
        )
    numbers = reduced(places.values(_stiffness), material.state)
    return AnisotropicRock(**{name: places.field(v, name) for name, v in numbers.items()})


def _stiffness(material: Material, x: np.ndarray) -> np.ndarray:
    elasticity = material.elasticity or Isotropic(E=material.E, nu=material.nu)
    return elasticity.stiffness(x)


def _expansion(places: Places) -> Coefficient:
    """A number, or where some rock has a tensor, a tensor."""

    def tensor(material: Material, x: np.ndarray) -> np.ndarray:
        if isinstance(material.expansion, np.ndarray):
            return np.broadcast_to(material.expansion, (x.shape[1], 3, 3))
        return values(material.expansion, x)[:, None, None] * np.eye(3)

    if places.any(lambda m: isinstance(m.expansion, np.ndarray)):
        return places.field(places.values(tensor), "expansion")
    return places.number(lambda m: m.expansion, "expansion")  # type: ignore[arg-type,return-value]


def _roughness(places: Places) -> Coefficient | None:
    """A of all rock, of the body's dimension; None if it is the identity everywhere."""
    if not places.any(lambda m: m.roughness is not None):
        return None
    dim = places.domain.dim

    def tensor(material: Material, x: np.ndarray) -> np.ndarray:
        A = np.eye(3) if material.roughness is None else material.roughness
        return np.broadcast_to(A[:dim, :dim], (x.shape[1], dim, dim))

    return places.field(places.values(tensor), "roughness")


def _prestress(domain: Domain, forces: Forces) -> fem.Function | None:
    """The stress of the rock itself at u = 0 (Pa): the whole one, and what its pores carry."""
    if forces.prestress is None and forces.pore_pressure is None:
        return None
    # Linear in each cell: exact for stress that grows with depth.
    field = fem.Function(fem.functionspace(domain.mesh, ("Discontinuous Lagrange", 1, (6,))))

    def stress(x: np.ndarray) -> np.ndarray:
        found = np.zeros((6, x.shape[1]))
        if forces.prestress is not None:
            found += forces.prestress(x)
        if forces.pore_pressure is not None:
            found[:3] += forces.biot * forces.pore_pressure(x)
        return found

    field.interpolate(stress)
    return field

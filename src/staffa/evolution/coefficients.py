"""Coefficients of the energy, cell by cell, from the numbers of a problem."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
from dolfinx import fem

from staffa.errors import InputError
from staffa.evolution.problem import Material, Problem
from staffa.loads.forces import Forces
from staffa.model.densities import Rock
from staffa.model.domain import Domain, middles
from staffa.model.energy import Energy
from staffa.model.external_loads import External
from staffa.model.fields import Spaces, State, vertices
from staffa.model.strain import AnisotropicRock, Coefficient, IsotropicRock, reduced
from staffa.model.temperature_properties import Expression, algebra, by_law, middle_of_cell
from staffa.physics.elasticity import Isotropic, Property, values
from staffa.physics.material import AXIAL
from staffa.physics.temperature import Algebra, Law

Values = Callable[[Material, np.ndarray], np.ndarray]
# Properties that may depend on temperature.
LAWFUL = ("E", "nu", "Gc", "expansion")


def energy_of(problem: Problem, spaces: Spaces, state: State) -> Energy:
    """Return the energy of a problem at a state. Collective.

    Parameters
    ----------
    problem : the problem.
    spaces : the function spaces.
    state : the fields.

    Raises
    ------
    InputError
        The state of the rock is not that of the body, or its split is not for it.
    """
    state_of, axial = problem.material.state, problem.domain.axial
    if (state_of == AXIAL) != axial:
        body = "the section of a body of revolution" if axial else "no body of revolution"
        raise InputError(
            f'the domain is {body}, and material.state is "{state_of}"; a section made with '
            f'axial=True goes with "{AXIAL}"'
        )
    places = CellValues(problem.domain, problem.material, problem.regions)
    density = places.number(lambda m: m.rho, "density")
    external = External(problem.domain, spaces, problem.forces, density, state.p)
    found = rock(places, problem.forces, warmth(problem, spaces, state))
    return Energy(
        domain=problem.domain,
        spaces=spaces,
        state=state,
        rock=replace(found, pores_at_rest=external.at_rest),
        external=external,
    )


@dataclass(frozen=True, kw_only=True)
class Warmth:
    """Temperatures of the body in forms (K).

    Attributes
    ----------
    now : temperature of the state.
    start : temperature before the first step.
    stress_free : stress-free temperature.
    middle : center of each cell (m).
    algebra : arithmetic of forms.
    """

    now: Expression
    start: Expression
    stress_free: Expression
    middle: fem.Function
    algebra: Algebra

    def factor(self, law: Law | None, T: Expression) -> Expression | float:
        """Return the factor on a property at a temperature (K)."""
        return 1.0 if law is None else law.at(T, self.middle, self.algebra)

    def warming(self, law: Law | None) -> Expression:
        """Return the free strain over the coefficient of expansion (K)."""
        if law is None:
            return self.now - self.stress_free
        return law.integral(self.stress_free, self.now, self.middle, self.algebra)


def warmth(problem: Problem, spaces: Spaces, state: State) -> Warmth | None:
    """Return the temperatures for the laws of the rock; None without a law. Collective.

    Parameters
    ----------
    problem : the problem.
    spaces : the function spaces.
    state : the fields.

    Raises
    ------
    InputError
        There are laws, and no temperatures.
    """
    if not any(rock.laws for rock in (problem.material, *problem.regions.values())):
        return None
    given = problem.temperatures
    if given is None:
        raise InputError(
            "the rock has properties of temperature, and only changes of temperature are known; "
            "give Problem.temperatures, or in a case the heat equation"
        )
    x = vertices(spaces.alpha).T
    stress_free, start = fem.Function(spaces.alpha), fem.Function(spaces.alpha)
    stress_free.x.array[:], start.x.array[:] = given.stress_free(x), given.initial(x)
    mesh = problem.domain.mesh
    return Warmth(
        now=stress_free + state.T,
        start=start,
        stress_free=stress_free,
        middle=middle_of_cell(mesh),
        algebra=algebra(mesh),
    )


class CellValues:
    """Material properties by cell: those of the body, and those of each region. Collective."""

    def __init__(self, domain: Domain, material: Material, regions: Mapping[str, Material]) -> None:
        self.domain, self.material = domain, material
        self._x = middles(domain.mesh)
        self._regions = [(domain.cells(name), rock) for name, rock in regions.items()]

    def values(self, of: Values) -> np.ndarray:
        """Return values in each cell, ghosts included, shape (n, ...)."""
        found = np.array(of(self.material, self._x), dtype=float)
        for cells, rock in self._regions:
            found[cells] = of(rock, self._x[:, cells])
        return found

    def field(self, values: np.ndarray, name: str) -> fem.Function:
        """Return values in each cell, ghosts included, as a piecewise constant function."""
        element = ("Discontinuous Lagrange", 0, values.shape[1:] or None)
        field = fem.Function(fem.functionspace(self.domain.mesh, element), name=name)
        cells = field.function_space.dofmap.list[:, 0]
        width = int(np.prod(values.shape[1:]))  # said, for a rank may own nothing
        field.x.array.reshape(-1, width)[cells] = values.reshape(-1, width)
        return field

    def number(self, get: Callable[[Material], Property], name: str) -> Coefficient:
        """Return a material property: a constant if it is uniform, else one number a cell."""
        everywhere = get(self.material)
        others = [get(rock) for _, rock in self._regions]
        if not callable(everywhere) and all(other == everywhere for other in others):
            return fem.Constant(self.domain.mesh, float(everywhere))
        return self.field(self.values(lambda m, x: values(get(m), x)), name)

    def by_law(self, name: str, value: Callable[[Law | None], Expression]) -> Expression:
        """Return factors from the law of a property, cell by cell."""
        every = np.arange(self._x.shape[1])
        rocks = [(self.material.laws.get(name), every)]
        rocks += [(rock.laws.get(name), cells) for cells, rock in self._regions]
        return by_law(self.domain.mesh, rocks, value)

    def has_law(self, name: str) -> bool:
        """Return True if a property of some rock depends on temperature."""
        return self.any(lambda m: name in m.laws)

    def any(self, of: Callable[[Material], bool]) -> bool:
        """Return True if a condition is true of some rock."""
        return any(of(rock) for rock in (self.material, *(rock for _, rock in self._regions)))


def rock(places: CellValues, forces: Forces | None = None, warm: Warmth | None = None) -> Rock:
    """Return the rock of a body, with its properties at the center of each cell.

    Parameters
    ----------
    places : material properties by cell.
    forces : the loads, with the prestress; None without any.
    warm : temperatures for laws; None without any.

    Raises
    ------
    InputError
        The split is for isotropic rock, and this rock is anisotropic.
    """
    material, elastic = places.material, _elasticity(places)
    Gc = places.field(places.values(lambda m, x: m.Gc * m.toughness(x)), "Gc")
    changing = frozenset(name for name in LAWFUL if warm and places.has_law(name))
    at_rest, warming = None, None
    if warm and changing & {"E", "nu"}:
        elastic, at_rest = (_at(elastic, places, warm, T) for T in (warm.now, warm.start))
    if warm and "expansion" in changing:
        warming = places.by_law("expansion", warm.warming)
    if warm and "Gc" in changing:
        Gc = Gc * places.by_law("Gc", lambda law: warm.factor(law, warm.now))
    return Rock(
        elasticity=elastic,
        expansion=_expansion(places),
        Gc=Gc,
        ell=material.ell,
        law=material.law,
        state=material.state,
        split=material.split,
        roughness=_roughness(places),
        prestress=None if forces is None else _prestress(places.domain, forces),
        residual_stiffness=material.residual_stiffness,
        warming=warming,
        at_rest=at_rest,
        of_temperature=changing,
        given=(*material.given, *material.cracks),
    )


def _at(
    elastic: IsotropicRock | AnisotropicRock, places: CellValues, warm: Warmth, T: Expression
) -> IsotropicRock:
    """Return the elasticity at a temperature (K)."""
    if isinstance(elastic, AnisotropicRock):
        raise InputError(
            "E and nu depend on temperature, and some rock has directions; give E and nu of "
            "temperature in rock without directions alone"
        )
    factors = {
        name: places.by_law(name, lambda law: warm.factor(law, T))
        for name in ("E", "nu")
        if places.has_law(name)
    }
    scaled = {name: getattr(elastic, name) * factor for name, factor in factors.items()}
    return replace(elastic, **scaled)


def _elasticity(places: CellValues) -> IsotropicRock | AnisotropicRock:
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


def _expansion(places: CellValues) -> Coefficient:
    """Return the thermal expansion: a number, or a tensor if some rock has one."""

    def tensor(material: Material, x: np.ndarray) -> np.ndarray:
        if isinstance(material.expansion, np.ndarray):
            return np.broadcast_to(material.expansion, (x.shape[1], 3, 3))
        return values(material.expansion, x)[:, None, None] * np.eye(3)

    if places.any(lambda m: isinstance(m.expansion, np.ndarray)):
        return places.field(places.values(tensor), "expansion")
    # No rock has a tensor here, which the type of `expansion` does not know.
    return places.number(lambda m: m.expansion, "expansion")  # type: ignore[arg-type,return-value]


def _roughness(places: CellValues) -> Coefficient | None:
    """Return A of all rock, of the body's dimension; None if it is the identity everywhere."""
    if not places.any(lambda m: m.roughness is not None):
        return None
    dim = places.domain.dim

    def tensor(material: Material, x: np.ndarray) -> np.ndarray:
        A = np.eye(3) if material.roughness is None else material.roughness
        return np.broadcast_to(A[:dim, :dim], (x.shape[1], dim, dim))

    return places.field(places.values(tensor), "roughness")


def _prestress(domain: Domain, forces: Forces) -> fem.Function | None:
    """Return the effective stress at u = 0 (Pa): the total one, and the part that pores carry."""
    if forces.prestress is None and forces.pore_pressure is None:
        return None
    # Linear in each cell: exact for stress that grows with depth.
    field = fem.Function(fem.functionspace(domain.mesh, ("Discontinuous Lagrange", 1, (6,))))

    def stress(x: np.ndarray) -> np.ndarray:
        found = np.zeros((6, x.shape[1]))
        if forces.prestress is not None:
            found += forces.prestress(x)
        if forces.pore_pressure is not None:
            found[:3] += forces.biot * forces.pore_pressure(x, 0.0)
        return found

    field.interpolate(stress)
    return field

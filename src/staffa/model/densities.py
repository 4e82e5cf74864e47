"""Rock properties cell by cell, and the parts of the energy density: strain and crack density."""

from dataclasses import dataclass

from staffa.backend.stack import MPI  # noqa: F401

import ufl
from dolfinx import fem

from staffa.model.initial_cracks import FlatCrack
from staffa.model.strain import AnisotropicRock, Coefficient, IsotropicRock, elastic_strain
from staffa.physics.damage import DamageLaw
from staffa.physics.elasticity import PAIRS
from staffa.physics.material import PLANE_STRESS
from staffa.physics.split import NO_SPLIT, EnergySplit

# A gradient of the damage whose square is below this, in 1/ell^2, has no direction.
FLAT = 1e-12


@dataclass(frozen=True, kw_only=True)
class Rock:
    """Elasticity, toughness and damage of the body.

    Attributes
    ----------
    elasticity : elastic law.
    expansion : thermal expansion (1/K), one for all, one a cell, or a tensor.
    Gc : fracture toughness (J/m^2), one a cell.
    ell : regularization length (m).
    law : damage law.
    state : one of the states of `physics.material`.
    split : energy split.
    roughness : structural tensor A, see `evolution.problem.Material`; None for the identity.
    prestress : prestress (Pa) without the part that the pores carry; None for none.
    pores_at_rest : part (Pa) of it that a fluid carries whose pressure comes with the temperature,
        which is not in `prestress`; None without one.
    residual_stiffness : fraction k_res of the stiffness left in a crack.
    warming : free strain over `expansion` (K); None if it is the temperature change.
    at_rest : elasticity before the first step; None if temperature does not change it.
    of_temperature : names of the properties that depend on temperature.
    given : cracks whose normals are known.
    """

    elasticity: IsotropicRock | AnisotropicRock
    expansion: Coefficient
    Gc: ufl.core.expr.Expr
    ell: float
    law: DamageLaw
    state: str
    split: EnergySplit = NO_SPLIT
    roughness: Coefficient | None = None
    prestress: fem.Function | None = None
    pores_at_rest: ufl.core.expr.Expr | None = None
    residual_stiffness: float = 1e-6
    warming: ufl.core.expr.Expr | None = None
    at_rest: IsotropicRock | None = None
    of_temperature: frozenset[str] = frozenset()
    given: tuple[FlatCrack, ...] = ()

    @property
    def plane_stress(self) -> bool:
        """True if the strain across the plane is free."""
        return self.state == PLANE_STRESS


def strain(u: fem.Function, T: fem.Function, rock: Rock) -> ufl.core.expr.Expr:
    """Return the elastic strain e(u) - e_th(T) + e_0, with e_0 that of the prestress.

    It is 2 x 2 in plane stress, else 3 x 3.

    Parameters
    ----------
    u : displacement (m).
    T : temperature change (K).
    rock : properties of the rock.
    """
    scalar = not rock.expansion.ufl_shape
    T = T if rock.warming is None else rock.warming
    thermal = T * (rock.expansion * ufl.Identity(3) if scalar else rock.expansion)
    elastic = elastic_strain(u, thermal, rock.state)
    rest = [] if rock.prestress is None else [prestrain(rock.prestress, rock)]
    if rock.pores_at_rest is not None:
        size = elastic.ufl_shape[0]
        rest.append(_strain_at_rest(rock.pores_at_rest * ufl.Identity(size), rock))
    return sum(rest, elastic)


def swelling(T: fem.Function, rock: Rock, dim: int) -> ufl.core.expr.Expr:
    """Return the free thermal change of volume; of area in 2-D.

    Parameters
    ----------
    T : temperature change (K).
    rock : properties of the rock.
    dim : number of directions that count, 2 or 3.
    """
    T = T if rock.warming is None else rock.warming
    if rock.expansion.ufl_shape:
        return T * sum(rock.expansion[i, i] for i in range(dim))
    return dim * rock.expansion * T


def prestrain(prestress: fem.Function, rock: Rock) -> ufl.core.expr.Expr:
    """Return the elastic strain of the prestress, which is given in Voigt's order (Pa)."""
    size = 2 if rock.plane_stress else 3
    place = {ij: k for k, ij in enumerate(PAIRS)}
    stress = [[prestress[place[min(i, j), max(i, j)]] for j in range(size)] for i in range(size)]
    return _strain_at_rest(ufl.as_tensor(stress), rock)


def _strain_at_rest(stress: ufl.core.expr.Expr, rock: Rock) -> ufl.core.expr.Expr:
    """Return the elastic strain of a stress (Pa) before the first step."""
    return (rock.at_rest or rock.elasticity).strain_of(stress)


def crack_density(alpha: fem.Function, rock: Rock) -> ufl.core.expr.Expr:
    """Return 1/(4 c_w) (w(alpha)/ell + ell grad alpha . A grad alpha), area a volume (1/m)."""
    gradient = ufl.grad(alpha)
    rough = gradient if rock.roughness is None else ufl.dot(rock.roughness, gradient)
    local = rock.law.w(alpha) / rock.ell
    return (local + rock.ell * ufl.dot(gradient, rough)) / (4 * rock.law.c_w)


def crack_measure(alpha: fem.Function, rock: Rock) -> ufl.core.expr.Expr:
    """Return `crack_density` without its direction's factor sqrt(n . A n), n along grad alpha."""
    if rock.roughness is None:
        return crack_density(alpha, rock)
    gradient = ufl.grad(alpha)
    square = ufl.dot(gradient, gradient) + FLAT / rock.ell**2
    rough = ufl.dot(gradient, ufl.dot(rock.roughness, gradient)) + FLAT / rock.ell**2
    return crack_density(alpha, rock) * ufl.sqrt(square / rough)

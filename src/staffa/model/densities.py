"""The rock, cell by cell, and what its energy is made of: strain, and density of cracks."""

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

    expansion (1/K): a number a cell or of all, or a tensor; Gc: toughness (J/m^2) a cell; ell:
    regularization length (m); roughness: A, see `evolution.problem.Material`, None for the
    identity; prestress (Pa): without what the pores carry, None for none; residual_stiffness:
    fraction k_res left in a crack; state: one of those of `physics.material`.
    warming: the free strain over `expansion` (K), None where that is the temperature change;
    at_rest: the elasticity before the first step, None where temperature does not change it;
    of_temperature: names of the properties that temperature changes; given: cracks whose normals
    are known.
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
    """The elastic strain e(u) - e_th(T) + e_0, e_0 that of the prestress: 2 x 2 in plane stress,
    else 3 x 3."""
    scalar = not rock.expansion.ufl_shape
    T = T if rock.warming is None else rock.warming
    thermal = T * (rock.expansion * ufl.Identity(3) if scalar else rock.expansion)
    elastic = elastic_strain(u, thermal, rock.state)
    return elastic if rock.prestress is None else elastic + prestrain(rock.prestress, rock)


def swelling(T: fem.Function, rock: Rock, dim: int) -> ufl.core.expr.Expr:
    """The change of volume, of area in 2-D, that cold brings about by itself."""
    T = T if rock.warming is None else rock.warming
    if rock.expansion.ufl_shape:
        return T * sum(rock.expansion[i, i] for i in range(dim))
    return dim * rock.expansion * T


def prestrain(prestress: fem.Function, rock: Rock) -> ufl.core.expr.Expr:
    """The elastic strain of the prestress, given in Voigt's order."""
    size = 2 if rock.plane_stress else 3
    place = {ij: k for k, ij in enumerate(PAIRS)}
    stress = [[prestress[place[min(i, j), max(i, j)]] for j in range(size)] for i in range(size)]
    return (rock.at_rest or rock.elasticity).strain_of(ufl.as_tensor(stress))


def crack_density(alpha: fem.Function, rock: Rock) -> ufl.core.expr.Expr:
    """1/(4 c_w) (w(alpha)/ell + ell grad alpha . A grad alpha): crack length an area, or area a
    volume."""
    gradient = ufl.grad(alpha)
    rough = gradient if rock.roughness is None else ufl.dot(rock.roughness, gradient)
    local = rock.law.w(alpha) / rock.ell
    return (local + rock.ell * ufl.dot(gradient, rough)) / (4 * rock.law.c_w)


def crack_measure(alpha: fem.Function, rock: Rock) -> ufl.core.expr.Expr:
    """`crack_density` without what the direction does to it, sqrt(n . A n), n along grad alpha."""
    if rock.roughness is None:
        return crack_density(alpha, rock)
    gradient = ufl.grad(alpha)
    square = ufl.dot(gradient, gradient) + FLAT / rock.ell**2
    rough = ufl.dot(gradient, ufl.dot(rock.roughness, gradient)) + FLAT / rock.ell**2
    return crack_density(alpha, rock) * ufl.sqrt(square / rough)

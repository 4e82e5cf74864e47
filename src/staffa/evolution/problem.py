"""Problem: everything that defines a run, as objects that a case or a script makes."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Literal

import numpy as np

from staffa.errors import InputError, choices
from staffa.evolution.schedule import Schedule
from staffa.heat.thermal_body import Conduction
from staffa.loads.closed_form import CoupledLoad, Face, Load, NoLoad
from staffa.loads.forces import Forces
from staffa.model.domain import Domain
from staffa.model.initial_cracks import FlatCrack
from staffa.model.supports import GeneralizedPlaneStrain, SideSupport
from staffa.physics.damage import DamageLaw, effective_gc_factor
from staffa.physics.elasticity import Elasticity, PointFunction, Property
from staffa.physics.locking import LINEAR
from staffa.physics.split import NO_SPLIT, Contact, EnergySplit
from staffa.physics.temperature import Law
from staffa.records.step import Stop

# A mesh that resolves the regularization length less than this guesses too badly to be of use.
RESOLVED = 3.0

GUESSES = ("coarser", "none")


def ones(x: np.ndarray) -> np.ndarray:
    """Return 1 at every point."""
    return np.ones(x.shape[1])


def nowhere(x: np.ndarray) -> np.ndarray:
    """Return False at every point."""
    return np.zeros(x.shape[1], dtype=bool)


@dataclass(frozen=True, kw_only=True)
class Material:
    """Material properties of a rock, in SI units or scaled.

    Attributes
    ----------
    E, nu : Young's modulus (Pa) and Poisson's ratio; with `elasticity` those for scales.
    Gc : fracture toughness (J/m^2).
    expansion : thermal expansion (1/K), or a symmetric tensor along x, y, z, shape (3, 3).
    ell : regularization length (m).
    law : damage law.
    state : one of the states of `physics.material`.
    split : energy split.
    rho : density (kg/m^3), for the weight alone.
    elasticity : elastic law in place of the isotropic one of E and nu; None for that.
    roughness : symmetric tensor A, shape (3, 3), of the term ell grad alpha . A grad alpha: a
        straight crack of unit normal n costs Gc sqrt(n . A n); None for the identity.
    residual_stiffness : fraction of the stiffness left in a crack.
    toughness : factor on Gc, a function of points alone.
    cracked : True at the points of initial cracks.
    cracks : initial cracks that break every cell they cut, on any mesh.
    laws : factors on E, nu, Gc and expansion by temperature, by these names.
    given : initial cracks whose normals are known.
    """

    E: Property
    nu: Property
    Gc: float
    expansion: Property | np.ndarray
    ell: float
    law: DamageLaw
    state: str
    split: EnergySplit = NO_SPLIT
    rho: Property = 0.0
    elasticity: Elasticity | None = None
    roughness: np.ndarray | None = None
    residual_stiffness: float = 1e-6
    toughness: PointFunction = ones
    cracked: PointFunction = nowhere
    cracks: tuple[FlatCrack, ...] = ()
    laws: Mapping[str, Law] = field(default_factory=dict)
    given: tuple[FlatCrack, ...] = ()


@dataclass(frozen=True, kw_only=True)
class Temperatures:
    """Temperatures at points (K).

    Attributes
    ----------
    stress_free : stress-free temperature.
    initial : temperature before the first step.
    """

    stress_free: PointFunction
    initial: PointFunction


@dataclass(frozen=True, kw_only=True)
class Irreversibility:
    """Irreversibility of the damage.

    Attributes
    ----------
    crack_set_only : True if only the crack set is irreversible (the paper's rule), else all damage.
    threshold : damage from which a point is in the crack set.
    """

    crack_set_only: bool = False
    threshold: float = 0.95


@dataclass(frozen=True, kw_only=True)
class Solvers:
    """Solvers and their stop.

    Attributes
    ----------
    displacement, damage, acceleration : names of presets in `petsc_options`.
    guess : "coarser" for a first guess from a coarser mesh after a large change of loads, and
        from a try of a step on cells that were too coarse; or "none".
    stop : tolerances of a minimum.
    """

    displacement: str = "direct"
    damage: str = "tao"
    acceleration: str = "newton"
    guess: str = "coarser"
    stop: Stop = field(default_factory=Stop)


@dataclass(frozen=True, kw_only=True)
class Backtracking:
    """Backtracking: each step's damage is tried at earlier times, and kept there if it is better.

    Attributes
    ----------
    tolerance : least decrease of the energy there, over the energy.
    """

    tolerance: float = 1e-4


@dataclass(frozen=True, kw_only=True)
class SecondOrder:
    """Second-order test of each step's state.

    Attributes
    ----------
    kind : "test", a cheap search for a direction along which the energy falls, which is followed;
        "report", the smallest second variations, exactly; "follow", the same, and a state is left
        along a mode of negative value.
    tolerance : a value is negative if it is below minus this.
    """

    kind: Literal["test", "report", "follow"] = "test"
    tolerance: float = 1e-3


@dataclass(frozen=True, kw_only=True)
class Measuring:
    """Settings of the measures.

    Attributes
    ----------
    depths : depths below the face at which cracks are counted (m).
    threshold : damage above which a point is cracked.
    cooled : boundaries that are cooled besides that face.
    cools : False if these are cooled and that face is not.
    """

    depths: tuple[float, ...] = ()
    threshold: float = 0.8
    cooled: tuple[str, ...] = ()
    cools: bool = True


@dataclass(frozen=True, kw_only=True)
class Refinement:
    """When cells of a mesh that may be refined are split.

    Attributes
    ----------
    ahead : distance (m) around damage within which cells are the finest.
    drive : energy that drives the damage over its threshold from which on cells are the finest.
    drop : largest change of temperature over a cell, over the largest change since t = 0.
    """

    ahead: float
    drive: float = 0.5
    drop: float = 0.02


@dataclass(frozen=True, kw_only=True)
class Problem:
    """A body, what it is made of, what holds and loads it, when to look, and how to solve.

    Attributes
    ----------
    domain : mesh with its named sides.
    elements : elements of the displacement, see `physics.locking`.
    material : rock of the body.
    regions : rock of the regions that differs from `material`, by name; ell, the laws, the plane
        state and what is cracked are those of `material`.
    load : source of the temperature: a closed form, the heat equation, or any other that
        `evolution.coupling.coupling_of` knows.
    temperatures : temperatures from which it changes; needed where a rock has laws of them.
    forces : other loads; those of t = 0, with the prestress, are in equilibrium before the first
        step.
    schedule : times of the steps.
    sides : supports of the sides.
    section : right side of a slab's cell that stays plane; None without.
    anchor : boundary on which pins are sought, see `model.supports`; None without.
    face : cooled face, from which depths are measured; None without.
    tau_of : dimensionless time of a time (s); None where nothing diffuses.
    irreversibility : rule by which damage cannot heal.
    solvers : settings of the solvers.
    backtracking : settings of backtracking; None without.
    second_order : settings of the second-order test; None without.
    measuring : settings of the measures.
    refinement : when cells are split; None for a mesh that stays as it is.
    """

    domain: Domain
    elements: str = LINEAR
    material: Material
    regions: Mapping[str, Material] = field(default_factory=dict)
    load: Load | CoupledLoad | Conduction
    temperatures: Temperatures | None = None
    forces: Forces = field(default_factory=Forces)
    schedule: Schedule
    sides: tuple[SideSupport, ...] = ()
    section: GeneralizedPlaneStrain | None = None
    anchor: str | None = None
    face: Face | None = None
    tau_of: Callable[[float], float] | None = None
    irreversibility: Irreversibility = field(default_factory=Irreversibility)
    solvers: Solvers = field(default_factory=Solvers)
    backtracking: Backtracking | None = None
    second_order: SecondOrder | None = field(default_factory=SecondOrder)
    measuring: Measuring = field(default_factory=Measuring)
    refinement: Refinement | None = None


def coarser(problem: Problem) -> Problem | None:
    """Return the problem on cells twice as long, with the same effective Gc, for a first guess.

    None if such a guess is useless. Its temperature is taken from the finer mesh. A crack
    dissipates about Gc (1 + h/(4 c_w ell)) on cells of edge h, and the new Gc makes up for it. In
    3-D the guess saved 3 sweeps of 10 but no time, and costs memory (docs/performance.md).
    Collective.
    """
    domain, material, guess = problem.domain, problem.material, problem.solvers.guess
    if guess not in GUESSES:
        raise InputError(f"there is no first guess '{guess}'; {choices(guess, GUESSES)}")
    held = problem.forces.crack_volume is not None  # its pressure is not the coarser mesh's
    held = held or isinstance(material.split, Contact)  # nor are faces and their slip
    if guess == "none" or held or domain.dim != 2 or domain.coarser is None:
        return None
    if material.ell < 2 * RESOLVED * domain.h * (1 - 1e-9):  # round-off decides nothing
        return None
    body = domain.coarser()
    factor = partial(effective_gc_factor, material.law, ell=material.ell)
    share = factor(h=domain.h) / factor(h=body.h)

    def tougher(rock: Material) -> Material:
        return replace(rock, Gc=share * rock.Gc)

    regions = {name: tougher(rock) for name, rock in problem.regions.items()}
    return replace(problem, domain=body, material=tougher(material), regions=regions, load=NoLoad())

"""Everything that defines a run, as objects: what a case file becomes, and a script can write."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Literal

import numpy as np

from staffa.errors import InputError, choices
from staffa.evolution.schedule import Schedule
from staffa.heat.thermal_body import Conduction
from staffa.loads.closed_form import Face, Load, NoLoad
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
    """1 at every point."""
    return np.ones(x.shape[1])


def nowhere(x: np.ndarray) -> np.ndarray:
    """False at every point."""
    return np.zeros(x.shape[1], dtype=bool)


@dataclass(frozen=True, kw_only=True)
class Material:
    """Numbers of the rock: E, Gc, expansion, ell (SI or scaled), nu; its laws; its heterogeneity.

    split: how tension and compression share the energy; rho: density, for its weight alone.

    expansion: also a symmetric tensor, shape (3, 3), along x, y, z. elasticity: another than the
    isotropic one of E and nu, which then are what scales are told in. toughness: factor on Gc at
    points, a function of position alone. roughness: symmetric A, shape (3, 3), of the term
    ell grad alpha . A grad alpha: a straight crack of unit normal n costs Gc sqrt(n . A n); None:
    the identity. laws: factors on E, nu, Gc and expansion by temperature, by these names.
    cracked: True at the points
    of cracks that are there from the start; cracks: those that break every cell they cut, which any
    mesh can carry; given: cracks among all these whose normals are known.
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
    """Temperatures (K) at points: free of thermal strain, and before the first step."""

    stress_free: PointFunction
    initial: PointFunction


@dataclass(frozen=True, kw_only=True)
class Irreversibility:
    """What cannot heal: all damage, or only the crack set, alpha >= threshold (the paper's)."""

    crack_set_only: bool = False
    threshold: float = 0.95


@dataclass(frozen=True, kw_only=True)
class Solvers:
    """Names of the presets in `options`, and when a state counts as a minimum.

    guess: "coarser", a first guess from a coarser mesh where new loads overwhelm the state, or
    "none".
    """

    displacement: str = "direct"
    damage: str = "tao"
    acceleration: str = "newton"
    guess: str = "coarser"
    stop: Stop = field(default_factory=Stop)


@dataclass(frozen=True, kw_only=True)
class Backtracking:
    """Whether a step's damage is tried at earlier times too, and taken back where it is better.

    tolerance: by how much of the energy there it must be lower.
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
    tolerance : a value counts as negative below minus this.
    """

    kind: Literal["test", "report", "follow"] = "test"
    tolerance: float = 1e-3


@dataclass(frozen=True, kw_only=True)
class Measuring:
    """Depths below the face at which cracks are counted (m), and the damage that is a crack."""

    depths: tuple[float, ...] = ()
    threshold: float = 0.8


@dataclass(frozen=True, kw_only=True)
class Problem:
    """A body, what it is made of, what holds and loads it, when to look, and how to solve.

    elements: of the displacement, see `physics.locking`. regions: the rock of the domain's regions
    that differs from `material`; ell, the laws, the plane state and what is cracked are the body's,
    those of `material`.
    load: where the temperature comes from: a closed form, the heat equation, or what else
    `coupling.coupling_of` has a line for. temperatures: from
    which it changes, needed where a rock has laws of it. forces: what else
    acts; those of t = 0, with the prestress, are in equilibrium before the first step.
    face: the cooled one, from which depths are measured; tau_of: the paper's time of a time, or
    None where nothing diffuses. backtracking, second_order: None for none; by default the second
    order is tested.
    """

    domain: Domain
    elements: str = LINEAR
    material: Material
    regions: Mapping[str, Material] = field(default_factory=dict)
    load: Load | Conduction
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


def coarser(problem: Problem) -> Problem | None:
    """The same on cells twice as long, as tough; None if that is of no use for a first guess.
    Its temperature is brought from the finer one.

    A crack dissipates about Gc (1 + h/(4 c_w ell)) on cells of edge h: Gc makes up for it. In 3-D
    the guess saved 3 sweeps of 10 but no time, and costs memory (docs/performance.md). Collective.
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

"""A law, a split and a load that a script gives in place of a case's: tried, and known again."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import ufl

from staffa.arguments import told
from staffa.backend.parallel import best_candidate, max_over_ranks, on_root
from staffa.case.schema.case import Case
from staffa.case.values.subdomains import averages, subdomains_of
from staffa.errors import InputError
from staffa.evolution.coupling import in_closed_form
from staffa.evolution.problem import Problem
from staffa.heat.thermal_body import Conduction
from staffa.loads.closed_form import CoupledLoad, Load, pressure_of
from staffa.model.domain import Domain
from staffa.physics.damage import DamageLaw
from staffa.physics.material import PLANE_STRESS
from staffa.physics.split import EnergySplit
from staffa.physics.strained import of_principal
from staffa.physics.trial import has_members, law_values, split_values, try_law, try_split
from staffa.records.manifest import Own
from staffa.setup.object_identity import object_identity, said_identity

# How the arguments are called in sentences.
WORDS = {"damage": "law", "split": "split", "temperature": "load"}
# Functions of place by which a load is known, and the turns that each makes along x, y and z.
WAVES, TURNS = 6, np.array([1.0, 2**0.5, 3**0.5]) / 2


@dataclass(frozen=True, kw_only=True)
class Given:
    """Objects that a script gives in place of a case's; None for the case's.

    Attributes
    ----------
    damage : damage law.
    split : energy split.
    temperature : load, which gives the temperature.
    """

    damage: DamageLaw | None = None
    split: EnergySplit | None = None
    temperature: Load | CoupledLoad | None = None

    @property
    def names(self) -> frozenset[str]:
        """Return the arguments that are given."""
        return frozenset(name for name, value in vars(self).items() if value is not None)


def try_given(given: Given, case: Case) -> None:
    """Try a law and a split at samples, in numbers and in UFL; see `physics.trial`.

    Raises
    ------
    InputError
        One of them breaks a rule.
    """
    law, split = given.damage, given.split
    if law is not None:
        try_law(law, residual=case.damage.residual_stiffness)
        for name in ("a", "w"):
            function = getattr(law, name)
            _in_ufl(f"the damage law '{law.name}': {name}(alpha)", function, ufl.as_ufl(0.5))
    if split is not None:
        plane_stress = case.plane_stress
        for nu in {averages(subdomain).nu for subdomain in subdomains_of(case)}:
            try_split(split, plane_stress=plane_stress, nu=nu)
        strains = (0.1, -0.1) if plane_stress else (0.1, 0.0, -0.1)
        e = of_principal(tuple(map(ufl.as_ufl, strains)), E=ufl.as_ufl(1.0), nu=ufl.as_ufl(0.2))
        _in_ufl(
            f"the energy split '{split.name}': density(e, g)", split.density, e, ufl.as_ufl(0.5)
        )


def _in_ufl(what: str, function: Callable[..., Any], *values: Any) -> None:
    try:
        ufl.as_ufl(function(*values))
    except Exception as error:  # whatever a user's function raises
        raise InputError(
            f"{what} cannot be written in UFL ({type(error).__name__}: {error}); use arithmetic "
            f"alone, which floats, NumPy and UFL have in common"
        ) from error


def known_load(load: Any, domain: Domain, at: tuple[float, ...]) -> Own:
    """Return what identifies a load: its values, or what it says of itself. Collective.

    Parameters
    ----------
    load : load in closed form, or one that `evolution.coupling.coupling_of` knows.
    domain : the mesh.
    at : times (s) at which a closed form is tried.

    Raises
    ------
    InputError
        It is no load, or does not tell its identity.
    """
    if in_closed_form(load):
        values = tried_load(load, domain, at)
        return Own(identity=object_identity(load), values=values, at=at)
    if isinstance(load, Conduction) and not hasattr(load, "identity"):
        return Own(identity=object_identity(load), at=at)
    text, numbers = on_root(domain.comm, lambda: said_identity(load))
    return Own(identity=text, values=numbers, at=at)


def tried_load(load: Load, domain: Domain, at: tuple[float, ...]) -> tuple[float, ...]:
    """Return numbers that identify a load on any partition. Collective.

    They are its largest value, and those of its products with some waves over the body.

    Parameters
    ----------
    load : the load.
    domain : the mesh.
    at : times (s).

    Raises
    ------
    InputError
        It is no load, or gives what is no temperature at the vertices.
    """
    has_members("temperature", load, ("temperature",), methods=("temperature",))
    x = np.array(domain.mesh.geometry.x.T)
    lower, size = np.zeros((3, 1)), np.ones((3, 1))
    lower[: domain.dim, 0], size[: domain.dim, 0] = domain.lower, domain.size
    places = 2 * np.pi * TURNS @ ((x - lower) / size)
    waves = np.cos(np.arange(WAVES)[:, None] * places)
    found = []
    given = {"temperature": load.temperature, "pressure": pressure_of(load)}
    for name, value in given.items():
        for t in at if value is not None else ():
            values, said = _values(name, value, x, t)
            first = best_candidate(domain.comm, (said,) if said else None)
            if first:
                raise InputError(f"the load {type(load).__name__}: {first[0]}")
            found += [max_over_ranks(domain.comm, wave * values) for wave in waves]
    return tuple(found)


def _values(name: str, value: Any, x: np.ndarray, t: float) -> tuple[np.ndarray, str]:
    """Return a load's values at points, shape (3, n) -> (n,), and what is wrong with them."""
    n, when = x.shape[1], f"at t = {t:.6g}"
    none = np.zeros(n)
    try:
        found, again = (np.asarray(value(x.copy(), t)) for _ in range(2))
    except Exception as error:  # whatever a user's function raises
        return none, f"{name}(x, t) fails {when} ({type(error).__name__}: {error}); fix it"
    if found.shape != (n,) or found.dtype.kind not in "fiu":
        shape = f"an array of shape {found.shape} and type {found.dtype}"
        kind = shape if found.shape else told(found.item())
        return none, (
            f"{name}(x, t) gives {kind} for points of shape (3, {n}); give one number a "
            f"point, shape ({n},), like np.full(x.shape[1], -1.0)"
        )
    if not np.all(np.isfinite(found)):
        where = ", ".join(f"{c:.6g}" for c in x[:, np.flatnonzero(~np.isfinite(found))[0]])
        return none, f"the {name} is not finite {when}, at x = ({where}); fix it"
    if not np.array_equal(found, again):
        return none, (
            f"it gives another {name} when it is asked again {when}, and must depend on place "
            f"and time alone; fix it"
        )
    return found, ""


def recorded(given: Given, setup: Problem) -> dict[str, Own]:
    """Describe what is given, for the manifest. Collective."""
    times = setup.schedule.times
    return _known(given, setup, (times[0], times[-1]))


def _known(given: Given, setup: Problem, at: tuple[float, ...]) -> dict[str, Own]:
    found = {}
    if given.damage is not None:
        found["damage"] = Own(
            identity=object_identity(given.damage), values=law_values(given.damage)
        )
    if given.split is not None:
        plane_stress = setup.material.state == PLANE_STRESS
        values = split_values(given.split, plane_stress=plane_stress)
        found["split"] = Own(identity=object_identity(given.split), values=values)
    load = given.temperature
    if load is not None:
        found["temperature"] = known_load(load, setup.domain, at)
    return found


def require_given(given: Given, own: dict[str, Own] | None, run: str) -> None:
    """Require, of a script that goes on with a run, objects as at the start.

    Parameters
    ----------
    given : objects of the script that goes on.
    own : identities of the objects of the start, from the manifest; None if unknown.
    run : the run directory, for messages.

    Raises
    ------
    InputError
        Something is missing, or too much.
    """
    if own is None:
        return
    for name in sorted(own.keys() - given.names):
        raise InputError(
            f"{run} was run with the {WORDS[name]} {own[name].identity} of a script, in place of "
            f"the case's; go on from Python, with staffa.resume({run!r}, {name}=...)"
        )
    for name in sorted(given.names - own.keys()):
        raise InputError(
            f"{run} was run with the case's own {WORDS[name]}; leave {name}=... out, or begin a "
            f"new run with it"
        )


def unrecorded(own: dict[str, Own] | None, given: Given) -> str | None:
    """Return a sentence on a run whose manifest does not say what a script gave it.

    Parameters
    ----------
    own : from the manifest, None if it was written before that was recorded.
    given : by who goes on with the run.
    """
    if own is not None or given.names:
        return None
    return (
        "an earlier version wrote this run and did not record whether a script gave it a law, a "
        "split or a load: it goes on with the case's; if a script did, stop it and go "
        "on from Python with the same object"
    )


def require_same(given: Given, own: dict[str, Own] | None, setup: Problem, run: str) -> None:
    """Require the objects of a script with which the run began. Collective.

    Parameters
    ----------
    given : objects of the script that goes on.
    own : identities of the objects with which the run began, by name; None if unknown.
    setup : the problem.
    run : the run directory, for messages.

    Raises
    ------
    InputError
        It is something else.
    """
    if not own:
        return
    at = own["temperature"].at if "temperature" in own else ()
    for name, now in _known(given, setup, at).items():
        then = own[name]
        if now.identity != then.identity:
            raise InputError(
                f"{run} was run with the {WORDS[name]} {then.identity}, not {now.identity}; go on "
                f"with the same one"
            )
        if not now.alike(then):
            raise InputError(
                f"{run} was run with another {WORDS[name]} of the same name, {now.identity}, which "
                f"gave other values; go on with the same one"
            )

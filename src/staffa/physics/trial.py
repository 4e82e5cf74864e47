"""Tests of a damage law and an energy split at samples: do they obey the rules of the theory?"""

from collections.abc import Iterable, Mapping
from dataclasses import replace
from itertools import chain
from numbers import Real
from typing import Any

import numpy as np
from scipy.integrate import quad

from staffa.arguments import py_text, told
from staffa.errors import InputError
from staffa.physics.damage import KNOWN, DamageLaw
from staffa.physics.split import SPLITS, EnergySplit
from staffa.physics.strained import of_principal

# Round-off of a law's or a split's arithmetic, over its largest value.
ROUND_OFF = 1e-9
# c_w may be given to four digits; the surface energy is divided by it.
DIGITS = 1e-4
# If damage takes at most this part of every strain's energy, it changes nothing.
NOTHING = 1e-3
LONGEST_NAME = 60
# Fractions of the stiffness at which a split is tested, and the number of strains.
FRACTIONS, STRAINS = (1e-6, 0.3, 0.7), 500


def try_law(law: DamageLaw, *, residual: float = 0.0) -> None:
    """Test a damage law against the rules of the theory.

    Parameters
    ----------
    law : the damage law.
    residual : part of the stiffness that `a` may leave at alpha = 1.

    Raises
    ------
    InputError
        It breaks a rule: a falls from 1 to 0, w rises from 0 to 1, c_w is the integral of sqrt(w).
    """
    has_members("damage", law, ("name", "c_w", "a", "w"), methods=("a", "w"), known=KNOWN)
    who, c_w = f"the damage law '{law.name}'", law.c_w
    _require(who, law, "c_w", Real, "a number")
    alpha = np.linspace(0.0, 1.0, 201)
    a, w = _sampled(who, law, "a", alpha), _sampled(who, law, "w", alpha)
    risen, fallen = alpha[np.diff(a).argmax()], alpha[np.diff(w).argmin()]
    ends = "scale it so that it does"
    rules = (
        (abs(a[0] - 1) <= ROUND_OFF, f"a(0) = {a[0]:.6g}, and sound rock has a(0) = 1; {ends}"),
        (
            -ROUND_OFF <= a[-1] <= residual + ROUND_OFF,
            f"a(1) = {a[-1]:.6g}, and broken rock has a(1) = 0, but for damage.residual_stiffness, "
            f"which is added; {ends}",
        ),
        (np.diff(a).max() <= ROUND_OFF, f"a rises at alpha = {risen:.3g}, and must fall; fix a"),
        (abs(w[0]) <= ROUND_OFF, f"w(0) = {w[0]:.6g}, and sound rock has w(0) = 0; {ends}"),
        (abs(w[-1] - 1) <= ROUND_OFF, f"w(1) = {w[-1]:.6g}, and a crack has w(1) = 1; {ends}"),
        (np.diff(w).min() >= -ROUND_OFF, f"w falls at alpha = {fallen:.3g}, and must rise; fix w"),
    )
    _obey(who, rules)
    integral = quad(lambda s: float(np.sqrt(max(law.w(s), 0.0))), 0.0, 1.0, limit=200)[0]
    right = abs(float(c_w) / integral - 1) <= DIGITS
    told_c_w = f"c_w = {c_w:.6g}, and the integral of sqrt(w) over [0, 1] is {integral:.6g}"
    _obey(who, [(right, f"{told_c_w}; write c_w = {integral:.6g}")])


def law_values(law: DamageLaw) -> tuple[float, ...]:
    """Return c_w, and a and w at some damages, by which a law is recognized."""
    alpha, who = np.linspace(0.0, 1.0, 6), f"the damage law '{law.name}'"
    sampled = (_sampled(who, law, name, alpha).tolist() for name in ("a", "w"))
    return tuple(map(float, (law.c_w, *chain(*sampled))))


def try_split(split: EnergySplit, *, plane_stress: bool, nu: float) -> None:
    """Test an energy split against the rules of the theory, in rock with E = 1.

    Parameters
    ----------
    split : the energy split.
    plane_stress : True for two principal strains, else three.
    nu : Poisson's ratio.

    Raises
    ------
    InputError
        It breaks a rule: psi at g = 1, nothing at no strain, nowhere negative, convex in the
        strain, and less with less of the stiffness at some strain.
    """
    members = ("name", "isotropic", "density")
    has_members("split", split, members, methods=("density",), known=SPLITS)
    who = f"the energy split '{split.name}'"
    _require(who, split, "isotropic", bool, "True or False")
    one, other = _pairs(2 if plane_stress else 3)
    psi = np.asarray(of_principal(tuple(_ordered(one)), E=1.0, nu=nu).psi)

    def density(strains: np.ndarray, g: float) -> np.ndarray:
        return _density(who, split, strains, g, nu)

    whole, at_rest = density(one, 1.0), density(0 * one, FRACTIONS[1])
    off = np.abs(whole / psi - 1).argmax()
    rules = [
        (
            np.abs(at_rest).max() <= ROUND_OFF,
            f"its density is {np.abs(at_rest).max():.3g} where there is no strain, and must be 0",
        ),
        (
            abs(whole[off] / psi[off] - 1) <= ROUND_OFF,
            f"its density at g = 1 is {whole[off]:.6g} at {_strain(one[:, off])}, and sound rock "
            f"has psi = {psi[off]:.6g}",
        ),
    ]
    for g in FRACTIONS:
        here, there, between = density(one, g), density(other, g), density((one + other) / 2, g)
        least, chord = here.argmin(), (here + there) / 2
        scale = ROUND_OFF * (np.abs(here) + np.abs(there) + psi)
        above = ((between - chord) / scale).argmax()
        middle = _strain((one[:, above] + other[:, above]) / 2)
        rules += [
            (
                here[least] >= -ROUND_OFF * psi[least],
                f"its density is {here[least]:.3g} at {_strain(one[:, least])} and g = {g:g}, and "
                f"must not be negative",
            ),
            (
                between[above] - chord[above] <= scale[above],
                f"its density is not convex in the strain: at {middle} and g = {g:g} it is "
                f"{between[above]:.6g}, above the mean {chord[above]:.6g} of two strains around",
            ),
        ]
    lost = float((1 - density(one, FRACTIONS[0]) / psi).max())
    rules.append(
        (lost > NOTHING, f"g takes {max(lost, 0):.3g} of no strain's energy: nothing could break")
    )
    _obey(who, ((kept, f"{said}; fix density") for kept, said in rules))


def split_values(split: EnergySplit, *, plane_stress: bool) -> tuple[float, ...]:
    """Return densities at some strains, by which a split is recognized."""
    strains = _pairs(2 if plane_stress else 3)[0][:, :8]
    who = f"the energy split '{split.name}'"
    return tuple(_density(who, split, strains, FRACTIONS[1], 0.2).tolist())


def has_members(
    argument: str,
    thing: Any,
    members: tuple[str, ...],
    *,
    methods: tuple[str, ...],
    known: Mapping[str, Any] | None = None,
) -> None:
    """Refuse an object that lacks a member, is a class, or has a name that is taken.

    Parameters
    ----------
    argument : name of the argument by which the object was given.
    thing : the object.
    members : names of the members that it needs.
    methods : those of the members that are methods.
    known : the objects of staffa by their names.

    Raises
    ------
    InputError
        The object breaks one of these rules.
    """
    listed = ", ".join(f"{name}()" if name in methods else name for name in members)
    way_out = f"give an object with {listed}; docs/how-to/extending.md has one"
    if isinstance(thing, type):
        name = thing.__name__
        raise InputError(f"{argument} = {name} is a class; give an object of it, like {name}()")
    lacks = [name for name in members if not hasattr(thing, name)]
    if lacks:
        raise InputError(f"{argument} = {py_text(thing)} has no {', '.join(lacks)}; {way_out}")
    for name in methods:
        if not callable(getattr(thing, name)):
            raise InputError(f"{argument} = {py_text(thing)}: {name} is no method; {way_out}")
    if known is None:
        return
    name = thing.name
    if not (isinstance(name, str) and name.strip() and name.isprintable()) or (
        len(name) > LONGEST_NAME
    ):
        raise InputError(
            f"{argument} = {py_text(thing)}: name = {py_text(name)}, and a name is a text of 1 "
            f"to {LONGEST_NAME} characters that can be printed; give it one"
        )
    if name in known and type(thing) is not type(known[name]):
        raise InputError(
            f"{argument} = {py_text(thing)}: staffa has another one whose name is '{name}'; give "
            f"it another name"
        )


def _require(who: str, thing: Any, member: str, kind: type, needed: str) -> None:
    """Refuse a member of another type."""
    value = getattr(thing, member)
    if not isinstance(value, kind) or (kind is Real and isinstance(value, bool)):
        raise InputError(f"{who}: {member} = {py_text(value)} is {told(value)}; give {needed}")


def _obey(who: str, rules: Iterable[tuple[Any, str]]) -> None:
    for kept, said in rules:
        if not kept:
            raise InputError(f"{who}: {said}")


def _sampled(who: str, law: DamageLaw, name: str, alpha: np.ndarray) -> np.ndarray:
    """Return one of a law's functions at damages, shape (n,)."""
    try:
        with np.errstate(all="ignore"):
            found = np.asarray(getattr(law, name)(alpha) + 0 * alpha)
    except Exception as error:  # whatever a user's function raises
        raise _not_computed(who, f"{name}(alpha)", error) from error
    _are_numbers(who, f"{name}(alpha)", found, alpha.shape)
    return found.astype(float)


def _density(who: str, split: EnergySplit, strains: np.ndarray, g: float, nu: float) -> np.ndarray:
    """Return densities of principal strains in any order, shape (2 or 3, n) -> (n,)."""
    e = of_principal(tuple(_ordered(strains)), E=1.0, nu=nu)
    try:
        with np.errstate(all="ignore"):
            given = e if split.isotropic else replace(e, principal=None)
            found = np.asarray(split.density(given, g) + 0 * e.psi)
    except Exception as error:
        raise _not_computed(who, "density(e, g)", error) from error
    _are_numbers(who, "density(e, g)", found, np.shape(e.psi))
    return found.astype(float)


def _not_computed(who: str, what: str, error: Exception) -> InputError:
    return InputError(
        f"{who}: {what} cannot be computed with numbers ({type(error).__name__}: {error}); write "
        f"it with arithmetic alone, which floats, NumPy and UFL have in common"
    )


def _are_numbers(who: str, what: str, found: np.ndarray, shape: tuple[int, ...]) -> None:
    if found.dtype.kind not in "fiu" or found.shape != shape:
        raise InputError(f"{who}: {what} gives {told(found.flat[0])}; give one number for each")
    if not np.all(np.isfinite(found)):
        raise InputError(f"{who}: {what} is not finite everywhere; fix it")


def _pairs(n: int) -> tuple[np.ndarray, np.ndarray]:
    """Return pairs of principal strains, distant and close, always the same; shape (n, m) each."""
    numbers = np.random.default_rng(0)
    one, way = numbers.normal(size=(2, n, STRAINS))
    alone = np.repeat(np.eye(n), 2, axis=1) * np.tile([1.0, -1.0], n)
    even = np.outer(np.ones(n), [1.0, -1.0])
    corners = np.concatenate([alone, even], axis=1)
    ends = np.concatenate([one, one, one, corners], axis=1)
    ways = np.concatenate([way, way / 10, way / 100, -np.roll(corners, 1, axis=1)], axis=1)
    return ends, ends + ways


def _ordered(strains: np.ndarray) -> np.ndarray:
    """Return the strains, largest first."""
    return -np.sort(-strains, axis=0)


def _strain(principal: np.ndarray) -> str:
    numbers = ", ".join(f"{value:.3g}" for value in _ordered(principal))
    return f"the principal strains ({numbers})"

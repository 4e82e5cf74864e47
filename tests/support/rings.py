"""Rings under pressure from within, whose displacement and stress are known: Lame's cylinder."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np

from staffa.case.reading.read import parse_case
from staffa.evolution.problem import Problem
from staffa.evolution.system import System, build
from staffa.minimize.alternate import equilibrium
from staffa.model.fields import at_vertices, vertices
from staffa.setup.build import problem

INNER, OUTER = 0.1, 0.3
WALL = OUTER - INNER
# A block that becomes a quarter of the ring: x runs across the wall, the last axis along it.
CASE = """
[domain]
size = {size}
h = {h}
cells = "{cells}"
[material]
nu = {nu}
Gc = 1e6
{plane}
[damage]
ell = {h}
allow_coarse = true
[temperature]
profile = "none"
[forces]
left = {{ pressure = 1.0 }}
[solver]
displacement = "direct"
[supports]
bottom = "rollers"
top = "rollers"
{across}
[time]
t = [1.0]
"""


@dataclass(frozen=True, kw_only=True)
class Widened:
    """A ring in equilibrium: mean radial displacement at the inner side, and the largest
    difference of the stress from Lame's over the pressure (root mean square over cells)."""

    inner: float
    stress: float


def quarter(cells: str, n: int, nu: float, settings: Sequence[str] = ()) -> Problem:
    """A quarter of the ring, plane strain or a slice of it between rollers.

    cells: of a block; n: so many across the wall.
    """
    solid, h = cells in ("hexahedron", "tetrahedron"), WALL / n
    text = CASE.format(
        size=[WALL, 2 * h, 1.5 * WALL] if solid else [WALL, 1.5 * WALL],
        h=h * (1 + 1e-6),
        cells=cells,
        nu=nu,
        plane="" if solid else 'plane = "strain"',
        across='front = "rollers"\nback = "rollers"' if solid else "",
    )
    made = problem(parse_case(text, settings))
    bent(made, last=2 if solid else 1)
    top = [replace(s, components={0: lambda x, t: 0.0}) for s in made.sides if s.side == "top"]
    return replace(made, sides=(*(s for s in made.sides if s.side != "top"), *top))


def bent(made: Problem, *, last: int) -> None:
    """Bend the block of a problem into the quarter of a ring: the top then faces x = 0."""
    x = made.domain.mesh.geometry.x
    radius, angle = INNER + x[:, 0], np.pi / 2 * x[:, last] / (1.5 * WALL)
    x[:, 0], x[:, last] = radius * np.cos(angle), radius * np.sin(angle)


def lame(nu: float, radius: float | np.ndarray) -> float | np.ndarray:
    """Radial displacement in plane strain, E = 1, pressure 1."""
    a, b = INNER, OUTER
    return (1 + nu) * a**2 / (b**2 - a**2) * ((1 - 2 * nu) * radius + b**2 / radius)


def in_equilibrium(made: Problem) -> System:
    """Its forces put on, without damage. The caller destroys it."""
    system = build(made)
    system.energy.external.at(1.0)
    equilibrium(system.alternation, system.supports.values(1.0))
    return system


def widened(made: Problem) -> Widened:
    """Answer of a ring to the pressure."""
    system = in_equilibrium(made)
    try:
        last = made.domain.dim - 1
        x, u = vertices(system.spaces.alpha), at_vertices(system.state.u, system.spaces)
        radius = np.hypot(x[:, 0], x[:, last])
        inner = np.abs(radius - INNER) < 1e-6
        moved = (u[:, 0] * x[:, 0] + u[:, last] * x[:, last]) / radius
        return Widened(inner=float(moved[inner].mean()), stress=_off(system, made, last))
    finally:
        system.destroy()


def _off(system: System, made: Problem, last: int) -> float:
    """Radial stress in the middle of cells less Lame's, over the pressure."""
    x = made.domain.mesh.geometry.x[made.domain.mesh.geometry.dofmaps[0]].mean(axis=1)
    radius = np.hypot(x[:, 0], x[:, last])
    n = np.column_stack([x[:, 0], 0 * radius, x[:, last]] if last == 2 else [x[:, 0], x[:, 1]])
    n /= radius[:, None]
    dim = made.domain.dim
    found = np.einsum("ci,cij,cj->c", n, system.energy.stress()[:, :dim, :dim], n)
    a, b = INNER, OUTER
    right = a**2 / (b**2 - a**2) * (1 - b**2 / radius**2)
    return float(np.sqrt(np.mean((found - right) ** 2)))

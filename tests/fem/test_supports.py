"""Supports hold what they say, and pins remove rigid motions without bending anything."""

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest
from dolfinx import fem

from staffa.errors import InputError
from staffa.evolution.apply_loads import change_loads
from staffa.evolution.equilibrate import Loads
from staffa.evolution.march import march
from staffa.evolution.system import build
from staffa.minimize.alternate import equilibrium, support_reactions
from staffa.model.fields import linear_spaces, owned, vertices
from staffa.model.supports import build_supports, clamped, rigid_modes, rollers
from support.bodies import Unbreakable, body, quench, rock

SIZES = {2: (1.0, 0.6), 3: (1.0, 0.6, 0.7)}


class Uniform:
    """The same temperature everywhere."""

    def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
        """Minus five at any time."""
        return np.full(x.shape[1], -5.0)


def sound(dim: int):
    return rock(law=Unbreakable(), state="plane stress" if dim == 2 else "solid", ell=0.3)


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("anchor", [None, "top", "left"])
def test_free_body_shrinks_without_stress(dim: int, anchor: str | None) -> None:
    problem = body(SIZES[dim], 0.1, load=Uniform(), material=sound(dim), anchor=anchor)
    system = build(problem)
    (step,) = march(problem, system)
    assert step.energies.elastic < 1e-20
    u, x = owned(system.state.u).reshape(-1, dim), vertices(system.spaces.u)[:, :dim]
    gap = u - u.mean(axis=0) + 5.0 * (x[: len(u)] - x[: len(u)].mean(axis=0))
    assert np.abs(gap).max() < 1e-10, "uniform cooling is uniform shrinking"
    system.destroy()


@pytest.mark.parametrize("dim", [2, 3])
def test_pins_carry_no_reaction(dim: int) -> None:
    face_load = quench(3.0)
    problem = body(SIZES[dim], 0.1, load=face_load, times=(0.02,), material=sound(dim))
    system = build(problem)
    parts, values = system.alternation, np.zeros(len(system.supports.fixed))
    assert len(values) == {2: 3, 3: 6}[dim], "as many pins as rigid motions"
    equilibrium(parts, values)
    change_loads(problem, system, Loads(time=0.0, values=values), Loads(time=0.02, values=values))
    assert np.abs(support_reactions(parts)).max() < 1e-10 * parts.elastic.load.norm()
    system.destroy()


@pytest.mark.parametrize("anchor", [None, "bottom", "left"])
def test_where_the_pins_are_does_not_matter(anchor: str | None) -> None:
    def energy(where: str | None) -> float:
        problem = body(
            (1.0, 0.6), 0.05, load=quench(3.0), times=(0.02,), material=sound(2), anchor=where
        )
        system = build(problem)
        (step,) = march(problem, system)
        system.destroy()
        return step.energies.elastic

    assert energy(anchor) == pytest.approx(energy("top"), rel=1e-10)


@pytest.mark.parametrize(
    ("sides", "pins"),
    [
        ([], 3),
        (["left"], 1),
        (["left", "right"], 1),
        (["left", "bottom"], 0),
    ],
)
def test_as_many_pins_as_rollers_leave_motions(sides: list[str], pins: int) -> None:
    domain = body((1.0, 0.6), 0.2).domain
    spaces = linear_spaces(domain)
    held = [rollers(domain, side) for side in sides]
    on_rollers = np.zeros(0, dtype=int)
    for side in sides:
        found = fem.locate_dofs_topological(spaces.alpha, 1, domain.facets(side))
        on_rollers = np.union1d(on_rollers, found * 2 + (side == "bottom"))
    supports = build_supports(domain, spaces, held)
    assert len(supports.fixed) == len(on_rollers) + pins


def test_clamped_body_needs_no_pin() -> None:
    domain = body(SIZES[3], 0.35).domain
    spaces = linear_spaces(domain)
    found = fem.locate_dofs_topological(spaces.alpha, 2, domain.facets("bottom"))
    assert len(build_supports(domain, spaces, [clamped(domain, "bottom")]).fixed) == 3 * len(found)


@pytest.mark.parametrize("dim", [2, 3])
def test_rigid_modes_store_no_energy(dim: int) -> None:
    problem = body(SIZES[dim], 0.2, material=sound(dim))
    system = build(problem)
    matrix = system.alternation.elastic.stiffness
    system.energy.stiffness(matrix)
    vector = matrix.createVecRight()
    for mode in rigid_modes(problem.domain, system.spaces).T:
        vector.array_w[:] = mode[: len(vector.array_r)]
        assert (matrix * vector).norm() < 1e-12 * matrix.norm() * vector.norm()
    system.destroy()


def test_unknown_side_is_named() -> None:
    domain = body((1.0, 0.6), 0.3).domain
    with pytest.raises(InputError, match=r"no boundary 'botom'.*Did you mean 'bottom'"):
        rollers(domain, "botom")

"""The toughness that a mesh really has: that of a straight crack, measured on the same cells."""

from staffa.stack import MPI

import numpy as np

from staffa.domain import block
from staffa.energy import Energy
from staffa.evolution.problem import Material
from staffa.evolution.system import bounded_energy, bounded_solver, rock
from staffa.fields import linear_spaces, unit_bounds, vertices, zero_state

# Half width of the strip in ell: AT1's profile ends at 2, AT2's has fallen to exp(-8) = 3e-4.
REACH = 8


def discrete_toughness(material: Material, *, dim: int, h: float, cells: str) -> float:
    """Surface energy of a unit of straight crack over Gc, on cells of edge h.

    One layer of cells of a strip is broken (alpha = 1), the damage around it is minimized without
    any load; expected 1 + h/(4 c_w ell) up to the discretization of the profile. Not collective:
    each rank that calls it works alone.
    """
    columns = 2 * int(np.ceil(REACH * material.ell / h)) + 1
    size = (columns * h, *[2 * h] * (dim - 1))
    strip = block(MPI.COMM_SELF, size=size, h=h, cells=cells)
    spaces = linear_spaces(strip)
    state, bounds = zero_state(strip, spaces), unit_bounds(strip, spaces)
    x = vertices(spaces.alpha)[:, 0]
    broken = np.abs(x - size[0] / 2) <= 0.5001 * h
    bounds.lower.x.array[broken] = 1.0
    state.alpha.x.array[broken] = 1.0
    uniform = Material(**{**vars(material), "toughness": lambda x: np.ones(x.shape[1])})
    energy = Energy(domain=strip, spaces=spaces, state=state, rock=rock(uniform, spaces))
    damage = bounded_energy(energy)
    solver = bounded_solver("snes", damage, 1e-6, of="toughness")
    try:
        solver.minimize(state.alpha.x.petsc_vec, bounds.lower.x.petsc_vec, bounds.upper.x.petsc_vec)
        return energy.crack_length() / float(np.prod(size[1:]))
    finally:
        solver.destroy()
        damage.matrix.destroy()
        damage.unit.destroy()

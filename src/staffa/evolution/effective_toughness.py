"""Effective Gc of a mesh: that of a straight crack, measured on the same cells."""

from staffa.backend.stack import MPI

import numpy as np

from staffa.backend.parallel import on_root
from staffa.evolution.coefficients import CellValues, rock
from staffa.evolution.problem import Material, Problem
from staffa.evolution.system import bounded_energy, bounded_solver
from staffa.geometry.block import UNSTRUCTURED, divisions
from staffa.model.domain import block
from staffa.model.energy import Energy
from staffa.model.fields import linear_spaces, unit_bounds, zero_state
from staffa.model.initial_cracks import FlatCrack, broken
from staffa.physics.material import AXIAL, PLANE_STRAIN, SOLID
from staffa.physics.trial import law_values

# Half width of the strip in ell: AT1's profile ends at 2, AT2's has fallen to exp(-8) = 3e-4.
REACH = 8
# Extent of the crack in h. On blocks Gc is the same all along. Over unstructured cells, whose layer
# is uneven, it is a mean, which scatters from mesh to mesh by 0.3 % (2-D) and 1 % (3-D).
BLOCKS, UNEVEN = 2, {2: 160, 3: 12}


_measured: dict[tuple[object, ...], float] = {}


def effective_gc_ratio(problem: Problem) -> float:
    """Return effective Gc over Gc of a problem's cells, measured once. Collective."""
    domain, material = problem.domain, problem.material
    law, plane = material.law, _state(material, domain.dim)
    key = (type(law), law_values(law), plane, domain.dim, domain.cell_kind, material.ell, domain.h)

    def measured() -> float:
        return effective_gc(material, dim=domain.dim, h=domain.h, cells=domain.cell_kind)

    if key not in _measured:
        _measured[key] = on_root(domain.comm, measured)
    return _measured[key]


def effective_gc(material: Material, *, dim: int, h: float, cells: str) -> float:
    """Return the surface energy of a unit of straight crack over Gc.

    The cells that the middle line of a strip cuts are broken (alpha = 1), and the damage around
    them is minimized without load. Expected is 1 + h/(4 c_w ell), up to the discretization of the
    profile, if the cells are one layer. Not collective: each rank that calls it works alone.

    Parameters
    ----------
    material : the rock, with law and ell.
    dim : 2 or 3.
    h : mesh size (m).
    cells : shape of the cells, as `block` takes it.
    """
    columns = 2 * divisions((REACH * material.ell,), h)[0] + 1
    extent = UNEVEN[dim] if cells == UNSTRUCTURED else BLOCKS
    size = (columns * h, *[extent * h] * (dim - 1))
    strip = block(MPI.COMM_SELF, size=size, h=h, cells=cells)
    spaces = linear_spaces(strip)
    state, bounds = zero_state(spaces), unit_bounds(spaces)
    middle = FlatCrack(center=(size[0] / 2, 0.0, 0.0), normal=(1.0, 0.0, 0.0), radius=np.inf)
    layer = broken(spaces.alpha, middle, h=h)
    bounds.lower.x.array[layer] = 1.0
    state.alpha.x.array[layer] = 1.0
    uniform = Material(
        E=1.0,
        nu=0.0,
        Gc=1.0,
        expansion=0.0,
        ell=material.ell,
        law=material.law,
        state=_state(material, dim),
    )
    rock_of_strip = rock(CellValues(strip, uniform, {}))
    energy = Energy(domain=strip, spaces=spaces, state=state, rock=rock_of_strip)
    damage = bounded_energy(energy)
    solver = bounded_solver("snes", damage, 1e-6, of="toughness")
    try:
        solver.minimize(state.alpha.x.petsc_vec, bounds.lower.x.petsc_vec, bounds.upper.x.petsc_vec)
        return energy.crack_length() / float(np.prod(size[1:]))
    finally:
        solver.destroy()
        damage.matrix.destroy()
        damage.unit.destroy()


def _state(material: Material, dim: int) -> str:
    """Return the state of the strip; far from the axis a crack around it is a straight one."""
    if dim == 3:
        return SOLID
    return PLANE_STRAIN if material.state == AXIAL else material.state

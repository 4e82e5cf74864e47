"""Cracks of rock whose toughness has directions: what straight ones cost, where growing ones go."""

from dataclasses import dataclass, replace

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest
from scipy.special import erfc

from staffa.evolution.coefficients import energy_of
from staffa.evolution.effective_toughness import effective_gc
from staffa.evolution.march import march
from staffa.evolution.problem import Material
from staffa.evolution.system import bounded_energy, bounded_solver, build
from staffa.model.fields import linear_spaces, unit_bounds, vertices, zero_state
from staffa.model.initial_cracks import FlatCrack, broken
from staffa.model.supports import SideSupport, no_displacement
from staffa.physics.damage import AT1, AT2
from staffa.physics.elasticity import Elasticity
from support.bodies import body, needs_gmsh, rock

CRACKED = 0.9


def roughness(ratio: float, angle: float) -> np.ndarray:
    """A of a rock that is `ratio` times as tough across its second axis as across its first, which
    lies at this angle (degrees) to x; of cracks across the first Gc is that of the rock."""
    c, s = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    axes = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
    return axes.T @ np.diag([1.0, ratio**2, 1.0]) @ axes


def normal_at(angle: float) -> np.ndarray:
    return np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0.0])


def cost_of_cracks(material: Material, angle: float, radii, *, margin, h, cells) -> float:
    """Surface energy over length of a straight crack in a plate, its normal at this angle to x, the
    damage beside it minimized without any load.

    By two half lengths (ell = 1), so that what the ends cost drops out.
    """
    size = 2 * (max(radii) + margin)
    problem = body((size, size), h, cells=cells, material=material)
    spaces = linear_spaces(problem.domain)
    found = []
    for radius in radii:
        state, bounds = zero_state(spaces), unit_bounds(spaces)
        crack = FlatCrack(
            center=(size / 2, size / 2, 0.0), normal=tuple(normal_at(angle)), radius=radius
        )
        layer = broken(spaces.alpha, crack, h=problem.domain.h)
        state.alpha.x.array[layer] = bounds.lower.x.array[layer] = 1.0
        energy = energy_of(problem, spaces, state)
        damage = bounded_energy(energy)
        solver = bounded_solver("snes", damage, 1e-6, of="crack")
        solver.minimize(state.alpha.x.petsc_vec, bounds.lower.x.petsc_vec, bounds.upper.x.petsc_vec)
        found.append(energy.energies().surface)
        for thing in (solver, damage.matrix, damage.unit):
            thing.destroy()
    return (found[1] - found[0]) / (2 * (radii[1] - radii[0]))


def cost(A: np.ndarray, angle: float) -> float:
    """sqrt(n . A n)."""
    n = normal_at(angle)
    return float(np.sqrt(n @ A @ n))


@pytest.mark.parametrize("law", [AT1(), AT2()], ids=["AT1", "AT2"])
@pytest.mark.parametrize("axis", [0.0, 35.0, 90.0])
def test_a_straight_crack_along_cells_costs_what_its_normal_says(law, axis: float) -> None:
    """Gc sqrt(n . A n), by the discrete toughness of a profile that is sqrt(n . A n) ell wide."""
    A = roughness(2.0, axis)
    material = rock(ell=1.0, law=law, roughness=A, Gc=3.0)
    # AT2's profile along the crack ends as exp(-distance/2), of which the square counts: 1e-4.
    lengths = {"radii": (8.0, 10.0), "margin": 9.0}
    found = cost_of_cracks(material, 0.0, **lengths, h=0.5, cells="quadrilateral")
    wide = replace(material, ell=cost(A, 0.0), roughness=None)
    factor = effective_gc(wide, dim=2, h=0.5, cells="quadrilateral")
    assert found == pytest.approx(3.0 * cost(A, 0.0) * factor, rel=1e-3)


@pytest.mark.long
@pytest.mark.slow
@needs_gmsh
@pytest.mark.parametrize("angle", [-60.0, -20.0, 75.0])
def test_a_straight_crack_costs_what_its_normal_says_at_any_angle(angle: float) -> None:
    """On cells that favor no direction, within what their uneven layers scatter."""
    A = roughness(2.0, 30.0)
    material = rock(ell=1.0, roughness=A)
    lengths = {"radii": (3.0, 8.0), "margin": 5.0}
    found = cost_of_cracks(material, angle, **lengths, h=0.25, cells="unstructured")
    wide = replace(material, ell=cost(A, angle), roughness=None)
    factor = effective_gc(wide, dim=2, h=0.25, cells="unstructured")
    assert found == pytest.approx(cost(A, angle) * factor, rel=0.02)


@dataclass(frozen=True, kw_only=True)
class ColdFront:
    """Cold by dT behind a front that moves up from `start` by 1 in a unit of time."""

    dT: float
    start: float
    width: float

    def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
        """See `Load`."""
        return -self.dT / 2 * erfc((x[1] - self.start - t) / self.width)


def direction(A: np.ndarray, uneven: float = 0.0) -> tuple[float, float]:
    """The angle from y (degrees, to the left) of the straight crack that costs least for each unit
    of height, and this cost over Gc.

    uneven: what each unit of length costs besides Gc sqrt(n . A n): h/(4 c_w ell), or measured.
    """
    slope = np.linspace(-4.0, 4.0, 80_001)
    costs = np.sqrt(A[0, 0] + 2 * A[0, 1] * slope + A[1, 1] * slope**2)
    costs += uneven * np.sqrt(1 + slope**2)
    least = int(costs.argmin())
    return float(np.degrees(np.arctan(slope[least]))), float(costs[least])


@dataclass(frozen=True, kw_only=True)
class Path:
    """A crack that turned: its angle from y (degrees, to the left), its vertices, shape (n, 2), and
    those of them that the angle is of."""

    angle: float
    x: np.ndarray
    fitted: np.ndarray


def along(stiffness: Elasticity) -> float:
    """Young's modulus of a pull along x."""
    return float(1 / np.linalg.inv(stiffness.stiffness(np.zeros((3, 1)))[0])[0, 0])


def turning(
    A: np.ndarray,
    *,
    cells_per_ell: float,
    width: float,
    rise: float,
    stiffness: Elasticity | None = None,
) -> Path:
    """A crack that follows a cold front through a plate whose ends are held, from a notch.

    Steady, each unit of height that front and crack move up releases the same energy, and costs
    Gc sqrt(n . A n)/cos(theta), n = (cos theta, sin theta): least at tan theta = -A_xy/A_yy. That
    is a minimum among all cracks; one that grows finds it because nothing depends on x: the whole
    force on its tip along x is zero, which is the same condition (Hakim and Karma, J. Mech. Phys.
    Solids 57, 342, 2009).

    width: of the plate (ell). Its ends attract or repel the crack, by what is odd about its middle:
    the notch is put where the crack crosses the middle halfway, and the angle is that of a line
    through all of this rise but `width`/8 at its beginning and 2 ell at its end. rise: how far the
    crack runs up (ell). stiffness: of the rock, if it has directions, too: no matter for the angle.
    """
    h, notch, front = 1 / cells_per_ell, 0.6 * width, 4.0
    angle, least = direction(A, uneven=3 / 8 * h)
    # A third more than it costs: it runs as the front does, and nothing else cracks.
    modulus = 1.0 if stiffness is None else along(stiffness)
    dT = np.sqrt(2 * 1.33 * least / (width * modulus))
    start = width / 2 + np.tan(np.radians(angle)) * rise / 2
    crack = FlatCrack(center=(start, 0.0, 0.0), normal=(1.0, 0.0, 0.0), radius=notch)
    problem = body(
        (width, notch + rise + 4.0),
        h,
        cells="unstructured",
        material=rock(ell=1.0, roughness=A, elasticity=stiffness, cracks=(crack,)),
        load=ColdFront(dT=dT, start=notch, width=front),
        sides=tuple(
            SideSupport(side=s, components={0: no_displacement}) for s in ("left", "right")
        ),
        times=tuple(np.arange(0.0, 2 * rise + front, 1.5)[1:]),
    )
    system = build(problem)
    x, alpha = vertices(system.spaces.alpha)[:, :2], system.state.alpha.x.array
    try:
        for step in march(problem, system):
            assert not step.audit.violations
            top = x[alpha > CRACKED, 1].max()
            if top > notch + rise:
                break
        path = x[alpha > CRACKED]
    finally:
        system.destroy()
    end = min(top, notch + rise) - 2.0  # its last step may carry it far beyond
    fitted = path[(path[:, 1] > notch + width / 8) & (path[:, 1] < end)]
    slope = np.polyfit(fitted[:, 1], fitted[:, 0], 1)[0]
    return Path(angle=float(-np.degrees(np.arctan(slope))), x=path, fitted=fitted)


@pytest.mark.long
@pytest.mark.slow
@needs_gmsh
def test_a_crack_behind_a_cold_front_turns_by_the_angle_that_costs_least() -> None:
    A = roughness(2.0, 45.0)
    expected, _ = direction(A)
    assert np.tan(np.radians(expected)) == pytest.approx(-A[0, 1] / A[1, 1], abs=1e-4)
    found = turning(A, cells_per_ell=3, width=14.0, rise=14.0)
    assert found.angle == pytest.approx(expected, abs=3.0), f"{found.angle:.1f} degrees"

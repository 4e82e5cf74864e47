"""Small problems that several tests share."""

from dataclasses import replace

from staffa.backend.stack import MPI

import numpy as np
import pytest

from staffa.evolution.march import march
from staffa.evolution.problem import Material, Problem, Solvers
from staffa.evolution.schedule import Schedule, schedule
from staffa.evolution.system import build
from staffa.loads.closed_form import Face, HalfSpace, Load, NoLoad
from staffa.model.domain import block
from staffa.model.supports import SideSupport
from staffa.physics.damage import AT1
from staffa.records.step import Step, Stop


def _has_gmsh() -> bool:
    try:
        import gmsh  # noqa: F401
    except (ImportError, OSError):  # it, or a library of the system that it needs
        return False
    return True


needs_gmsh = pytest.mark.skipif(not _has_gmsh(), reason="Gmsh cannot be loaded here")
UNSTRUCTURED = pytest.param("unstructured", marks=needs_gmsh)
# On two ranks most parts run in whole cases as well.
RANKS = [pytest.param(2, marks=pytest.mark.long), 3]
BOTTOM = Face(axis=1, position=0.0, inward=1)


class Unbreakable(AT1):
    """A law that never damages: the stiffness does not depend on alpha."""

    name = "unbreakable"

    def a(self, alpha):
        """No loss."""
        return 1 + 0 * alpha


def rock(**changes) -> Material:
    """E = Gc = expansion = 1, plane stress, AT1."""
    scaled = Material(
        E=1.0, nu=0.2, Gc=1.0, expansion=1.0, ell=0.1, law=AT1(), state="plane stress"
    )
    return replace(scaled, **changes)


def body(
    size: tuple[float, ...],
    h: float,
    *,
    cells: str | None = None,
    load: Load | None = None,
    times=(1.0,),
    sides: tuple[SideSupport, ...] = (),
    stop: Stop | None = None,
    material: Material | None = None,
    displacement: str = "direct",
    damage: str = "tao",
    comm: MPI.Comm = MPI.COMM_WORLD,
    **more,
) -> Problem:
    """A block of rock."""
    default = "quadrilateral" if len(size) == 2 else "hexahedron"
    return Problem(
        domain=block(comm, size=size, h=h, cells=cells or default),
        material=material or rock(),
        load=load or NoLoad(),
        schedule=times if isinstance(times, Schedule) else schedule(tuple(times)),
        sides=sides,
        solvers=Solvers(
            displacement=displacement,
            damage=damage,
            stop=stop or Stop(change=1e-4, residual=1e-2),
        ),
        **more,
    )


def quench(dT: float) -> HalfSpace:
    """The bottom dropped by dT, kappa = 1."""
    return HalfSpace(dT=dT, kappa=1.0, face=BOTTOM)


def rates(errors, steps) -> np.ndarray:
    """Observed orders of convergence between successive steps."""
    errors, steps = np.asarray(errors), np.asarray(steps)
    return np.log(errors[1:] / errors[:-1]) / np.log(steps[1:] / steps[:-1])


def run(problem: Problem) -> list[Step]:
    """Every step as it comes, superseded ones too."""
    system = build(problem)
    try:
        return list(march(problem, system))
    finally:
        system.destroy()

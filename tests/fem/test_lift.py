"""The state of a mesh on a finer one whose cells lie in its own."""

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest
from dolfinx import fem

from staffa.evolution.session import Session
from staffa.evolution.system import build
from staffa.model.block_parts import middles
from staffa.model.domain import local_edges
from staffa.model.fields import vertices
from staffa.model.refinement import Wanted
from staffa.setup.build import problem
from support.refining import refining

QUADRATIC = "domain.elements=quadratic"


def _linear(x: np.ndarray) -> np.ndarray:
    return 0.2 + 0.3 * x[0] + 0.1 * x[1]


def _turned(x: np.ndarray) -> np.ndarray:
    return np.stack([1 + 2 * x[0] - x[1], x[0] + 3 * x[1]])


def _in_cells(field: fem.Function) -> np.ndarray:
    """Numbers that differ to the left and right of the middle, and from component to component."""
    x = middles(field.function_space.mesh)
    width = field.function_space.dofmap.index_map_bs
    return (np.sign(x[0] - 0.5)[:, None] * (1 + np.arange(width))).ravel()


def errors_of_lift(*settings: str) -> list[float]:
    """Largest error of each field after half of the body was split; of its ghosts too."""
    setup = problem(refining("damage.split=contact", *settings))
    session = Session(setup, build(setup))
    state, system = session.state, session.system
    state.u.interpolate(_turned)
    for field in (state.T, state.alpha, system.bounds.lower):
        field.interpolate(_linear)
    for field in system.energy.frozen:
        field.x.array[:] = _in_cells(field)
    edges, before = local_edges(session.domain), session.domain.mesh.topology.index_map(2)
    wanted = Wanted.nothing(len(edges))
    wanted.edge[middles(session.domain.mesh)[0, : len(edges)] < 0.5] = 0.0
    session.refine(wanted)
    assert session.domain.mesh.topology.index_map(2).size_global > 5 * before.size_global
    state, system = session.state, session.system
    fields = (state.T, state.alpha, system.bounds.lower)
    found = [np.abs(f.x.array - _linear(vertices(f.function_space).T)).max() for f in fields]
    expected = fem.Function(state.u.function_space)
    expected.interpolate(_turned)
    found.append(np.abs(state.u.x.array - expected.x.array).max())
    assert system.energy.frozen, "faces of cracks are kept in cells"
    found += [np.abs(field.x.array - _in_cells(field)).max() for field in system.energy.frozen]
    session.destroy()
    return [float(error) for error in found]


@pytest.mark.parametrize(
    "settings",
    [(), pytest.param((QUADRATIC,), marks=pytest.mark.slow)],
    ids=["linear", "quadratic"],
)
def test_a_state_passes_to_a_finer_mesh(settings: tuple[str, ...]) -> None:
    """Linear fields exactly, and what cells have goes to the cells in them."""
    assert max(errors_of_lift(*settings)) < 1e-12

"""Unstructured cells fill the body, favor no direction, and crack and cool as blocks do."""

import subprocess
import sys
from dataclasses import replace

from staffa.backend.stack import MPI

import numpy as np
import pytest

from fem.test_domain import areas, corners
from fem.test_measures import gauge
from staffa.errors import StaffaError
from staffa.evolution.march import march
from staffa.evolution.problem import Problem
from staffa.evolution.system import build
from staffa.geometry import block_simplices
from staffa.geometry.block import SIDES, cells_and_vertices
from staffa.measure.crack import damaged_layer
from staffa.model.domain import Domain, block, cell_count
from staffa.model.fields import linear_spaces, vertices
from support.bodies import body, needs_gmsh, quench, rock

pytestmark = needs_gmsh
SHAPES = {2: ((1.5, 0.4), 0.05), 3: ((1.2, 0.8, 0.4), 0.1)}


def made(dim: int, cells: str = "unstructured") -> Domain:
    """A body whose extents differ."""
    size, h = SHAPES[dim]
    return block(MPI.COMM_SELF, size=size, h=h, cells=cells)


def edges(domain: Domain, *, margin: float = 0.0) -> np.ndarray:
    """Every edge whose middle is this far from the sides (m), as a vector, shape (n, dim)."""
    domain.mesh.topology.create_connectivity(1, 0)
    ends = domain.mesh.topology.connectivity(1, 0).array.reshape(-1, 2)
    space = linear_spaces(domain).alpha
    points = np.zeros((domain.mesh.topology.index_map(0).size_local, 3))
    cell_vertices = domain.mesh.topology.connectivity(domain.dim, 0).array
    points[cell_vertices] = vertices(space)[space.dofmap.list.ravel()]
    a, b = points[ends[:, 0], : domain.dim], points[ends[:, 1], : domain.dim]
    inside = np.abs((a + b) / 2 - np.array(domain.size) / 2) <= np.array(domain.size) / 2 - margin
    return (b - a)[inside.all(axis=1)]


def volume(domain: Domain) -> float:
    """Sum of the cells' areas or volumes, each from its corners."""
    space = linear_spaces(domain).alpha
    x = vertices(space)[space.dofmap.list][..., : domain.dim]
    return float(np.abs(np.linalg.det(x[:, 1:] - x[:, :1])).sum() / [1, 2, 6][domain.dim - 1])


@pytest.mark.parametrize("dim", SHAPES)
def test_the_cells_fill_the_body_and_every_side(dim: int) -> None:
    domain = made(dim)
    size = domain.size
    assert volume(domain) == pytest.approx(np.prod(size), rel=1e-12)
    for side, (axis, end) in SIDES[dim].items():
        facets = corners(domain, side)
        assert areas(facets).sum() == pytest.approx(np.prod(size) / size[axis], rel=1e-12), side
        assert set(facets[..., axis].ravel()) == {size[axis] if end > 0 else 0.0}, side


@pytest.mark.parametrize("dim", SHAPES)
def test_the_mean_edge_is_h(dim: int) -> None:
    mean = np.linalg.norm(edges(made(dim)), axis=1).mean() / SHAPES[dim][1]
    assert mean == pytest.approx(1.0, abs=0.1), f"the mean edge is {mean:.3f} h"


@pytest.mark.parametrize(
    ("size", "h"),
    [
        ((5.0, 1.0), 0.05),
        ((1.0, 1.0), 0.1),
        ((3.0, 0.1), 0.02),
        ((1.0, 0.8, 0.6), 0.1),
        ((4.0, 0.4, 0.4), 0.1),
        ((1.0, 1.0, 0.5), 0.1),
    ],
)
def test_check_foretells_cells_and_vertices_within_ten_percent(size, h: float) -> None:
    domain = block(MPI.COMM_SELF, size=size, h=h, cells="unstructured")
    count = linear_spaces(domain).alpha.dofmap.index_map.size_global
    found, foretold = (cell_count(domain), count), cells_and_vertices(size, h, "unstructured")
    assert foretold == pytest.approx(found, rel=0.1), f"{found} cells and vertices, not {foretold}"


def order(domain: Domain, fold: int) -> float:
    """|mean exp(i fold theta)| over the directions theta of all edges, 0 if they are equal."""
    x, y = edges(domain).T
    return float(np.abs(np.exp(1j * fold * np.arctan2(y, x)).mean()))


@pytest.mark.parametrize("fold", [2, 4, 6, 8])
def test_no_direction_is_preferred(fold: int) -> None:
    """Order of 9000 edges: a triangular lattice has 1 of fold 6, four triangles a square .33."""
    domain = block(MPI.COMM_SELF, size=(2.0, 1.0), h=0.03, cells="unstructured")
    found = order(domain, fold)
    assert found < 0.06, f"edges are ordered {fold}-fold by {found:.3f}"


@pytest.mark.parametrize(("cells", "most"), [("quadrilateral", 0.9), ("triangle", 0.3)])
def test_blocks_prefer_directions_by_the_same_measure(cells: str, most: float) -> None:
    domain = block(MPI.COMM_SELF, size=(2.0, 1.0), h=0.03, cells=cells)
    assert order(domain, 4) > most, f"{order(domain, 4):.3f}"


def anisotropy(domain: Domain) -> float:
    """Error of the mean of d_i d_j from 1/3, and of the sum of d_i^4 from 3/5; d: of length 1."""
    way = edges(domain, margin=2 * domain.h)
    d = way / np.linalg.norm(way, axis=1)[:, None]
    second = np.abs(np.linalg.eigvalsh(d.T @ d / len(d)) - 1 / 3).max()
    return float(max(second, np.abs((d**4).sum(axis=1).mean() - 3 / 5)))


def test_no_direction_is_preferred_in_space() -> None:
    """Away from the sides, in which edges must lie."""
    bodies = (
        block(MPI.COMM_SELF, size=(1.0, 1.0, 1.0), h=0.1, cells=cells)
        for cells in ("unstructured", "tetrahedron")
    )
    found, lattice = map(anisotropy, bodies)
    assert found < 0.03 < 0.1 < lattice, f"{found:.3f}, and {lattice:.3f} of the block's"


def test_the_same_body_gives_the_same_mesh_and_another_another() -> None:
    def identity(size: tuple[float, ...], h: float) -> str:
        return block(MPI.COMM_SELF, size=size, h=h, cells="unstructured").identity

    same = identity((1.0, 0.5), 0.1)
    assert same == identity((1.0, 0.5), 0.1)
    assert len({same, identity((1.0, 0.6), 0.1), identity((1.0, 0.5), 0.09)}) == 3


def test_a_body_of_micrometers_is_meshed_like_one_of_meters() -> None:
    counts = [
        cell_count(block(MPI.COMM_SELF, size=(1.5 * s, 0.4 * s), h=0.05 * s, cells="unstructured"))
        for s in (1.0, 1e-6)
    ]
    assert counts[0] == counts[1], f"{counts} cells"


def test_the_coarser_body_has_cells_twice_as_long_until_they_are_as_long_as_the_body() -> None:
    domain, steps = made(2), 0
    assert domain.h == 0.05
    while domain.coarser is not None:
        domain, steps = domain.coarser(), steps + 1
    assert steps == 3 and domain.h == pytest.approx(0.4), f"{steps} steps, to h = {domain.h}"
    assert domain.facets("left").size >= 1 and volume(domain) == pytest.approx(0.6)


def test_what_gmsh_cannot_mesh_is_an_error_that_names_the_key(monkeypatch) -> None:
    def fail(gmsh, size):
        raise Exception("PLC Error")

    monkeypatch.setattr(block_simplices, "_meshed", fail)
    with pytest.raises(StaffaError, match=r'domain.cells = "unstructured".*h = 0.05 .PLC Error'):
        made(2)


def test_a_gmsh_that_the_caller_has_open_stays_open_with_its_model() -> None:
    import gmsh

    gmsh.initialize()
    try:
        gmsh.model.add("own")
        made(2)
        assert gmsh.isInitialized() and "own" in gmsh.model.list()
        assert "staffa" not in gmsh.model.list()
    finally:
        gmsh.finalize()


def cooled(cells: str, *, h: float = 0.02, **changes: str) -> Problem:
    """A slab whose lower edge breaks up; uneven, so that no round-off decides where."""

    def uneven(x: np.ndarray) -> np.ndarray:
        return 1 + 0.05 * np.sin(23 * x[0] + 1) * np.cos(5 * x[0])

    made = body(
        (1.0, 0.5),
        h,
        cells=cells,
        load=quench(14.0),
        times=(0.0005, 0.001),
        anchor="top",
        material=rock(ell=0.12, toughness=uneven),
    )
    return replace(made, solvers=replace(made.solvers, **changes))


def energies(case: Problem) -> list[float]:
    system = build(case)
    found = [step.energies.total for step in march(case, system)]
    system.destroy()
    return found


@pytest.fixture(scope="module")
def of_the_slab() -> list[float]:
    """Energies of the cooled slab, by the presets of a case that names none."""
    return energies(cooled("unstructured"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "changes",
    [{"damage": "snes"}, {"displacement": "iterative"}, {"guess": "none"}],
    ids=lambda c: next(iter(c)),
)
def test_every_preset_breaks_the_slab_alike(
    changes: dict[str, str], of_the_slab: list[float]
) -> None:
    assert energies(cooled("unstructured", **changes)) == pytest.approx(of_the_slab, rel=1e-3)


@pytest.mark.slow
def test_squares_break_with_the_same_energies(of_the_slab: list[float]) -> None:
    """Within what one crack in another place makes: 2 %."""
    assert energies(cooled("quadrilateral")) == pytest.approx(of_the_slab, rel=0.02)


def test_a_first_guess_comes_from_the_coarser_cells() -> None:
    case = cooled("unstructured")
    system = build(case)
    assert system.coarser is not None and system.coarser.problem.domain.h == pytest.approx(0.04)
    first = next(iter(march(case, system)))
    system.destroy()
    assert first.effort.guesses == 1 and first.effort.refused == 0, f"{first.effort}"


def test_every_depth_of_a_layer_has_vertices_and_a_drawn_layer_is_found() -> None:
    """As bins of depth h see it: to half a bin."""
    h = 0.02
    case = cooled("unstructured", h=h, guess="none")
    system = build(case)
    depth = vertices(system.spaces.alpha)[:, 1]
    points = np.bincount(np.rint(depth / h).astype(int))
    assert points.min() >= 1 / h, f"{points.min()} vertices at a depth, {1 / h:.0f} cells long"
    for layer in (0.0, 0.1, 0.2):
        system.state.alpha.x.array[:] = np.where(depth < layer, 1.0, 0.0)
        found = damaged_layer(case.domain, system.state, gauge(h))
        assert abs(found - layer) <= 0.5001 * h, f"{found:.3f}, not {layer}"
    system.destroy()


def test_gmsh_leaves_the_signals_of_the_process_alone() -> None:
    """Else a run on its mesh dies of SIGTERM where it should save and say how to go on."""
    code = (
        "import os, signal\n"
        "from staffa.geometry.gmsh_model import open_gmsh\n"
        "heard = []\n"
        "for number in (signal.SIGTERM, signal.SIGINT):\n"
        "    signal.signal(number, lambda n, frame: heard.append(n))\n"
        "with open_gmsh('a mesh', 'do without'): os.kill(os.getpid(), signal.SIGTERM)\n"
        "os.kill(os.getpid(), signal.SIGTERM)\n"
        "os.kill(os.getpid(), signal.SIGINT)\n"
        "print(*heard)\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout == "15 15 2\n", done

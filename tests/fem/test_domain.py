"""The mesh of a block: its sides are where they are named, and its triangles lean nowhere."""

from staffa.backend.stack import MPI

import numpy as np
import pytest
from dolfinx import mesh as dmesh

from staffa.errors import InputError
from staffa.geometry.block import SIDES, cells_and_vertices, face_position
from staffa.model.domain import Domain, block, cell_count
from staffa.model.fields import linear_spaces, vertices

# Extents that differ along each axis, so that no two sides can be taken for one another.
BLOCKS = {
    "quadrilateral": (1.5, 0.4),
    "triangle": (1.5, 0.4),
    "hexahedron": (1.2, 0.8, 0.4),
    "tetrahedron": (1.2, 0.8, 0.4),
}
H = 0.1
NAMED = [(cells, side) for cells, size in BLOCKS.items() for side in SIDES[len(size)]]


def made(cells: str) -> Domain:
    """The block of these cells."""
    return block(MPI.COMM_WORLD, size=BLOCKS[cells], h=H, cells=cells)


def corners(domain: Domain, side: str) -> np.ndarray:
    """Corners of every facet of a side, shape (n, corners, 3)."""
    nodes = dmesh.entities_to_geometry(domain.mesh, domain.dim - 1, domain.facets(side))
    return domain.mesh.geometry.x[nodes]


def areas(facets: np.ndarray) -> np.ndarray:
    """Length of edges, area of triangles and of rectangles (corners in tensor order)."""
    if facets.shape[1] == 2:
        return np.linalg.norm(facets[:, 1] - facets[:, 0], axis=1)
    across = np.cross(facets[:, 1] - facets[:, 0], facets[:, 2] - facets[:, 0])
    return np.linalg.norm(across, axis=1) / (2 if facets.shape[1] == 3 else 1)


@pytest.mark.parametrize(("cells", "side"), NAMED)
def test_a_named_side_has_the_measure_and_the_place_of_that_side(cells: str, side: str) -> None:
    domain, size = made(cells), BLOCKS[cells]
    facets, (axis, end) = corners(domain, side), SIDES[len(size)][side]
    measure, expected = areas(facets).sum(), np.prod(size) / size[axis]
    assert measure == pytest.approx(expected, rel=1e-12), f"{side}: {measure}, not {expected}"
    place = size[axis] if end > 0 else 0.0
    gap = np.abs(facets[..., axis] - place).max()
    assert gap < 1e-12, f"{side}: {gap} away from {'xyz'[axis]} = {place}"


def test_the_names_of_the_sides_are_those_of_a_body_in_front_of_one() -> None:
    """x runs from left to right, the last axis from bottom to top, y in 3-D from front to back."""
    size = (1.0, 2.0, 3.0)
    expected = {"left": 0.0, "right": 1.0, "front": 0.0, "back": 2.0, "bottom": 0.0, "top": 3.0}
    axes = {"left": 0, "right": 0, "front": 1, "back": 1, "bottom": 2, "top": 2}
    assert {side: face_position(side, size) for side in SIDES[3]} == expected
    assert {side: axis for side, (axis, _) in SIDES[3].items()} == axes
    assert {side: face_position(side, (1.0, 2.0)) for side in SIDES[2]} == {
        "left": 0.0, "right": 1.0, "bottom": 0.0, "top": 2.0
    }  # fmt: skip


def test_a_side_that_does_not_exist_is_named_with_the_nearest() -> None:
    with pytest.raises(InputError, match=r"no boundary 'lefft'.*Did you mean 'left'"):
        made("triangle").facets("lefft")


@pytest.mark.parametrize("cells", BLOCKS)
def test_the_block_reaches_from_the_origin_to_its_size(cells: str) -> None:
    domain, size = made(cells), BLOCKS[cells]
    x = vertices(linear_spaces(domain).alpha)[:, : len(size)]
    assert x.min(axis=0) == pytest.approx(np.zeros(len(size)), abs=1e-12)
    assert x.max(axis=0) == pytest.approx(size, rel=1e-12)
    assert domain.size == size and domain.dim == len(size)


@pytest.mark.parametrize("cells", BLOCKS)
def test_cells_and_vertices_are_as_many_as_check_foretells(cells: str) -> None:
    domain = made(cells)
    found = cell_count(domain), linear_spaces(domain).alpha.dofmap.index_map.size_global
    expected = cells_and_vertices(BLOCKS[cells], H, cells)
    assert found == expected, f"{found} cells and vertices, foretold {expected}"


@pytest.mark.parametrize("h", [0.3, 0.1])
def test_a_cell_is_the_longest_that_divides_the_body_and_is_not_longer_than_h(h: float) -> None:
    """1.0 in cells of at most 0.3 are four, of 0.25."""
    domain = block(MPI.COMM_WORLD, size=(1.0, 1.0), h=h, cells="quadrilateral")
    assert domain.h == pytest.approx(1 / np.ceil(1 / h - 1e-9))
    assert cell_count(domain) == round(1 / domain.h) ** 2


def edges_of(domain: Domain) -> np.ndarray:
    """Both ends of every edge, shape (n, 2, 2)."""
    domain.mesh.topology.create_entities(1)
    count = domain.mesh.topology.index_map(1).size_local
    nodes = dmesh.entities_to_geometry(domain.mesh, 1, np.arange(count, dtype=np.int32))
    return domain.mesh.geometry.x[nodes][:, :, :2]


def as_set(edges: np.ndarray) -> set[tuple[tuple[float, float], ...]]:
    """Edges as what can be compared: without direction, to round-off."""
    return {tuple(sorted(tuple(map(float, p)) for p in edge)) for edge in edges.round(9) + 0.0}


def test_triangles_prefer_no_diagonal() -> None:
    """Mirrored in x or in y, the mesh is itself; as many edges rise as fall."""
    size = np.array(BLOCKS["triangle"])
    domain = made("triangle")
    edges = edges_of(domain)
    for axis in (0, 1):
        mirrored = edges.copy()
        mirrored[:, :, axis] = size[axis] - mirrored[:, :, axis]
        strays = as_set(edges) ^ as_set(mirrored)
        assert not strays, f"{len(strays)} edges differ from their mirror image along {'xy'[axis]}"
    way = edges[:, 1] - edges[:, 0]
    slope = way[:, 0] * way[:, 1]
    rising, falling = int((slope > 1e-9).sum()), int((slope < -1e-9).sum())
    blocks = 15 * 4
    assert rising == falling == 2 * blocks, f"{rising} rise, {falling} fall, of {blocks} squares"


def test_every_second_vertex_of_triangles_is_the_middle_of_a_square() -> None:
    counts, domain = (15, 4), made("triangle")
    x = vertices(linear_spaces(domain).alpha)[:, :2] / domain.h
    middles = np.all(np.isclose(x % 1, 0.5), axis=1).sum()
    assert middles == counts[0] * counts[1], f"{middles} middles of {counts[0] * counts[1]} squares"
    assert len(x) == (counts[0] + 1) * (counts[1] + 1) + middles


def test_the_same_block_has_the_same_identity_and_another_another() -> None:
    def identity(size: tuple[float, ...], h: float, cells: str) -> str:
        return block(MPI.COMM_SELF, size=size, h=h, cells=cells).identity

    same = identity((1.0, 0.5), 0.1, "triangle")
    others = {
        identity((1.0, 0.6), 0.1, "triangle"),
        identity((1.0, 0.5), 0.05, "triangle"),
        identity((1.0, 0.5), 0.1, "quadrilateral"),
    }
    assert same == identity((1.0, 0.5), 0.1, "triangle") and same not in others
    assert len(others) == 3

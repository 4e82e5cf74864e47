"""Meshes whose cells are split: what the finer mesh keeps of the coarser one."""

from dataclasses import replace
from functools import cache

from staffa.backend.stack import MPI

import numpy as np
import pytest
from dolfinx import mesh as dmesh

from staffa.geometry.edges import cell_edges
from staffa.geometry.nested import Nested, nested
from staffa.geometry.simplices import Simplices, facets, keys
from staffa.model.domain import Domain, block, body, local_edges
from staffa.model.refinement import Wanted, refined, too_coarse

COMM = MPI.COMM_SELF
AHEAD = 0.15
SQUARE, CUBE = pytest.param(2, id="2-D"), pytest.param(3, id="3-D")


def sizes(corners: np.ndarray) -> np.ndarray:
    """Area or volume of simplices (m2 or m3), or length or area of their facets."""
    legs = corners[:, 1:] - corners[:, :1]
    factorial = {1: 1, 2: 2, 3: 6}[legs.shape[1]]
    return np.sqrt(np.abs(np.linalg.det(legs @ legs.transpose(0, 2, 1)))) / factorial


def roundness(corners: np.ndarray) -> np.ndarray:
    """Return volume over the cube (area over the square) of the mean edge, 1 for regular cells."""
    dim = corners.shape[2]
    regular = {2: np.sqrt(3) / 4, 3: 1 / np.sqrt(72)}[dim]
    return sizes(corners) / cell_edges(corners) ** dim / regular


def named_mesh(dim: int) -> Simplices:
    """A unit square or cube with two regions, two faces, and a crack inside."""
    n = {2: 6, 3: 4}[dim]
    make = dmesh.create_unit_square if dim == 2 else dmesh.create_unit_cube
    made = make(COMM, *(n,) * dim)
    x = np.asarray(made.geometry.x[:, :dim])
    cells = made.geometry.dofmaps[0].astype(np.int64)
    every = facets(cells).reshape(-1, dim)
    every = every[np.unique(keys(every), return_index=True)[1]]

    def where(found: np.ndarray) -> np.ndarray:
        return every[found.all(axis=1)]

    at = x[every]
    low = x[cells].mean(axis=1)[:, -1] < 0.5
    crack = (at[..., -1] == 0.5) & (at[..., 0] <= 0.5 + 1e-12)
    return Simplices(
        x=x,
        cells=cells,
        regions={"low": np.flatnonzero(low), "high": np.flatnonzero(~low)},
        faces={"west": where(at[..., 0] == 0.0), "top of it": where(at[..., -1] == 1.0)},
        cracks={"fault": where(crack)},
    )


def marked(domain: Domain, where) -> Wanted:
    """Cells whose center is so are to be the finest, and those around them."""
    geometry = domain.mesh.geometry
    centers = geometry.x[geometry.dofmaps[0], : domain.dim].mean(axis=1)
    wanted = Wanted.nothing(len(centers))
    wanted.around[:] = where(centers) & too_coarse(local_edges(domain), domain.source.finest)
    wanted.edge[wanted.around] = domain.source.finest
    return wanted


@cache
def split_in_rounds(dim: int) -> tuple[Simplices, Nested, Domain]:
    """The named mesh split twice by other wishes: before, the relation, and the body after."""
    mesh = named_mesh(dim)
    domain = body(COMM, lambda: mesh, halvings={2: 3, 3: 1}[dim])
    domain, first = refined(domain, marked(domain, lambda c: c[:, -1] < 0.2), ahead=0.05)
    domain, second = refined(
        domain, marked(domain, lambda c: np.linalg.norm(c - 0.7, axis=1) < 0.3), ahead=0.05
    )
    return mesh, first.then(second), domain


@pytest.mark.parametrize("dim", [SQUARE, CUBE])
def test_old_points_come_first_and_cells_fill_their_parents(dim: int) -> None:
    mesh, found, domain = split_in_rounds(dim)
    finer, n = found.mesh, len(mesh.x)
    assert len(finer.cells) > 2 * len(mesh.cells) and domain.source.mesh is finer
    assert np.array_equal(finer.x[:n], mesh.x)
    assert len(np.unique(finer.x.round(12), axis=0)) == len(finer.x), "no point twice"
    size = sizes(finer.x[finer.cells])
    assert size.min() > 0
    filled = np.bincount(found.parents, size, len(mesh.cells))
    assert filled == pytest.approx(sizes(mesh.x[mesh.cells]), rel=1e-12)
    # In the coordinates of its parent every corner has parts between 0 and 1.
    start, corners = mesh.x[mesh.cells[found.parents]], finer.x[finer.cells]
    legs = np.linalg.inv(start[:, 1:] - start[:, :1])
    parts = (corners - start[:, :1]) @ legs
    assert parts.min() > -1e-12 and parts.sum(axis=2).max() < 1 + 1e-12


@pytest.mark.parametrize("dim", [SQUARE, CUBE])
def test_linear_functions_pass_exactly_and_old_values_to_the_last_bit(dim: int) -> None:
    mesh, found, _ = split_in_rounds(dim)
    linear = np.array([1.0, -2.0, 0.5])[:dim]
    assert found.values @ (mesh.x @ linear + 3) == pytest.approx(
        found.mesh.x @ linear + 3, abs=1e-13
    )
    drawn = np.random.default_rng(1).normal(size=(len(mesh.x), 2)) ** 3
    passed = found.values @ drawn
    assert np.array_equal(passed[: len(mesh.x)], drawn)
    assert passed.max() <= drawn.max() and passed.min() >= drawn.min()
    assert np.array_equal(found.values @ np.ones(len(mesh.x)), np.ones(len(found.mesh.x)))


@pytest.mark.parametrize("dim", [SQUARE, CUBE])
def test_names_are_split_exactly(dim: int) -> None:
    """Regions by their volume, faces and cracks by their area, and each where it was."""
    mesh, found, domain = split_in_rounds(dim)
    finer = found.mesh
    for name, cells in mesh.regions.items():
        assert np.isin(found.parents[finer.regions[name]], cells).all(), name
        assert sizes(finer.x[finer.cells[finer.regions[name]]]).sum() == pytest.approx(0.5)
    whole = {"west": 1.0, "top of it": 1.0, "fault": 0.5}
    split = finer.faces | finer.cracks
    assert list(split) == list(whole)
    for name, rows in split.items():
        assert len(rows) > len((mesh.faces | mesh.cracks)[name]), f"{name} was not split"
        assert sizes(finer.x[rows]).sum() == pytest.approx(whole[name], rel=1e-12), name
    assert np.all(finer.x[finer.faces["west"]][..., 0] == 0.0)
    assert np.all(finer.x[finer.faces["top of it"]][..., -1] == 1.0)
    fault = finer.x[finer.cracks["fault"]]
    assert np.all(fault[..., -1] == 0.5) and fault[..., 0].max() <= 0.5 + 1e-12
    every = np.unique(keys(np.concatenate([facets(finer.cells).reshape(-1, dim)])))
    assert len(every) * 2 > len(finer.cells) * (dim + 1), "facets have one or two cells"
    for name in whole:
        if name in domain.boundaries:
            assert len(domain.boundaries[name]) == len(finer.faces[name]), "all on the surface"


def test_the_finer_mesh_does_not_depend_on_the_order_in_which_its_cells_come() -> None:
    mesh = named_mesh(2)
    domain = body(COMM, lambda: mesh, halvings=1)
    _, once = refined(domain, marked(domain, lambda c: c[:, 0] < 0.5), ahead=0.01)
    corners, parents = once.mesh.x[once.mesh.cells], once.parents
    draw = np.random.default_rng(2)
    order = draw.permutation(len(parents))
    again = nested(mesh, corners[order], parents[order])
    assert np.array_equal(again.mesh.x, once.mesh.x)
    assert np.array_equal(again.mesh.cells, once.mesh.cells)
    assert np.array_equal(again.parents, parents)
    assert not (again.values != once.values).nnz


def segment_distance(x: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """Distance (m) of points from a straight crack."""
    along = np.clip((x - start) @ (end - start) / ((end - start) @ (end - start)), 0, 1)
    return np.linalg.norm(x - start - along[:, None] * (end - start), axis=1)


@pytest.mark.parametrize(
    ("end", "cells", "halvings", "worst"),
    [((0.7, 0.5), "triangle", 5, 0.99), ((0.3, 0.2, 0.2), "tetrahedron", 2, 0.5)],
    ids=["2-D", "3-D"],
)
def test_around_a_drawn_crack_cells_are_fine_and_well_shaped(end, cells, halvings, worst) -> None:
    """The crack grows in rounds: no cell of its band is coarse, none is flat, few lie afar."""
    h, size = 0.25 / 2**halvings, (1.0,) * len(end)
    domain = block(COMM, size=size, h=h, cells=cells, halvings=halvings)
    base = domain.source.mesh.x[domain.source.mesh.cells]
    start = np.full(len(end), 0.1)
    for grown in (0.3, 0.6, 1.0):
        tip, edges = start + grown * (end - start), local_edges(domain)
        wanted = marked(
            domain,
            lambda c, tip=tip, edges=edges: segment_distance(c, start, tip) < 2 * h + edges,
        )
        domain, _ = refined(domain, wanted, ahead=2 * h)
    corners = domain.source.mesh.x[domain.source.mesh.cells]
    coarse = too_coarse(cell_edges(corners), domain.source.finest)
    away = segment_distance(corners.mean(axis=1), start, end)
    assert not coarse[away < 4 * h].any()
    assert away[~coarse].max() < 4 * h + 3 * cell_edges(base).max()
    assert roundness(corners).min() > worst * roundness(base).min()
    uniform = len(base) * 2 ** (len(size) * halvings)
    assert len(corners) < 0.5 * uniform, "most of it stays coarse"


@pytest.mark.parametrize(
    ("size", "cells"),
    [((1.0, 1.0), "triangle"), ((0.75, 0.75, 1.0), "tetrahedron")],
    ids=["2-D", "3-D"],
)
def test_a_fine_part_that_grows_over_the_whole_body_ends_as_the_uniform_mesh(size, cells) -> None:
    """Cells beside a fine part are cut on the way: that must not leave them far too small."""
    domain = block(COMM, size=size, h=1 / 16, cells=cells, halvings=2)
    uniform = len(domain.source.mesh.cells) * 4 ** len(size)
    for depth in np.arange(0.2, 1.3, 0.1):
        domain, _ = refined(domain, marked(domain, lambda c, d=depth: c[:, -1] < d), ahead=0.05)
    edges = local_edges(domain)
    assert not too_coarse(edges, domain.source.finest).any()
    assert 0.9 * uniform < len(edges) < 1.1 * uniform


def test_a_mesh_without_a_wish_stays_as_it_is() -> None:
    domain = block(COMM, size=(1.0, 1.0), h=0.05, cells="triangle", halvings=2)
    same, found = refined(domain, Wanted.nothing(len(local_edges(domain))), ahead=AHEAD)
    assert found.mesh is domain.source.mesh and np.array_equal(
        found.parents, np.arange(len(found.parents))
    )
    assert replace(same.source, mesh=None) == replace(domain.source, mesh=None)

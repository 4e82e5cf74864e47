"""Warnings about what a mesh resolves, details smaller than its cells, and memory."""

import os
from collections.abc import Iterator
from importlib.util import find_spec
from math import inf
from typing import Any

import numpy as np

from staffa.case.check.cost import coarser_for, memory
from staffa.case.check.edge_warnings import long_edges
from staffa.case.check.element_notes import locking_warnings
from staffa.case.rules.support_rules import moved_axes
from staffa.case.schema.case import Case
from staffa.case.schema.property_keys import RandomField
from staffa.case.schema.quantity_text import amount, at_least, at_most
from staffa.case.schema.shape_keys import Layers, PlateWithHole, Wellbore
from staffa.case.schema.toml_text import inline
from staffa.case.values.subdomains import box_of, subdomains_of
from staffa.geometry.block_simplices import MISSING
from staffa.geometry.gmsh_model import missing
from staffa.geometry.msh import WAY_OUT

MUCH_LEFT = 1e-3  # of the stiffness, in a crack
WIDTH = 4.0  # of a crack's damage with AT1, over ell


def cell_edge(case: Case) -> float:
    """Return the longest cell edge (m), at most domain.h; the mean of unstructured cells."""
    return case.outline.h


def widest_ell(case: Case) -> float:
    """Return the largest ell (m) with which the damage of a crack is no wider than the body.

    For a body that is only pulled, the width counts along the axes of the pull, across the cracks.
    """
    other = case.temperature.profile != "none" or case.forces is not None or case.cracks
    axes = () if other else moved_axes(case)
    return min(case.outline.size[axis] for axis in axes or range(case.dim)) / WIDTH


def mesh_warnings(case: Case) -> Iterator[str]:
    """Yield all warnings about the mesh."""
    yield from _of_ell(case)
    yield from _of_residual_stiffness(case)
    yield from _of_noise(case)
    yield from locking_warnings(case)
    yield from _of_regions(case)
    yield from _of_shape(case)
    yield from _of_memory(case)


def mesh_notes(case: Case) -> Iterator[str]:
    """Yield notes on changes of a mesh, and on cells that barely resolve a crack."""
    yield from case.outline.notes
    yield from (text for much, text in long_edges(case, cell_edge(case)) if not much)


def _of_ell(case: Case) -> Iterator[str]:
    ell, widest = float(case.damage.ell), widest_ell(case)
    meshed_here = case.domain.has_simplices and case.domain.mesh is None
    if meshed_here and find_spec("gmsh") is None:
        yield MISSING if case.domain.is_block else missing("domain.shape", WAY_OUT)
    yield from (text for much, text in long_edges(case, cell_edge(case)) if much)
    if widest < ell * (1 - 1e-9):
        yield (
            f"the smallest extent is {WIDTH * widest / ell:.2g} ell: a crack's damage, 4 ell wide, "
            f"is as wide as the body; take damage.ell <= {at_most(case, widest, 'm')}"
        )


def _of_residual_stiffness(case: Case) -> Iterator[str]:
    left = case.damage.residual_stiffness
    if left > MUCH_LEFT:
        yield (
            f"damage.residual_stiffness = {left:g}: a crack still carries {left:.2g} of what whole "
            f"rock does; take {MUCH_LEFT:g} or less"
        )


def _of_noise(case: Case) -> Iterator[str]:
    """Warn of random fields that are finer than the mesh."""
    h, length = cell_edge(case), case.toughness.correlation_length
    coarser = f"{amount(case, 2 * case.damage.ell, 'm')}, which is 2 ell, or more"
    if case.toughness.amplitude and length is not None and length < h:
        yield (
            f"toughness.correlation_length = {inline(length)} is less than a cell: the mesh sees "
            f"noise that depends on it; take {coarser}"
        )
    for where, value in _written(case):
        lengths = value.length if isinstance(value, RandomField) else ()
        shortest = min(lengths if isinstance(lengths, tuple) else (lengths,), default=np.inf)
        if shortest < h:
            yield (
                f"{where}.length = {inline(shortest)} is less than a cell: the mesh sees noise "
                f"that depends on it; take {coarser}"
            )


def _written(case: Case) -> Iterator[tuple[str, Any]]:
    """Yield the values of properties, those that a region takes from the body only once."""
    seen: set[int] = set()
    for subdomain in subdomains_of(case):
        for _, where, value in subdomain.properties():
            if id(value) not in seen:
                yield where, value
            seen.add(id(value))


def _of_regions(case: Case) -> Iterator[str]:
    for name, region in case.regions.items():
        box = box_of(case, region)
        thinnest = min(b - a for a, b in zip(*box, strict=True)) if box else inf
        if thinnest < cell_edge(case) * (1 - 1e-9):
            yield (
                f"regions.{name} is {amount(case, thinnest, 'm')} thin, less than a cell, and may "
                f"hold none; make it thicker, or take {_edge(case, thinnest)}"
            )


def _of_shape(case: Case) -> Iterator[str]:
    """Warn of parts of a shape that are smaller than a cell."""
    keys, h = case.domain.shape, cell_edge(case) * (1 - 1e-9)
    if isinstance(keys, PlateWithHole | Wellbore) and keys.radius < h:
        yield (
            f"domain.shape.radius = {inline(keys.radius)} is less than a cell: the hole is not "
            f"round; take {_edge(case, float(keys.radius) / 3)}"
        )
    for number, layer in enumerate(keys.layers if isinstance(keys, Layers) else (), start=1):
        if layer.thickness < h:
            yield (
                f"domain.shape.layers, entry {number}, thickness = {inline(layer.thickness)} is "
                f"less than a cell; make it thicker, or take {_edge(case, float(layer.thickness))}"
            )


def _edge(case: Case, most: float) -> str:
    """Return the edge of cells (m) to take."""
    return f"domain.h <= {at_most(case, most, 'm')}"


def _of_memory(case: Case) -> Iterator[str]:
    here, needed = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES"), memory(case)
    if needed > here:
        coarser = at_least(case, coarser_for(case, here), "m")
        yield (
            f"about {needed / 1e9:.2g} GB of memory are needed and this machine has "
            f"{here / 1e9:.2g} GB; run it on a larger one, or take domain.h >= {coarser}"
        )

"""Estimate of the cells of a mesh that follows the cracks, at the start and at the end of a run.

It is the integral over the depth below the cooled face of the density of the cells, which are

- h long down to the depth that cooling drives, by rules.drive of the threshold, before any crack
  lets go; and a band of 4 ell + ahead and more around it;
- h long in a band of that kind around each crack, down to the depth that cooling drives at the
  end; the cracks are as far apart as parallel ones that double (`physics.doubling`);
- as long as the temperature allows, elsewhere.

Boundaries of regions, which are split from the start, do not count.
"""

from dataclasses import dataclass

import numpy as np

from staffa.case.check.cracking import first_and_last, other_causes, peak_drop
from staffa.case.scales.case_scales import Numbers, derived_numbers, load
from staffa.case.schema.case import Case
from staffa.case.schema.refine_keys import RefineKeys, multiple
from staffa.geometry.block import cells_and_vertices
from staffa.geometry.shapes import shape_outline
from staffa.physics.doubling import spacing_at

# Refined runs have end within this factor of what is said (`tests/run/test_refined_results.py`).
CELLS_WITHIN = 1.5
POINTS = 400  # of the depth
TIMES = 20  # at which the temperature is looked at
MEAN_SPACING = 1.5  # of cracks, over that at which they double: it lies between 1 and 2
TAIL = 2.0  # half of the width of a crack's damage, over ell


@dataclass(frozen=True, kw_only=True)
class MeshSize:
    """Numbers of cells and vertices of a mesh."""

    cells: int
    vertices: int


@dataclass(frozen=True, kw_only=True)
class MeshGrowth:
    """Size of a mesh over a run.

    Attributes
    ----------
    start : size before the first step.
    end : estimated size after the last step.
    most : size if all cells were as fine as the finest.
    known : False if only the run can tell the end, which is then the most.
    """

    start: MeshSize
    end: MeshSize
    most: MeshSize
    known: bool = True


def mesh_growth(case: Case) -> MeshGrowth:
    """Return the size of the mesh of a case over its run."""
    body, keys = case.outline, case.domain
    most = MeshSize(cells=body.n_cells, vertices=body.n_vertices)
    if keys.refining is None or not keys.halvings:
        return MeshGrowth(start=most, end=most, most=most)
    if keys.file is not None:  # the outline has the numbers of the file, which is the coarse mesh
        assert body.edges is not None
        finer = (body.edges.mean / body.h) ** case.dim
        most = MeshSize(cells=round(finer * most.cells), vertices=round(finer * most.vertices))
    start, derived = _at_start(case), derived_numbers(case)
    known = derived.face is not None and derived.cooled and derived.dT_c and derived.ell0
    if not known or other_causes(case):
        return MeshGrowth(start=start, end=most, most=most, known=False)
    fine = _fine_share(case, derived, keys.refining)
    end = MeshSize(
        cells=round(start.cells + fine * (most.cells - start.cells)),
        vertices=round(start.vertices + fine * (most.vertices - start.vertices)),
    )
    return MeshGrowth(start=start, end=end, most=most)


def _at_start(case: Case) -> MeshSize:
    """Return the size of the mesh that a run begins with."""
    keys, body = case.domain, case.outline
    longest = float(keys.h or 0.0) * 2**keys.halvings
    if keys.file is not None:
        return MeshSize(cells=body.n_cells, vertices=body.n_vertices)
    if keys.shape is not None:
        coarse = shape_outline(keys.shape.shape(), longest)
        return MeshSize(cells=coarse.n_cells, vertices=coarse.n_vertices)
    cells, vertices = cells_and_vertices(body.size, longest, str(keys.cells))
    return MeshSize(cells=cells, vertices=vertices)


def _fine_share(case: Case, derived: Numbers, keys: RefineKeys) -> float:
    """Return the share of the uniform mesh that the finest cells make up at the end."""
    face = derived.face
    assert face is not None
    assert derived.dT_c
    z = derived.L * (np.arange(POINTS) + 0.5) / POINTS
    first, last = first_and_last(derived)
    drops = {t: _drop(case, derived, z, t) for t in np.geomspace(first, last, TIMES).tolist()}
    driving = np.sqrt(keys.drive) * derived.dT_c
    ell, ahead = float(case.damage.ell), multiple(keys.ahead) * float(case.damage.ell)
    beyond = TAIL * ell + ahead
    at_once, at_end = (_deepest(z, drops[t] >= driving) for t in (min(drops), max(drops)))
    fine = _even(case, drops, z, keys.drop)
    apart = MEAN_SPACING * _doubled(z, derived)
    covered = np.minimum(1.0, 2 * beyond / apart)
    covered = covered if case.dim == 2 else 1 - (1 - covered) ** 2
    if at_end:
        fine = np.where(z < at_end + beyond, np.maximum(fine, covered), fine)
    if at_once:
        fine = np.where(z < at_once + beyond, 1.0, fine)
    return float(fine.mean())


def _drop(case: Case, derived: Numbers, z: np.ndarray, t: float) -> np.ndarray:
    """Return the drop (K) at depths z (m), shape (n,), at a time, in a body without cracks."""
    face = derived.face
    assert face is not None
    x = np.zeros((3, len(z) + 1))
    x[face.axis] = face.position + face.inward * np.concatenate([[0.0], z])
    found = -load(case, derived).temperature(x, t)
    surface = peak_drop(case, derived) if case.heat is not None else found[0]
    return np.asarray(found[1:] * (surface / found[0] if found[0] else 0.0))


def _deepest(z: np.ndarray, there: np.ndarray) -> float:
    """Return the largest depth (m) that is marked, 0 for none."""
    return float(z[there].max(initial=0.0))


def _doubled(z: np.ndarray, derived: Numbers) -> np.ndarray:
    """Return the spacing (m) of cracks that double at depths z (m); beyond the table its ends."""
    assert derived.ell0 is not None
    found = spacing_at(z, derived.ell0)
    known = np.isfinite(found)
    if not known.any():
        return np.full_like(z, 1e-300)  # all of it is fine: nothing is known
    return np.asarray(np.interp(z, z[known], found[known]))


def _even(case: Case, drops: dict[float, np.ndarray], z: np.ndarray, most: float) -> np.ndarray:
    """Return the share of the finest density that the temperature needs at depths z, shape (n,)."""
    h, times = case.outline.h, case.domain.halvings
    wanted = np.full_like(z, np.inf)
    for drop in drops.values():
        change = np.abs(np.gradient(drop, z)) / max(drop.max(), 1e-300)
        wanted = np.minimum(wanted, most / np.maximum(change, 1e-300))
    halved = np.clip(np.ceil(np.log2(wanted / h)), 0, times)
    coarsest = 2.0 ** (-case.dim * times)
    return np.asarray((2.0 ** (-case.dim * halved) - coarsest) / (1 - coarsest))

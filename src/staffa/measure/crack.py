"""Cracks of a state: their number on depth sections, their tips, lengths and volume."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from scipy.spatial import cKDTree

from staffa.backend.parallel import gather, on_root, sum_over_ranks
from staffa.geometry.places import SAME
from staffa.loads.closed_form import Face
from staffa.measure.coarse import Local, coarse, local_length
from staffa.measure.column_planes import Planes
from staffa.measure.free_distance import room
from staffa.measure.opening import REACH
from staffa.measure.starting_faces import Ahead, OtherFace, Starts, started
from staffa.measure.statistics import cracks_on_line, layer_depth, tips
from staffa.model.domain import Domain
from staffa.model.energy import Energy
from staffa.model.fields import State, owned, vertices
from staffa.records.step import CracksAtHeight, Fluid, Measures, OtherCracks, Tip

# Largest distance (in ell) of a sharp tip from the recorded one (see `measure.tip`).
FARTHEST = 3.0


@dataclass(frozen=True, kw_only=True)
class Gauge:
    """Settings of the crack measures.

    Attributes
    ----------
    face : face from which depth is measured; None for a body without a cooled face (then no tips).
    depths : depths at which cracks are counted (m).
    threshold : damage above which a point is cracked.
    prominence : least depth of a tip below its surroundings, ell (m).
    h : mesh size (m).
    toughness_factor : effective Gc over Gc, measured on the same cells.
    local : mesh size and effective Gc of each cell, on a mesh of unequal cells; else None.
    others : cooled faces besides `face`; cracks that start there are counted apart.
    cools : False if these are cooled and `face` is not: then no crack starts on it.
    """

    face: Face | None
    depths: tuple[float, ...]
    threshold: float
    prominence: float
    h: float
    toughness_factor: float
    local: Local | None = None
    others: tuple[OtherFace, ...] = ()
    cools: bool = True

    @property
    def reach(self) -> float:
        """Distance from a crack within which rock may be soft because of it (m)."""
        return REACH * self.prominence + (1 + SAME) * self.h

    @property
    def start(self) -> float:
        """Distance from a face within which a crack touches it (m)."""
        return self.prominence + (1 + SAME) * self.h


def planes(domain: Domain, gauge: Gauge, ell: float) -> Planes | None:
    """Return the depth planes of a 3-D body, found once; None without any. Collective.

    Parameters
    ----------
    domain : the mesh.
    gauge : settings of the measures.
    ell : regularization length (m).
    """
    if domain.dim == 2 or gauge.face is None or not gauge.depths:
        return None
    return Planes(domain, gauge.face, gauge.depths, ell=ell, threshold=gauge.threshold)


def measures(
    domain: Domain,
    state: State,
    energy: Energy,
    gauge: Gauge,
    below: Planes | None = None,
    before: Measures | None = None,
) -> Measures:
    """Measure a state. Collective.

    Parameters
    ----------
    domain : the mesh.
    state : the fields.
    energy : the energy of the same state.
    gauge : settings of the measures.
    below : depth planes of a 3-D body (see `planes`); None without any.
    before : measures of the step before; None without one.
    """
    found = cracks(domain, state, gauge, before) if gauge.face else MeasuredCracks()
    lines = gauge.depths if domain.dim == 2 else ()
    cells, too_long = gauge.local, None
    if cells is None:
        length = energy.crack_length() / gauge.toughness_factor
    else:
        spent = energy.crack_lengths()
        length = local_length(domain, spent, cells)
        too_long = coarse(domain, state.alpha, spent, cells, gauge.prominence)
    return Measures(
        sections=tuple(crossing(domain, state, gauge, depth, found.starts) for depth in lines),
        tips=found.tips,
        others=found.others,
        front=max((tip.depth for tip in found.tips), default=0.0),
        length_surface=length,
        length_geometry=energy.crack_variation(),
        volume=crack_volume(domain, state, energy, gauge),
        fluid=fluid(energy),
        cells=below(state) if below else (),
        coarse=too_long,
    )


def fluid(energy: Energy) -> Fluid | None:
    """Return pressure and volume of the fluid in the cracks; None without one. Collective."""
    external = energy.external
    if not external.forces.in_cracks:
        return None
    field = external.forces.fluid or external.forces.crack_field is not None
    pressure = energy.pressure_in_cracks() if field else float(external.pressure.value)
    return Fluid(pressure=pressure, volume=energy.crack_volume())


# Edges of a triangle, and of a quadrilateral: a quadrilateral's fields are linear along edges only.
EDGES = {3: [(0, 1), (1, 2), (2, 0)], 4: [(0, 1), (1, 3), (3, 2), (2, 0)]}


def crack_volume(domain: Domain, state: State, energy: Energy, gauge: Gauge) -> float:
    """Return the crack volume (m^3; area in 2-D, m^2): the opening strain near cracks, summed.

    Collective.

    Parameters
    ----------
    domain : the mesh.
    state : the fields.
    energy : the energy of the same state.
    gauge : settings of the measures.
    """
    space = state.alpha.function_space
    x = vertices(space)
    cracked = owned(state.alpha) > gauge.threshold
    parts = gather(domain.comm, x[: len(cracked)][cracked])
    points = on_root(domain.comm, lambda: np.concatenate(parts or []))
    volumes = energy.openings.volumes()
    middles = x[_cells(domain, state)].mean(axis=1)
    if not len(points):
        return 0.0
    near = cKDTree(points).query(middles, distance_upper_bound=gauge.reach)[0] < np.inf
    return sum_over_ranks(domain.comm, float(volumes[near].sum()))


def crossing(
    domain: Domain, state: State, gauge: Gauge, depth: float, starts: Starts | None = None
) -> CracksAtHeight:
    """Return the cracks of a 2-D body that cross a depth section. Collective.

    Parameters
    ----------
    domain : the mesh.
    state : the fields.
    gauge : settings of the measures.
    depth : depth of the section below the face (m).
    starts : faces from which cracks start, on rank 0 where several are cooled.
    """
    assert gauge.face is not None and domain.dim == 2
    face = gauge.face
    x = vertices(state.alpha.function_space)
    side = gauge.face.depth(x.T) - depth
    side[np.abs(side) < SAME * gauge.h] = 0.0
    cells = _cells(domain, state)
    across = (side[cells] <= 0).any(axis=1) & (side[cells] > 0).any(axis=1)
    ends = cells[across][:, EDGES[cells.shape[1]]].reshape(-1, 2)
    edges = np.concatenate([ends, ends[:, ::-1]])
    i, j = edges[(side[edges[:, 0]] <= 0) & (side[edges[:, 1]] > 0)].T
    weight = (side[i] / (side[i] - side[j]))[:, None]
    values = np.column_stack([x[:, 1 - gauge.face.axis], state.alpha.x.array])
    samples = gather(domain.comm, (1 - weight) * values[i] + weight * values[j])

    def count() -> CracksAtHeight:
        along, alpha = np.concatenate(samples or []).T
        found = cracks_on_line(along, alpha, height=depth, threshold=gauge.threshold)
        if starts is None:
            return found
        places = np.zeros((found.cracks, 3))
        places[:, 1 - face.axis] = found.positions
        places[:, face.axis] = face.position + face.inward * depth
        return starts.on_line(found, places)

    return on_root(domain.comm, count)


@dataclass(frozen=True, kw_only=True, eq=False)
class MeasuredCracks:
    """The cracks of a state.

    Attributes
    ----------
    tips : tips of those that start on no other cooled face than that of the depths.
    others : cracks that start on each of these.
    starts : face from which each starts, on rank 0 where several are cooled; else None.
    """

    tips: tuple[Tip, ...] = ()
    others: tuple[OtherCracks, ...] = ()
    starts: Starts | None = None


def cracks(
    domain: Domain, state: State, gauge: Gauge, before: Measures | None = None
) -> MeasuredCracks:
    """Return the tip of each crack that leaves the damaged layer, in 2-D and 3-D. Collective.

    Parameters
    ----------
    domain : the mesh.
    state : the fields.
    gauge : settings of the measures; `face` is given.
    before : measures of the step before; None without one.
    """
    assert gauge.face is not None
    layer = damaged_layer(domain, state, gauge) if gauge.cools else 0.0
    parts = _cracked(domain, state, gauge, layer)
    kept: list[Starts] = []

    def find() -> tuple[tuple[Tip, ...], Sequence[tuple[OtherCracks, Ahead | None]]]:
        assert gauge.face is not None
        known, points, pairs = (np.concatenate(part or []) for part in parts)
        edges = np.searchsorted(known, np.unique(pairs, axis=0))
        depth, ell = gauge.face.depth(points.T), gauge.prominence
        if not gauge.others or not len(points):
            return tips(points[:, : domain.dim], depth, edges, prominence=ell), ()
        found = started(
            points, edges, depth, gauge.others, layer=layer, reach=gauge.start, cools=gauge.cools
        )
        kept.append(found)
        old = before.tips if before else ()
        ends = found.own(depth, old, dim=domain.dim, prominence=ell)
        return ends, found.others(before.others if before else (), prominence=ell)

    found, others = on_root(domain.comm, find)
    return MeasuredCracks(
        tips=_with_room(domain, gauge, found) if found else (),
        others=tuple(_with_other_room(domain, gauge, *one) for one in others),
        starts=kept[0] if kept else None,
    )


def _cracked(
    domain: Domain, state: State, gauge: Gauge, layer: float
) -> tuple[list[np.ndarray] | None, ...]:
    """Return the ranks' cracked points below the broken layer, on rank 0: their numbers, their
    coordinates, and pairs of neighbors. Collective."""
    assert gauge.face is not None
    space = state.alpha.function_space
    cracked = state.alpha.x.array > gauge.threshold
    if layer:  # without one cracks begin on the face
        cracked &= gauge.face.depth(vertices(space).T) > layer + SAME * gauge.h
    cells = _cells(domain, state)
    pairs = _pairs(cells[cracked[cells].sum(axis=1) >= 2])
    pairs = pairs[cracked[pairs].all(axis=1)]
    index_map = space.dofmap.index_map
    numbers = index_map.local_to_global(pairs.ravel().astype(np.int32)).reshape(-1, 2)
    used = np.flatnonzero(cracked[: index_map.size_local])
    here = index_map.local_to_global(used.astype(np.int32))
    found = (here, vertices(space)[used], numbers)
    return tuple(gather(domain.comm, part) for part in found)


def _with_room(domain: Domain, gauge: Gauge, found: Sequence[Tip]) -> tuple[Tip, ...]:
    """Return tips with their distance to the end of the body, but for cracks that have met others.
    Collective."""
    assert gauge.face is not None
    way = np.zeros(domain.dim)
    way[gauge.face.axis] = gauge.face.inward
    places = np.array([tip.position for tip in found])
    left = room(domain, places, way, reach=FARTHEST * gauge.prominence + gauge.h)
    return tuple(
        replace(tip, room=float(r)) if np.isfinite(r) and not tip.met else tip
        for tip, r in zip(found, left, strict=True)
    )


def _with_other_room(
    domain: Domain, gauge: Gauge, one: OtherCracks, ahead: Ahead | None
) -> OtherCracks:
    """Return cracks of another face with the free distance of their deepest tip. Collective."""
    if ahead is None:
        return one
    place, way = ahead
    reach = FARTHEST * gauge.prominence + gauge.h
    left = room(domain, place[None, : domain.dim], way[: domain.dim], reach=reach)[0]
    return replace(one, room=float(left)) if np.isfinite(left) else one


def damaged_layer(domain: Domain, state: State, gauge: Gauge) -> float:
    """Return the depth (m) of the layer at the face that is cracked throughout. Collective.

    The depth is 0 without such a layer.

    Parameters
    ----------
    domain : the mesh.
    state : the fields.
    gauge : settings of the measures; `face` is given.
    """
    assert gauge.face is not None
    n_owned = state.alpha.function_space.dofmap.index_map.size_local
    depth = gauge.face.depth(vertices(state.alpha.function_space)[:n_owned].T)
    cracked = owned(state.alpha) > gauge.threshold
    bins = np.floor(depth / gauge.h + 0.5 + SAME).astype(np.int64)
    count = int(np.rint(max(domain.size) / gauge.h)) + 2
    points = sum_over_ranks(domain.comm, np.bincount(bins, minlength=count))
    broken = sum_over_ranks(domain.comm, np.bincount(bins[cracked], minlength=count))
    return layer_depth(broken, points, bin_depth=gauge.h)


def _cells(domain: Domain, state: State) -> np.ndarray:
    """Return the vertices (local numbers) of the cells that this rank owns, shape (n, vertices)."""
    owned_cells = domain.mesh.topology.index_map(domain.dim).size_local
    return np.asarray(state.alpha.function_space.dofmap.list[:owned_cells])


def _pairs(cells: np.ndarray) -> np.ndarray:
    """Return all pairs of vertices of each cell, shape (n, 2)."""
    return np.concatenate([cells[:, pair] for pair in combinations(range(cells.shape[1]), 2)])

"""Distance from points in a body to its surface along a direction."""

from staffa.backend.stack import MPI  # noqa: F401

import dolfinx.mesh as dmesh
import numpy as np

from staffa.backend.parallel import gather, on_root
from staffa.model.domain import Domain

# A facet whose normal has a smaller component along the direction lies beside the path.
FACING = 0.2


def room(domain: Domain, places: np.ndarray, way: np.ndarray, *, reach: float) -> np.ndarray:
    """Return the distance to the surface along a direction (m), shape (n,); inf beyond `reach`.

    The surface includes those of holes. Collective.

    Parameters
    ----------
    domain : the mesh.
    places : start points (m), shape (n, dim), the same on all ranks.
    way : direction, a unit vector, shape (dim,).
    reach : largest distance that matters (m).
    """
    mesh, dim = domain.mesh, domain.dim
    mesh.topology.create_connectivity(dim - 1, dim)
    facets = dmesh.exterior_facet_indices(mesh.topology)
    nodes = dmesh.entities_to_geometry(mesh, dim - 1, facets)
    corners = mesh.geometry.x[nodes][..., :dim]
    near = np.full((len(places), len(corners)), np.inf)
    if len(corners):
        middles = corners.mean(axis=1)
        sizes = np.linalg.norm(corners - middles[:, None], axis=2).max(axis=1)
        sides = corners[:, 1:dim] - corners[:, :1]
        turned = np.stack([-sides[:, 0, 1], sides[:, 0, 0]], axis=1) if dim == 2 else None
        across = np.cross(sides[:, 0], sides[:, 1]) if turned is None else turned
        across /= np.linalg.norm(across, axis=1)[:, None]
        facing = across @ way
        offset = middles[None] - places[:, None]
        ahead = np.abs(facing) > FACING
        along = np.einsum("pfi,fi->pf", offset, across) / np.where(ahead, facing, 1)
        aside = np.linalg.norm(offset - along[..., None] * way, axis=2)
        met = ahead & (aside <= 1.01 * sizes) & (along > -sizes) & (along < reach)
        near = np.where(met, np.maximum(along, 0.0), np.inf)
    here = near.min(axis=1, initial=np.inf)
    parts = gather(domain.comm, here)
    return on_root(domain.comm, lambda: np.min(parts or [here], axis=0))

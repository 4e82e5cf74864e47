"""Growth of cracks between two states of a body."""

import numpy as np
from scipy.spatial import KDTree

from staffa.backend.parallel import gather, on_root
from staffa.model.fields import State, vertices


def crack_advance(state: State, before: np.ndarray, *, threshold: float) -> float:
    """Return the largest distance (m) of a newly cracked vertex from the earlier cracks.

    Infinite without earlier cracks. Collective.

    Parameters
    ----------
    state : the current fields.
    before : damage of the earlier state, ghosts included, shape (n_local,).
    threshold : damage above which a vertex is cracked.
    """
    space = state.alpha.function_space
    n_owned = space.dofmap.index_map.size_local
    x = vertices(space)[:n_owned]
    was = before[:n_owned] > threshold
    new = ~was & (state.alpha.x.array[:n_owned] > threshold)
    comm = space.mesh.comm
    old_points, new_points = gather(comm, x[was]), gather(comm, x[new])

    def farthest() -> float:
        old, fresh = np.concatenate(old_points or []), np.concatenate(new_points or [])
        if not len(fresh):
            return 0.0
        return float(KDTree(old).query(fresh)[0].max()) if len(old) else np.inf

    return on_root(comm, farthest)

"""Distance of cracks to their neighbors, from cracks that are sorted into cells."""

import numpy as np

from staffa.reservoir.grid import Grid

# A cell with this share of the area of a straight crack through it is cracked.
PART = 0.3
STEPS = 2  # of a ray in the smallest edge of a cracked cell


def crack_spacing(grid: Grid, area: np.ndarray, across: np.ndarray, reach: float) -> float | None:
    """Return the distance of half of the area of cracks to the next crack (m); None without cracks.

    From each cracked cell rays go along the normal of its crack, out of the crack, and on to the
    next cracked cell. The nearer one counts, or `reach` where there is none so near.

    Parameters
    ----------
    grid : the cells.
    area : area of cracks in each cell (m^2), shape (n_cells,).
    across : sum of area times n_i n_j (m^2), with n their normals, shape (n_cells, dim, dim).
    reach : length of the rays (m).
    """
    dim, sizes = grid.dim, grid.sizes[:, : grid.dim]
    edge = sizes.prod(axis=1) ** (1 / dim)
    dense = area / grid.volumes * edge > PART
    cracked = np.flatnonzero(dense)
    if not len(cracked):
        return None
    _, directions = np.linalg.eigh(across[cracked])
    normals = directions[:, :, -1]
    step = float(sizes[cracked].min()) / STEPS
    along = np.arange(1, int(np.ceil(reach / step)) + 1) * step
    nearest = np.full(len(cracked), reach)
    for sign in (-1.0, 1.0):
        out = np.zeros(len(cracked), dtype=bool)
        found = np.zeros(len(cracked), dtype=bool)
        for distance in along:
            points = grid.centers[cracked, :dim] + sign * distance * normals
            cells, inside = grid.cells_around(points)
            meets = dense[cells] & inside
            arrived = meets & out & ~found
            nearest[arrived] = np.minimum(nearest[arrived], distance)
            found |= arrived
            out |= ~meets
    order = np.argsort(nearest)
    share = np.cumsum(area[cracked][order])
    return float(nearest[order][np.searchsorted(share, share[-1] / 2)])

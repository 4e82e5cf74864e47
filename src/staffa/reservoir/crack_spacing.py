"""Distance of cracks to their neighbors, from cracks that are sorted into cells."""

import numpy as np
from scipy.sparse import csr_matrix

from staffa.reservoir.grid import Grid

# Share of the density of a straight crack, 2/(pi radius), above which a cell is in its band, and
# the half width of that band over the radius.
PART, HALF = 0.3, 0.95
STEPS = 2  # of a ray in the smallest edge of a cracked cell


def crack_spacing(
    grid: Grid, area: np.ndarray, across: np.ndarray, near: tuple[csr_matrix, float], reach: float
) -> float | None:
    """Return the distance of half of the area of cracks to the next crack (m); None without cracks.

    From each cracked cell rays go along the normal of its crack, out of its band, and on to the
    next band. The nearer one counts, or `reach` where there is none so near. Cracks nearer than
    twice the half width of a band are in one band, and count as that far apart.

    Parameters
    ----------
    grid : the cells.
    area : area of cracks in each cell (m^2), shape (n_cells,).
    across : sum of area times n_i n_j (m^2), with n their normals, shape (n_cells, dim, dim).
    near : matrix that spreads cracks to bands, and its radius (m).
    reach : length of the rays (m).
    """
    dim, (bands, radius) = grid.dim, near
    half = HALF * radius
    in_band = bands @ area / grid.volumes > PART * 2 / (np.pi * radius)
    cracked = np.flatnonzero(in_band & (area > 0))
    if not len(cracked):
        return None
    _, directions = np.linalg.eigh(across[cracked])
    normals = directions[:, :, -1]
    step = float(grid.sizes[cracked, :dim].min()) / STEPS
    nearest = np.full(len(cracked), reach)
    merged = np.ones(len(cracked), dtype=bool)
    for sign in (-1.0, 1.0):
        out, found = np.zeros((2, len(cracked)), dtype=bool)
        for distance in np.arange(1, int(np.ceil(reach / step)) + 1) * step:
            points = grid.centers[cracked, :dim] + sign * distance * normals
            cells, inside = grid.cells_around(points)
            meets = in_band[cells] & inside
            arrived = meets & out & ~found
            nearest[arrived] = np.minimum(nearest[arrived], distance + half)
            found |= arrived
            out |= ~meets & (distance <= 2 * half)
        merged &= ~out
    nearest[merged] = 2 * half
    order = np.argsort(nearest)
    share = np.cumsum(area[cracked][order])
    return float(nearest[order][np.searchsorted(share, share[-1] / 2)])

"""The opening of cracks by the jump of u across them, from the fields alone: a reference.

Along the normal of a crack, 2 ell to each side: u there less u here, less the strain that intact
rock would have in between, which is free of cracks. This is expansion T (times 1 + nu in plane
strain) and the elastic strain: either that at both ends of the line, taken for all of it, or that
of the rock's stress across the line and of its stretch along the crack, point by point.
"""

from pathlib import Path

import numpy as np
import pyvista

SAMPLES = 161


def jumps(
    fields: Path,
    at: np.ndarray,
    normals: np.ndarray,
    *,
    reach: float,
    expansion: float,
    rock: tuple[float, float, str] | None = None,
    rest: float = 0.0,
) -> np.ndarray:
    """The opening (m) at points of cracks, shape (n,); nan where a line leaves the body.

    at, normals: shape (n, 3). reach: of the line to each side (m). rock: E (Pa), nu and the plane
    state, for the elastic strain point by point. rest: a prestress (Pa), the same in all directions
    (in plane stress, in the plane).
    """
    mesh = pyvista.read(fields).compute_derivative(scalars="u", gradient="grad")
    s = np.linspace(-reach, reach, SAMPLES)
    lines = at[:, None, :] + s[None, :, None] * normals[:, None, :]
    found = pyvista.PolyData(lines.reshape(-1, 3)).sample(mesh)
    inside = np.asarray(found["vtkValidPointMask"]).reshape(len(at), -1).all(axis=1)
    u = np.asarray(found["u"]).reshape(len(at), -1, 3)
    grad = np.asarray(found["grad"]).reshape(len(at), -1, 3, 3)
    free = expansion * np.asarray(found["T"]).reshape(len(at), -1)
    across = normals[:, :, None] * normals[:, None, :]
    jump = np.einsum("ki,ki->k", u[:, -1] - u[:, 0], normals)
    stretch = np.einsum("kij,ksij->ks", across, grad)
    if rock is None:
        beside = (stretch - free)[:, [0, -1]].mean(axis=1)
        intact = np.trapezoid(free, s, axis=1) + beside * 2 * reach
        return np.where(inside, jump - intact, np.nan)
    E, nu, state = rock
    stress = np.asarray(found["stress"]).reshape(len(at), -1, 3, 3)
    traction = np.einsum("kij,ksij->ks", across, stress)
    along = np.einsum("ksii->ks", grad[..., :2, :2]) - stretch
    if state == "plane stress":
        at_rest = (1 - nu) * rest / E
        others, over, lost = along - free + at_rest, nu, (1 - nu**2) / E
    else:
        at_rest = (1 - 2 * nu) * rest / E
        others = along + grad[..., 2, 2] - 2 * free + 2 * at_rest
        over, lost = nu / (1 - nu), (1 + nu) * (1 - 2 * nu) / (1 - nu) / E
    intact = free - at_rest + lost * traction - over * others
    return np.where(inside, jump - np.trapezoid(intact, s, axis=1), np.nan)

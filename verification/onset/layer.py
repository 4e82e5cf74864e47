"""When a damaged layer under a cold face stops being the only one: wave by wave, without `staffa`.

The layer depends on depth alone; beside it go u = (U(y) sin kx, V(y) cos kx) and
beta = B(y) cos kx, with B free where there is damage. Plane stress, AT1, linear elements in y;
E = Gc = expansion = ell ell0 = 1.
"""

from math import pi, sqrt

import numpy as np
from scipy.optimize import brentq
from scipy.special import erfc

NU, DEPTH, H = 0.2, 16.0, 0.05


def regularization_length(m: float) -> float:
    """ell over sqrt(ell ell0), where dT/dT_c = m = sqrt(8 ell/(3 ell0))."""
    return m * sqrt(3 / 8)


def _elements() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Two Gauss points a cell: depths and weights, values and slopes of the elements there."""
    cells = round(DEPTH / H)
    cell = np.repeat(np.arange(cells), 2)
    at = np.tile([(1 - 1 / sqrt(3)) / 2, (1 + 1 / sqrt(3)) / 2], cells)
    values, slopes = np.zeros((2, 2 * cells, cells + 1))
    rows = np.arange(2 * cells)
    values[rows, cell], values[rows, cell + 1] = 1 - at, at
    slopes[rows, cell], slopes[rows, cell + 1] = -1 / H, 1 / H
    return (cell + at) * H, np.full(2 * cells, H / 2), values, slopes


Y, W, N, D = _elements()


def _form(left: np.ndarray, weight: np.ndarray, right: np.ndarray) -> np.ndarray:
    return left.T @ ((W * weight)[:, None] * right)


def damage(m: float, diffusion: float) -> tuple[np.ndarray, np.ndarray]:
    """Damage at the nodes when sqrt(kappa t) is `diffusion`, and True where it is not zero."""
    ell = regularization_length(m)
    drive = ell * erfc(Y / (2 * diffusion)) ** 2  # (expansion dT)^2 = ell
    A = _form(N, drive, N) + 0.75 * ell * _form(D, np.ones_like(Y), D)
    f = N.T @ (W * (drive - 3 / (8 * ell)))
    alpha, free = np.zeros(len(f)), np.ones(len(f), dtype=bool)
    for _ in range(200):
        alpha[:] = 0.0
        alpha[free] = np.linalg.solve(A[np.ix_(free, free)], f[free])
        after = np.where(free, alpha > 0, A @ alpha < f)
        if (after == free).all():
            return alpha, free
        free = after
    raise RuntimeError(f"the layer was not found at sqrt(kappa t) = {diffusion}")


def curvature(m: float, diffusion: float, wavelength: float) -> float:
    """Smallest second variation of the energy along waves of this length."""
    ell, k, shear = regularization_length(m), 2 * pi / wavelength, 1 / (2 * (1 + NU))
    alpha, free = damage(m, diffusion)
    left, theta = 1 - N @ alpha, erfc(Y / (2 * diffusion))
    a, plane, none = left**2, left**2 / (1 - NU**2), np.zeros_like(N)
    # The rows are strains e_xx, e_yy, 2 e_xy by displacements U, V.
    xx, yy, xy = np.hstack([k * N, none]), np.hstack([none, D]), np.hstack([D, -k * N])
    K = _form(xx, plane, xx) + _form(yy, plane, yy) + _form(xy, shear * a, xy)
    K += NU * (_form(xx, plane, yy) + _form(yy, plane, xx))
    C = _form(xx, -2 * left * sqrt(ell) * theta, N)[:, free]
    H = _form(N, ell * theta**2 + 0.75 * ell * k**2, N) + 0.75 * ell * _form(D, np.ones_like(Y), D)
    S = H[np.ix_(free, free)] - C.T @ np.linalg.solve(K, C)
    return float(np.linalg.eigvalsh(S)[0])


def onset(m: float) -> tuple[float, float]:
    """Wavelength that can grow first, and sqrt(kappa t) then, both over sqrt(ell ell0)."""
    lengths = np.arange(8.0, 13.1, 0.5)
    times = [brentq(lambda d, p=p: curvature(m, d, p), 0.6, 1.2, xtol=1e-4) for p in lengths]
    return lowest(lengths, np.array(times))


def lowest(x: np.ndarray, y: np.ndarray) -> tuple[float, float]:
    """The lowest point of the parabola through the lowest value and its two neighbors."""
    i = int(np.argmin(y))
    if not 0 < i < len(y) - 1:
        raise RuntimeError(f"the lowest value lies at an end of the scan: {x}, {y}")
    parabola = np.polyfit(x[i - 1 : i + 2], y[i - 1 : i + 2], 2)
    place = -parabola[1] / (2 * parabola[0])
    return float(place), float(np.polyval(parabola, place))

"""Random fields of the rock: functions of position alone, so that any mesh partition sees one."""

from math import gamma

import numpy as np

from staffa.physics.elasticity import PointFunction
from staffa.properties.remembered import Remembered

DISTRIBUTIONS = ("lognormal", "normal", "weibull")


def random_factor(
    distribution: str,
    variation: float,
    *,
    lengths: tuple[float, ...],
    axes: np.ndarray,
    seed: int,
) -> PointFunction:
    """Return a field of mean 1 and this coefficient of variation, at points of shape (3, n).

    It is g(z) of a normal score z, a sum of waves whose numbers come from the seed (GSTools,
    Gaussian correlation; Hesse et al., Env. Modell. Softw. 55, 32, 2014), which is evaluated at
    the points themselves.

    Parameters
    ----------
    distribution : distribution of the values, which gives g.
    variation : coefficient of variation, dimensionless.
    lengths : correlation lengths of z (m): the integral of its correlation along each of the axes.
    axes : rows are perpendicular directions, shape (dim, dim).
    seed : seed of the random numbers.
    """
    import gstools  # takes a second to load, and few cases need it

    dim, same = len(axes), len(set(lengths)) == 1
    model = gstools.Gaussian(dim=dim, var=1.0, len_scale=lengths[0] if same else list(lengths))
    score = gstools.SRF(model, seed=seed)

    def factor(x: np.ndarray) -> np.ndarray:
        if x.shape[1] == 0:
            return np.ones(0)
        places = x[:dim] if same else axes @ x[:dim]
        return marginal(distribution, variation, score(tuple(places), store=False))

    return Remembered(factor)


def marginal(distribution: str, variation: float, z: np.ndarray) -> np.ndarray:
    """Return values of mean 1 and this coefficient of variation, increasing, from normal scores z.

    A Weibull value is (-ln(1 - Phi(z)))^(1/m)/Gamma(1 + 1/m), its inverse distribution function at
    Phi(z).
    """
    if distribution == "normal":
        return 1 + variation * z
    if distribution == "lognormal":
        log_variance = np.log1p(variation**2)
        return np.asarray(np.exp(np.sqrt(log_variance) * z - log_variance / 2))
    from scipy.special import log_ndtr

    m = weibull_modulus(variation)
    return np.asarray((-log_ndtr(-z)) ** (1 / m) / gamma(1 + 1 / m))


def weibull_modulus(variation: float) -> float:
    """Return the modulus m of a Weibull distribution from its coefficient of variation.

    The coefficient, between 0.001 and 1, is sqrt(Gamma(1 + 2/m)/Gamma(1 + 1/m)^2 - 1).
    """
    from scipy.optimize import brentq
    from scipy.special import gammaln

    def excess(m: float) -> float:
        return float(np.expm1(gammaln(1 + 2 / m) - 2 * gammaln(1 + 1 / m)) - variation**2)

    return float(brentq(excess, 0.5, 2000.0))

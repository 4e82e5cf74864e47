"""Where the rock is tougher, weaker, or already cracked: functions of position alone."""

import numpy as np

from staffa.cases.model import Case, Disc, Segment
from staffa.evolution.problem import PointFunction


def toughness_factor(case: Case) -> PointFunction:
    """Toughness over Gc at points: a seeded lognormal field of mean 1, times the bands' factors.

    The field is a sum of waves whose numbers come from the seed (GSTools, Gaussian correlation),
    evaluated at the points, so that it is the same on any mesh partition.
    """
    keys = case.toughness
    noise = _noise(case) if keys.amplitude > 0 else None

    def factor(x: np.ndarray) -> np.ndarray:
        values = np.ones(x.shape[1])
        if noise is not None:
            values *= noise(x)
        for band in keys.bands:
            bounds = zip(x, band.lower, band.upper, strict=False)
            inside = np.all([(c >= low) & (c <= high) for c, low, high in bounds], axis=0)
            values[inside] *= band.factor
        return values

    return factor


def _noise(case: Case) -> PointFunction:
    import gstools  # takes a second to load, and few cases need it

    keys, dim = case.toughness, case.dim
    model = gstools.Gaussian(dim=dim, var=1.0, len_scale=float(keys.correlation_length or 0))
    field = gstools.SRF(model, seed=keys.seed)
    log_variance = np.log1p(keys.amplitude**2)  # so that the coefficient of variation is amplitude

    def noise(x: np.ndarray) -> np.ndarray:
        if x.shape[1] == 0:
            return np.ones(0)
        normal = field(tuple(x[:dim]), store=False)
        return np.exp(np.sqrt(log_variance) * normal - log_variance / 2)

    return noise


def cracked(case: Case, h: float) -> PointFunction:
    """True within a cell edge h of a crack of the case: so that a layer of cells breaks wherever
    the crack lies in the mesh."""
    reach = h * (1 + 1e-9)

    def near(x: np.ndarray) -> np.ndarray:
        found = np.zeros(x.shape[1], dtype=bool)
        for crack in case.cracks:
            found |= _distance(crack, x) <= reach
        return found

    return near


def _distance(crack: Segment | Disc, x: np.ndarray) -> np.ndarray:
    return _from_disc(crack, x) if isinstance(crack, Disc) else _from_segment(crack, x)


def _from_segment(crack: Segment, x: np.ndarray) -> np.ndarray:
    start, end = np.array(crack.start, dtype=float), np.array(crack.end, dtype=float)
    along = end - start
    offset = x[:2] - start[:, None]
    fraction = np.clip(along @ offset / (along @ along), 0.0, 1.0)
    return np.linalg.norm(offset - np.outer(along, fraction), axis=0)


def _from_disc(crack: Disc, x: np.ndarray) -> np.ndarray:
    normal = np.array(crack.normal, dtype=float) / np.linalg.norm(crack.normal)
    offset = x - np.array(crack.center, dtype=float)[:, None]
    height = normal @ offset
    radial = np.linalg.norm(offset - np.outer(normal, height), axis=0)
    return np.hypot(height, np.maximum(radial - float(crack.radius), 0.0))

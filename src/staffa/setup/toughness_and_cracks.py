"""Tougher, weaker and initially cracked parts of the rock: functions of position alone."""

import numpy as np

from staffa.case.schema.boxes import product
from staffa.case.schema.case import Case, Disc, Named, Segment
from staffa.evolution.problem import ones
from staffa.geometry.places import SAME
from staffa.model.initial_cracks import FlatCrack
from staffa.physics.elasticity import PointFunction
from staffa.properties.random_field import random_factor


def toughness_factor(case: Case) -> PointFunction:
    """Return the toughness over that of the rock at points, from the table [toughness].

    It is a seeded lognormal field of mean 1, times the factors of the bands.
    """
    keys = case.toughness
    noise: PointFunction = ones
    if keys.amplitude > 0:
        noise = random_factor(
            "lognormal",
            keys.amplitude,
            lengths=(float(keys.correlation_length or 0),) * case.dim,
            axes=np.eye(case.dim),
            seed=keys.seed,
        )
    bands = [(band, band.factor) for band in keys.bands]
    return lambda x: product(x, bands, h=case.outline.h, start=noise(x))


def cracks_of_case(case: Case) -> tuple[Segment | Disc, ...]:
    """Return the cracks whose shape the case gives; others are the mesh's own."""
    return tuple(crack for crack in case.cracks if not isinstance(crack, Named))


def cracked(case: Case, h: float) -> PointFunction:
    """Return True on both sides of a crack of the case, h wide in all and h/2 beyond its ends.

    The distance is counted with its sign, and one end of the range is left out: so that exactly
    one layer of cells of edge h breaks, also where a crack lies on their vertices.
    """

    def near(x: np.ndarray) -> np.ndarray:
        found = np.zeros(x.shape[1], dtype=bool)
        for crack in cracks_of_case(case):
            across, beyond = _disc(crack, x) if isinstance(crack, Disc) else _segment(crack, x)
            tiny = SAME * h
            found |= (across > -h + tiny) & (across <= h + tiny) & (beyond <= h / 2 + tiny)
        return found

    return near


def _segment(crack: Segment, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the signed distance across the crack's line, and that beyond its ends (m)."""
    start, end = np.array(crack.start, dtype=float), np.array(crack.end, dtype=float)
    length = float(np.linalg.norm(end - start))
    along, offset = (end - start) / length, x[:2] - start[:, None]
    position = along @ offset
    across = along[0] * offset[1] - along[1] * offset[0]
    return across, np.maximum(-position, position - length)


def _disc(crack: Disc, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the signed distance across the disc's plane, and that beyond its rim (m)."""
    normal = np.array(crack.normal, dtype=float) / np.linalg.norm(crack.normal)
    offset = x - np.array(crack.center, dtype=float)[:, None]
    across = normal @ offset
    radial = np.linalg.norm(offset - np.outer(normal, across), axis=0)
    return across, radial - float(crack.radius)


def flat_cracks(case: Case) -> tuple[FlatCrack, ...]:
    """Return the cracks of a case by their shapes, for unstructured cells: the cells they cut
    break.

    Their vertices lie anywhere: those within h of a line leave cells whole across it, which held a
    plate in traction together with 5 to 16 % of its stiffness.
    """
    return tuple(_flat(crack) for crack in cracks_of_case(case))


def _flat(crack: Segment | Disc) -> FlatCrack:
    if isinstance(crack, Disc):
        x, y, z = (float(c) for c in crack.center)
        a, b, c = np.array(crack.normal, dtype=float) / np.linalg.norm(crack.normal)
        return FlatCrack(center=(x, y, z), normal=(a, b, c), radius=float(crack.radius))
    start, end = np.array(crack.start, dtype=float), np.array(crack.end, dtype=float)
    length = float(np.linalg.norm(end - start))
    (x, y), (a, b) = (start + end) / 2, (end - start) / length
    return FlatCrack(center=(x, y, 0.0), normal=(-b, a, 0.0), radius=length / 2)

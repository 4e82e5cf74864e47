"""The yardstick's cases: body, rock, loads and times, as plain numbers that both sides read."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import gstools
import numpy as np
from scipy.special import erfc

from staffa.geometry.block import edge, halvings
from staffa.properties.remembered import Remembered

PointFunction = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True, kw_only=True)
class BenchCase:
    """One body on one mesh; scaled, E = Gc = expansion = 1.

    size, counts: extent and number of square cells along each axis. law: "AT1" or "AT2". state:
    "plane stress" or "solid". severity: temperature drop of the cooled face (y = 0 in 2-D, z = 0
    in 3-D), whose times are taus; 0 where the top is pulled by the times instead, the bottom
    clamped, and a notch runs from the left to the middle. tolerance: largest change of the damage
    in the last sweep; at ten times this one the script ends A's first step after 3 sweeps, on the
    plateau before its cracks appear, instead of 120.
    """

    name: str
    size: tuple[float, ...]
    counts: tuple[int, ...]
    law: str
    state: str
    ell: float
    severity: float
    times: tuple[float, ...]
    ranks: tuple[int, ...] = (1,)
    nu: float = 0.2
    residual_stiffness: float = 1e-6
    spread: float = 0.05
    correlation_length: float = 0.06
    seed: int = 1
    tolerance: float = 1e-4

    @property
    def dim(self) -> int:
        """2 or 3."""
        return len(self.size)

    @property
    def h(self) -> float:
        """Edge of a cell."""
        return self.size[0] / self.counts[0]

    @property
    def longest(self) -> float:
        """Longest edge of the simplices that stand for the script's cells.

        Four triangles to a square of sides sqrt(2) h have legs h, and as many vertices as squares
        of sides h; six tetrahedra to a cube of edges h have those of the cube.
        """
        return self.h * (2**0.5 if self.dim == 2 else 1.0)

    @property
    def halvings(self) -> int:
        """Number of times that edges of a mesh that follows the cracks are halved.

        Such a mesh is a block's, whose cells end at `longest` or shorter. It begins with cells at
        least 4 times as long, and at most a quarter of the shortest side: the coarsest of those
        that end within 5 % of `longest`, or the one that ends nearest to it.
        """
        most = halvings(min(self.size) / 4, self.longest, self.size)
        several = range(min(2, most), most + 1)
        near = [k for k in several if self.finest(k) >= 0.95 * self.longest]
        return max(near) if near else max(several, key=self.finest)

    def finest(self, halved: int) -> float:
        """Return the longest edge of a block's finest square or cube, halved so often."""
        whole = 2**halved * self.longest
        return edge(self.size, whole, "triangle") / 2**halved

    @property
    def unknowns(self) -> int:
        """Number of displacement unknowns."""
        return self.dim * int(np.prod([n + 1 for n in self.counts]))

    def temperature(self, x: np.ndarray, tau: float) -> np.ndarray:
        """Half-space after a sudden drop, T = -severity erfc(y/tau); x of shape (3, n)."""
        return -self.severity * erfc(x[self.dim - 1] / tau)

    @property
    def toughness(self) -> PointFunction:
        """A seeded lognormal field of mean 1, at points of shape (3, n)."""
        model = gstools.Gaussian(dim=self.dim, var=1.0, len_scale=self.correlation_length)
        field = gstools.SRF(model, seed=self.seed)
        variance = np.log1p(self.spread**2)

        def factor(x: np.ndarray) -> np.ndarray:
            normal = field(tuple(x[: self.dim]), store=False)
            return np.exp(np.sqrt(variance) * normal - variance / 2)

        return Remembered(factor)

    def cracked(self, x: np.ndarray) -> np.ndarray:
        """True at the points of the notch, one layer of cells, where there is one."""
        if self.severity:
            return np.zeros(x.shape[1], dtype=bool)
        across, h = x[1] - self.size[1] / 2, self.h
        return (across > -0.9 * h) & (across < 1.1 * h) & (x[0] <= self.size[0] / 2 + 1e-9)


def slab(name: str, n: int, times: tuple[float, ...]) -> BenchCase:
    """The paper's slab, cut to a square between symmetry lines."""
    return BenchCase(
        name=name,
        size=(1.0, 1.0),
        counts=(n, n),
        law="AT1",
        state="plane stress",
        ell=0.03,
        severity=54.0,
        times=times,
    )


def brick(name: str, n: int) -> BenchCase:
    """A cube cooled from below, between symmetry planes."""
    return BenchCase(
        name=name,
        size=(1.0, 1.0, 1.0),
        counts=(n, n, n),
        law="AT1",
        state="solid",
        ell=0.15,
        severity=6.0,
        times=(0.1, 0.2),
        ranks=(1, 2),
        spread=0.3,
        correlation_length=0.2,
    )


def large_brick(name: str, n: int) -> BenchCase:
    """A cube three times as large as `brick` in units of ell, cooled as strongly in these units.

    Its edge is 20 ell, and h = ell/3 at n = 60. Cracks and cold stay near the cooled face.
    """
    small, ratio = brick(name, n), 3
    return replace(
        small,
        ell=small.ell / ratio,
        severity=small.severity * ratio**0.5,
        times=tuple(round(tau / ratio, 3) for tau in small.times),
        correlation_length=small.correlation_length / ratio,
        ranks=(1,),
    )


TEN = tuple(round(0.02 * i, 2) for i in range(1, 11))

CASES = {
    case.name: case
    for case in (
        slab("A30k", 122, TEN),
        slab("A120k", 244, TEN),
        slab("B30k", 122, (0.05, 0.1)),  # what B480k's growth is measured from
        slab("B480k", 489, (0.05, 0.1)),
        BenchCase(
            name="C120k",
            size=(1.0, 1.0),
            counts=(244, 244),
            law="AT2",
            state="plane stress",
            ell=0.02,
            severity=0.0,
            times=(1.0, 1.4, 1.6, 1.7),
        ),
        brick("D100k", 31),
        brick("D300k", 45),
        large_brick("E680k", 60),
    )
}
# Small enough to count, in a few seconds each, how many sweeps and iterations they take.
COUNTED = {
    case.name: case
    for case in (
        replace(slab("slab, 3k", 40, TEN[1:6:2]), ell=0.08),
        replace(CASES["C120k"], name="notch, 3k", counts=(40, 40), ell=0.08, times=(1.0, 1.4)),
        replace(brick("brick, 4k", 10), ell=0.3),
    )
}
# Small enough to try every preset on, from start to end.
SMALL = {case.name: case for case in (slab("slab, 30k", 122, TEN[:4]), brick("brick, 28k", 20))}

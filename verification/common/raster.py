"""The last damage of a run on squares, as an array, and the connected cracks in it."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import label

from staffa.io.run_directory import Run
from staffa.plot.frames import read_frames
from staffa.records.step import Step

BROKEN = 0.8  # as measures.threshold


@dataclass(frozen=True, kw_only=True)
class Raster:
    """Vertices at x (m,) and y (n,), damage alpha (n, m) there."""

    x: np.ndarray
    y: np.ndarray
    alpha: np.ndarray

    def cracks(self) -> list[np.ndarray]:
        """Broken vertices that hang together, shape (k, 2), one array for each crack."""
        found, number = label(self.alpha > BROKEN, structure=np.ones((3, 3)))
        rows_columns = (np.nonzero(found == k) for k in range(1, number + 1))
        return [np.column_stack([self.x[j], self.y[i]]) for i, j in rows_columns]


def raster(run: Run, step: Step | None = None) -> Raster:
    """The damage of a step whose fields were kept, by default the last one."""
    (frame,), _ = read_frames(run, [step or run.steps[-1]])
    points = frame.grid.points.round(9)
    x, y = np.unique(points[:, 0]), np.unique(points[:, 1])
    order = np.lexsort((points[:, 0], points[:, 1]))
    return Raster(x=x, y=y, alpha=frame.alpha[order].reshape(len(y), len(x)))

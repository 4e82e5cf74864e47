"""Damage of a 3-D body on planes below the cooled face, and the polygonal cells in them."""

from collections.abc import Sequence

import numpy as np

from staffa.backend.parallel import gather, on_root
from staffa.geometry.block import section_raster
from staffa.loads.closed_form import Face
from staffa.measure.cells import cell_section, cells
from staffa.measure.probes import located
from staffa.model.domain import Domain
from staffa.model.fields import State
from staffa.records.step import CellSection


class Planes:
    """Pixel grids of edge h/2 on depth planes, found in the mesh once."""

    def __init__(
        self, domain: Domain, face: Face, depths: Sequence[float], *, ell: float, threshold: float
    ) -> None:
        """Find the pixels of all planes. Collective.

        Parameters
        ----------
        domain : the mesh.
        face : the cooled face.
        depths : depths of the planes below the face (m).
        ell : regularization length (m).
        threshold : damage above which a pixel is cracked.
        """
        self.comm, self.depths, self.ell, self.threshold = domain.comm, depths, ell, threshold
        flat = [axis for axis in range(3) if axis != face.axis]
        raster = section_raster((domain.size[flat[0]], domain.size[flat[1]]), domain.h)
        self.shape, self.pixel = raster.counts, raster.pixel
        middles = raster.middles
        at = np.empty((len(depths), len(middles), 3))
        at[:, :, flat] = np.array(domain.lower)[flat] + middles
        at[:, :, face.axis] = (face.position + face.inward * np.array(depths))[:, None]
        points = at.reshape(-1, 3)
        self.here, self.cells = located(domain, points)
        self.points = points[self.here]

    def __call__(self, state: State) -> tuple[CellSection, ...]:
        """Return the polygonal cells at each depth, the same on every rank. Collective."""
        damage = state.alpha.eval(self.points, self.cells).ravel() if len(self.here) else self.here
        found = gather(self.comm, np.stack([self.here, damage]))

        def measured() -> tuple[CellSection, ...]:
            place, values = np.concatenate(found or [], axis=1)
            planes = np.full((len(self.depths), *self.shape), np.nan)  # what no rank has is outside
            planes.flat[place.astype(int)] = values
            return tuple(map(self._section, self.depths, planes))

        return on_root(self.comm, measured)

    def _section(self, depth: float, damage: np.ndarray) -> CellSection:
        found = cells(damage, pixel=self.pixel, ell=self.ell, threshold=self.threshold)
        return cell_section(found, depth=depth, pixel=self.pixel)

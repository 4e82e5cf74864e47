"""Permeability of a reservoir's cells with the cracks of the rock in them."""

from dataclasses import dataclass

import numpy as np

from staffa.geometry.block import SIDES
from staffa.records.crack_flow import CrackFlow, SideOpening
from staffa.records.reservoir_facts import CrackRule
from staffa.reservoir.crack_spacing import crack_spacing
from staffa.reservoir.permeability import of_opening, rock_cells, spreading
from staffa.reservoir.simulator import Fracture, ReservoirModel

# Share of the area that a straight crack has in a unit of volume, 2/(pi spread), below which the
# opening of a cell is not told: nothing of a crack but the end of its damage is there.
FEW = 0.1
SEEN = 5.0  # spreads within which the next crack is looked for


@dataclass(frozen=True, kw_only=True)
class CrackedCells:
    """Cracks of the rock, sorted into the cells of a reservoir.

    Attributes
    ----------
    area : area of cracks in each cell (m^2), shape (n_cells,).
    volume : volume of open cracks in each cell (m^3), shape (n_cells,).
    along : area times the share of it that counts along each axis, `permeability.along_axes`, in
        each cell (m^2), shape (n_cells, 3).
    across : sum of area times n_i n_j in each cell (m^2), with n the normals of cracks, shape
        (n_cells, dim, dim).
    walls : displacement (m) of the wall into the body, at each cell of the rows of fractures, the
        fractures in their order in the model, shape (n_rows,).
    """

    area: np.ndarray
    volume: np.ndarray
    along: np.ndarray
    across: np.ndarray
    walls: np.ndarray


@dataclass(frozen=True, kw_only=True)
class CrackedPermeability:
    """Permeability of the cells, and how it came about.

    Attributes
    ----------
    k : permeability (m^2) along each axis, shape (n_cells, 3).
    w : opening of cracks within its bounds (m), 0 where there are none, shape (n_cells,).
    A : area of cracks in a unit of volume (1/m), shape (n_cells,).
    account : the same in a few numbers.
    """

    k: np.ndarray
    w: np.ndarray
    A: np.ndarray
    account: CrackFlow


class CrackPermeability:
    """Permeability from cracks: k_0 + A w^3/12 along them, with w = V/A.

    A and V are area and volume of cracks in a unit of the cells' volume, both spread over a radius,
    since fluxes between two cells lose an oblique crack else. `along_axes` tells how much of A
    counts along each axis. The row of a fracture along a side opens as its wall moves into the
    body: w = w_0 + 2 u, and k = w^3/(24 b).

    Parameters
    ----------
    model : the reservoir.
    rule : bounds of the opening, and the radius.
    """

    def __init__(self, model: ReservoirModel, rule: CrackRule) -> None:
        self.model, self.rule = model, rule
        k = np.array(model.permeability, dtype=float)
        self._k0 = k if k.ndim == 2 else np.repeat(k[:, None], 3, axis=1)
        rock, half = rock_cells(model.grid), rule.spread / 2
        self._spreading = spreading(model.grid, rule.spread, rock)
        self._bands = (spreading(model.grid, half, rock), half)
        self._rows = [model.grid.row(fracture.side) for fracture in model.fractures]

    @property
    def n_rows(self) -> int:
        """Number of cells in the rows of all fractures."""
        return sum(map(len, self._rows))

    def __call__(self, cracks: CrackedCells, walls_at_rest: np.ndarray) -> CrackedPermeability:
        """Return the permeability with cracks.

        Parameters
        ----------
        cracks : the cracks.
        walls_at_rest : displacement of the walls (m) at which fractures have the opening of the
            model, shape (n_rows,).
        """
        model, rule = self.model, self.rule
        area, volume = self._spreading @ cracks.area, self._spreading @ cracks.volume
        A = area / model.grid.volumes
        free = np.divide(volume, area, out=np.zeros_like(area), where=area > 0)
        w = np.where(area > 0, np.clip(free, rule.smallest, rule.largest), 0.0)
        along = self._spreading @ cracks.along / model.grid.volumes[:, None]
        k = self._k0 + along * (w**3 / 12)[:, None]
        sides, opened = {}, 0.0
        ends = np.cumsum([len(row) for row in self._rows])[:-1]
        moved = np.split(cracks.walls - walls_at_rest, ends)
        for fracture, row, into_body in zip(model.fractures, self._rows, moved, strict=False):
            opening = fracture.opening + 2 * into_body
            clipped = np.clip(opening, rule.smallest, rule.largest)
            k[row] = of_opening(clipped, fracture.height)[:, None]
            # Half of the fracture is in the cells.
            opened += float(into_body @ model.grid.volumes[row]) / (fracture.height / 2)
            sides[self._name(fracture)] = _side(opening, rule)
        cracked = FEW * 2 / (np.pi * rule.spread) < A
        total = float(area.sum())

        def share(where: np.ndarray) -> float:
            return float(area[where].sum()) / total if total else 0.0

        account = CrackFlow(
            area=float(cracks.area.sum()),
            volume=float(cracks.volume.sum()),
            opened=opened,
            widest=float(free[cracked].max(initial=0.0)),
            at_smallest=share(free < rule.smallest),
            at_largest=share(free > rule.largest),
            permeability=float(k[cracked].max(initial=0.0)),
            spacing=crack_spacing(
                model.grid, cracks.area, cracks.across, self._bands, SEEN * rule.spread
            ),
            sides=sides,
        )
        return CrackedPermeability(k=k, w=w, A=A, account=account)

    def _name(self, fracture: Fracture) -> str:
        sides = SIDES[self.model.grid.dim]
        return next(name for name, side in sides.items() if side == fracture.side)


def _side(opening: np.ndarray, rule: CrackRule) -> SideOpening:
    return SideOpening(
        narrowest=float(opening.min()),
        widest=float(opening.max()),
        at_smallest=float(np.mean(opening < rule.smallest)),
        at_largest=float(np.mean(opening > rule.largest)),
    )

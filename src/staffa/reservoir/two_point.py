"""Fluxes between two neighboring cells, and between a well and a cell."""

from dataclasses import dataclass

import numpy as np

from staffa.reservoir.grid import Grid
from staffa.reservoir.simulator import ReservoirModel, Well

LEAST = 0.2  # of the logarithm in a well index: of a cell that is hardly larger than the borehole


@dataclass(frozen=True, kw_only=True)
class Connections:
    """Faces between two cells, of all axes.

    Attributes
    ----------
    lower, upper : indices of the cells on both sides of each face, shape (n_faces,).
    area : area of each face (m^2), shape (n_faces,).
    from_lower, from_upper : distances (m) from the nodes of the cells to the face.
    axis : axis across each face, shape (n_faces,).
    """

    lower: np.ndarray
    upper: np.ndarray
    area: np.ndarray
    from_lower: np.ndarray
    from_upper: np.ndarray
    axis: np.ndarray

    def conductance(self, values: np.ndarray) -> np.ndarray:
        """Return area over resistance of each face, the two cells in series, shape (n_faces,).

        Parameters
        ----------
        values : permeability or conductivity of each cell, shape (n_cells,), or along each axis,
            shape (n_cells, 3).
        """
        resistance = np.zeros(len(self.area))
        for cells, way in ((self.lower, self.from_lower), (self.upper, self.from_upper)):
            with np.errstate(divide="ignore", invalid="ignore"):
                of_cells = values[cells] if values.ndim == 1 else values[cells, self.axis]
                resistance += np.where(way > 0, way / of_cells, 0.0)
        with np.errstate(divide="ignore"):
            return self.area / resistance


def connections(grid: Grid) -> Connections:
    """Return the faces between the cells of a grid, those across the first axis first.

    Distances are counted from the nodes, so the row of a fracture has no resistance across it.
    """
    index = np.arange(grid.size).reshape(grid.shape, order="F")
    found = []
    for axis in range(3):
        lower = index.take(range(grid.shape[axis] - 1), axis).ravel(order="F")
        upper = index.take(range(1, grid.shape[axis]), axis).ravel(order="F")
        across = np.delete(grid.sizes[lower], axis, axis=1).prod(axis=1)
        face = grid.centers[lower, axis] + grid.sizes[lower, axis] / 2
        ways = [np.abs(face - grid.nodes[cells, axis]) for cells in (lower, upper)]
        # Of a node on the face, the difference may be a rounding error.
        near = 1e-12 * (grid.edges[axis][-1] - grid.edges[axis][0])
        near_and_far = (np.where(way > near, way, 0.0) for way in ways)
        found.append([lower, upper, across, *near_and_far, np.full(len(lower), axis)])
    lower, upper, area, from_lower, from_upper, axes = (
        np.concatenate(parts) for parts in zip(*found, strict=True)
    )
    return Connections(
        lower=lower, upper=upper, area=area, from_lower=from_lower, from_upper=from_upper, axis=axes
    )


def well_indices(model: ReservoirModel, well: Well, permeability: np.ndarray) -> np.ndarray:
    """Return the flow (m^3) that a well has with each of its cells, per pressure over viscosity.

    It is Peaceman's: 2 pi k length/ln(r_e/radius) with r_e = 0.14 times the diagonal of the cell
    across the well. Where permeability differs along the two axes across it, the larger one counts:
    a well on a crack opens to the crack. A well crosses a 2-D body along its thickness, a fracture
    along a side of a 3-D body at a right angle to it, and other cells along gravity. In a fracture
    of a 2-D body water comes in along the whole thickness, and flows to the end of the cell and not
    around the well: there the index is that of half the cell.

    Parameters
    ----------
    model : the reservoir.
    well : one of its wells.
    permeability : permeability (m^2) of each cell, shape (n_cells,), or along each axis, shape
        (n_cells, 3).
    """
    return np.array([_well_index(model, well.radius, cell, permeability) for cell in well.cells])


def _well_index(model: ReservoirModel, radius: float, cell: int, permeability: np.ndarray) -> float:
    grid, sizes = model.grid, model.grid.sizes[cell]
    k = np.broadcast_to(permeability[cell], 3)
    in_rows = [axis for axis, end in grid.rows if cell in grid.row((axis, end))]
    if grid.dim == 2 and in_rows:
        along = 1 - in_rows[0]
        across = np.delete(sizes, along).prod()
        return float(k[along] * across / (sizes[along] / 2))
    if grid.dim == 2:
        axis = 2
    elif in_rows:
        axis = in_rows[0]
    else:
        axis = int(np.argmax(np.abs(model.gravity))) if any(model.gravity) else 2
    equivalent = 0.14 * np.linalg.norm(np.delete(sizes, axis))
    best = np.delete(k, axis).max()
    return float(2 * np.pi * best * sizes[axis] / max(np.log(equivalent / radius), LEAST))

"""The record of the mesh of a step, where the mesh follows the cracks."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class RefinedMesh:
    """Mesh of a step.

    Attributes
    ----------
    cells
        Number of its cells.
    vertices
        Number of its vertices.
    changes
        Number of times that cells were split since the step before.
    energy
        Change of the total energy by that alone, with the cracks and loads of the step before (J;
        in 2-D J/m).
    coarse_damage
        Largest damage in a cell that is not among the finest.
    """

    cells: int
    vertices: int
    changes: int = 0
    energy: float = 0.0
    coarse_damage: float = 0.0

"""Growth of a mesh that follows the cracks over a run."""

from dataclasses import dataclass

from staffa.io.run_directory import Run


@dataclass(frozen=True, kw_only=True)
class MeshChanges:
    """Changes of the mesh of a run; none of a mesh that stays as it is.

    Attributes
    ----------
    start, end : numbers of cells before the first step and after the last.
    times : number of times that cells were split.
    energy : change of the total energy by that alone (J; in 2-D J/m).
    coarse_damage : largest damage in a coarse cell, at any step.
    """

    start: int
    end: int
    times: int = 0
    energy: float = 0.0
    coarse_damage: float = 0.0


def mesh_changes(run: Run) -> MeshChanges:
    """Return the changes of the mesh of a run."""
    cells, meshes = run.manifest.cells, [step.mesh for step in run.steps if step.mesh]
    return MeshChanges(
        start=cells,
        end=meshes[-1].cells if meshes else cells,
        times=sum(mesh.changes for mesh in meshes),
        energy=sum(mesh.energy for mesh in meshes),
        coarse_damage=max((mesh.coarse_damage for mesh in meshes), default=0.0),
    )


def mesh_text(run: Run) -> str:
    """Return the changes of the mesh of a run in words."""
    found, unit = mesh_changes(run), run.manifest.shown.energy
    total = abs(run.steps[-1].energies.total)
    share = f" ({abs(found.energy) / total:.1e} of the total)" if total else ""
    change = f"changed the energy by {unit.text(found.energy, 3)}{share}"
    return (
        f"{found.start:,} cells at the start, {found.end:,} at the end; split {found.times} times, "
        f"which {change if found.energy else 'did not change the energy'}; largest damage in a "
        f"coarse cell {found.coarse_damage:.2g}"
    )

"""What is read off each step of two runs, so that it can be held side by side."""

from collections.abc import Callable
from dataclasses import dataclass

from staffa.compare.pair import Pair, Side
from staffa.geometry.block import face_axis
from staffa.records.step import Step


@dataclass(frozen=True, kw_only=True)
class Reading:
    """A number of a step, on a scale that both runs share; None where a step does not have it.

    whole: it grows with the body, so that only bodies of one size can agree in it.
    """

    name: str
    unit: str
    value: Callable[[Side, Step], float | None]
    whole: bool = True

    def of(self, pair: Pair, steps: tuple[Step, Step]) -> tuple[float | None, float | None]:
        """Of a step of each run."""
        return self.value(pair.first, steps[0]), self.value(pair.second, steps[1])


def readings(pair: Pair) -> dict[str, Reading]:
    """All of them, by name; energies and lengths only of bodies of one dimension."""
    length, energy = pair.length_unit, pair.energy_unit
    plane = pair.first.extents == 2
    size = length if plane or not length else f"{length}²"
    crack = "crack length" if plane else "crack area"
    found = (
        Reading(name="cracks", unit="", value=_cracks),
        Reading(name="spacing", unit=length, value=_spacing, whole=False),
        Reading(name="deepest crack", unit=length, value=_deepest, whole=False),
        Reading(name=crack, unit=size, value=_by_energy),
        Reading(name=f"{crack}, by geometry", unit=size, value=_by_geometry),
        Reading(name="elastic energy", unit=energy, value=_elastic),
        Reading(name="surface energy", unit=energy, value=_surface),
        Reading(name="energy of loads", unit=energy, value=_loads),
        Reading(name="work of friction", unit=energy, value=_friction),
        Reading(name="total energy", unit=energy, value=_total),
    )
    kept = found if pair.dim else [r for r in found if not r.whole or r.name == "cracks"]
    return {reading.name: reading for reading in kept}


def named(reading: Reading) -> str:
    """A reading with its unit."""
    return f"{reading.name} ({reading.unit})" if reading.unit else reading.name


def _cracks(side: Side, step: Step) -> int | None:
    if side.run.manifest.face is None or step.measures is None:
        return None
    return len(step.measures.tips)


def _spacing(side: Side, step: Step) -> float | None:
    """Mean distance of neighboring tips along the face of a 2-D body."""
    face = side.run.manifest.face
    if side.dim == 3 or face is None or step.measures is None or len(step.measures.tips) < 2:
        return None
    along = [tip.position[1 - face_axis(face, 2)] for tip in step.measures.tips]
    return (max(along) - min(along)) / (len(along) - 1) / side.length


def _deepest(side: Side, step: Step) -> float | None:
    if side.run.manifest.face is None or step.measures is None:
        return None
    return side.run.manifest.deepest(step.measures) / side.length


def _by_energy(side: Side, step: Step) -> float | None:
    if step.measures is None:
        return None
    return step.measures.length_surface / side.length ** (side.extents - 1)


def _by_geometry(side: Side, step: Step) -> float | None:
    if step.measures is None:
        return None
    return step.measures.length_geometry / side.length ** (side.extents - 1)


def _elastic(side: Side, step: Step) -> float:
    return step.energies.elastic / side.energy


def _surface(side: Side, step: Step) -> float:
    return step.energies.surface / side.energy


def _loads(side: Side, step: Step) -> float | None:
    return step.energies.loads / side.energy or None


def _friction(side: Side, step: Step) -> float | None:
    return step.energies.friction / side.energy or None


def _total(side: Side, step: Step) -> float:
    return step.energies.total / side.energy

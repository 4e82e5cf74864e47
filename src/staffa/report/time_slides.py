"""Pictures of all times whose fields are kept, for the time slider of a page."""

from dataclasses import dataclass, field
from math import isfinite

import matplotlib

from staffa.io.run_directory import Run
from staffa.plot.frames import Frame, evenly_spread, read_frames, with_fields
from staffa.plot.labels import moment
from staffa.plot.mesh_picture import plane
from staffa.plot.slides import (
    Limits,
    SlidePainter,
    color_limits,
    damage_painter,
    range_shown,
    section_place,
    temperature_painter,
    temperatures,
)
from staffa.plot.style import RC
from staffa.records.manifest import Manifest
from staffa.records.step import Step
from staffa.report.embedding import embedded_image

MOST = 40  # times at most, so that a page has some MB
LONG = 2.5  # width over height of a body whose pictures stand one below the other
Slide = dict[str, str]
Key = tuple[int, float]  # index of a step and its total energy


@dataclass(frozen=True, kw_only=True)
class TimeSlides:
    """Pictures of several times, oldest first.

    Attributes
    ----------
    slides : "label", the time, and "damage" and "temperature", addresses that hold the pictures.
    where : words on the section that they show; empty in 2-D.
    stacked : True if damage and temperature stand one below the other.
    """

    slides: tuple[Slide, ...]
    where: str
    stacked: bool


@dataclass
class SlideMaker:
    """Draws slides, one step in memory at a time, and remembers those that it has drawn.

    Attributes
    ----------
    most_new : number of steps that are read, and of slides that are drawn, at one time, the latest
        ones; None for all.
    ranges : lowest and highest temperature of each step that was read, as shown; None if unknown.
    drawn : slides by step and ends of the color scale.
    painters : what draws damage and temperature, by ends of the color scale.
    """

    most_new: int | None = None
    ranges: dict[Key, Limits | None] = field(default_factory=dict)
    drawn: dict[tuple[Key, Limits], Slide] = field(default_factory=dict)
    painters: dict[Limits, tuple[SlidePainter, SlidePainter]] = field(default_factory=dict)

    def slides(self, run: Run) -> TimeSlides | None:
        """Return the slides of a run; None if no fields can be read."""
        known = self._read(run, evenly_spread(with_fields(run), MOST))
        if not known:
            return None
        place, steps = section_place(run.manifest), [step for step, _ in known]
        limits = color_limits([found for _, found in known])
        wide, tall = (run.manifest.size[axis] for axis in plane(run.manifest))
        new = [step for step in steps if (_key(step), limits) not in self.drawn]
        later = {step.index for step in new} - {step.index for step in self._next(new)}
        return TimeSlides(
            slides=tuple(self._slide(run, s, limits) for s in steps if s.index not in later),
            where=f", {place}" if place else "",
            stacked=wide > LONG * tall,
        )

    def _next(self, steps: list[Step]) -> list[Step]:
        """Return the steps whose turn it is, of those that are still to be read or drawn."""
        return steps[-self.most_new :] if self.most_new else steps

    def _read(self, run: Run, steps: list[Step]) -> list[tuple[Step, Limits]]:
        """Return the steps whose temperatures are known, with their ranges; read those next."""
        for step in self._next([step for step in steps if _key(step) not in self.ranges]):
            frames, _ = read_frames(run, [step])
            ranges = [range_shown(run.manifest, frame) for frame in frames]
            finite = [found for found in ranges if all(map(isfinite, found))]
            self.ranges[_key(step)] = finite[0] if finite else None
        known = [(step, self.ranges.get(_key(step))) for step in steps]
        return [(step, found) for step, found in known if found]

    def _slide(self, run: Run, step: Step, limits: Limits) -> Slide:
        key = (_key(step), limits)
        if key not in self.drawn:
            (frame,), _ = read_frames(run, [step])
            self.drawn[key] = self._draw(run.manifest, frame, limits)
        return self.drawn[key]

    def _draw(self, manifest: Manifest, frame: Frame, limits: Limits) -> Slide:
        with matplotlib.rc_context(RC):
            if limits not in self.painters:
                both = (damage_painter(manifest), temperature_painter(manifest, limits))
                self.painters[limits] = both
            of_damage, of_temperature = self.painters[limits]
            _, T = temperatures(manifest, frame.T)
            damage = of_damage.image(frame, frame.alpha)
            temperature = of_temperature.image(frame, T, around=True)
        return {
            "label": f"{moment(manifest, frame.step)}, step {frame.step.index}",
            "damage": embedded_image("webp", damage),
            "temperature": embedded_image("webp", temperature),
        }


def _key(step: Step) -> Key:
    """Return what tells a step from one that replaces it after backtracking."""
    return step.index, step.energies.total

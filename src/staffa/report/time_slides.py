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
    most_new : number of slides that are drawn at one time, the latest ones; None for all.
    ranges : lowest and highest temperature of each step that was read, as shown.
    drawn : slides by step and ends of the color scale.
    painters : what draws damage and temperature, by ends of the color scale.
    """

    most_new: int | None = None
    ranges: dict[Key, Limits] = field(default_factory=dict)
    drawn: dict[tuple[Key, Limits], Slide] = field(default_factory=dict)
    painters: dict[Limits, tuple[SlidePainter, SlidePainter]] = field(default_factory=dict)

    def slides(self, run: Run) -> TimeSlides | None:
        """Return the slides of a run; None if no fields can be read."""
        steps = evenly_spread(with_fields(run), MOST)
        steps = [step for step in steps if self._range(run, step)]
        if not steps:
            return None
        place = section_place(run.manifest)
        limits = color_limits([self.ranges[_key(step)] for step in steps])
        wide, tall = (run.manifest.size[axis] for axis in plane(run.manifest))
        new = [step for step in steps if (_key(step), limits) not in self.drawn]
        later = {step.index for step in (new[: -self.most_new] if self.most_new else ())}
        return TimeSlides(
            slides=tuple(self._slide(run, s, limits) for s in steps if s.index not in later),
            where=f", {place}" if place else "",
            stacked=wide > LONG * tall,
        )

    def _range(self, run: Run, step: Step) -> Limits | None:
        """Return the range of the temperatures of a step; None if they are unknown."""
        if _key(step) not in self.ranges:
            for frame in read_frames(run, [step])[0]:
                found = range_shown(run.manifest, frame)
                if all(map(isfinite, found)):
                    self.ranges[_key(step)] = found
        return self.ranges.get(_key(step))

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

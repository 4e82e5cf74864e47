"""The words on axes: quantities with their units, and the time that a run counts in."""

from collections.abc import Sequence

from staffa.manifest import Manifest
from staffa.records import Step

TAU = r"$\tau = 2\sqrt{\kappa t}/L$"
TAU_CONVENTION = TAU + r", so that $T = -\Delta T\,\mathrm{erfc}(y/(\tau L))$ in a half-space"


def has_tau(steps: Sequence[Step]) -> bool:
    """True if every step has its tau."""
    return bool(steps) and all(step.tau is not None for step in steps)


def clock(steps: Sequence[Step]) -> list[float]:
    """What goes on the axis of time: tau, or the time (s) where nothing diffuses."""
    tau = has_tau(steps)
    return [step.tau if tau and step.tau is not None else step.time for step in steps]


def clock_label(manifest: Manifest, steps: Sequence[Step]) -> str:
    """Label of the axis of time."""
    if has_tau(steps):
        return TAU_CONVENTION
    return "time (scaled)" if manifest.scaled else "time (s)"


def moment(manifest: Manifest, step: Step) -> str:
    """The time of a step in words, for a title."""
    when = reading(manifest, step.time)
    if step.tau is None:
        return when
    return f"τ = {step.tau:.3g}" + ("" if manifest.scaled else f"   ({when})")


def reading(manifest: Manifest, time: float) -> str:
    """A time (s, or scaled) as a clock shows it."""
    return f"t = {time:.4g}" if manifest.scaled else f"t = {duration(time)}"


def duration(seconds: float) -> str:
    """A time in the largest unit of which it is one or more."""
    for unit, size in (("y", 365.25 * 86400), ("d", 86400), ("h", 3600), ("min", 60)):
        if seconds >= 0.9995 * size:
            return f"{seconds / size:.3g} {unit}"
    return f"{seconds:.3g} s"


def with_unit(name: str, manifest: Manifest, unit: str) -> str:
    """A quantity's name with its unit, or with the word that says that it has none."""
    return f"{name} (scaled)" if manifest.scaled else f"{name} ({unit})"


def energy_label(manifest: Manifest) -> str:
    """Label of an axis of energy: per unit thickness in 2-D."""
    return with_unit("energy", manifest, "J/m" if len(manifest.size) == 2 else "J")


def heat_label(manifest: Manifest) -> str:
    """Label of an axis of heat: per unit thickness in 2-D."""
    return with_unit("heat since the start", manifest, "J/m" if len(manifest.size) == 2 else "J")


def crack_label(manifest: Manifest) -> str:
    """Label of an axis of crack length, in 3-D of crack area."""
    if len(manifest.size) == 2:
        return with_unit("crack length", manifest, "m")
    return with_unit("crack area", manifest, "m²")

"""The numbers of a run that a reader wants first, as plain rows for a terminal or a page."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce

from staffa.io.run_directory import Run
from staffa.manifest import Manifest
from staffa.plot.labels import reading
from staffa.records import Effort, Heat, Step
from staffa.report.comparison import remaining, run_arrests


@dataclass(frozen=True, kw_only=True)
class Fact:
    """One row: what, and how much, in words. alarm: True if it tells of something wrong."""

    name: str
    text: str
    alarm: bool = False


def summary(run: Run) -> tuple[Fact, ...]:
    """What the run is, how far it came, what it found, and what its audit says."""
    return (
        *_case(run),
        *_progress(run),
        *_state(run),
        *_heat(run),
        *_arrests(run),
        *_audit(run),
    )


def title(run: Run) -> str:
    """The case's title, or the name of the run directory."""
    return run.manifest.title or run.path.resolve().name


def _case(run: Run) -> Iterator[Fact]:
    manifest = run.manifest
    unit = "" if manifest.scaled else " m"
    size = " x ".join(f"{length:g}" for length in manifest.size)
    severity = manifest.scales.get("severity")
    cooled = f", cooled on face '{manifest.face}'" if manifest.face else ""
    yield Fact(
        name="body", text=f"{size}{unit}{cooled}, {manifest.cells} cells of {manifest.h:g}{unit}"
    )
    text = f"{manifest.law}, ell = {manifest.ell:g}{unit}"
    text += f", energy split {manifest.split}" if manifest.split != "none" else ""
    yield Fact(name="damage", text=text + (f", severity {severity:.3g}" if severity else ""))


def _progress(run: Run) -> Iterator[Fact]:
    steps, planned = run.steps, "" if run.manifest.adaptive else f" of {len(run.manifest.times)}"
    if not steps:
        yield Fact(name="status", text=f"no step is finished yet{planned and ',' + planned}")
        return
    count = f"{len(steps)}{planned} steps"
    if steps[-1].status != "converged":
        text = f"{steps[-1].status} at step {steps[-1].index}, {count}: {steps[-1].reason}"
        yield Fact(name="status", text=text, alarm=True)
    elif run.finished:
        yield Fact(name="status", text=f"finished, {count}")
    else:
        yield Fact(name="status", text=f"{count}; still going on, or stopped")
    yield Fact(name="time", text=_time(run.manifest, steps[-1]))
    every = (*steps, *run.superseded, *run.rejected)
    most = max(steps, key=lambda step: step.sweeps)
    spent = f"{sum(step.sweeps for step in every)}, at most {most.sweeps} in a step ({most.index})"
    yield Fact(name="sweeps", text=spent)
    left = sum(step.returned is not None for step in run.rejected)
    if shorter := len(run.rejected) - left:
        text = f"{shorter}, in which cracks ran too far, and were taken again shorter"
        yield Fact(name="rejected steps", text=text)
    if left:
        text = f"{left}, which failed or ran out of sweeps: the run went on without them"
        yield Fact(name="returns that failed", text=text)
    yield Fact(name="computing", text=f"{sum(step.seconds for step in every):.0f} s")
    returns = sum(step.returned is not None for step in (*steps, *run.superseded))
    if returns:
        text = f"went back {returns} times, {len(run.superseded)} steps superseded"
        ended = [s for s in every if s.returned and s.returned.number == s.returned.limit]
        for step in ended:
            text += f"; to step {step.index} as often as is allowed where heat feels the cracks"
        yield Fact(name="backtracking", text=text)


def _time(manifest: Manifest, step: Step) -> str:
    text = reading(manifest, step.time)
    return text if step.tau is None else f"tau = {step.tau:.4g}, {text}"


def _state(run: Run) -> Iterator[Fact]:
    if not run.steps:
        return
    step, plane = run.steps[-1], len(run.manifest.size) == 2
    scaled = run.manifest.scaled
    unit = "" if scaled else " J/m" if plane else " J"
    e = step.energies
    loads = f", of loads {e.loads:.5g}" if e.loads else ""
    text = f"elastic {e.elastic:.5g}, surface {e.surface:.5g}{loads}, total {e.total:.5g}{unit}"
    yield Fact(name="energies", text=text)
    measures = step.measures
    if measures is None:
        return
    if run.manifest.face:
        deepest = f", the deepest {run.manifest.deepest(measures):.4g}{'' if scaled else ' m'}"
        text = f"{len(measures.tips)}{deepest if measures.tips else ''}"
        yield Fact(name="cracks", text=text)
    unit = "" if scaled else " m" if plane else " m²"
    text = (
        f"{measures.length_surface:.4g} by energy, {measures.length_geometry:.4g} by geometry{unit}"
    )
    yield Fact(name="crack length" if plane else "crack area", text=text)
    if measures.fluid:
        pressure, volume = measures.fluid.pressure, measures.fluid.volume
        units = ("", "") if scaled else (" Pa", " m²" if plane else " m³")
        text = f"pressure {pressure:.5g}{units[0]}, volume {volume:.5g}{units[1]}"
        yield Fact(name="fluid in cracks", text=text)
    if measures.sections:
        counts = (f"{s.cracks} at {s.height:.3g}" for s in measures.sections)
        yield Fact(name="cracks at depth", text=", ".join(counts))
    if measures.cells:
        counts = (f"{cells.number} at {cells.depth:.3g}" for cells in measures.cells)
        yield Fact(name="cells at depth", text=", ".join(counts))


def _heat(run: Run) -> Iterator[Fact]:
    """What the heat equation did, over all steps that stand."""
    heats = [step.heat for step in run.steps if step.heat]
    if not heats:
        return
    spent = reduce(Heat.then, heats)
    unit = "" if run.manifest.scaled else " J/m" if len(run.manifest.size) == 2 else " J"
    parts = [f"{name} {amount:.4g}" for name, amount in spent.entered.items() if amount]
    text = f"stored {spent.stored:.4g}{unit}; entered: {', '.join(parts) or 'none'}"
    yield Fact(name="heat", text=f"{text}; balance {spent.imbalance:.1e}")
    seconds = sum(step.seconds for step in run.steps)
    share = f", {spent.seconds / seconds:.1%} of the time" if seconds else ""
    followed = f", {spent.passes} passes to agree with the cracks" if spent.passes else ""
    yield Fact(name="heat steps", text=f"{spent.substeps}{share}{followed}")


def _arrests(run: Run) -> Iterator[Fact]:
    found = run_arrests(run)
    if found is None or not (found.generations or found.left):
        return
    unit = "" if run.manifest.scaled else " m"
    for g in found.generations:
        when = reading(run.manifest, g.time) if g.tau is None else f"tau = {g.tau:.3g}"
        cracks = "1 crack" if g.cracks == 1 else f"{g.cracks} cracks"
        text = f"{cracks} stopped at depth {g.depth:.3g}{unit}, {when}"
        yield Fact(name=f"generation {g.number}", text=text)
    if found.left and found.depth is not None:
        text = f"{remaining(found)}, median depth {found.depth:.3g}{unit}"
        yield Fact(name="at the end", text=text)


def _audit(run: Run) -> Iterator[Fact]:
    audits = [step.audit for step in run.steps if step.audit]
    if not audits:
        return
    worst = (
        f"largest rise in a half sweep {max(a.largest_rise for a in audits):.1e}",
        f"healing {max(a.healing for a in audits):.1e}",
        f"balance {max(a.balance for a in audits):.1e}",
        f"first-order residual {max(a.optimality for a in audits):.1e}",
    )
    yield Fact(name="audit, worst step", text=", ".join(worst))
    every = (*run.steps, *run.superseded, *run.rejected)
    effort = sum((step.effort for step in every), Effort())
    needed = {
        "the second damage solver": effort.fallbacks,
        "a step by alternation alone": effort.plain,
        "a step cut in two": effort.halvings,
    }
    if any(needed.values()):
        counts = ", ".join(f"{what} {n} times" for what, n in needed.items() if n)
        yield Fact(name="fall-backs", text=f"needed {counts}")
    looked = [step for step in run.steps if step.stability is not None]
    if looked:
        yield Fact(name="stability", text=_second_order(looked))
    found = [f"step {s.index}: {text}" for s in run.steps if s.audit for text in s.audit.violations]
    if not found:
        yield Fact(name="violations", text="none")
    for text in found:
        yield Fact(name="violation", text=text, alarm=True)


def _second_order(steps: Sequence[Step]) -> str:
    """What the second derivative of the energy says of the steps it was looked at in."""
    seen = [(step, step.stability) for step in steps if step.stability is not None]
    unstable = [step.index for step, s in seen if s.stability is not None and s.stability < 0]
    many = [step.index for step, s in seen if s.bifurcation is not None and s.bifurcation < 0]
    escapes = sum(s.escapes for _, s in seen)
    parts = [
        f"not stable at {len(unstable)} of {len(seen)} steps",
        f"a bifurcation at {len(many)}" + (f", the first {many[0]}" if many else ""),
    ]
    return ", ".join([*parts, f"left along a mode {escapes} times"] if escapes else parts)

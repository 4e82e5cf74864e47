"""Summary of a run as rows of text, for a terminal or a page."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce

from staffa.display_units import Unit
from staffa.io.run_directory import Run
from staffa.measure.radial import radial_steps
from staffa.plot.labels import reading
from staffa.records.manifest import Manifest
from staffa.records.status import Status, Verdict
from staffa.records.step import Audit, Energies, Heat, SolverStatistics, Step
from staffa.results.crack_warnings import crack_warnings
from staffa.results.mesh_changes import mesh_text
from staffa.results.production_table import production_lines
from staffa.results.release_table import release_text
from staffa.results.slab_table import remaining, run_arrests

# Notes that are told; each step may have one, which says much the same.
MOST_NOTES = 3


@dataclass(frozen=True, kw_only=True)
class Fact:
    """Row of a summary.

    Attributes
    ----------
    name : its name.
    text : its value.
    alarm : True if something is wrong.
    """

    name: str
    text: str
    alarm: bool = False


def summary(run: Run) -> tuple[Fact, ...]:
    """Return the facts of a run: case, progress, results and audit."""
    return (
        *_case(run),
        *_progress(run),
        *_state(run),
        *_quantities(run),
        *_heat(run),
        *(Fact(name=name, text=text) for name, text in production_lines(run)),
        *(Fact(name="flow in cracks", text=text, alarm=True) for text in crack_warnings(run)),
        *_arrests(run),
        *_coarse(run),
        *_mesh(run),
        *_audit(run),
    )


def title(run: Run) -> str:
    """Return the case's title, or the name of the run directory."""
    return run.manifest.title or run.path.resolve().name


def violations(run: Run) -> list[str]:
    """Return the violations of the kept steps, one sentence each."""
    audited = [(step.index, step.audit) for step in run.steps if step.audit]
    return [f"step {index}: {text}" for index, audit in audited for text in audit.violations]


def _case(run: Run) -> Iterator[Fact]:
    manifest = run.manifest
    unit, severity = manifest.shown.length, manifest.scales.get("severity")
    size = " x ".join(f"{unit.of(length):g}" for length in manifest.size)
    face, own_load = "", manifest.own_load
    if manifest.face:
        what = "cooled on" if manifest.cools else "depths from"
        face = f", {what} face '{manifest.face}'"
    cells = f"{manifest.cells} cells of {unit.text(manifest.h, 6)}"
    if run.manifest.refined:
        cells = f"cells of {unit.text(manifest.h, 6)} at cracks, else longer"
    yield Fact(name="body", text=f"{size}{unit.behind}{face}, {cells}")
    text = f"{manifest.law}, ell = {unit.text(manifest.ell, 6)}"
    why = f" ({manifest.split_reason})" if manifest.split_reason else ""
    text += f", energy split {manifest.split}{why}" if manifest.split != "none" or why else ""
    yield Fact(name="damage", text=text + (f", severity {severity:.3g}" if severity else ""))
    if own_load:
        yield Fact(name="load", text=f"{own_load.identity}, of a script")


def _progress(run: Run) -> Iterator[Fact]:
    steps, planned = run.steps, "" if run.manifest.adaptive else f" of {len(run.manifest.times)}"
    if not steps:
        yield Fact(name="status", text=f"no step is finished yet{planned and ',' + planned}")
        return
    count = f"{len(steps)}{planned} steps"
    if steps[-1].status != Status.CONVERGED:
        text = f"{steps[-1].status} at step {steps[-1].index}, {count}: {steps[-1].reason}"
        yield Fact(name="status", text=text, alarm=True)
    elif run.finished:
        violated = bool(violations(run))
        text = f"finished, {count}" + (", but the audit is violated" if violated else "")
        yield Fact(name="status", text=text, alarm=violated)
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
    return text if step.tau is None else f"{text}, tau = {step.tau:.4g}"


def _state(run: Run) -> Iterator[Fact]:
    if not run.steps:
        return
    step, shown, plane = run.steps[-1], run.manifest.shown, run.manifest.plane
    yield Fact(name="energies", text=_energies(shown.energy, step.energies))
    measures = step.measures
    if measures is None:
        return
    if run.manifest.face:
        deepest = f", the deepest {shown.length.text(run.manifest.deepest(measures))}"
        text = f"{len(measures.tips)}{deepest if measures.tips else ''}"
        yield Fact(name="cracks", text=text)
    by_energy = shown.crack.text(measures.length_surface)
    text = f"{by_energy} by energy, {shown.crack.text(measures.length_geometry)} by geometry"
    yield Fact(name="crack length" if plane else "crack area", text=text)
    if rate := release_text(run):
        yield Fact(name="energy release rate", text=rate)
    yield from _opposite_boundary(run)
    if measures.fluid:
        pressure = shown.stress.text(measures.fluid.pressure, 5)
        acting = "acting pressure" if run.manifest.reservoir else "pressure"
        text = f"{acting} {pressure}, volume {shown.volume.text(measures.fluid.volume, 5)}"
        yield Fact(name="fluid in cracks", text=text)


def _quantities(run: Run) -> Iterator[Fact]:
    """The script's own quantities at the last step."""
    last = run.steps[-1].quantities if run.steps else {}
    for quantity in run.manifest.quantities:
        if quantity.name in last:
            numbers = ", ".join(f"{number:.5g}" for number in last[quantity.name])
            yield Fact(name=quantity.name, text=f"{numbers}{quantity.shown.behind}")


def _energies(unit: Unit, e: Energies) -> str:
    """Return the energies as text; energies counted from an equilibrium say so."""
    rest = " since rest" if e.at_rest else ""
    loads = f", of loads {unit.of(e.loads):.5g}{rest}" if e.loads else ""
    loads += f", of friction {unit.of(e.friction):.5g}" if e.friction else ""
    parts = f"elastic {unit.of(e.elastic):.5g}{rest}, surface {unit.of(e.surface):.5g}{loads}"
    return f"{parts}, total {unit.text(e.total, 5)}"


def _opposite_boundary(run: Run) -> Iterator[Fact]:
    """Yield the first step in which a crack has reached the opposite boundary."""
    manifest = run.manifest
    near = max(manifest.ell, manifest.h)
    for step in run.steps if manifest.face else ():
        if step.measures is None or manifest.deepest(step.measures) < manifest.L - near:
            continue
        length, front = manifest.shown.length, manifest.deepest(step.measures)
        text = f"a crack reached it by step {step.index}, {_time(manifest, step)}, at a depth of "
        text += f"{length.of(front):.4g} of {length.text(manifest.L)}; later "
        text += "results are those of this body, no more of deep rock"
        yield Fact(name="opposite boundary", text=text, alarm=True)
        return


def _heat(run: Run) -> Iterator[Fact]:
    """Yield the heat balance and the solver statistics of the heat equation over all kept steps."""
    heats = [step.heat for step in run.steps if step.heat]
    if not heats:
        return
    spent = reduce(Heat.then, heats)
    unit = run.manifest.shown.heat
    parts = [f"{name} {unit.of(amount):.4g}" for name, amount in spent.entered.items() if amount]
    text = f"stored {unit.text(spent.stored)}; entered: {', '.join(parts) or 'none'}"
    yield Fact(name="heat", text=f"{text}; balance {spent.imbalance:.1e}")
    seconds = sum(step.seconds for step in run.steps)
    share = f", {spent.seconds / seconds:.1%} of the time" if seconds else ""
    followed = f", {spent.passes} passes to agree with the cracks" if spent.passes else ""
    yield Fact(name="heat steps", text=f"{spent.substeps}{share}{followed}")


def _arrests(run: Run) -> Iterator[Fact]:
    found = run_arrests(run)
    if found is None or not (found.generations or found.left):
        return
    unit = run.manifest.shown.length
    for g in found.generations:
        when = [] if g.tau is not None and run.manifest.scaled else [reading(run.manifest, g.time)]
        when += [] if g.tau is None else [f"tau = {g.tau:.3g}"]
        cracks = "1 crack" if g.cracks == 1 else f"{g.cracks} cracks"
        text = f"{cracks} stopped at depth {unit.text(g.depth, 3)}, {', '.join(when)}"
        yield Fact(name=f"generation {g.number}", text=text)
    if found.left and found.depth is not None:
        text = f"{remaining(found)}, median depth {unit.text(found.depth, 3)}"
        yield Fact(name="at the end", text=text)


def _coarse(run: Run) -> Iterator[Fact]:
    """Yield a fact on cracks in cells that are too large for ell."""
    found = [step.measures.coarse for step in run.steps if step.measures and step.measures.coarse]
    if not found:
        return
    last, unit = found[-1], run.manifest.shown.length
    place = ", ".join(f"{unit.of(c):.4g}" for c in last.place)
    where = f"{f"in region '{last.region}', " if last.region else ''}at ({place}){unit.behind}"
    yield Fact(
        name="cells too long",
        text=f"{last.share:.0%} of the cracks' length is in cells of edge "
        f"{unit.text(last.edge, 3)}, {last.edge / run.manifest.ell:.2g} ell, most {where}: "
        f"a crack costs about {last.toughness:.3f} Gc there; mesh it finer, h <= ell/3",
        alarm=last.edge > run.manifest.ell / 2,
    )


def _mesh(run: Run) -> Iterator[Fact]:
    if run.manifest.refined and run.steps:
        yield Fact(name="mesh", text=mesh_text(run))


def _gap(audits: Sequence[Audit]) -> str:
    """Return the largest gap, and the number of steps of earlier versions without one."""
    found = [a.gap for a in audits if a.gap is not None]
    if not found:
        return "not recorded"
    without = len(audits) - len(found)
    return f"{max(found):.1e}" + (
        f" ({without} of {len(audits)} steps did not record it)" if without else ""
    )


def _audit(run: Run) -> Iterator[Fact]:
    audits = [step.audit for step in run.steps if step.audit]
    if not audits:
        return
    worst = (
        f"largest rise in a half sweep {max(a.largest_rise for a in audits):.1e}",
        f"irreversibility violation {max(a.healing for a in audits):.1e}",
        f"balance {max(a.balance for a in audits):.1e}",
        f"gap between steps {_gap(audits)}",
        f"first-order residual {max(a.optimality for a in audits):.1e}",
    )
    yield Fact(name="audit, worst step", text=", ".join(worst))
    every = (*run.steps, *run.superseded, *run.rejected)
    effort = sum((step.effort for step in every), SolverStatistics())
    needed = {
        "the second damage solver": effort.fallbacks,
        "a factorization in place of the iterative solver": effort.direct,
        "a step by alternation alone": effort.plain,
        "a step cut in two": effort.halvings,
    }
    if any(needed.values()):
        counts = ", ".join(f"{what} {n} times" for what, n in needed.items() if n)
        yield Fact(name="fall-backs", text=f"needed {counts}")
    looked = [step for step in run.steps if step.stability is not None]
    if looked:
        yield Fact(name="stability", text=_second_order(looked))
    tests = [step for step in run.steps if step.curvature is not None]
    if tests:
        yield Fact(name="second-order test", text=_curvature(tests))
    if driven := radial_steps(run.steps):
        yield Fact(name="radial cracks", text=driven, alarm=True)
    amiss = violations(run)
    if not amiss:
        yield Fact(name="violations", text="none")
    for text in amiss:
        yield Fact(name="violation", text=text, alarm=True)
    noted = [f"step {s.index}: {text}" for s in run.steps if s.audit for text in s.audit.notes]
    for text in noted[:MOST_NOTES]:
        yield Fact(name="note", text=text, alarm=True)
    if len(noted) > MOST_NOTES:
        yield Fact(name="notes", text=f"{len(noted) - MOST_NOTES} more in steps.jsonl", alarm=True)


def _second_order(steps: Sequence[Step]) -> str:
    """Return the results of the second-order conditions at the steps that were tested."""
    seen = [(step, step.stability) for step in steps if step.stability is not None]
    unstable = [step.index for step, s in seen if s.stability is not None and s.stability < 0]
    many = [step.index for step, s in seen if s.bifurcation is not None and s.bifurcation < 0]
    escapes = sum(s.escapes for _, s in seen)
    parts = [
        f"not stable at {len(unstable)} of {len(seen)} steps",
        f"a bifurcation at {len(many)}" + (f", the first {many[0]}" if many else ""),
    ]
    return ", ".join([*parts, f"left along a mode {escapes} times"] if escapes else parts)


def _curvature(steps: Sequence[Step]) -> str:
    """Return the results of the search for directions along which the energy falls."""
    found = [(step.index, step.curvature) for step in steps if step.curvature is not None]
    tested = [(n, c) for n, c in found if c.verdict is not Verdict.NOT_TESTED]
    many = [n for n, c in found if c.verdict is Verdict.BIFURCATION]
    saddles = [n for n, c in found if c.verdict is Verdict.SADDLE]
    minima = [c for _, c in found if c.verdict is Verdict.MINIMUM]
    reasons = Counter(c.reason for _, c in found if c.verdict is Verdict.NOT_TESTED)
    parts = []
    if tested:
        parts.append(f"no descent direction found at {len(minima)} of {len(tested)} states tested")
    if many:
        parts.append(f"a bifurcation at {_steps(many)}, where only less damage lowers the energy")
    if saddles:
        parts.append(f"a saddle was kept at {_steps(saddles)}")
    escapes = sum(c.escapes for _, c in tested)
    if escapes:
        parts.append(f"a saddle was left {escapes} times")
    values = [c.smallest for c in minima if c.smallest is not None]
    if values:
        parts.append(f"smallest curvature found {min(values):.2g} of 1")
    parts += [f"{number} states {reason}" for reason, number in reasons.items()]
    return ", ".join(parts)


def _steps(numbers: Sequence[int]) -> str:
    """Return step numbers as text."""
    return f"step{'s' * (len(numbers) > 1)} {', '.join(map(str, numbers))}"

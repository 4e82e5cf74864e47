"""Summary of a run as rows of text, for a terminal or a page."""

from collections.abc import Iterator
from functools import reduce

from staffa.display_units import Unit
from staffa.io.run_directory import Run
from staffa.plot.labels import reading
from staffa.records.manifest import Manifest
from staffa.records.step import Energies, Heat, Measures, Step
from staffa.results.audit_facts import audit_facts, violations
from staffa.results.crack_sizes import crack_sizes, size_name
from staffa.results.crack_warnings import crack_warnings
from staffa.results.facts import Fact
from staffa.results.mesh_changes import mesh_text
from staffa.results.production_table import production_lines
from staffa.results.release_table import release_text
from staffa.results.slab_table import remaining, run_arrests


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
        *audit_facts(run),
    )


def title(run: Run) -> str:
    """Return the case's title, or the name of the run directory."""
    return run.manifest.title or run.path.resolve().name


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
    count = f"{len(steps)}{planned} steps"
    if left := run.unreached:
        text = f"{left.status} at step {left.index}, {count} reached: {left.reason}"
        yield Fact(name="status", text=text, alarm=True)
        yield Fact(name="not reached", text=_unreached(run, left))
    elif not steps:
        yield Fact(name="status", text=f"no step is finished yet{planned and ',' + planned}")
    elif run.finished:
        violated = bool(violations(run))
        text = f"finished, {count}" + (", but the audit is violated" if violated else "")
        yield Fact(name="status", text=text, alarm=violated)
    else:
        yield Fact(name="status", text=f"{count}; still going on, or stopped")
    if steps:
        yield Fact(name="time", text=_time(run.manifest, steps[-1]))
    yield from _spent(run)


def _unreached(run: Run, step: Step) -> str:
    """Return a sentence on the step that ended the run before its end."""
    text = f"step {step.index}, {_time(run.manifest, step)}: it is in no curve, table or picture"
    return f"{text}; {step.fields} has its last state" if step.fields else text


def _spent(run: Run) -> Iterator[Fact]:
    """Yield what the steps cost, and how often the run went back."""
    steps, every = run.audited, run.computed
    if not steps:
        return
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
    step, shown = run.steps[-1], run.manifest.shown
    yield Fact(name="energies", text=_energies(shown.energy, step.energies))
    measures = step.measures
    if measures is None:
        return
    if run.manifest.face:
        yield Fact(name="cracks", text=_cracks(run.manifest, measures))
    yield Fact(name=f"crack {size_name(run)}", text=crack_sizes(run, measures))
    if rate := release_text(run):
        yield Fact(name="energy release rate", text=rate)
    yield from _opposite_boundary(run)
    if measures.fluid:
        pressure = shown.stress.text(measures.fluid.pressure, 5)
        acting = "acting pressure" if run.manifest.reservoir else "pressure"
        text = f"{acting} {pressure}, volume {shown.volume.text(measures.fluid.volume, 5)}"
        yield Fact(name="fluid in cracks", text=text)


def _cracks(manifest: Manifest, measures: Measures) -> str:
    """Return the number of cracks and the deepest of them, of each cooled face by itself."""
    unit, reach = manifest.shown.length, manifest.tip_reach or 0.0
    deepest = f", the deepest {unit.text(manifest.deepest(measures))}" if measures.tips else ""
    if not measures.others:
        return f"{len(measures.tips)}{deepest}"
    own = f"from '{manifest.face}'" if manifest.face_cools else "from no cooled face"
    away = "" if manifest.face_cools or not deepest else f" from '{manifest.face}'"
    met = sum(tip.met for tip in measures.tips)
    joined = f", {met} of them joined with cracks of other faces" if met else ""
    told = [f"{len(measures.tips)} {own}{deepest}{away}{joined}"]
    told += [
        f"{one.cracks} from '{one.face}', the deepest {unit.text(one.sharp(reach))} from there"
        for one in measures.others
    ]
    return "; ".join(told)


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
        front = _reached(manifest, step.measures) if step.measures else 0.0
        if front < manifest.L - near:
            continue
        length = manifest.shown.length
        text = f"a crack reached it by step {step.index}, {_time(manifest, step)}, at a depth of "
        text += f"{length.of(front):.4g} of {length.text(manifest.L)}; later "
        text += "results are those of this body, no more of deep rock"
        yield Fact(name="opposite boundary", text=text, alarm=True)
        return


def _reached(manifest: Manifest, measures: Measures) -> float:
    """Return the depth (m) to which cracks from the face go, also joined with those of others."""
    joined = (one.joined for one in measures.others if one.joined is not None)
    return max([manifest.deepest(measures), *joined])


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

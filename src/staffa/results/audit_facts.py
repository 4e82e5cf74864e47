"""The audit of a run in facts: its worst figures, what it fell back to, violations and notes."""

from collections import Counter
from collections.abc import Iterator, Sequence

from staffa.io.run_directory import Run
from staffa.measure.radial import radial_steps
from staffa.records.status import Verdict
from staffa.records.step import Audit, SolverStatistics, Step
from staffa.results.facts import Fact

# Notes that are told; each step may have one, which says much the same.
MOST_NOTES = 3


def violations(run: Run) -> list[str]:
    """Return the violations of the steps, also of one that was not reached, a sentence each."""
    audited = [(step.index, step.audit) for step in run.audited if step.audit]
    return [f"step {index}: {text}" for index, audit in audited for text in audit.violations]


def _gap(audits: Sequence[Audit]) -> str:
    """Return the largest gap, and the number of steps of earlier versions without one."""
    found = [a.gap for a in audits if a.gap is not None]
    if not found:
        return "not recorded"
    without = len(audits) - len(found)
    return f"{max(found):.1e}" + (
        f" ({without} of {len(audits)} steps did not record it)" if without else ""
    )


def audit_facts(run: Run) -> Iterator[Fact]:
    """Yield the worst figures of the audit, fall-backs, tests of second order, and violations."""
    audits = [step.audit for step in run.steps if step.audit]
    if audits:
        yield from _worst(run, audits)
    amiss = violations(run)
    if audits and not amiss:
        yield Fact(name="violations", text="none")
    for text in amiss:
        yield Fact(name="violation", text=text, alarm=True)
    noted = [f"step {s.index}: {text}" for s in run.steps if s.audit for text in s.audit.notes]
    for text in noted[:MOST_NOTES]:
        yield Fact(name="note", text=text, alarm=True)
    if len(noted) > MOST_NOTES:
        yield Fact(name="notes", text=f"{len(noted) - MOST_NOTES} more in steps.jsonl", alarm=True)


def _worst(run: Run, audits: Sequence[Audit]) -> Iterator[Fact]:
    """Yield the worst figures of the audits of the reached steps, fall-backs, and tests."""
    worst = (
        f"largest rise in a half sweep {max(a.largest_rise for a in audits):.1e}",
        f"irreversibility violation {max(a.healing for a in audits):.1e}",
        f"balance {max(a.balance for a in audits):.1e}",
        f"gap between steps {_gap(audits)}",
        f"first-order residual {max(a.optimality for a in audits):.1e}",
    )
    yield Fact(name="audit, worst step", text=", ".join(worst))
    effort = sum((step.effort for step in run.computed), SolverStatistics())
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

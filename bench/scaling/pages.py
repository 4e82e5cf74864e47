"""Page, figure and head of the batch script, from bench/scaling/results.json.

    python -m bench.scaling.pages

Written between the lines that say "scaling: begin" and "scaling: end" of docs/performance.md and
docs/cluster/brick-large.slurm. Run by bench/scaling/run.py; tests hold both against the json.
"""

import json
from itertools import product
from math import ceil
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from bench.scaling.laws import CONFIDENCE, Cost, Law, beside, held_out, law, predict
from staffa.case.reading.read import read_case
from staffa.case.scales.case_scales import derived_numbers
from staffa.evolution.schedule import schedule
from staffa.geometry.block import divisions

HERE = Path(__file__).parent
DOCS = HERE.parent.parent / "docs"
PAGE, PICTURE = DOCS / "performance.md", DOCS / "pictures" / "scaling.png"
CASE, SCRIPT = DOCS / "cluster" / "brick-large.toml", DOCS / "cluster" / "brick-large.slurm"
KEPT = HERE / "results.json"
NOT_YET = "Not measured yet on a quiet machine.\n"
# Runs whose cells have no law, and the law that stands in.
ALIKE = {"unstructured": "tetrahedron"}
# Unknowns that count as twice as many, up to this part.
TWICE = 0.1
# The cluster of the batch script: nodes of two sockets of 64 cores are common.
NODES, CORES = 4, 128


def measured() -> dict | None:
    """Return the results of bench/scaling/run.py; None before it has run in full."""
    return json.loads(KEPT.read_text()) if KEPT.exists() else None


def laws(results: dict) -> dict[str, Law]:
    """The law of each kind of cells."""
    return {cells: law(runs) for cells, runs in by_cells(results).items()}


def by_cells(results: dict) -> dict[str, list[dict]]:
    """The runs of each kind of cells."""
    kinds = dict.fromkeys(run["cells"] for run in results["runs"])
    return {kind: [run for run in results["runs"] if run["cells"] == kind] for kind in kinds}


def large(results: dict) -> tuple[int, Cost]:
    """Displacement unknowns and expected cost of the case of the batch script."""
    case, medium = read_case(CASE), results["medium"]
    derived = derived_numbers(case)
    assert case.domain.size is not None and case.domain.h is not None
    counts = divisions(tuple(float(s) for s in case.domain.size), float(case.domain.h))
    unknowns = 3 * int(np.prod([n + 1 for n in counts]))
    cost = predict(
        laws(results)[case.domain.cells or ""],
        unknowns=unknowns,
        ranks=NODES * CORES,
        steps=len(schedule(derived.times, derived.requested).times),
        sweeps=medium["sweeps"] / medium["steps"],
    )
    return unknowns, cost


def head(results: dict | None) -> str:
    """The lines of the batch script that the law decides: ranks, time, and what they rest on."""
    nodes = f"#SBATCH --nodes={NODES}\n#SBATCH --ntasks-per-node={CORES}\n"
    if results is None:
        return f"{nodes}#SBATCH --time=24:00:00\n# What it costs: {NOT_YET[0].lower()}{NOT_YET[1:]}"
    unknowns, cost = large(results)
    medium = results["medium"]
    return (
        f"{nodes}"
        f"#SBATCH --time={ceil(cost.hours * cost.factor)}:00:00\n"
        f"# {unknowns:,} displacement unknowns on {NODES * CORES} ranks, expected from smaller "
        f"runs (docs/performance.md):\n"
        f"# {cost.sweeps:.0f} sweeps of {cost.seconds_a_sweep:.1f} s: {cost.hours:.1f} hours, "
        f"{cost.core_hours:.0f} core hours, within a factor of {cost.factor:.1f};\n"
        f"# --time is the upper end. Sweeps a step are those of a run of "
        f"{medium['unknowns']:,} unknowns.\n"
        f"# {cost.GB:.0f} GB of memory, {cost.GB / NODES:.0f} GB a node.\n"
    )


def page(results: dict | None) -> str:
    """The part of docs/performance.md."""
    if results is None:
        return NOT_YET
    parts = [runs_table(results), weak_table(results), laws_table(results), checks_table(results)]
    unknowns, cost = large(results)
    medium = results["medium"]
    days = sorted({run["date"][:10] for run in results["runs"]})
    parts.append(
        f"`docs/cluster/brick-large.toml`, {unknowns:,} unknowns on {NODES * CORES} ranks, should "
        f"take {cost.sweeps:.0f} sweeps of {cost.seconds_a_sweep:.1f} s: **{cost.hours:.1f} hours**"
        f" ({cost.core_hours:.0f} core hours), within a factor of {cost.factor:.1f} in "
        f"{100 * CONFIDENCE:.0f} % of cases if the laws hold so far out, and {cost.GB:.0f} GB. "
        f"Sweeps a step: {medium['sweeps'] / medium['steps']:.1f}, from a run of "
        f"{medium['unknowns']:,} unknowns."
    )
    parts.append(f"![Cost of a brick](pictures/{PICTURE.name})")
    machine = results["runs"][-1]["machine"]
    parts.append(f"Measured on {machine['cpu']}, {machine['cores']} cores, {', '.join(days)}.")
    return "\n\n".join(parts) + "\n"


def runs_table(results: dict) -> str:
    """Every run, a line."""
    rows = [
        "| cells | unknowns | ranks | a sweep | a sweep and unknown | gain of 2 ranks | multigrid "
        "iterations, set-ups a sweep | Newton iterations a sweep | memory | an unknown, without "
        "the libraries |",
        "|" + " --- |" * 10,
    ]
    for runs in by_cells(results).values():
        for run in runs:
            sweep = run["seconds"] / run["sweeps"]
            alone = [r for r in runs if r["ranks"] == 1 and r["columns"] == run["columns"]]
            gain = alone[0]["seconds"] / alone[0]["sweeps"] / sweep if run["ranks"] > 1 else None
            own = (run["peak_bytes"] - run["libraries_bytes"]) / run["unknowns"]
            rows.append(
                f"| {run['cells']} | {run['unknowns']} | {run['ranks']} | {sweep:.2f} s | "
                f"{1e6 * sweep / run['unknowns']:.0f} us | {'' if gain is None else f'{gain:.2f}'} "
                f"| {run['multigrid_iterations'] / run['sweeps']:.1f}, "
                f"{run['multigrid_set_ups'] / run['sweeps']:.1f} | "
                f"{run['newton_iterations'] / run['sweeps']:.1f} | "
                f"{run['peak_bytes'] / 1e9:.2f} GB | {own / 1e3:.1f} kB |"
            )
    return "\n".join(rows)


def weak_table(results: dict) -> str:
    """Twice as much on two ranks as on one: the time should be the same."""
    rows = [
        "| cells | unknowns on 1 rank | on 2 ranks | a sweep on 1 rank | on 2 ranks | efficiency, "
        "per unknown |",
        "|" + " --- |" * 6,
    ]
    for cells, runs in by_cells(results).items():
        for one, two in product(runs, runs):
            share = two["unknowns"] / (2 * one["unknowns"])
            if (one["ranks"], two["ranks"]) != (1, 2) or abs(share - 1) > TWICE:
                continue
            alone, both = (run["seconds"] / run["sweeps"] for run in (one, two))
            rows.append(
                f"| {cells} | {one['unknowns']} | {two['unknowns']} | {alone:.2f} s | {both:.2f} s "
                f"| {100 * share * alone / both:.0f} % |"
            )
    return "\n".join(rows)


def laws_table(results: dict) -> str:
    """Coefficients with their standard errors."""
    rows = [
        "| cells | seconds of a sweep, N unknowns on R ranks | scatter | memory | scatter |",
        "|" + " --- |" * 5,
    ]
    for cells, found in laws(results).items():
        _, p, s = np.sqrt(np.diag(found.covariance))
        at = np.exp(found.log_c) * 1e4**found.p
        rows.append(
            f"| {cells} | {at:.2f} (N/R/10^4)^({found.p:.2f} +- {p:.2f}) "
            f"R^({found.s:.2f} +- {s:.2f}) | {100 * found.scatter:.0f} % | "
            f"{found.bytes_a_rank / 1e9:.2f} GB R + {found.bytes_an_unknown / 1e3:.2f} kB N | "
            f"{100 * found.memory_scatter:.0f} % |"
        )
    return "\n".join(rows)


def checks_table(results: dict) -> str:
    """The forecast of the laws for runs that they were not fitted to."""
    rows = [
        "| run | unknowns | ranks | measured | predicted | within a factor | memory | predicted |",
        "|" + " --- |" * 8,
    ]
    for cells, runs in by_cells(results).items():
        rows += [_check(f"{cells}, by the smaller ones", *pair) for pair in held_out(runs)]
    medium = results["medium"]
    kind = ALIKE.get(medium["cells"], medium["cells"])
    rows.append(_check(f"the medium run, by all of {kind}", *beside(laws(results)[kind], medium)))
    return "\n".join(rows)


def _check(name: str, run: dict, cost: Cost) -> str:
    held = f"{run['peak_bytes'] / 1e9:.2f} GB" if "peak_bytes" in run else ""
    return (
        f"| {name} | {run['unknowns']} | {run['ranks']} | {run['seconds']:.0f} s | "
        f"{3600 * cost.hours:.0f} s | {cost.factor:.2f} | {held} | {cost.GB:.2f} GB |"
    )


def draw(results: dict) -> None:
    """Seconds of a sweep and memory against unknowns, with the laws."""
    figure, (time, memory) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    fitted = laws(results)
    for color, (cells, runs) in zip(("C0", "C1"), by_cells(results).items(), strict=False):
        for ranks, mark, dashes in ((1, "o", "-"), (2, "s", "--")):
            on = [run for run in runs if run["ranks"] == ranks]
            N = np.array([run["unknowns"] for run in on])
            line = [predict(fitted[cells], unknowns=n, ranks=ranks, steps=1, sweeps=1) for n in N]
            label = f"{cells}, {ranks} rank{'s' if ranks > 1 else ''}"
            a_sweep = [run["seconds"] / run["sweeps"] for run in on]
            time.loglog(N, a_sweep, color + mark, label=label)
            time.loglog(N, [cost.seconds_a_sweep for cost in line], color + dashes)
            memory.loglog(N, [run["peak_bytes"] / 1e9 for run in on], color + mark)
            memory.loglog(N, [cost.GB for cost in line], color + dashes)
    time.set(xlabel="displacement unknowns", ylabel="seconds of a sweep")
    memory.set(xlabel="displacement unknowns", ylabel="memory, all ranks together (GB)")
    time.legend(frameon=False, fontsize=9)
    figure.savefig(PICTURE, dpi=120, bbox_inches="tight")
    plt.close(figure)


def within(text: str, inside: str) -> str:
    """A text with what stands between the two marked lines replaced."""
    lines = text.splitlines(keepends=True)
    begin, end = (
        next(i for i, line in enumerate(lines) if f"scaling: {mark}" in line)
        for mark in ("begin", "end")
    )
    return "".join([*lines[: begin + 1], inside, *lines[end:]])


def write(results: dict | None) -> None:
    """Write all of it."""
    if results is not None:
        draw(results)
    for path, inside in ((PAGE, "\n" + page(results) + "\n"), (SCRIPT, head(results))):
        path.write_text(within(path.read_text(encoding="utf-8"), inside), encoding="utf-8")


if __name__ == "__main__":
    write(measured())

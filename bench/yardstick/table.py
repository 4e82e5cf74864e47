"""The tables of docs/performance.md and docs/how-to/choose-a-solver.md, from results.json.

python -m bench.yardstick.table
"""

import json
from math import log
from pathlib import Path

RESULTS = Path(__file__).parent / "results.json"


def ratios(results: dict) -> list[str]:
    """The hand script beside staffa, a case a line."""
    rows = [
        "| case | unknowns | script | staffa | ratio | in CPU time | sweeps | "
        "energy above the script's |",
        "| --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for run in results["runs"].values():
        if run["ranks"] > 1:
            continue
        script, ours = run["script"], run["staffa"]
        rows.append(
            f"| {run['case']}, {run['steps_run']} steps | {run['unknowns']} | "
            f"{script['wall_s']:.0f} s | "
            f"{ours['wall_s']:.0f} s | {run['ratio_wall']:.2f} | {run['ratio_cpu']:.2f} | "
            f"{script['sweeps']} : {ours['sweeps']} | "
            f"{100 * run['largest_energy_above_script']:+.4f} % |"
        )
    return rows


def refined(results: dict) -> list[str]:
    """The hand script beside staffa on a mesh that follows the cracks; empty where none was run."""
    runs = [run for run in results["runs"].values() if "refined" in run]
    rows = [
        "| case | h: script, refined | cells at the end | script | refined | ratio | in CPU time | "
        "sweeps | energy above the script's |",
        "| --- | --- | --- | --- | --- | --- | --- | --- | --- |",
    ]
    for run in runs:
        script, ours, beside = run["script"], run["refined"], run["refined_beside_script"]
        rows.append(
            f"| {run['case']}, {run['steps_run']} steps | {beside['h']:.5f}, "
            f"{beside['finest_h']:.5f} | {beside['cells']} | {script['wall_s']:.0f} s | "
            f"{ours['wall_s']:.0f} s | {beside['ratio_wall']:.2f} | {beside['ratio_cpu']:.2f} | "
            f"{script['sweeps']} : {ours['sweeps']} | "
            f"{100 * beside['largest_energy_above_script']:+.4f} % |"
        )
    return rows if runs else []


def presets(results: dict) -> list[str]:
    """Each choice of solvers on the small cases."""
    rows = ["| case | presets | time | sweeps | peak memory |", "| --- | --- | --- | --- | --- |"]
    for run in results["presets"]["found"]:
        chosen = ", ".join(f'{k} = "{v}"' for k, v in run["presets"].items()) or "defaults"
        rows.append(
            f"| {run['case']} | {chosen} | {run['wall_s']:.0f} s | {run['sweeps']} | "
            f"{run['peak_MB']:.0f} MB |"
        )
    return rows


def growth(results: dict) -> list[str]:
    """CPU time and sweeps of a step of staffa on one slab on two meshes, for the steps both ran."""
    runs = {name.split(":")[0]: run for name, run in results["runs"].items()}
    rows = [
        "| slabs: steps | unknowns | CPU time a step | time ~ unknowns^ | sweeps a step |",
        "| --- | --- | --- | --- | --- |",
    ]
    for coarse, fine in (("A30k", "A120k"), ("B30k", "B480k")):
        n = [runs[name]["unknowns"] for name in (coarse, fine)]
        both = [runs[name]["steps"]["staffa"] for name in (coarse, fine)]
        shared = min(len(steps) for steps in both)
        cpu, sweeps = (
            [sum(step[key] for step in steps[:shared]) / shared for steps in both]
            for key in ("cpu_s", "sweeps")
        )
        exponent = log(cpu[1] / cpu[0]) / log(n[1] / n[0])
        rows.append(
            f"| {coarse}, {fine}: {shared} | {n[0]}, {n[1]} | {cpu[0]:.1f} s, {cpu[1]:.1f} s | "
            f"{exponent:.2f} | {sweeps[0]:.1f}, {sweeps[1]:.1f} |"
        )
    return rows


def ranks(results: dict) -> list[str]:
    """The gain of more ranks, and the memory of an unknown."""
    rows = [
        "| case | 1 rank | more ranks | gain | memory an unknown | without the libraries |",
        "| --- | --- | --- | --- | --- | --- |",
    ]
    for run in results["runs"].values():
        if run["ranks"] > 1:
            one, more = run["one"], run["more"]
            rows.append(
                f"| {run['case']} | {one['wall_s']:.1f} s, {one['sweeps']} sweeps | "
                f"{more['wall_s']:.1f} s, {more['sweeps']} sweeps on {run['ranks']} | "
                f"{run['gain']:.2f} | {run['kB_per_unknown']:.2f} kB | "
                f"{run['kB_per_unknown_without_libraries']:.2f} kB |"
            )
    return rows


def main() -> None:
    """Print all tables."""
    results = json.loads(RESULTS.read_text())
    for table in (ratios, refined, growth, ranks, presets):
        print("\n".join(table(results)), end="\n\n")


if __name__ == "__main__":
    main()

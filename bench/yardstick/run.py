"""The yardstick: the hand script beside staffa on the same cases, step by step, in turns.

    python -m bench.yardstick.run [CASE[:RANKS] ...] [--steps N] [--out FILE]

staffa runs twice: on the script's mesh (`staffa`), and on a mesh that follows the cracks
(`refined`), whose energy is that of the minimum on the script's mesh that its damage leads to.
Without a case, all of them; what FILE holds of other cases is kept. N: only the first steps.
CASE:2 runs staffa alone through the case's first step, on one rank and on two. Run by `make bench`.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path

from bench.common.cases import CASES, BenchCase
from bench.common.machine import ROOT, environment, machine, versions

HERE = Path(__file__).parent
SIDES = ("script", "staffa", "refined")
# Facts of the mesh that follows the cracks, at the end of the last step.
MESH = ("h", "longest_h", "finest_h", "coarsest_h", "edge_halvings", "cells", "unknowns")
# Phases of such a script on a quiet machine of two cores: seconds for 131 sweeps, 121k unknowns.
REFERENCE_SWEEPS = 131
REFERENCE = {
    "stiffness assembly": 4.3,
    "factorization or set-up": 26.3,
    "solve": 3.4,
    "damage assembly": 6.2,
    "damage solve": 5.1,
}


def start(who: str, case: BenchCase, ranks: int, folder: str) -> subprocess.Popen:
    """Begin to run one side."""
    mpiexec = Path(sys.executable).parent / "mpiexec"
    side = [
        sys.executable,
        "-m",
        "bench.yardstick.side",
        who,
        case.name,
        folder,
        str(len(case.times)),
    ]
    command = [mpiexec, "-n", str(ranks), *side]
    return subprocess.Popen(command, env=environment(), cwd=ROOT)


def finish(process: subprocess.Popen) -> None:
    """Wait for a side; raises CalledProcessError when it failed."""
    if process.wait():
        raise subprocess.CalledProcessError(process.returncode, process.args)


def record(folder: str, who: str, index: int) -> dict:
    """The record of a step by one side."""
    return json.loads((Path(folder) / f"{who}-{index}-0.json").read_text())


def beside(case: BenchCase, steps: int) -> dict:
    """All sides on one case, up to a number of steps."""
    case = replace(case, times=case.times[:steps])
    with tempfile.TemporaryDirectory() as folder:
        for process in [start(who, case, 1, folder) for who in SIDES]:
            finish(process)
        indices = range(len(case.times))
        found = {who: [record(folder, who, index) for index in indices] for who in SIDES}
        for index, step in enumerate(found["refined"]):  # its own energy, and that to be compared
            basin = record(folder, "basin", index)
            step |= {"energy_on_its_mesh": step["energy"]} | basin
    return summary(case, found)


def scaling(case: BenchCase, ranks: int) -> dict:
    """staffa alone on one rank and on more, one after the other, through the first step."""
    found = {}
    for number in (1, ranks):
        with tempfile.TemporaryDirectory() as folder:
            finish(start("alone", case, number, folder))
            found[number] = record(folder, "alone", 0)
    gain = found[1]["wall_s"] / found[ranks]["wall_s"]
    return {
        "case": case.name,
        "ranks": ranks,
        "unknowns": case.unknowns,
        "gain": round(gain, 2),
        "kB_per_unknown": round(found[1]["peak_MB"] * 1024 / case.unknowns, 2),
        "kB_per_unknown_without_libraries": round(
            (found[1]["peak_MB"] - found[1]["libraries_MB"]) * 1024 / case.unknowns, 2
        ),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "one": found[1],
        "more": found[ranks],
    }


def summary(case: BenchCase, steps: dict[str, list[dict]]) -> dict:
    """Totals of all sides, their ratios, and the steps themselves."""
    total = {
        who: {
            key: round(sum(step[key] for step in steps[who]), 3)
            for key in ("wall_s", "cpu_s", "sweeps")
        }
        | {"peak_MB": round(max(step["peak_MB"] for step in steps[who]), 1)}
        for who in SIDES
    }
    return {
        "case": case.name,
        "ranks": 1,
        "unknowns": case.unknowns,
        "tolerance": case.tolerance,
        "steps_run": f"{len(case.times)} of {len(CASES[case.name].times)}",
        **total,
        **beside_script(total, steps, "staffa"),
        "refined_beside_script": beside_script(total, steps, "refined")
        | {key: steps["refined"][-1][key] for key in MESH}
        | {"largest_coarse_damage": max(step["coarse_damage"] for step in steps["refined"])},
        "script_phases": phases(case, steps["script"]),
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
        "steps": steps,
    }


def beside_script(total: dict, steps: dict[str, list[dict]], who: str) -> dict:
    """Ratios of the script's totals to those of a side, and how far its energy lies above."""
    pairs = zip(steps["script"], steps[who], strict=True)
    above = [(ours["energy"] - theirs["energy"]) / abs(theirs["energy"]) for theirs, ours in pairs]
    return {
        f"ratio_{key}": round(total["script"][of] / total[who][of], 2)
        for key, of in (("wall", "wall_s"), ("cpu", "cpu_s"), ("sweeps", "sweeps"))
    } | {"largest_energy_above_script": max(above)}


def phases(case: BenchCase, steps: list[dict]) -> dict:
    """Seconds of the script's phases for the reference's number of sweeps and unknowns in 2-D."""
    sweeps = sum(step["sweeps"] for step in steps)
    scale = REFERENCE_SWEEPS / sweeps
    return {
        key: {
            "s_for_131_sweeps": round(scale * sum(step["phases"][key] for step in steps), 2),
            **({"reference_at_121k_in_2d": REFERENCE[key]} if case.dim == 2 else {}),
        }
        for key in REFERENCE
    }


def main() -> None:
    """Run the chosen cases and write what came out after each."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", nargs="*", help=f"of {', '.join(CASES)}; CASE:2 for two ranks")
    parser.add_argument("--steps", type=int, help="number of steps of each case")
    parser.add_argument("--out", type=Path, default=HERE / "results.json")
    arguments = parser.parse_args()
    every = [f"{case.name}:{ranks}" for case in CASES.values() for ranks in case.ranks]
    results = json.loads(arguments.out.read_text()) if arguments.out.exists() else {"runs": {}}
    print(
        f"{'case':9}{'unknowns':>9} {'script':>16} {'staffa':>16} {'refined':>16} "
        f"{'ratio':>6}  energy    {'ratio':>6}  energy",
        flush=True,
    )
    for chosen in arguments.cases or every:
        name, _, ranks = chosen.partition(":")
        case, number = CASES[name], int(ranks or 1)
        steps = arguments.steps or len(case.times)
        outcome = beside(case, steps) if number == 1 else scaling(case, number)
        outcome |= {"machine": machine(), "versions": versions()}
        results["runs"][f"{name}:{ranks or 1}"] = outcome
        arguments.out.write_text(json.dumps(results, indent=1) + "\n")
        print(line(outcome), flush=True)


def line(outcome: dict) -> str:
    """One case on one line."""
    name = f"{outcome['case']}:{outcome['ranks']}"
    if outcome["ranks"] > 1:
        one, more = outcome["one"]["wall_s"], outcome["more"]["wall_s"]
        return f"{name:9}{outcome['unknowns']:9d} {one:8.1f} s alone, {more:.1f} s with {name[-1]}"
    sides = [f"{outcome[who]['wall_s']:8.1f} s {outcome[who]['sweeps']:5d}" for who in SIDES]
    found = [outcome, outcome["refined_beside_script"]]
    beside = [
        f"{one['ratio_wall']:6.2f}  {100 * one['largest_energy_above_script']:+.3f} %"
        for one in found
    ]
    return f"{name:9}{outcome['unknowns']:9d} {' '.join(sides)} {'  '.join(beside)}"


if __name__ == "__main__":
    main()

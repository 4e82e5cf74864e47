"""The cost of the second-order test of each step: its share of a run's CPU time.

    python -m bench.second_order.run [NAME ...]

Names: demo (the case `slab`), or a case of the yardstick, run from its first step to its last.
Writes bench/second_order/results.json, from which docs/performance.md quotes.
"""

import json
import subprocess
import sys
from pathlib import Path
from time import process_time
from unittest.mock import patch

from staffa.backend.stack import MPI

import staffa
from bench.common.cases import CASES
from bench.common.ours import problem
from staffa.case.reading.ready_cases import ready_case
from staffa.evolution import second_order

HERE = Path(__file__).parent
NAMES = ("demo", "A30k", "A120k")


def measured(name: str) -> dict:
    """Seconds of the whole run, of its tests, and what these found."""
    case = staffa.problem(ready_case("slab")) if name == "demo" else None
    body = case or problem(CASES[name], MPI.COMM_WORLD)
    spent, test = [], second_order.tested

    def timed(*args):
        start = process_time()
        found = test(*args)
        spent.append(process_time() - start)
        return found

    system = staffa.build(body)
    with patch.object(second_order, "tested", timed):
        start = process_time()
        steps = list(staffa.march(body, system))
        whole = process_time() - start
    system.destroy()
    return {
        "steps": len(steps),
        "sweeps": sum(step.sweeps for step in steps),
        "tests": len(spent),
        "iterations": sum(step.curvature.iterations for step in steps),
        "escapes": sum(step.curvature.escapes for step in steps),
        "seconds": round(whole, 1),
        "share": round(sum(spent) / whole, 3),
    }


def main() -> None:
    """Measure, and keep what was measured before of other cases."""
    file = HERE / "results.json"
    kept = json.loads(file.read_text()) if file.exists() else {}
    describe = ["git", "rev-parse", "--short", "HEAD"]
    commit = subprocess.run(describe, cwd=HERE, capture_output=True, text=True, check=False)
    for name in sys.argv[1:] or NAMES:
        kept[name] = {"commit": commit.stdout.strip(), **measured(name)}
        print(name, kept[name], flush=True)
        file.write_text(json.dumps(kept, indent=1) + "\n")


if __name__ == "__main__":
    main()

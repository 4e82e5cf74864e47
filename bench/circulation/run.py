"""The cost of a reservoir simulator beside the mechanics, within one run of a ready case.

    python -m bench.circulation.run

Runs `fracture-wall` with open-DARTS on one rank. Writes `results.json`, from which
docs/performance.md quotes. The part of the simulator is the time that the run waits for it, over
the time of all steps.
"""

import json
import tempfile
from pathlib import Path

import staffa

FILE = Path(__file__).parent / "results.json"
CASE = "fracture-wall"


def main() -> None:
    """Measure one run."""
    with tempfile.TemporaryDirectory() as folder:
        steps = staffa.run(staffa.ready_case(CASE), Path(folder) / "run")
    waited = sum(step.heat.seconds for step in steps)
    whole = sum(step.seconds for step in steps)
    found = {
        "steps": len(steps),
        "sweeps": sum(step.sweeps for step in steps),
        "inner steps of the simulator": sum(step.heat.substeps for step in steps),
        "part of the simulator": round(waited / whole, 3),
    }
    FILE.write_text(json.dumps({CASE: found}, indent=1) + "\n")
    print(CASE, found)


if __name__ == "__main__":
    main()

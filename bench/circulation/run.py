"""The cost of a reservoir simulator beside the mechanics, one way and two ways.

    python -m bench.circulation.run

Runs `fracture-wall` with open-DARTS on one rank, without feedback and as it is. Writes
`results.json`, from which docs/performance.md quotes. The part of the simulator is the time that
the run waits for it, over the time of all steps of the same run.
"""

import json
import tempfile
from pathlib import Path

import staffa

FILE = Path(__file__).parent / "results.json"
CASE = "fracture-wall"
WAYS = {"one way": ["reservoir.feedback=false"], "two ways": []}


def measured(settings: list[str]) -> dict[str, float]:
    """Run the case, and return what it cost."""
    with tempfile.TemporaryDirectory() as folder:
        steps = staffa.run(staffa.ready_case(CASE, settings), Path(folder) / "run")
    waited = sum(step.heat.seconds for step in steps)
    whole = sum(step.seconds for step in steps)
    return {
        "steps": len(steps),
        "sweeps": sum(step.sweeps for step in steps),
        "passes": sum(step.heat.passes for step in steps),
        "inner steps of the simulator": sum(step.heat.substeps for step in steps),
        "part of the simulator": round(waited / whole, 3),
    }


def main() -> None:
    """Measure both ways."""
    found = {f"{CASE}, {way}": measured(settings) for way, settings in WAYS.items()}
    FILE.write_text(json.dumps(found, indent=1) + "\n")
    print(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()

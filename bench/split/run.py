"""The cost of the safe split: ready cases, smaller and coarser, with it and without a split.

    python -m bench.split.run [NAME ...]

Runs each case side by side with damage.split "none" and "no-tension", from its first step to its
last. Writes `results.json`, from which docs/performance.md quotes. `excess` is the largest part
by which the energy that drove damage in a step exceeded that of the safe split
(docs/reference/results.md).
"""

import json
import sys
from pathlib import Path
from time import process_time

from staffa.backend.stack import MPI  # noqa: F401

import staffa
from staffa.case.reading.ready_cases import ready_case
from staffa.evolution.pressed_growth import PressedGrowth

HERE = Path(__file__).parent
STEPS = "time.tau={start=0.02,stop=0.36,steps=8}"
# Heated by 30 K, nothing is damaged with the safe split; nor without one.
CASES = {
    "slab": ("domain.size=[1.0,1.0]", "domain.h=0.0133", "damage.ell=0.04", STEPS, "output.at=[]"),
    "granite-face": (
        'domain.h="20 mm"', 'damage.ell="60 mm"', "output.at=[]",
        'time.t={start="2 min",stop="12 hours",steps=8}',
    ),
    "notched": ("domain.h=0.02", "damage.ell=0.06", "time.tau=[0.05,0.2,0.4,0.7]", "output.at=[]"),
    "granite-face, heated": (
        'domain.h="20 mm"', 'damage.ell="60 mm"', "output.at=[]", 'heat.bottom={T="230 °C"}',
        'time.t={start="2 min",stop="12 hours",steps=8}',
    ),
}  # fmt: skip


def measured(name: str, split: str) -> dict:
    """CPU seconds, sweeps and factorizations of a run, and its energies at the end."""
    case = ready_case(name.partition(",")[0], [*CASES[name], f'damage.split="{split}"'])
    problem = staffa.problem(case)
    system = staffa.build(problem)
    growth, excess = PressedGrowth(system.energy), 0.0
    before = system.state.alpha.x.array.copy()
    steps, spent, start = [], 0.0, process_time()
    for step in staffa.march(problem, system):
        spent += process_time() - start
        steps.append(step)
        driven = growth.driven(before)
        excess = max(excess, driven.excess if driven else 0.0)
        before, start = system.state.alpha.x.array.copy(), process_time()
    found = {
        "cpu": round(spent, 1),
        "sweeps": sum(step.sweeps for step in steps),
        "factorizations": system.alternation.elastic.renewals,
        "elastic": steps[-1].energies.elastic,
        "surface": steps[-1].energies.surface,
    }
    system.destroy()
    return found | ({"excess": round(excess, 4)} if split == "none" else {})


def main() -> None:
    """Measure, and keep what was measured before of other cases."""
    file = HERE / "results.json"
    known = json.loads(file.read_text()) if file.exists() else {}
    for name in sys.argv[1:] or CASES:
        known[name] = {split: measured(name, split) for split in ("none", "no-tension")}
        known[name]["ratio"] = round(
            known[name]["no-tension"]["cpu"] / known[name]["none"]["cpu"], 1
        )
        file.write_text(json.dumps(known, indent=1) + "\n")
        print(name, known[name], flush=True)


if __name__ == "__main__":
    main()

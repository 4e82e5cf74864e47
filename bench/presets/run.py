"""Every preset on two small cases, from start to end: which solver to choose, in numbers.

    python -m bench.presets.run [--out FILE]

Run by `make bench`; the results go beside those of run.py. Called with a case and presets, it is
one of these runs.
"""

import argparse
import json
import resource
import subprocess
import sys
from pathlib import Path
from time import perf_counter

from bench.common.cases import SMALL
from bench.common.machine import ROOT, environment, machine, versions

RESULTS = ROOT / "bench" / "yardstick" / "results.json"

CHOICES = (
    {},
    {"displacement": "other"},
    {"damage": "snes"},
    {"acceleration": "none"},
)
OTHER = {2: "iterative", 3: "direct"}


def one(name: str, presets: dict[str, str]) -> dict:
    """All steps of a case with these presets."""
    from staffa.backend.stack import MPI

    from bench.common.ours import Ours

    case = SMALL[name]
    ours = Ours(case, MPI.COMM_WORLD, **presets)
    ours.put_at_rest()
    started = perf_counter()
    steps = [ours.step(time) for time in case.times]
    return {
        "case": name,
        "unknowns": case.unknowns,
        "presets": presets,
        "wall_s": round(perf_counter() - started, 2),
        "sweeps": sum(step["sweeps"] for step in steps),
        "energy": steps[-1]["energy"](),
        "peak_MB": round(resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, 1),
    }


def every() -> list[dict]:
    """Each choice on each case, in a separate process."""
    found = []
    for name, case in SMALL.items():
        for choice in CHOICES:
            presets = {k: OTHER[case.dim] if v == "other" else v for k, v in choice.items()}
            command = [
                sys.executable,
                "-m",
                "bench.presets.run",
                "--one",
                name,
                json.dumps(presets),
            ]
            done = subprocess.run(
                command, env=environment(), cwd=ROOT, stdout=subprocess.PIPE, text=True, check=True
            )
            found.append(json.loads(done.stdout.splitlines()[-1]))
            print(f"{name} {presets or 'defaults'}: {found[-1]['wall_s']} s", flush=True)
    return found


def main() -> None:
    """Run all, or one of them."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--one", nargs=2, metavar=("CASE", "PRESETS"), help="one run, to stdout")
    parser.add_argument("--out", type=Path, default=RESULTS)
    arguments = parser.parse_args()
    if arguments.one:
        print(json.dumps(one(arguments.one[0], json.loads(arguments.one[1]))))
        return
    results = json.loads(arguments.out.read_text()) if arguments.out.exists() else {"runs": {}}
    results["presets"] = {"found": every(), "machine": machine(), "versions": versions()}
    arguments.out.write_text(json.dumps(results, indent=1) + "\n")


if __name__ == "__main__":
    main()

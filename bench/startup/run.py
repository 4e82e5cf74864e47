"""CPU time of commands that compute nothing: help, and the check of a scaled case and of one in SI.

    python -m bench.startup.run

Starts each command several times and keeps the least CPU time, of user and system: other programs
on the machine can only add to it. Writes `results.json`, from which docs/performance.md quotes.
Part of `make bench`; exit code 1 if a command takes more than its bound.
"""

import json
import resource
import subprocess
import sys
from pathlib import Path

from bench.common.machine import ROOT, environment, machine, versions

RESULTS = Path(__file__).parent / "results.json"
READY = ROOT / "src" / "staffa" / "case" / "ready"
TIMES = 10  # how often each command is started
# Most seconds of each.
BOUNDS = {
    "staffa --help": 0.5,
    "staffa check slab.toml": 1.5,
    "staffa check granite-face.toml": 1.5,
}


def cpu_seconds(command: list[str]) -> float:
    """Return the CPU time (s) of a command and of what it starts."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, cwd=READY, env=environment(), check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime - before.ru_utime + after.ru_stime - before.ru_stime


def main() -> None:
    """Measure, print and write."""
    program = str(Path(sys.executable).parent / "staffa")
    measured = {}
    for command in BOUNDS:
        line = [program, *command.split()[1:]]
        measured[command] = round(min(cpu_seconds(line) for _ in range(TIMES)), 2)
        print(f"{command}: {measured[command]:.2f} s, at most {BOUNDS[command]} s")
    found = {"machine": machine(), "versions": versions(), "bounds": BOUNDS, "cpu": measured}
    RESULTS.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
    sys.exit(any(measured[command] > bound for command, bound in BOUNDS.items()))


if __name__ == "__main__":
    main()

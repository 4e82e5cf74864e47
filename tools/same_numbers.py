"""Run five shortened ready cases and write their numbers, or compare them with those of before.

    .venv/bin/python tools/same_numbers.py before.json
    .venv/bin/python tools/same_numbers.py after.json --against before.json

Numbers are kept to the bit. One rank, one thread; both files from one machine.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

CASES = {
    "slab": "domain.size=[2.0,1.0] domain.h=0.025 damage.ell=0.06 "
    "time.tau=[0.02,0.06,0.12,0.2] output.at=[0.2]",
    "layered": "domain.h=0.03 damage.ell=0.06 time.tau=[0.05,0.1,0.2] output.at=[0.2]",
    "cell": "domain.h=0.02 damage.ell=0.05 time.tau=[0.01,0.05,0.1] output.at=[0.1]",
    "glass-slab": "domain.h=0.3mm damage.ell=0.8mm time.tau=[0.05,0.15,0.3] output.at=[0.3]",
    "granite-face": "domain.size=['1m','1m'] domain.h=30mm damage.ell=70mm "
    "time.t=['10min','1h','4h'] output.at=['4h']",
}
# Facts of the machine and of the moment, not results.
IGNORED = {"seconds", "wall", "memory"}


def numbers(value: Any, name: str = "") -> dict[str, str]:
    """Return every number within `value`, JSON as read, by its path, as hexadecimal text."""
    if isinstance(value, dict):
        parts = [(key, part) for key, part in value.items() if key not in IGNORED]
    elif isinstance(value, list):
        parts = [(str(place), part) for place, part in enumerate(value)]
    elif isinstance(value, int | float) and not isinstance(value, bool):
        return {name: float(value).hex()}
    else:
        return {}
    found: dict[str, str] = {}
    for key, part in parts:
        found |= numbers(part, f"{name}.{key}" if name else key)
    return found


def measured(name: str) -> list[dict[str, str]]:
    """Run one case and return the numbers of each of its steps."""
    with tempfile.TemporaryDirectory() as folder:
        out, ready = Path(folder) / "run", Path(folder) / "case.toml"
        settings = [word for setting in CASES[name].split() for word in ("--set", setting)]
        staffa = [sys.executable, "-c", "from staffa.cli import main; main()"]
        with ready.open("w") as file:
            subprocess.run([*staffa, "new", name], check=True, stdout=file)
        # As a user compiles, not as the tests do.
        environment = {k: v for k, v in os.environ.items() if k != "STAFFA_CFLAGS"}
        environment["OMP_NUM_THREADS"] = "1"
        command = [*staffa, "run", str(ready), "--quiet", "--out", str(out), *settings]
        subprocess.run(command, check=True, env=environment)
        lines = (out / "steps.jsonl").read_text().splitlines()
    return [numbers(json.loads(line)) for line in lines]


def difference(before: dict[str, str], after: dict[str, str], name: str) -> float:
    """Return by how much one number differs, relative to the larger one of the two."""
    old, new = float.fromhex(before[name]), float.fromhex(after[name])
    return 0.0 if old == new else abs(new - old) / max(abs(old), abs(new))


def compare(before: dict[str, Any], after: dict[str, Any]) -> bool:
    """Print for each case where its numbers differ; return whether all are equal to the bit."""
    same = True
    for name, steps in after.items():
        old = before[name]
        worst = [(0.0, 0, "")]
        for place, (was, now) in enumerate(zip(old, steps, strict=False)):
            both = was.keys() & now.keys()
            worst += [(difference(was, now, key), place, key) for key in both]
            new = sorted(was.keys() ^ now.keys())
            if new:
                print(f"{name}, step {place}: only in one of them: {', '.join(new)}")
        count = len(steps) == len(old)
        most, place, key = max(worst)
        equal = most == 0 and count
        same &= equal
        said = "equal to the bit" if equal else f"differs by {most:.2e} in {key}, step {place}"
        print(f"{name}: {len(steps)} steps, {said}" + ("" if count else f"; {len(old)} before"))
    return same


def main() -> int:
    """Measure, write, and compare if asked to; return 1 where numbers differ."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("file", type=Path)
    parser.add_argument("--against", type=Path)
    asked = parser.parse_args()
    after = {name: measured(name) for name in CASES}
    asked.file.write_text(json.dumps(after, indent=1) + "\n")
    if asked.against is None:
        return 0
    return 0 if compare(json.loads(asked.against.read_text()), after) else 1


if __name__ == "__main__":
    sys.exit(main())

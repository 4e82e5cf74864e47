"""Long verifications, each figure against a reference; writes verify/results.json and the page.

    python verify/run.py [NAME ...]

Without a name, all of them; what the results hold of others is kept. Run by `make verify`. Ends
with exit code 1 if a figure misses its tolerance.
"""

import json
import sys
from datetime import UTC, datetime
from pathlib import Path

from checks import CHECKS
from figures import Found

HERE = Path(__file__).parent
RESULTS = HERE / "results.json"
PAGE = HERE.parent / "docs" / "verification.md"
HEAD = """# Verification

Written by `make verify` from `verify/results.json`: each figure with its reference, its tolerance,
the command that measured it, and the day. What was missed is said to be missed.
"""


def record(found: Found) -> dict:
    """What is kept of one check."""
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "figures": [{**vars(figure), "met": figure.met} for figure in found.figures],
        "text": found.text,
    }


def page(results: dict) -> str:
    """The results as a page."""
    parts = [HEAD]
    for name, check in CHECKS.items():
        if name not in results:
            continue
        found = results[name]
        parts.append(f"## {check.title}\n\n{check.text}\n")
        parts.append(f"`make verify ONLY={name}`, {found['date']}\n")
        parts.append(
            "| figure | reference | measured | tolerance | |\n| --- | --- | --- | --- | --- |"
        )
        parts.append(
            "\n".join(
                f"| {f['what']} | {f['reference']:.4g} ({f['source']}) | {f['measured']:.4g} | "
                f"{f['tolerance']:.2g} | {'met' if f['met'] else '**missed**'} |"
                for f in found["figures"]
            )
        )
        parts.append("")
        if found.get("text"):
            parts.append(found["text"] + "\n")
    return "\n".join(parts)


def main(names: list[str]) -> int:
    """Run the checks named, or all."""
    unknown = [name for name in names if name not in CHECKS]
    if unknown:
        print(f"no check is called {', '.join(unknown)}; there are {', '.join(CHECKS)}")
        return 2
    results = json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    missed = 0
    for name in names or CHECKS:
        found = CHECKS[name].measure()
        if not isinstance(found, Found):
            found = Found(figures=found, text="")
        results[name] = record(found)
        RESULTS.write_text(json.dumps(results, indent=1) + "\n")
        PAGE.write_text(page(results))
        for figure in found.figures:
            print(f"{name}: {figure}", flush=True)
        missed += sum(not figure.met for figure in found.figures)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

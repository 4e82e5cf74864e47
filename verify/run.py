"""Long verifications, each figure against a reference; writes verify/results.json and the page.

    python verify/run.py [NAME ...]

Without a name, all of them; what the results hold of others is kept. Run by `make verify`. Ends
with exit code 1 if more figures miss their tolerances than in the results that are committed.
"""

import json
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable
from datetime import UTC, datetime
from pathlib import Path

from checks import CHECKS
from figures import Found

HERE = Path(__file__).parent
RESULTS = HERE / "results.json"
PAGE = HERE.parent / "docs" / "verification.md"
HEAD = """# Verification

Written by `make verify` from `verify/results.json`: each figure with its reference, its tolerance,
the command that measured it, and the day. Runs of hours are kept, and read again by that command;
where, from when, and how they are made anew is said beside it. What was missed is said to be
missed.
"""


def record(found: Found) -> dict:
    """The record of one check."""
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "figures": [{**vars(figure), "met": figure.met} for figure in found.figures],
        "text": found.text,
    }


def committed() -> dict:
    """The results that are committed; those at hand where there is no git."""
    show = ["git", "show", "HEAD:./results.json"]
    try:
        done = subprocess.run(show, cwd=HERE, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return json.loads(RESULTS.read_text()) if RESULTS.exists() else {}
    return json.loads(done.stdout)


def verdicts(results: dict, names: Iterable[str]) -> dict[str, bool]:
    """True or False for each figure of these checks, by its check and its name."""
    return {
        f"{name}: {f['what']}": f["met"]
        for name in names
        for f in results.get(name, {}).get("figures", ())
    }


def worse(before: dict, now: dict) -> list[str]:
    """Figures that were met and are missed; of those that are new by name, how many more of a kind
    are missed than were: they are alike but for the numbers in their names."""
    old, new = verdicts(before, now), verdicts(now, now)
    lost = [what for what, met in new.items() if not met and old.get(what)]
    fresh = Counter(_kind(what) for what, met in new.items() if not met and what not in old)
    gone = Counter(_kind(what) for what, met in old.items() if not met and what not in new)
    return [*lost, *(fresh - gone)]


def _kind(what: str) -> str:
    return re.sub(r"[0-9.]+", "#", what)


def days(kept: object) -> set[str]:
    """The days on which the runs of a kept file were made."""
    if isinstance(kept, list):
        return set().union(*map(days, kept))
    if not isinstance(kept, dict):
        return set()
    return {kept["date"]} if "date" in kept else set().union(*map(days, kept.values()))


def origin(name: str, found: dict) -> str:
    """The command, the day, and where runs are kept that it only reads."""
    said = f"`make verify ONLY={name}`, {found['date']}"
    kept = CHECKS[name].kept
    if kept is None:
        return said
    files = sorted((HERE / kept).glob("*.json")) if (HERE / kept).is_dir() else [HERE / kept]
    made = sorted(set().union(*(days(json.loads(file.read_text())) for file in files)))
    when = made[0] if len(made) == 1 else f"{made[0]} to {made[-1]}"
    script = f"verify/{Path(kept).stem}.py"
    return f"{said}, from runs of {when} kept in `verify/{kept}` (made anew as `{script}` says)"


def balance(results: dict) -> str:
    """Number of figures of each check, and of those that it missed."""
    rows, all_of, missed = [], 0, 0
    for name, check in CHECKS.items():
        figures = results.get(name, {}).get("figures", [])
        away = sum(not f["met"] for f in figures)
        all_of, missed = all_of + len(figures), missed + away
        link = re.sub(r"[^a-z0-9 -]", "", check.title.lower()).replace(" ", "-")
        rows.append(f"| [{check.title}](#{link}) | {len(figures)} | {away or ''} |")
    head = "| | figures | missed |\n| --- | --- | --- |"
    return "\n".join([head, *rows, f"| together | {all_of} | {missed} |", ""])


def row(figure: dict) -> str:
    """A figure as a row of its table."""
    bound = {None: "", "least": "at least ", "most": "at most "}[figure.get("bound")]
    expected = f"{bound}{figure['reference']:.4g} ({figure['source']})"
    verdict = "met" if figure["met"] else "**missed**"
    numbers = f"{figure['measured']:.4g} | {figure['tolerance']:.2g}"
    return f"| {figure['what']} | {expected} | {numbers} | {verdict} |"


def page(results: dict) -> str:
    """The results as a page."""
    parts = [HEAD, balance(results)]
    for name, check in CHECKS.items():
        if name not in results:
            continue
        found = results[name]
        parts.append(f"## {check.title}\n\n{check.text}\n")
        parts.append(f"{origin(name, found)}\n")
        parts.append(
            "| figure | reference | measured | tolerance | |\n| --- | --- | --- | --- | --- |"
        )
        parts.extend(map(row, found["figures"]))
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
    before = committed()
    for name in names or CHECKS:
        found = CHECKS[name].measure()
        if not isinstance(found, Found):
            found = Found(figures=found, text="")
        results[name] = record(found)
        RESULTS.write_text(json.dumps(results, indent=1) + "\n")
        PAGE.write_text(page(results))
        for figure in found.figures:
            print(f"{name}: {figure}", flush=True)
    found = worse(before, {name: results[name] for name in names or CHECKS})
    for figure in found:
        print(f"missed, which was not: {figure}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

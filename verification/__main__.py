"""Measure figures against references; write each folder's expected.json and the page.

    python -m verification [NAME ...]

Without a name, all of them; what is expected of others is kept. Run by `make verify`. Ends with
exit code 1 if more figures miss their tolerances than in the files that are committed.
"""

import json
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable
from datetime import UTC, datetime
from importlib import import_module
from pathlib import Path

from verification.common.figures import Check, Found

HERE = Path(__file__).parent
PAGE = HERE.parent / "docs" / "verification.md"
# In the order of the page.
FOLDERS = (
    *("heat", "quench", "injection", "solid", "second_order", "saddles", "onset", "surfing"),
    *("cohesive", "toughness_direction", "arrays", "pairs", "energies", "slabs", "uneven"),
    *(
        "openings",
        "slabs_refined",
        "squeezed",
        "grain",
        "opposite_boundary",
        "columns",
        "columns_theory",
        "bricks",
    ),
    *("brick_refined", "layers", "neighbors", "lens", "imposed_cracks", "feedback", "strip"),
    *("doublet_cracks", "stimulation"),
)
FOUND: dict[str, dict[str, Check]] = {
    folder: import_module(f"verification.{folder}.run").CHECKS for folder in FOLDERS
}
# Rooms whose figures are new, or hold what other rooms measure against another reference.
ADDED = ("cohesive", "uneven", "openings", "columns_theory", "bricks", "lens", "strip")
CHECKS = {name: check for checks in FOUND.values() for name, check in checks.items()}
FOLDER_OF = {name: HERE / folder for folder, checks in FOUND.items() for name in checks}
HEAD = """# Verification

`make verify` writes this page from `verification/NAME/expected.json`: each figure with its
reference, its tolerance, the command that measured it, and the day. Runs of hours are kept, and
that command only reads them. Beside the command are the place of these runs, their dates, and how
to make them again. A missed figure is marked as missed.
"""


def record(found: Found) -> dict:
    """The record of one check."""
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "figures": [
            {**vars(figure), "met": figure.met, "met_before": figure.met_before}
            for figure in found.figures
        ],
        "text": found.text,
    }


def current_results(folder: Path) -> dict:
    """Results of the checks of a folder, as its file has them now."""
    file = folder / "expected.json"
    return json.loads(file.read_text()) if file.exists() else {}


def committed(folder: Path) -> dict:
    """The results that are committed; the current ones where there is no git."""
    show = ["git", "show", "HEAD:./expected.json"]
    try:
        done = subprocess.run(show, cwd=folder, capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return current_results(folder)
    return json.loads(done.stdout)


def write(name: str, results: dict) -> None:
    """Write the results of the folder of a check, and the page."""
    folder = FOLDER_OF[name]
    own = {check: results[check] for check in FOUND[folder.name] if check in results}
    (folder / "expected.json").write_text(json.dumps(own, indent=1) + "\n")
    PAGE.write_text(page(results))


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
    where = FOLDER_OF[name] / kept
    files = sorted(where.glob("*.json")) if where.is_dir() else [where]
    made = sorted(set().union(*(days(json.loads(file.read_text())) for file in files)))
    when = made[0] if len(made) == 1 else f"{made[0]} to {made[-1]}"
    place = f"verification/{FOLDER_OF[name].name}"
    again = f"made again as `{place}/run.py` says"
    return f"{said}, from runs of {when} kept in `{place}/{kept}` ({again})"


def balance(results: dict) -> str:
    """Number of figures of each check, and of those that it missed; added ones also apart.

    Figures that are met now, and were missed against the reference before, are told.
    """
    rows, counts, former = [], {True: [0, 0], False: [0, 0]}, 0
    for name, check in CHECKS.items():
        figures = results.get(name, {}).get("figures", [])
        away = sum(not f["met"] for f in figures)
        former += sum(f["met"] and not f.get("met_before", True) for f in figures)
        added = FOLDER_OF[name].name in ADDED
        counts[added][0] += len(figures)
        counts[added][1] += away
        link = re.sub(r"[^a-z0-9 -]", "", check.title.lower()).replace(" ", "-")
        star = " \\*" if added else ""
        rows.append(f"| [{check.title}](#{link}){star} | {len(figures)} | {away or ''} |")
    head = "| | figures | missed |\n| --- | --- | --- |"
    rows.append("| together | {} | {} |".format(*counts[False]))
    rows.append("| together, of the sections with \\* | {} | {} |".format(*counts[True]))
    note = "Sections with \\* are new, or hold figures of others against new ones; those stay."
    if former:
        note += f" {former} of the figures that are met missed a reference that they had before: "
        note += "it stands beside the other."
    return "\n".join([head, *rows, "", note, ""])


def row(figure: dict) -> str:
    """A figure as a row of its table."""
    bound = {None: "", "least": "at least ", "most": "at most "}[figure.get("bound")]
    expected = f"{bound}{figure['reference']:.4g} ({figure['source']})"
    if figure.get("before"):
        reference, source = figure["before"]
        past = "met" if figure["met_before"] else "missed"
        expected += f"; before: {reference:.4g} ({source}), {past}"
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
    results: dict = {}
    before: dict = {}
    for folder in FOLDERS:
        results |= current_results(HERE / folder)
        before |= committed(HERE / folder)
    for name in names or CHECKS:
        found = CHECKS[name].measure()
        if not isinstance(found, Found):
            found = Found(figures=found, text="")
        results[name] = record(found)
        write(name, results)
        print(f"{name}:", *map(row, results[name]["figures"]), sep="\n", flush=True)
    found = worse(before, {name: results[name] for name in names or CHECKS})
    for figure in found:
        print(f"missed, which was not: {figure}")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

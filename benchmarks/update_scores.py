"""Score the submissions of this folder; write scores/NAME.json, and the table of README.md.

python -m benchmarks.update_scores
"""

import re
from collections.abc import Sequence
from pathlib import Path

from benchmarks.score import MISSING, Figure, by_case, record, score

HERE = Path(__file__).parent
SUBMISSIONS, SCORES, README = HERE / "submissions", HERE / "scores", HERE / "README.md"
MARKS = "<!-- scores -->\n", "<!-- end of scores -->\n"


def distance(figure: Figure) -> float:
    """Return how far a value is off, in tolerances; above an upper bound alone if it is one."""
    assert figure.value is not None
    over = figure.value - figure.reference
    return (max(over, 0.0) if figure.bound else abs(over)) / figure.tolerance


def cell(figures: Sequence[Figure]) -> str:
    """Return the score of a case for the table: the verdict, and the largest distance."""
    (found,) = by_case(figures).values()
    values = [figure for figure in figures if figure.value is not None]
    if found["verdict"] == MISSING or not values:
        return MISSING
    worst = max(map(distance, values))
    return f"{found['verdict']} ({worst:.2g})"


def table() -> str:
    """Return the table of all submissions."""
    scores = {folder.name: score(folder) for folder in sorted(SUBMISSIONS.iterdir())}
    lines = [f"| case | {' | '.join(scores)} |", "| --- |" + " --- |" * len(scores)]
    for case in dict.fromkeys(figure.case for figure in next(iter(scores.values()))):
        of_case = [[f for f in figures if f.case == case] for figures in scores.values()]
        lines.append(f"| `{case}` | {' | '.join(map(cell, of_case))} |")
    return "\n".join(lines) + "\n"


def main() -> None:
    """Write the scores of all submissions, and the table."""
    SCORES.mkdir(exist_ok=True)
    for folder in sorted(SUBMISSIONS.iterdir()):
        (SCORES / f"{folder.name}.json").write_text(record(folder, score(folder)))
    begin, end = map(re.escape, MARKS)
    marked = f"{MARKS[0]}{table()}{MARKS[1]}"
    README.write_text(re.sub(f"{begin}.*?{end}", marked, README.read_text(), flags=re.DOTALL))


if __name__ == "__main__":
    main()

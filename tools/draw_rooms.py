"""Draw the rooms of the package and the way of the data, from the code's own imports.

.venv/bin/python tools/draw_rooms.py                       # docs/pictures/{rooms,data-flow}.svg
.venv/bin/python tools/draw_rooms.py --source DIR --out F  # the rooms of another tree
"""

import argparse
import ast
import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch, Rectangle
from matplotlib.path import Path as Line

ROOT = Path(__file__).parent.parent
SOURCE = ROOT / "src" / "staffa"
PICTURES = ROOT / "docs" / "pictures"
LIGHT, HEAVY, INK = "#e8f1dc", "#dbe6f4", "#2b2b2b"
WIDTH, HEIGHT, ROW, PITCH = 2.35, 0.62, 1.05, 2.6  # of boxes and between them, in inches
GAP = 0.3  # for an arrow that passes between boxes, in inches
ROUNDS = 40  # of sorting each floor by its neighbors; it is at rest before

# The way of the data: (what flows, the room that makes it or keeps it, what happens on the way).
FLOW = [
    ("my.toml", "", ""),
    ("Case", "case.schema", "case.reading reads it, case.rules tests it, case.check warns"),
    ("Problem", "evolution", "setup makes numbers and functions of the keys"),
    ("System", "evolution", "forms, matrices and solvers are made once"),
    ("State", "model", "evolution marches in time; heat and minimize solve"),
    ("Step", "records", "measure makes numbers of the state"),
    ("run directory", "io", "runs writes a line and the fields of each step"),
    ("pages and tables", "report", "results, plot and compare read the directory"),
]


def room(name: str) -> str:
    """Return the room of a module, from its full name: its top folder, within `case` the next."""
    parts = name.split(".")[1:]
    return ".".join(parts[: 2 if parts[0] == "case" else 1])


def imported(tree: ast.AST) -> Iterator[str]:
    """Yield the full name of everything that a tree imports."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from (f"{node.module}.{alias.name}" for alias in node.names)


class Rooms:
    """The rooms of a source tree, the imports between them, and the floor of each.

    Attributes
    ----------
    below : the rooms that a room imports from, by room.
    about : first words of the room's docstring, by room.
    heavy : the rooms of which some module loads MPI and PETSc, through `staffa.backend.stack`.
    """

    def __init__(self, source: Path) -> None:
        self.below: dict[str, set[str]] = {}
        self.about: dict[str, str] = {}
        self.heavy: set[str] = set()
        for path in sorted(source.rglob("*.py")):
            name = ".".join(path.relative_to(source.parent).with_suffix("").parts)
            package = name.removesuffix(".__init__")
            if package in ("staffa", "staffa.case"):
                continue
            here, tree = room(package), ast.parse(path.read_text(encoding="utf-8"))
            names = set(imported(tree))
            there = {room(other) for other in names if other.startswith("staffa.")}
            self.below.setdefault(here, set()).update(there - {here})
            if name.endswith("__init__") or path.parent == source:
                self.about[here] = re.split(
                    "[:;.]", (ast.get_docstring(tree) or "").replace("`", "")
                )[0]
            if any(other.startswith(("staffa.backend.stack", "staffa.stack")) for other in names):
                self.heavy.add(here)

    def floor(self, name: str) -> int:
        """Return the number of the floor: one above the highest room that it imports from."""
        return max((1 + self.floor(other) for other in self.below[name]), default=0)

    def reached(self, name: str) -> set[str]:
        """Return every room that a room imports from, directly or through others."""
        return self.below[name].union(*(self.reached(other) for other in self.below[name]))

    def arrows(self) -> set[tuple[str, str]]:
        """Return the imports that are not implied by others, as (room, room below it)."""
        implied = {
            (name, far)
            for name, others in self.below.items()
            for other in others
            for far in self.reached(other)
        }
        return {(a, b) for a, others in self.below.items() for b in others} - implied


@dataclass(frozen=True)
class Bend:
    """A point at which an arrow passes a floor between two rooms.

    Attributes
    ----------
    above, below : the rooms at the ends of the arrow.
    floor : the number of the floor.
    """

    above: str
    below: str
    floor: int


def ways(rooms: Rooms) -> list[list[str | Bend]]:
    """Return each arrow as the points that it passes, one on each floor, from the upper room."""
    return [
        [a, *(Bend(a, b, f) for f in range(rooms.floor(a) - 1, rooms.floor(b), -1)), b]
        for a, b in sorted(rooms.arrows())
    ]


def places(rooms: Rooms) -> dict[str | Bend, tuple[float, float]]:
    """Return the place of each box and bend in inches: floors as rows, neighbors close together."""
    near: dict[str | Bend, list[str | Bend]] = {name: [] for name in sorted(rooms.below)}
    for way in ways(rooms):
        for one, other in pairwise(way):
            near.setdefault(one, []).append(other)
            near.setdefault(other, []).append(one)
    rows: dict[int, list[str | Bend]] = {}
    for point in near:
        floor = point.floor if isinstance(point, Bend) else rooms.floor(point)
        rows.setdefault(floor, []).append(point)
    found: dict[str | Bend, tuple[float, float]] = {}

    def lay(floor: int) -> None:
        widths = [GAP if isinstance(point, Bend) else PITCH for point in rows[floor]]
        x = -sum(widths) / 2
        for point, width in zip(rows[floor], widths, strict=True):
            found[point] = (x + width / 2, floor * ROW)
            x += width

    def mean(point: str | Bend) -> float:
        return sum(found[other][0] for other in near[point]) / max(len(near[point]), 1)

    for floor in rows:
        lay(floor)
    for _ in range(ROUNDS):
        for floor in sorted(rows):
            rows[floor].sort(key=lambda point: round(mean(point), 6))
            lay(floor)
    return found


def box(axes: Axes, at: tuple[float, float], title: str, text: str, color: str) -> None:
    """Draw a box with its bold title and one or two lines of text."""
    corner = (at[0] - WIDTH / 2, at[1] - HEIGHT / 2)
    shape = FancyBboxPatch(
        corner, WIDTH, HEIGHT, "round,pad=0,rounding_size=0.08", facecolor=color, edgecolor=INK,
        linewidth=0.8, zorder=3,
    )  # fmt: skip
    axes.add_patch(shape)
    up = 0.17 if text else 0.0
    axes.text(at[0], at[1] + up, title, ha="center", va="center", weight="bold", zorder=4)
    lines = textwrap.fill(text, 40)
    axes.text(at[0], at[1] - 0.1, lines, ha="center", va="center", fontsize=7.5, zorder=4)


def canvas(width: float, height: float) -> Axes:
    """Return empty axes of a size in inches, one unit an inch."""
    figure, axes = plt.subplots(figsize=(width, height))
    axes.set_axis_off()
    axes.set_aspect("equal")
    figure.subplots_adjust(left=0, right=1, bottom=0, top=1)
    return axes


def draw_rooms(rooms: Rooms, out: Path) -> None:
    """Draw the floors with an arrow for each import that others do not imply."""
    at = places(rooms)
    width = max(x for x, _ in at.values()) - min(x for x, _ in at.values()) + WIDTH + 0.4
    height = max(y for _, y in at.values()) + HEIGHT + 0.7
    axes = canvas(width, height)
    for way in ways(rooms):
        ends = [[(at[p][0], at[p][1] + side * HEIGHT / 2) for side in (1, -1)] for p in way]
        arrow = FancyArrowPatch(
            path=Line([point for pair in ends for point in pair][1:-1]), arrowstyle="-|>",
            mutation_scale=8, color="#8a8a8a", linewidth=0.9, shrinkA=0, shrinkB=0, zorder=2,
        )  # fmt: skip
        arrow.set_gid(f"{way[0]}->{way[-1]}")
        axes.add_patch(arrow)
    for name in rooms.below:
        color = HEAVY if name in rooms.heavy else LIGHT
        box(axes, at[name], name, rooms.about.get(name, ""), color)
    for shift, color, text in (
        (-3.4, LIGHT, "loads without MPI and PETSc"),
        (0.4, HEAVY, "some modules need MPI and PETSc"),
    ):
        axes.add_patch(Rectangle((shift, -0.77), 0.3, 0.2, facecolor=color, edgecolor=INK))
        axes.text(shift + 0.4, -0.67, text, va="center", fontsize=9)
    axes.set(xlim=(-width / 2, width / 2), ylim=(-0.95, height - 0.75))
    save(axes, out)


def draw_flow(out: Path) -> None:
    """Draw what becomes of a case file, from top to bottom."""
    axes = canvas(6.6, len(FLOW) * 0.85 + 0.1)
    for row, (what, where, how) in enumerate(FLOW):
        y = -row * 0.85
        box(axes, (0, y), what, f"in {where}" if where else "what a user writes", LIGHT)
        if row:
            start, end = (0, y + 0.85 - HEIGHT / 2), (0, y + HEIGHT / 2)
            axes.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=9))
        axes.text(WIDTH / 2 + 0.15, y, textwrap.fill(how, 58), va="center", fontsize=8)
    axes.set(xlim=(-WIDTH / 2 - 0.1, 5.3), ylim=(-len(FLOW) * 0.85 + 0.45, HEIGHT / 2 + 0.1))
    save(axes, out)


def save(axes: Axes, out: Path) -> None:
    """Write a picture, without the date: the same code gives the same file."""
    metadata = {"Date": None} if out.suffix == ".svg" else None
    axes.figure.savefig(out, dpi=110, metadata=metadata)
    plt.close("all")


def main() -> None:
    """Draw what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--source", type=Path, default=SOURCE, help="the folder of a package")
    parser.add_argument("--out", type=Path, help="the picture of its rooms")
    options = parser.parse_args()
    plt.rcParams.update({"svg.fonttype": "none", "svg.hashsalt": "staffa", "font.size": 10})
    draw_rooms(Rooms(options.source), options.out or PICTURES / "rooms.svg")
    if options.out is None:
        draw_flow(PICTURES / "data-flow.svg")


if __name__ == "__main__":
    main()

"""Draw the rooms of the package and the way of the data, from the code's own imports.

.venv/bin/python tools/draw_rooms.py                       # docs/pictures/{rooms,data-flow}.svg
.venv/bin/python tools/draw_rooms.py --source DIR --out F  # the rooms of another tree
"""

import argparse
import ast
import re
import textwrap
from collections.abc import Iterator
from pathlib import Path

import matplotlib

matplotlib.use("Agg")

from matplotlib import pyplot as plt
from matplotlib.axes import Axes
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch, Rectangle

ROOT = Path(__file__).parent.parent
SOURCE = ROOT / "src" / "staffa"
PICTURES = ROOT / "docs" / "pictures"
LIGHT, HEAVY, INK = "#e8f1dc", "#dbe6f4", "#2b2b2b"
WIDTH, HEIGHT, ROW, PITCH = 2.35, 0.62, 1.05, 2.6  # of boxes and between them, in inches

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
                self.about[here] = re.split("[:;.]", ast.get_docstring(tree) or "")[0]
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


def places(rooms: Rooms) -> dict[str, tuple[float, float]]:
    """Return the center of each box in inches: floors as rows, neighbors near one another."""
    rows: dict[int, list[str]] = {}
    for name in sorted(rooms.below):
        rows.setdefault(rooms.floor(name), []).append(name)
    found: dict[str, tuple[float, float]] = {}

    def lay(order: list[str], height: int) -> None:
        for column, name in enumerate(order):
            found[name] = ((column - (len(order) - 1) / 2) * PITCH, height * ROW)

    for height, names in rows.items():
        lay(names, height)
    links = rooms.arrows()
    near = {n: [b if a == n else a for a, b in links if n in (a, b)] for n in rooms.below}
    for _ in range(12):
        for height, names in sorted(rows.items()):
            mean = {
                n: sum(found[o][0] for o in near[n]) / len(near[n]) if near[n] else 0.0
                for n in names
            }
            lay(sorted(names, key=lambda n: (round(mean[n], 6), n)), height)
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
    for above, below in sorted(rooms.arrows()):
        (x0, y0), (x1, y1) = at[above], at[below]
        arrow = FancyArrowPatch(
            (x0, y0 - HEIGHT / 2), (x1, y1 + HEIGHT / 2), arrowstyle="-|>", mutation_scale=8,
            color="#8a8a8a", linewidth=0.9, shrinkA=0, shrinkB=0, zorder=2,
        )  # fmt: skip
        arrow.set_gid(f"{above}->{below}")
        axes.add_patch(arrow)
    for name, center in at.items():
        color = HEAVY if name in rooms.heavy else LIGHT
        box(axes, center, name, rooms.about.get(name, ""), color)
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
    axes = canvas(7.4, len(FLOW) * 0.85 + 0.1)
    for row, (what, where, how) in enumerate(FLOW):
        y = -row * 0.85
        box(axes, (0, y), what, f"in {where}" if where else "what a user writes", LIGHT)
        if row:
            start, end = (0, y + 0.85 - HEIGHT / 2), (0, y + HEIGHT / 2)
            axes.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=9))
        axes.text(WIDTH / 2 + 0.15, y, textwrap.fill(how, 58), va="center", fontsize=8)
    axes.set(xlim=(-WIDTH / 2 - 0.1, 6.1), ylim=(-len(FLOW) * 0.85 + 0.45, HEIGHT / 2 + 0.1))
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

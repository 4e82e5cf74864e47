"""Tables of even arrays of cracks: growth at G = Gc, and loss of stability; kept as CSV.

    python -m verification.columns_theory.table

computes them (some minutes of CPU time) and writes stability.csv, growth.csv and checks.csv beside
this file. Rows that are there stay: to compute them again, delete the files. With `tables N` or
`checks N` it computes N rows.
"""

import csv
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from verification.columns_theory.array import BELOW, Array
from verification.columns_theory.cross_sections import hexagon, strip
from verification.columns_theory.variation import Solved, Wave

HERE = Path(__file__).parent
COMMAND = "python -m verification.columns_theory.table"
NU = 0.2  # of the runs of verification/columns
# Wave vectors times the spacing: every other zigzag row of walls, odd across x, even across y; and
# others to compare: every third cell, and what lies between these.
ROWS = Wave(k=np.array([2 * np.pi / np.sqrt(3), 0.0]), mirrors=(-1, 1))
OTHERS = {
    "every third cell": Wave(k=np.array([0.0, 4 * np.pi / 3])),
    "half of rows": Wave(k=np.array([np.pi / np.sqrt(3), 0.0])),
    "half of every third": Wave(k=np.array([0.0, 2 * np.pi / 3])),
    "between rows and every third": Wave(k=np.array([2 * np.pi / np.sqrt(3), np.pi / 3])),
    "all cells alike": Wave(k=np.zeros(2)),
}
THIRD = "every third cell stops"
TURNS = Wave(k=np.array([np.pi]))  # every other crack of parallel ones
DEPTHS = (0.2, 0.3, 0.4, 0.5, 0.65, 0.85, 1.1, 1.4)  # of the fronts, over the spacing
# First steps of the mesh at a front over the spacing: results go as it, and are extrapolated to 0.
STEPS = {"parallel": (0.02, 0.01), "hexagons": (0.1, 0.05)}
PER_SIDE = 2
RATIO = 2.0
WIDER = 1.13  # sqrt(kappa t) of hexagons over that of parallel cracks, about
# Depth and sqrt(kappa t) at which parallel cracks lose stability, about: where the search starts.
START = (DEPTHS, (0.15, 0.19, 0.23, 0.26, 0.3, 0.35, 0.4, 0.45))


THIRDS = {"softest": OTHERS["every third cell"]}
# Rows of checks.csv: what differs from the tables, at a = 0.85 p and on their coarser mesh.
VARIANTS: tuple[tuple[str, dict], ...] = (
    ("as the table", {}),
    ("4 cells a side", {"per_side": 4}),
    ("body 2.4 p deep below the fronts", {"below": 2.4}),
    ("first = 0.05", {"first": 0.05}),
    ("first = 0.025", {"first": 0.025}),
    ("nu = 0", {"nu": 0.0}),
    ("nu = 0.3", {"nu": 0.3}),
    (THIRD, {"waves": THIRDS, "depth": 0.4, "start": 0.4}),
    (THIRD, {"waves": THIRDS, "start": 0.56}),
    (THIRD, {"waves": THIRDS, "depth": 1.4, "start": 0.7}),
)


def solved(
    cells: str,
    depth: float,
    first: float,
    waves: dict[str, Wave] | None = None,
    *,
    nu: float = NU,
    per_side: int = PER_SIDE,
    below: float = BELOW,
) -> Solved:
    """Make an array ready for any time.

    Parameters
    ----------
    cells : "parallel" or "hexagons".
    depth : of the fronts, over the spacing.
    first : first step of the mesh at a front.
    waves : patterns by name; by default the softest one.
    nu : Poisson's ratio.
    per_side : cells of the mesh along a side of a hexagon.
    below : depth of the body below the fronts.
    """
    parallel = cells == "parallel"
    section = strip(first, RATIO) if parallel else hexagon(first, RATIO, per_side)
    array = Array(section, depth=depth, nu=nu, first=first, ratio=RATIO, below=below)
    return Solved(array, waves or {"softest": TURNS if parallel else ROWS})


def spacing(release: float, nu: float = NU) -> float:
    """p over ell0 of a solid from G = Gc, G over sigma^2 p/E."""
    return (1 - nu**2) / release


def loss(ready: Solved, start: float) -> float:
    """Find sqrt(kappa t) over the spacing at which the softest pattern loses stability."""
    at = [start, 1.04 * start]
    least = [ready.softest(ready.at(layer), "softest")[0] for layer in at]
    while abs(at[-1] - at[-2]) > 1e-4 * start:
        slope = (least[-1] - least[-2]) / (at[-1] - at[-2])
        at.append(float(np.clip(at[-1] - least[-1] / slope, 0.8 * at[-1], 1.2 * at[-1])))
        least.append(ready.softest(ready.at(at[-1]), "softest")[0])
    return at[-1]


def growth(cells: str, depth: float, first: float, ready: Solved, near: float) -> Iterator[dict]:
    """The spacing at which G = Gc, at some times around one."""
    for layer in near * np.array([0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.2, 1.5]):
        p = spacing(ready.release(layer)[0])
        yield row(cells, first, depth, layer, p)


def row(cells: str, first: float, depth: float, layer: float, p: float) -> dict:
    """A row of a table; lengths over ell0 but for `first`."""
    return {
        "cells": cells,
        "first": first,
        "a/p": depth,
        "sqrt(kappa t)/p": round(float(layer), 6),
        "p": float(f"{p:.6g}"),
        "a": float(f"{p * depth:.6g}"),
        "sqrt(kappa t)": float(f"{p * layer:.6g}"),
    }


def write(name: str, rows: list[dict]) -> None:
    """Write a table, with its command on the first line."""
    with (HERE / name).open("w", newline="") as file:
        file.write(f"# {COMMAND}; nu = {NU}; lengths over ell0, `first` over the spacing\n")
        table = csv.DictWriter(file, rows[0], lineterminator="\n")
        table.writeheader()
        table.writerows(rows)


def read(name: str) -> list[dict[str, str]]:
    """Read a table, as far as it is there."""
    if not (HERE / name).exists():
        return []
    with (HERE / name).open() as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))


def tables(most: int) -> None:
    """Growth and loss of stability of both arrays, on both meshes; rows that are there stay.

    Parameters
    ----------
    most : rows to compute in this call.
    """
    lost, grown = read("stability.csv"), read("growth.csv")
    known = {(row["cells"], row["a/p"], row["first"]) for row in lost}
    asked = [(cells, a, first) for cells in STEPS for a in DEPTHS for first in STEPS[cells]]
    missing = [key for key in asked if tuple(map(str, key)) not in known]
    for cells, depth, first in missing[:most]:
        ready = solved(cells, depth, first)
        start = float(np.interp(depth, *START)) * (1.0 if cells == "parallel" else WIDER)
        layer = loss(ready, start)
        release, local = ready.release(layer)
        ends = {"local G from": local.min().round(4), "to": local.max().round(4)}
        lost.append(row(cells, first, depth, layer, spacing(release)) | ends)
        print(lost[-1], flush=True)
        if first == STEPS[cells][-1]:
            grown.extend(growth(cells, depth, first, ready, layer))
            write("growth.csv", grown)
        write("stability.csv", lost)


def checks(most: int) -> None:
    """Influence of the mesh, of the depth of the body, and of nu; every third cell alone.

    Parameters
    ----------
    most : rows to compute in this call.
    """
    rows = read("checks.csv")
    known = {(row["what"], row["a/p"]) for row in rows}
    for what, changed in VARIANTS:
        told = {"depth": 0.85, "first": 0.1, "nu": NU, "start": 0.4} | changed
        depth, first, nu, start = (float(told.pop(n)) for n in ("depth", "first", "nu", "start"))
        if (what, str(depth)) in known:
            continue
        ready = solved("hexagons", depth, first, nu=nu, **told)
        layer = loss(ready, start)
        p = spacing(ready.release(layer)[0], nu)
        rows.append({"what": what, **row("hexagons", first, depth, layer, p)})
        print(rows[-1], flush=True)
        write("checks.csv", rows)
        most -= 1
        if not most:
            return


if __name__ == "__main__":
    parts = {"tables": tables, "checks": checks}
    part, number = sys.argv[1:] or (None, "1000")
    for name in [part] if part else parts:
        parts[name](int(number))

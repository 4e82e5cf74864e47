"""Write the reference tables from the data of `verification`, which is their one source.

    python -m benchmarks.make_tables

Also copies the two sharp-crack tables that the references are taken from.
"""

import csv
import json
import math
import re
import shutil
from pathlib import Path

import numpy as np

from verification.common.sharp import DATA, PAIR, array_growth, first_doubling, length_at

HERE = Path(__file__).parent
REFERENCE, SHARP, ROCK = HERE / "reference", HERE / "sharp", HERE / "rock"
VERIFICATION = HERE.parent / "verification"
P = 0.1285
# A row: quantity, place (None for a single number), value, tolerance (absolute), bound.
Row = tuple[str, float | None, float, float, str]
# Tolerances as parts of the reference; README.md has their reasons.
STRENGTH, ENERGY, SURFING, LENGTH, ARREST = 0.01, 0.02, 0.03, 0.05, 0.05
WAVELENGTH, FIRST, LOWEST = 0.1, 0.05, 0.03
# Length that the cracks of `array` and `spacing` begin with, by spacing. A smeared crack counts as
# an ell longer or so before it has grown: the tables begin where the sharp one is GROWN times that.
STARTS = {P: 0.08, 0.2: 0.1, 0.3: 0.12}
GROWN = 1.15


def _figure(quantity: str, at: float | None, value: float, share: float, bound: str = "") -> Row:
    return quantity, at, value, share * abs(value), bound


def bar() -> list[Row]:
    """Strength by AT1's formula, which the case asks for, and Gc times the section."""
    strength = math.sqrt(3 * 1.0 * 100.0 / (8 * 0.1))
    return [
        _figure("strength", None, strength, STRENGTH),
        _figure("crack energy", None, 0.3, ENERGY),
    ]


def surfing() -> list[Row]:
    """A crack follows the tip that drives it, at Gc."""
    return [_figure("speed", None, 1.0, SURFING), _figure("cost", None, 1.0, SURFING)]


def array() -> list[Row]:
    """Length against tau, from where the crack has grown up to the first doubling."""
    rows = []
    for section, last in (("fixed", 10), ("free", 11)):
        tau, a = array_growth(section)
        for at in np.arange(6, last + 1) / 100:
            value = float(np.interp(at, tau, a))
            rows.append(_figure(f"length, {section}", float(at), value, LENGTH))
    return _grown(rows, P)


def spacing() -> list[Row]:
    """Length against tau at other spacings, where the crack has grown up to the first doubling."""
    rows = []
    for p in (0.2, 0.3):
        lengths = {at: length_at("fixed", p, at) for at in (0.06, 0.08, 0.10, 0.12, 0.14, 0.16)}
        of_spacing = [_figure(f"length, p = {p}", at, a, LENGTH) for at, a in lengths.items()]
        rows += _grown(of_spacing, p)
    return rows


def _grown(rows: list[Row], p: float) -> list[Row]:
    """The rows in which a crack of an array of this spacing has grown."""
    return [row for row in rows if row[2] >= GROWN * STARTS[p]]


def doubling() -> list[Row]:
    """The arrest of every other crack of an even array."""
    tau, a = first_doubling("fixed", P)
    return [_figure("arrest length", None, a, ARREST), _figure("arrest tau", None, tau, ARREST)]


def pair() -> list[Row]:
    """The arrest of a crack that is tougher by 1 % than its neighbors."""
    tau, a = PAIR
    return [_figure("arrest length", None, a, ARREST), _figure("arrest tau", None, tau, ARREST)]


def onset() -> list[Row]:
    """The first mode of the damaged layer, dT/dT_c = 3, wave by wave."""
    file = VERIFICATION / "onset" / "expected.json"
    figures = json.loads(file.read_text())["onset"]["figures"]
    exact = [f for f in figures if "wave by wave" in f["source"] and f["what"].endswith("= 3")]
    wavelength, depth = (found["reference"] for found in exact)
    return [
        _figure("wavelength", None, wavelength, WAVELENGTH),
        _figure("depth of cooling", None, depth, FIRST),
    ]


def energies() -> list[Row]:
    """The lowest energy found of a slab, of three ways to minimize."""
    text = json.loads((VERIFICATION / "energies" / "expected.json").read_text())["energies"]["text"]
    part = text.split("| slab, dT/dT_c = 1.28, tau |")[1].split("\n\n")[0]
    found = re.findall(r"^\| ([0-9.]+) \|((?: [0-9.]+ \(\d+\) \|)+)$", part, re.M)
    return [
        _figure("total energy", float(tau), min(_totals(row)), LOWEST, "most")
        for tau, row in found
        if float(tau) <= 0.4
    ]


def _totals(row: str) -> list[float]:
    return [float(cell.split()[0]) for cell in row.split("|") if cell.strip()]


TABLES = {
    make.__name__: make for make in (bar, surfing, array, spacing, doubling, pair, onset, energies)
}


def rows_of(case: str) -> list[list[str]]:
    """The reference rows of a case as texts."""
    return [
        [quantity, "" if at is None else f"{at:g}", f"{value:.5g}", f"{tolerance:.3g}", bound]
        for quantity, at, value, tolerance, bound in TABLES[case]()
    ]


def rock() -> list[list[str]]:
    """The random toughness of `energies` at the nodes of its mesh, as texts."""
    from staffa.properties.random_field import random_factor

    factor = random_factor("lognormal", 0.05, lengths=(0.06, 0.06), axes=np.eye(2), seed=0)
    y, x = (axis.ravel() for axis in np.mgrid[0:51, 0:151] * 0.02)
    values = factor(np.array([x, y, np.zeros_like(x)]))
    return [[f"{a:g}", f"{b:g}", f"{c:.4f}"] for a, b, c in zip(x, y, values, strict=True)]


def main() -> None:
    """Write all tables."""
    for case in TABLES:
        with (REFERENCE / f"{case}.csv").open("w", newline="") as opened:
            to = csv.writer(opened, lineterminator="\n")
            to.writerow(("quantity", "at", "value", "tolerance", "bound"))
            to.writerows(rows_of(case))
    with (ROCK / "energies.csv").open("w", newline="") as opened:
        to = csv.writer(opened, lineterminator="\n")
        to.writerow(("x", "y", "Gc"))
        to.writerows(rock())
    SHARP.mkdir(exist_ok=True)
    for name in ("array_growth.csv", "spacing_and_doubling.csv"):
        shutil.copyfile(DATA / name, SHARP / name)


if __name__ == "__main__":
    main()

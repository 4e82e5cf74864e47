"""A bar and a disc-shaped crack in three dimensions, pulled until they break.

    python -m verification.solid.run

runs the disc, which takes minutes, and keeps it in `kept.json`; `make verify ONLY=solid-disc`
looks at what is kept, and runs it if nothing is. `make verify ONLY=solid-bar` runs the bars.
"""

import json
from datetime import UTC, datetime
from math import pi, sqrt
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import matplotlib.pyplot as plt
import numpy as np

import staffa
from staffa.case.reading.read import read_case
from staffa.evolution.effective_toughness import effective_gc
from staffa.evolution.march import march
from staffa.model.fields import vertices
from staffa.records.step import Step
from verification.common.figures import Check, Figure, Found
from verification.common.fine_mesh import make_mesh
from verification.common.runs import ROOT, keep

KEPT = Path(__file__).parent / "kept.json"
PICTURE = ROOT / "docs" / "pictures" / "verify-solid-disc.png"
# The ready case `bar` with a square section: 25 cells along it, so that one is in the middle.
SECTION, ELL, STRENGTH, STRAIN_AT_1 = 0.3, 0.1, 19.365, 0.25
BAR = ["domain.size=[1.0, 0.3, 0.3]", f"domain.h={1 / 25}", "output.at=[]"]
# As the ready case pulls, and on.
FAR = "supports.right={x={t=[0.0, 4.0], u=[0.0, 1.0]}}"
MIDDLE = "{lower=[0.4,0.0,0.0], upper=[0.6,0.3,0.3], factor=0.995}"


def bar(cells: str) -> list[Figure]:
    """Strength, and what a crack across costs and how wide it is."""
    figures = [
        Figure(
            what=f"{cells}: largest stress of an even bar without damage",
            source="sqrt(3 Gc E/(8 ell)), uniaxial stress in three dimensions",
            reference=STRENGTH,
            measured=strength(cells),
            tolerance=0.005 * STRENGTH,
        )
    ]
    # From sound to broken in one step: damage before the crack would stay, and be paid for too.
    settings = [f"toughness.bands=[{MIDDLE}]", FAR, "time.t=[0.05, 1.2, 3.2]"]
    case = staffa.ready_case("bar", [*BAR, f"domain.cells={cells}", *settings])
    problem = staffa.problem(case)
    system = staffa.build(problem)
    *_, last = march(problem, system)
    h = problem.domain.h
    factor = effective_gc(problem.material, dim=3, h=h, cells=cells)
    x, alpha = vertices(system.spaces.alpha)[:, 0], system.state.alpha.x.array
    # Each damage, on both sides of the broken cells, as it would be from a sharp crack: exact
    # profiles are 1 - sqrt(alpha) = r/(2 ell).
    on = (alpha > 0.05) & (alpha < 0.9)
    broken = x[alpha > 0.99]
    r = np.maximum(broken.min() - x, x - broken.max())[on]
    widths = r / (1 - np.sqrt(alpha[on]))
    paid = system.energy.crack_length() / SECTION**2
    system.destroy()
    return [
        *figures,
        Figure(
            what=f"{cells}: dissipated energy over Gc, the section and the factor of the effective "
            f"Gc {factor:.3f}",
            source="one plane crack across",
            reference=1.0,
            measured=paid / factor,
            tolerance=0.01,
        ),
        Figure(
            what=f"{cells}: half width of the damage",
            source="(1 - r/(2 ell))^2",
            reference=2 * ELL,
            measured=float(np.mean(widths)),
            tolerance=0.03 * 2 * ELL,
        ),
        Figure(
            what=f"{cells}: stress at four times the critical strain",
            source="broken",
            reference=0.0,
            measured=stress(last),
            tolerance=0.01 * STRENGTH,
        ),
    ]


def strength(cells: str) -> float:
    """The largest stress without damage, over steps of 0.25 % of the critical strain."""
    critical = STRENGTH / 100 / STRAIN_AT_1
    times = [round(float(f * critical), 6) for f in np.arange(0.99, 1.0101, 0.0025)]
    # An even bar has no reason to break here rather than there: how it does is another matter.
    even = ["toughness.bands=[]", f"time.t={times}", "solver.sweeps=3"]
    problem = staffa.problem(staffa.ready_case("bar", [*BAR, f"domain.cells={cells}", *even]))
    system = staffa.build(problem)
    largest = 0.0
    for step in march(problem, system):
        if step.energies.surface > 0:
            break
        largest = stress(step)
    system.destroy()
    return largest


def stress(step: Step) -> float:
    """The mean stress on the end that is pulled."""
    return abs(step.reactions["right"][0]) / SECTION**2


def bars() -> list[Figure]:
    """Both kinds of cells."""
    return [*bar("hexahedron"), *bar("tetrahedron")]


# Radius of the broken disc; the block reaches 3 each way, 6 radii of the crack.
NU = 0.2
SIZES = {"a": 0.5, "ell": 0.1, "h": 0.1 / 3, "reach": 0.7, "width": 3.0}
# Of the stress at which a sharp disc of its radius would grow; steps of 2 % where it will.
RATIOS = (0.4, 0.6, 0.7, *(round(0.8 + 0.02 * i, 2) for i in range(27)))
GROWN = 1.5  # over the step before: it runs through. Before, damage around its edge builds up
DISC = """
title = "A disc-shaped crack in a block that is pulled"

[domain]
mesh = "{mesh}"
h = {h}

[material]
nu = 0.2

[damage]
law = "AT1"
ell = {ell}
split = "none"  # nothing presses the crack shut

[temperature]
profile = "none"

[supports]
left = "rollers"
front = "rollers"

[forces]
top = {{ z = {{ formula = "t" }} }}
bottom = {{ z = {{ formula = "-t" }} }}

[[cracks]]
center = [0.0, 0.0, 1e-4]
radius = {a}
normal = [0.0, 0.0, 1.0]

[solver]
sweeps = 40  # once it runs, it runs through: that it does is enough

[time]
t = {times}
"""


def critical(a: float, toughness: float) -> float:
    """The remote stress at which a sharp disc grows: G = 4 (1 - nu^2) s^2 a/(pi E)."""
    return sqrt(pi * toughness / (4 * (1 - NU**2) * a))


def radius(stored: float, s: float) -> float:
    """Radius of the sharp disc that adds this energy to a block under a remote stress (Sack 1946):
    8 (1 - nu^2) s^2 a^3/(3 E), which 2 pi a G sums up to."""
    return float(np.cbrt(3 * stored / (8 * (1 - NU**2) * s**2)))


def disc() -> dict:
    """Pull a quarter of the block until the crack runs."""
    folder = ROOT / "runs" / "verification" / "solid"
    folder.mkdir(parents=True, exist_ok=True)
    make_mesh(folder / "disc.msh", 3, SIZES, pulled=True)
    file = folder / "disc.toml"
    times = [round(ratio * critical(SIZES["a"], 1.0), 5) for ratio in RATIOS]
    file.write_text(DISC.format(mesh="disc.msh", times=times, **SIZES))
    case = read_case(file)
    problem = staffa.problem(case)
    system = staffa.build(problem)
    rows: list[list[float]] = []
    seconds = 0.0
    for step in march(problem, system):
        energies = step.energies
        rows.append([step.time, 4 * energies.elastic, 4 * energies.surface, step.sweeps])
        seconds += step.seconds
        print(step.index, rows[-1], step.reason, flush=True)
        if step.status != "converged" or rows[-1][2] > GROWN * rows[max(len(rows) - 2, 0)][2]:
            break
    space = system.state.u.function_space
    factor = effective_gc(problem.material, dim=3, h=SIZES["h"], cells="unstructured")
    system.destroy()
    return {
        "command": "python -m verification.solid.run",
        "date": datetime.now(UTC).date().isoformat(),
        "unknowns": space.dofmap.index_map.size_global * 3,
        "toughness_factor": round(factor, 4),
        "seconds": round(seconds),
        "rows": [[round(float(x), 6) for x in row] for row in rows],
    }


def pulled_disc() -> Found:
    """The radius by its compliance, and the stress at which it runs."""
    if not KEPT.exists():
        keep(KEPT, disc())
    found = json.loads(KEPT.read_text())
    s, elastic, surface, _ = np.array(found["rows"]).T
    whole = (2 * SIZES["width"]) ** 3
    a = [radius(e - t**2 * whole / 2, t) for t, e in zip(s, elastic, strict=True)]
    toughness = found["toughness_factor"]
    onset = (s[-2] + s[-1]) / 2
    expected = critical(a[-2], toughness)
    draw(s, surface, expected)
    text = (
        f"Radius of the broken cells: {SIZES['a']}; of the sharp disc of the same compliance: "
        f"{a[0]:.4f} at first, {a[-2]:.4f} before it runs. Effective Gc over Gc {toughness}, "
        f"ell = {SIZES['ell']} = 3 h, {found['unknowns']} displacement unknowns, "
        f"{found['seconds']} s. It runs between {s[-2]:.4f} and {s[-1]:.4f}.\n\n"
        f"![Surface energy against stress](pictures/{PICTURE.name})"
    )
    figures = [
        Figure(
            what="remote stress at which it runs, over that of a sharp disc of this radius",
            source="Sack 1946, G = 4 (1 - nu^2) s^2 a/(pi E) = effective Gc",
            reference=1.0,
            measured=float(onset / expected),
            tolerance=0.05,
        ),
    ]
    return Found(figures=figures, text=text)


def draw(s: np.ndarray, surface: np.ndarray, expected: float) -> None:
    """Surface energy against the remote stress, to where it runs."""
    figure, axes = plt.subplots(figsize=(5, 4))
    axes.plot(s, surface, "ko-", markersize=4, label="staffa")
    axes.axvline(expected, color="C1", label="a sharp disc runs")
    axes.set(xlabel="remote stress", ylabel="surface energy", ylim=(0, None))
    axes.legend(frameon=False, fontsize=9)
    figure.savefig(PICTURE, dpi=120, bbox_inches="tight")
    plt.close(figure)


CHECKS = {
    "solid-bar": Check(
        title="A bar in three dimensions",
        text=(
            "The ready case `bar` with a square section, 0.3 x 0.3, and cells of 0.04. It is "
            "weaker by 0.5 % in the middle, where it should break. Half width: by the exact "
            "profile from the damage of each vertex, mean over the vertices."
        ),
        measure=bars,
    ),
    "solid-disc": Check(
        title="A disc-shaped crack under a remote stress",
        text=(
            "A quarter of a large block in tension, by a stress on its two ends that grows by 2 % "
            "of the critical one a step; Gmsh's cells. The crack's radius follows from what it "
            "adds to the stored energy."
        ),
        measure=pulled_disc,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    keep(KEPT, disc())

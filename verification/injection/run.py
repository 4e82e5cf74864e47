"""Cracks that a given volume of fluid opens and drives: in a large plate, and in a large block.

    python -m verification.injection.run plate.AT1 block ...

runs members that are not kept yet (minutes each) and keeps them in `kept.json`;
`make verify ONLY=injection` looks at what is kept, and runs nothing.
"""

import json
import sys
from datetime import UTC, datetime
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from staffa.io.run_directory import Run, open_run
from verification.common.figures import Check, Figure, Found
from verification.common.fine_mesh import make_mesh
from verification.common.runs import ROOT, as_typed, staffa

KEPT = Path(__file__).parent / "kept.json"
PICTURE = ROOT / "docs" / "pictures" / "verify-injection.png"
NU, E_PRIME = 0.2, 1 / (1 - 0.2**2)
SNEDDON = "Sneddon 1946, and G = Gc"
# Length of the crack to begin with, reach of the fine cells, half width of the body.
PLATE = {"a": 0.2, "ell": 0.02, "h": 0.005, "reach": 0.45, "width": 3.0}
BLOCK = {"a": 0.5, "ell": 0.18, "h": 0.06, "reach": 1.0, "width": 3.0}
CASE = """
title = "A crack that a given volume of fluid opens and drives"

[domain]
mesh = "{mesh}"
h = {h}

[material]
{plane}nu = 0.2

[damage]
law = "{law}"
ell = {ell}

[temperature]
profile = "none"

[supports]
{supports}

[forces]
crack_volume = {{ formula = "t" }}  # held by the whole crack: this is half of it, or a quarter

[[cracks]]
{crack}

[solver]
residual = {residual}

[time]
t = {times}
"""


def critical_volume(dim: int, a: float, toughness: float) -> float:
    """The volume at which a crack of half length or radius a starts to grow."""
    if dim == 2:  # V = 2 pi a^2 p/E', K = p sqrt(pi a)
        return 2 * a**2 * np.sqrt(np.pi * toughness / (E_PRIME * a))
    # V = 16 a^3 p/(3 E'), K = 2 p sqrt(a/pi)
    return 16 * a**3 / (3 * E_PRIME) * np.sqrt(np.pi * E_PRIME * toughness / (4 * a))


def length(dim: int, pressure: np.ndarray, volume: np.ndarray) -> np.ndarray:
    """The half length or radius of the sharp crack that this pressure opens by this volume."""
    if dim == 2:
        return np.sqrt(E_PRIME * volume / (2 * np.pi * pressure))
    return np.cbrt(3 * E_PRIME * volume / (16 * pressure))


def growing(dim: int, volume: np.ndarray, toughness: float) -> np.ndarray:
    """The pressure of a sharp crack of this volume that grows."""
    if dim == 2:
        return np.cbrt(2 * toughness**2 * E_PRIME / (np.pi * volume))
    return (16 / (3 * E_PRIME) * (np.pi * E_PRIME * toughness / 4) ** 3 / volume) ** 0.2


def run_member(name: str) -> dict:
    """Run a member: "plate.AT1", "block.AT1"."""
    shape, law = name.split(".")
    dim, sizes = (2, PLATE) if shape == "plate" else (3, BLOCK)
    folder = ROOT / "runs" / "verification" / "injection"
    folder.mkdir(parents=True, exist_ok=True)
    mesh, case, where = (folder / f"{name}{end}" for end in (".msh", ".toml", ""))
    make_mesh(mesh, dim, sizes)
    parts = 2 if dim == 2 else 4
    first = critical_volume(dim, sizes["a"], 1.0) / parts
    # A disc of few ell is as wide as one of its radius and half an ell: it grows later.
    ratios = [0.4, 0.8, *(np.arange(1.2, 2.21, 0.1) if dim == 2 else np.arange(1.5, 2.71, 0.3))]
    crack = (
        f"start = [0.0, 1e-4]\nend = [{sizes['a']}, 1e-4]"
        if dim == 2
        else f"center = [0.0, 0.0, 1e-4]\nradius = {sizes['a']}\nnormal = [0.0, 0.0, 1.0]"
    )
    held = ("left",) if dim == 2 else ("left", "front")
    case.write_text(
        CASE.format(
            mesh=mesh.name,
            law=law,
            plane='plane = "strain"\n' if dim == 2 else "",
            ell=sizes["ell"],
            h=sizes["h"],
            residual=1e-2 if dim == 2 else 1e-1,
            supports="\n".join(f'{side} = "rollers"' for side in held),
            crack=crack,
            times=[round(float(r * first), 6) for r in ratios],
        )
    )
    if not where.exists():
        staffa(case, where, ["damage.split=none"])
    return digest(name, open_run(where), parts, dim)


def digest(name: str, run: Run, parts: int, dim: int) -> dict:
    """The numbers that are kept of a run, of the whole crack."""
    m = run.manifest
    rows = []
    for step in run.steps:
        assert step.measures is not None and step.measures.fluid is not None
        fluid = step.measures.fluid
        rows.append([parts * fluid.volume, fluid.pressure, parts * step.energies.surface])
    return {
        "command": f"python -m verification.injection.run {name}",
        "commit": m.commit,
        "date": datetime.now(UTC).date().isoformat(),
        "typed": as_typed(run, f"{name}.toml", ["damage.split=none"]),
        "dim": dim,
        "unknowns": m.unknowns,
        "ell": m.ell,
        "toughness_factor": m.toughness_factor,
        "seconds": round(sum(step.seconds for step in run.steps)),
        "rows": [[round(float(x), 6) for x in row] for row in rows],
    }


def kept() -> dict[str, dict]:
    """The kept numbers by name."""
    return json.loads(KEPT.read_text()) if KEPT.exists() else {}


def injection() -> Found:
    """Pressure against volume, before the crack grows and while it does."""
    figures, lines = [], []
    for name, found in kept().items():
        dim, (volume, pressure, surface) = found["dim"], np.array(found["rows"]).T
        tolerance, what = (0.03, "plate") if dim == 2 else (0.05, "block")
        a = length(dim, pressure, volume)
        size = 2 * a if dim == 2 else np.pi * a**2
        on = a > a[0] + found["ell"] / 2  # what has run by that runs on evenly
        toughness = growing_toughness(size, surface, on)
        still = 1  # at 0.8 of the volume at which a sharp crack of its length would grow
        figures.append(
            Figure(
                what=f"{name}: pressure over volume at {volume[still]:.3g}, before it grows, over "
                "that at the first volume",
                source="a crack of constant length",
                reference=1.0,
                measured=float(pressure[still] / volume[still] * volume[0] / pressure[0]),
                tolerance=tolerance,
            )
        )
        ratio = pressure / growing(dim, volume, toughness)
        worst = float(ratio[on][np.abs(ratio[on] - 1).argmax()])
        figures.append(
            Figure(
                what=f"{name}: pressure while it grows to {a[-1] / a[0]:.2f} of its length, over "
                "that of a sharp crack of this volume; the worst",
                source=f"{SNEDDON}, in a {what} without end",
                reference=1.0,
                measured=worst,
                tolerance=tolerance,
            )
        )
        lines.append(
            f"| {name} | {a[0]:.4f} | {a[-1]:.4f} | {found['toughness_factor']:.4f} | "
            f"{toughness:.4f} | {found['unknowns']} | {found['seconds']} | {found['commit'][:7]} |"
        )
    head = (
        "Effective length: that of the sharp crack that the first pressure opens by the first "
        "volume. Toughness of the growing crack: its new surface energy over the new length (area) "
        "by pressure and volume.\n\n"
        "| run | effective length | at the end | toughness of a straight crack on these cells | of "
        "the growing one | unknowns | s | commit |\n|" + " --- |" * 8
    )
    draw()
    return Found(
        figures=figures,
        text="\n".join([head, *lines, "", f"![Pressure and volume](pictures/{PICTURE.name})"]),
    )


def growing_toughness(size: np.ndarray, surface: np.ndarray, on: np.ndarray) -> float:
    """New surface energy over new length or area, from the last step before `on` to the end."""
    from_here = slice(int(np.flatnonzero(on)[0]) - 1, None)
    return float(np.polyfit(size[from_here], surface[from_here], 1)[0])


def draw() -> None:
    """Pressure against volume, beside sharp cracks of the effective length and toughness."""
    members = kept()
    figure, axes = plt.subplots(1, len(members), figsize=(5 * len(members), 4), squeeze=False)
    for panel, (name, found) in zip(axes[0], members.items(), strict=True):
        dim, (volume, pressure, surface) = found["dim"], np.array(found["rows"]).T
        a = length(dim, pressure, volume)
        size = 2 * a if dim == 2 else np.pi * a**2
        on = a > a[0] + found["ell"] / 2
        toughness = growing_toughness(size, surface, on)
        V = np.linspace(volume[0], volume[-1], 200)
        panel.plot(V, pressure[0] / volume[0] * V, "C0--", label="sharp, of constant length")
        panel.plot(V, growing(dim, V, toughness), "C1-", label="sharp, growing")
        panel.plot(volume, pressure, "ko", markersize=4, label="staffa")
        panel.set(xlabel="volume", ylabel="pressure", title=name, xlim=(0, None))
        panel.set_ylim(0, 1.3 * pressure.max())
        panel.legend(frameon=False, fontsize=9)
    figure.savefig(PICTURE, dpi=120, bbox_inches="tight")


CHECKS = {
    "injection": Check(
        title="Cracks that a fluid drives",
        text=(
            "A crack in a large plate, and a disc in a large block, filled by volume. Gmsh's cells "
            "are fine where the crack grows."
        ),
        measure=injection,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    for member in sys.argv[1:]:
        done = run_member(member)
        KEPT.write_text(json.dumps({**kept(), member: done}, indent=1) + "\n")
        print(member, done["seconds"], "s", done["rows"][-1], flush=True)

"""A piece of the paper's slab that is squeezed before it is cooled; run once, kept as one file.

    python -m verification.squeezed.run

runs the three members (ten minutes), draws the picture, and keeps what `make verify ONLY=squeezed`
looks at. Those that are in runs/verification/squeezed are taken as they are.
"""

import json
from pathlib import Path

import matplotlib.pyplot as plt

from staffa.io.run_directory import Run
from staffa.measure.generations import arrests
from staffa.plot.cracks import DAMAGE
from staffa.records.step import Step
from verification.common.figures import Check, Figure, Found
from verification.common.raster import raster
from verification.common.runs import ROOT, keep, origin, run_once

CASE = "verification/slabs/case.toml"
KEPT = Path(__file__).parent / "kept.json"
PICTURE = ROOT / "docs" / "pictures" / "verify-squeezed.png"
DROP = 54.0  # as in the case; E and expansion are 1, so that it is the thermal stress, too
SHARES = (0.0, 0.25, 0.5)
LOOKED_AT = (0.1, 0.2, 0.3)  # tau
DEPTHS = (0.1, 0.25)  # at which cracks are counted
WIDTH = 1.0


def settings(share: float) -> list[str]:
    """The setting of a member: the prestress; all else is common to them."""
    return [
        f"domain.size=[{WIDTH},1.0]",
        "damage.ell=0.04",
        "domain.h=0.0133",
        "damage.split=no-tension",
        "damage.residual_stiffness=1e-5",
        "supports.right=rollers",
        "time.tau={start=0.02,stop=0.3,steps=15}",
        f"output.at={list(LOOKED_AT)}",
        f"forces.prestress.xx={0 - DROP * share:g}",
    ]


def run_members() -> dict:
    """Run the members, or take those that are there; draw them, and keep their numbers."""
    runs = {s: run_once(CASE, f"squeezed/{s:g}", settings(s)) for s in SHARES}
    draw(runs)
    kept = {
        f"{s:g}": origin(run, CASE, settings(s))
        | {"states": states(run), "arrests": ends(run), "violations": violations(run)}
        for s, run in runs.items()
    }
    keep(KEPT, kept)
    return kept


def states(run: Run) -> list[dict]:
    """The cracks at each tau that is looked at; depths are those of sharp tips."""
    return [state(run, step) for step in run.steps if any(_at(step, tau) for tau in LOOKED_AT)]


def _at(step: Step, tau: float) -> bool:
    return step.tau is not None and abs(step.tau - tau) < 1e-9


def state(run: Run, step: Step) -> dict:
    """The cracks at one step."""
    m, measures = run.manifest, step.measures
    assert measures is not None
    depths = sorted(m.sharp(tip.depth) for tip in measures.tips)
    return {
        "tau": step.tau,
        "depths": [round(depth, 4) for depth in depths],
        "length": round(measures.length_surface, 4),
    }


def violations(run: Run) -> list[str]:
    """The findings of the audit, step by step."""
    return [f"tau = {step.tau:.2f}: {v}" for step in run.steps for v in step.audit.violations]


def ends(run: Run) -> list[tuple[int, float, float | None]]:
    """Arrests: how many cracks, their depth, tau."""
    m = run.manifest
    found = arrests(run.steps, axis=1, ell=m.ell, sharp=m.sharp)
    return [(g.cracks, round(g.depth, 4), g.tau) for g in found.generations]


def draw(runs: dict[float, Run]) -> None:
    """The damage of the members side by side, time downwards."""
    figure, axes = plt.subplots(
        len(LOOKED_AT), len(runs), figsize=(10, 7), layout="constrained", sharex=True, sharey=True
    )
    for column, (share, run) in zip(axes.T, runs.items(), strict=True):
        for panel, tau in zip(column, LOOKED_AT, strict=True):
            found = raster(run, next(step for step in run.steps if _at(step, tau)))
            panel.pcolormesh(
                found.x, found.y, found.alpha, cmap=DAMAGE, vmin=0, vmax=1, shading="gouraud"
            )
            panel.set_aspect("equal")
            panel.set(ylim=(0, 0.65))
            panel.set_title(f"s = {share:g}, tau = {tau:g}", fontsize=10)
    figure.savefig(PICTURE, dpi=130)
    plt.close(figure)


def squeezed() -> Found:
    """Cracks and depths under more and more compression, each beside that under less."""
    kept = json.loads(KEPT.read_text())
    figures = []
    for less, more in (("0", "0.25"), ("0.25", "0.5")):
        for k, tau in enumerate(LOOKED_AT):
            before, after = (kept[s]["states"][k] for s in (less, more))
            for what, a, b in (
                *((f"cracks deeper than {d:g}", deep(before, d), deep(after, d)) for d in DEPTHS),
                ("depth of the deepest", deepest(before), deepest(after)),
                ("length of all cracks", before["length"], after["length"]),
            ):
                if a == 0:
                    continue
                figures.append(
                    Figure(
                        what=f"{what} at tau = {tau:g}, s = {more}",
                        source=f"from none to as much as with s = {less}, {a:g}",
                        reference=a / 2,
                        measured=b,
                        tolerance=a / 2,
                    )
                )
    return Found(figures=figures, text=f"{table(kept)}\n\n![Cracks](pictures/{PICTURE.name})")


def deep(state: dict, least: float) -> int:
    """Number of cracks that are deeper than this."""
    return sum(depth > least for depth in state["depths"])


def deepest(state: dict) -> float:
    """Depth of the deepest crack, 0 without one."""
    return max(state["depths"], default=0.0)


def table(kept: dict) -> str:
    """One row a share and tau, then the commands."""
    lines = [
        "| s | tau | cracks | spacing | "
        + " | ".join(f"deeper than {d:g}" for d in DEPTHS)
        + " | median depth | deepest | length | arrests until then |",
        "|" + " --- |" * (8 + len(DEPTHS)),
    ]
    for s, k in kept.items():
        for found in k["states"]:
            depths, n = found["depths"], len(found["depths"])
            spacing = f"{WIDTH / n:.3f}" if n else "-"
            middle = f"{depths[n // 2]:.3f}" if n else "-"
            arrested = [
                f"{cracks} at {a:.3f}, tau {tau:.2f}"
                for cracks, a, tau in k["arrests"]
                if tau <= found["tau"]
            ]
            counts = " | ".join(str(deep(found, d)) for d in DEPTHS)
            lines.append(
                f"| {s} | {found['tau']:g} | {n} | {spacing} | {counts} | {middle} | "
                f"{deepest(found):.3f} | {found['length']:.2f} | {'; '.join(arrested) or '-'} |"
            )
    said = [f"`{k['command']}`, {k['date']}, commit {k['commit'][:7]}" for k in kept.values()]
    said += [f"Audit, s = {s}, {v}" for s, k in kept.items() for v in k["violations"]]
    return "\n".join(lines) + "\n\n" + "\n\n".join(said)


CHECKS = {
    "squeezed": Check(
        title="The paper's slab, squeezed",
        text=(
            "A part of the slab of 1 x 1, rollers left and right, ell = 0.04 = 3 h. Before it is "
            "cooled it is compressed along the face by s times the thermal stress of the face, E "
            "expansion dT. All three have the no-tension split, also s = 0, whose default would be "
            "none, so that they differ in s alone. This split is slow where many cracks are "
            "closed, so cracks keep 1e-5 of the stiffness. Depths are those of sharp tips; "
            "spacing: width over all cracks. Length: of all cracks, by energy, with the damaged "
            "layer under the face. We expected fewer and shorter cracks, and this holds at depth "
            "and early. Cracks that are shorter at a given tau have not yet come to where every "
            "other one arrests, so there are more shallow ones then. s = 0 and 0.25 were run by a "
            "version that ended displacements early between sweeps, which the audit noticed. A "
            "later version had the same energies, to six digits, up to tau = 0.1 of s = 0.25, and "
            "no remarks."
        ),
        measure=squeezed,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    print(json.dumps(run_members(), indent=1))

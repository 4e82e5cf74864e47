"""The paper's slab on several meshes, regularizations and rocks: run once, kept as small files.

    python verify/slabs.py NAME ...

runs members that are not kept yet, one after the other (minutes to hours each), like
"stretch-0.013-quadrilateral-1": section, ell, cells, seed. `make verify ONLY=slabs` runs all that
are missing. To run one again, delete its file in verify/slabs.
"""

import json
import shlex
import sys
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
from figures import Figure
from runs import ROOT, staffa
from sharp import SHARP, half_space_spacing, length_at

from staffa.io.run_directory import Run, read_run
from staffa.measure.generations import arrests, tracks
from staffa.measure.tip import reach
from staffa.report.published import BAHR, PAPER

KEPT = Path(__file__).parent / "slabs"
# What a crack costs on cells of ell/4, over Gc; `staffa run` measures it.
FACTOR = {"quadrilateral": 1.0956, "unstructured": 1.111}
LAST = {"stretch": (0.30, 30), "free": (0.32, 32)}
ELLS, SEEDS = (0.026, 0.018, 0.013), (1, 2, 3)
MEMBERS = (
    "free-0.013-quadrilateral-1",
    *(f"stretch-{e}-{c}-{s}" for e in ELLS for c in FACTOR for s in SEEDS),
)
# A segment of a crack's path this long, over ell, has a direction to five degrees.
SEGMENT = 3.0
COUNTED = (0.1, 0.2, 0.3)


@dataclass(frozen=True, kw_only=True)
class Growing:
    """The cracks that go on at a step: how many, their mean distance, their mean depth."""

    tau: float
    cracks: int
    spacing: float
    depth: float


def settings(name: str) -> list[str]:
    """What a member changes in verify/slab.toml."""
    section, ell, cells, seed = name.split("-")
    stop, steps = LAST[section]
    held = "rollers" if section == "free" else "free"
    return [
        f"damage.ell={ell}",
        f"domain.h={float(ell) / 4}",
        f"domain.cells={cells}",
        f"material.Gc={1 / FACTOR[cells]:.5f}",
        f"toughness.seed={seed}",
        f"supports.left={held}",
        f"supports.section={'none' if section == 'free' else section}",
        f"time.tau={{start=0.01,stop={stop},steps={steps}}}",
    ]


def run_member(name: str) -> dict:
    """Run a member, or take the one that is kept."""
    file = KEPT / f"{name}.json"
    if not file.exists():
        where = ROOT / "runs" / "verify" / "slabs" / name
        if not where.exists():
            staffa(ROOT / "verify" / "slab.toml", where, settings(name))
        KEPT.mkdir(exist_ok=True)
        file.write_text(json.dumps(digest(name, read_run(where)), indent=1) + "\n")
    return json.loads(file.read_text())


def digest(name: str, run: Run) -> dict:
    """What is kept of a run."""
    m, steps = run.manifest, run.steps
    beyond = reach(m.law, threshold=0.8, ell=m.ell, h=m.h)
    assert beyond is not None and run.finished
    found = arrests(steps, axis=1, ell=m.ell, reach=beyond)
    followed = tracks(steps, axis=1, reach=beyond)
    set_by = " ".join(f"--set {shlex.quote(s)}" for s in settings(name))
    ends = [(g.depth, g.tau) for g in found.generations]
    start = found.nucleation
    assert start is not None
    last = steps[-1].measures
    assert last is not None
    return {
        "command": f"staffa run verify/slab.toml {set_by}",
        "commit": m.commit,
        "date": m.created[:10],
        "unknowns": m.unknowns,
        "seconds": round(sum(step.seconds for step in steps)),
        "sweeps": sum(step.sweeps for step in steps),
        "toughness_factor": round(m.toughness_factor, 5),
        "ell": m.ell,
        "width": m.size[0],
        "p": start.spacing,
        "arrests": [[start.depth, start.tau], *map(list, ends)],
        "sections": [[s.height, s.cracks, s.spacing] for s in last.sections],
        "growing": [asdict(g) for g in growing(run, followed)],
        "angles": [round(a) for track in followed for a in angles(track.path, SEGMENT * m.ell)],
    }


def growing(run: Run, followed) -> list[Growing]:
    """Step by step the cracks that are deeper at the next one."""
    found = []
    for i, step in enumerate(run.steps[:-1]):
        on = [
            (track.path[i][0], track.depths[i])
            for track in followed
            if track.depths[i] is not None
            and track.depths[i + 1] is not None
            and track.depths[i + 1] > track.depths[i] + run.manifest.h / 2
        ]
        if len(on) > 2:
            x, depth = np.array(sorted(on)).T
            found.append(
                Growing(
                    tau=step.tau or 0.0,
                    cracks=len(on),
                    spacing=round(float(np.diff(x).mean()), 4),
                    depth=round(float(depth.mean()), 4),
                )
            )
    return found


def angles(path, length: float) -> list[float]:
    """Directions (degrees from the vertical) of the segments of a path, each so long at least."""
    points = [np.array(p) for p in path if p is not None]
    found, start = [], points[0]
    for point in points[1:]:
        step = point - start
        if np.hypot(*step) >= length:
            found.append(float(np.degrees(np.arctan2(step[0], step[1]))))
            start = point
    return found


def growth_and_spacing() -> list[Figure]:
    """Half a slab with free ends: lengths at the spacing that it has, spacings at each depth."""
    kept = run_member(MEMBERS[0])
    ell = kept["ell"]
    figures = []
    for g in kept["growing"]:
        if g["depth"] < 3 * ell:
            continue
        expected = length_at("free", g["spacing"], g["tau"])
        figures.append(
            Figure(
                what=f"mean length of the {g['cracks']} cracks that grow at tau = {g['tau']:.2f}",
                source=f"{SHARP}, spacing {g['spacing']:.3f}",
                reference=expected,
                measured=g["depth"],
                tolerance=max(ell, 0.03 * expected),
            )
        )
    for height, cracks, spacing in kept["sections"]:
        if height > 3 * ell and cracks > 2:
            p = half_space_spacing(height)
            figures.append(
                Figure(
                    what=f"spacing of the {cracks} cracks at depth {height:g}",
                    source=f"{SHARP}, half-space: p to 2 p, p = {p:.3f}",
                    reference=1.5 * p,
                    measured=spacing,
                    tolerance=0.5 * p,
                )
            )
    return figures


def means(ell: float, cells: str) -> dict[float, float]:
    """Mean number of cracks, over the seeds, that cross each depth at the end."""
    kept = [run_member(f"stretch-{ell}-{cells}-{seed}") for seed in SEEDS]
    table = {
        h: np.mean([dict((a, b) for a, b, _ in k["sections"])[h] for k in kept]) for h in COUNTED
    }
    return {h: float(n) for h, n in table.items()}


def convergence() -> list[Figure]:
    """Numbers of cracks on the two finest regularizations and on the two meshes; directions."""
    fine, coarse = means(0.013, "quadrilateral"), means(0.018, "quadrilateral")
    other = means(0.013, "unstructured")
    figures = []
    for what, table in (("ell = 0.018 against 0.013", coarse), ("unstructured cells", other)):
        for height, cracks in table.items():
            figures.append(
                Figure(
                    what=f"cracks that cross {height:g}, {what}",
                    source="ell = 0.013, squares, mean of 3 seeds",
                    reference=fine[height],
                    measured=cracks,
                    tolerance=max(1.0, 0.15 * fine[height]),
                )
            )
    return figures


def against_bahr() -> list[Figure]:
    """First and second arrest on `stretch`: nearer to Bahr's than the paper's own run was."""
    kept = run_member("stretch-0.013-quadrilateral-1")["arrests"]
    figures = []
    for what, k, part in (("a1", 1, 0), ("tau1", 1, 1), ("a2", 2, 0)):
        rows = [line.depths if part == 0 else line.taus for line in (BAHR, PAPER)]
        bahr, paper = (row[k] for row in rows)
        assert bahr is not None and paper is not None
        figures.append(
            Figure(
                what=f"{what}, section stretch, ell = 0.013",
                source=f"Bahr et al. 1988; the paper's own run has {paper:g}",
                reference=bahr,
                measured=kept[k][part] if len(kept) > k else float("nan"),
                tolerance=abs(paper - bahr),
            )
        )
    return figures


if __name__ == "__main__":
    for member in sys.argv[1:]:
        kept = run_member(member)
        print(member, kept["seconds"], "s", kept["sections"], flush=True)

"""Lengths of the slab's cracks against sharp cracks at the same places, stopped ones included.

    python -m verification.uneven.run [CELLS] [slab] [sharp]

runs the slab on a mesh that follows the cracks ("triangle", a quarter of an hour on one core) or on
a uniform one ("quadrilateral", more than an hour), or both, and keeps place and depth of each
crack at each step ("slab"). Then it grows sharp cracks at these places (five minutes each) and
keeps their lengths ("sharp"). A run in runs/verification is taken as it is. `make verify
ONLY=uneven` looks at what is kept, and grows an even array, for which there is a table. The lengths
on quadrilaterals stand under `slab-growth`.
"""

import json
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path
from time import perf_counter

import matplotlib.pyplot as plt
import numpy as np

from staffa.case.reading.read import read_case
from staffa.measure.generations import tracks
from staffa.setup.toughness_and_cracks import toughness_factor
from verification.common.figures import Check, Figure, Found
from verification.common.runs import ROOT, keep, origin, run_once
from verification.common.sharp import SHARP, array_growth, length_at
from verification.slabs.members import CASE, COUNTED, FACTOR, SEGMENT, WITHIN, settings
from verification.uneven.sharp_cracks import CrackedBlock, CrackPath, SlabBlock, grown

KEPT = Path(__file__).parent / "kept.json"
PICTURE = ROOT / "docs" / "pictures" / "verify-uneven.png"
# Where the runs are, in runs/verification; the second is also one of `slabs`.
MEMBERS = {
    "triangle": "uneven/free-0.013-triangle-1",
    "quadrilateral": "slabs/free-0.013-quadrilateral-1",
}
P = 0.1285  # spacing of the even array
H = 0.0065  # cells of the sharp cracks' body, ell/2: lengths are known to half of it
SHALLOW, DEEP = 0.2, 0.5  # how deep columns of double nodes go; the deeper ones from a third on
SHORTER = 2.0  # how much shorter than the run's, in ell, cracks begin that grow to G = Gc


def slab_settings(cells: str) -> list[str]:
    """Return the settings by which a run differs from verification/slabs/case.toml.

    Parameters
    ----------
    cells : a key of MEMBERS. The fields of the run on triangles are those that `openings` reads.
    """
    shown = f"output.at=[{','.join(f'{0.02 * k:.2f}' for k in range(1, 17))}]"
    return settings(Path(MEMBERS[cells]).name) + [shown] * (cells == "triangle")


def measured_cracks(cells: str) -> dict:
    """Return tau of the steps of a run, and for each crack the places and depths of its sharp tip.

    Parameters
    ----------
    cells : a key of MEMBERS.
    """
    run = run_once(CASE, MEMBERS[cells], slab_settings(cells))
    m = run.manifest
    followed = tracks(run.steps, axis=1, sharp=m.sharp)
    meshes = [step.mesh.vertices for step in run.steps if step.mesh]
    return origin(run, CASE, slab_settings(cells)) | {
        "unknowns": 3 * meshes[-1] if meshes else m.unknowns,
        "ell": m.ell,
        "h": m.h,
        "width": m.size[0],
        "toughness": round(m.toughness_factor / FACTOR[cells], 5),
        "tau": [round(step.tau or 0.0, 6) for step in run.steps],
        "x": [[_rounded(place and place[0]) for place in track.path] for track in followed],
        "depth": [[_rounded(depth) for depth in track.depths] for track in followed],
    }


def _rounded(value: float | None) -> float | None:
    return None if value is None else round(value, 5)


def running(slab: dict, step: int) -> np.ndarray:
    """Return the cracks that are deeper by more than h/2 at the next step."""
    now, then = depths(slab, step), depths(slab, step + 1)
    return np.flatnonzero(then > now + slab["h"] / 2)


def depths(slab: dict, step: int) -> np.ndarray:
    """Return the depths of the cracks at a step, shape (cracks,); nan if one was not seen."""
    return np.array([np.nan if d[step] is None else d[step] for d in slab["depth"]])


def compared_steps(slab: dict) -> list[int]:
    """Return the steps whose running cracks are 3 ell deep on average."""
    steps = range(len(slab["tau"]) - 1)
    cracks = [running(slab, step) for step in steps]
    return [
        step
        for step, on in zip(steps, cracks, strict=True)
        if len(on) > 2 and depths(slab, step)[on].mean() >= SEGMENT * slab["ell"]
    ]


def crack_paths(slab: dict) -> list[CrackPath]:
    """Return vertical paths of the cracks, each at the mean place of its tip.

    Parameters
    ----------
    slab : the kept numbers of the run.
    """
    final = np.array([deep[-1] for deep in slab["depth"]])
    return [
        CrackPath(
            x=float(np.mean([place for place in places if place is not None])),
            deepest=DEEP if last > final.max() / 3 else SHALLOW,
        )
        for places, last in zip(slab["x"], final, strict=True)
    ]


def sharp_lengths(cells: str, slab: dict) -> dict:
    """Return depths of sharp cracks at each compared step, by the two ways, and the time.

    "onward": all cracks begin as deep as the run's at the first of these steps. "given": at each
    step those of the run that rest are as deep as there, and the running ones begin SHORTER.

    Parameters
    ----------
    cells : a key of MEMBERS.
    slab : the kept numbers of its run.
    """
    began, paths = perf_counter(), crack_paths(slab)
    order = np.argsort([path.x for path in paths])
    body = CrackedBlock(SlabBlock(width=slab["width"]), [paths[k] for k in order], H)
    factor = toughness_factor(read_case(ROOT / CASE, slab_settings(cells)))

    def toughness(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.asarray(slab["toughness"] * factor(np.stack([x, y, 0 * x])))

    steps = compared_steps(slab)
    seen = [next(d for d in deep if d is not None) for deep in slab["depth"]]
    now = np.fmax(depths(slab, steps[0]), 0)
    onward = np.where(now > 0, now, seen)
    rows = []
    for step in steps:
        tau = slab["tau"][step]
        onward[order] = grown(body, tau, onward[order], toughness)
        start = np.where(np.isnan(depths(slab, step)), seen, depths(slab, step))
        start[running(slab, step)] -= SHORTER * slab["ell"]
        given = np.zeros(len(order))
        given[order] = grown(body, tau, np.maximum(start, 0)[order], toughness)
        rows.append({"onward": onward.round(4).tolist(), "given": given.round(4).tolist()})
    return {
        "date": datetime.now(UTC).date().isoformat(),
        "seconds": round(perf_counter() - began),
        "jumps": len(body.condensed),
        "rows": rows,
    }


@dataclass(frozen=True, kw_only=True)
class Lengths:
    """A run beside sharp cracks, as it is kept.

    Attributes
    ----------
    slab : what `measured_cracks` returns.
    sharp : what `sharp_lengths` returns.
    """

    slab: dict
    sharp: dict

    def __iter__(self) -> Iterator[tuple[int, np.ndarray, dict]]:
        """Yield the compared steps, the cracks that run there, and depths of sharp ones."""
        for step, row in zip(compared_steps(self.slab), self.sharp["rows"], strict=True):
            yield step, running(self.slab, step), row


def kept_lengths(cells: str) -> Lengths:
    """Return what is kept of a run.

    Parameters
    ----------
    cells : a key of MEMBERS.
    """
    return Lengths(**json.loads(KEPT.read_text())[cells])


def mean_lengths(lengths: Lengths, *, even_before: bool = False) -> list[Figure]:
    """Return mean depths of the running cracks beside sharp ones at their places.

    Parameters
    ----------
    lengths : the run beside sharp cracks.
    even_before : True if the reference before was an even array of the same spacing.
    """
    slab = lengths.slab
    figures = []
    for (step, on, row), even in zip(lengths, even_lengths(slab), strict=True):
        given = float(np.array(row["given"])[on].mean())
        figures.append(
            Figure(
                what=f"mean length of the {len(on)} cracks that grow at tau = "
                f"{slab['tau'][step]:.2f}",
                source=f"{SHARP}, cracks at the same places, the others as deep as in the run",
                reference=given,
                before=(even, "an even array of their spacing") if even_before else None,
                measured=float(depths(slab, step)[on].mean()),
                tolerance=max(slab["ell"], WITHIN * given),
            )
        )
    return figures


def each_length(lengths: Lengths) -> list[Figure]:
    """Return the depth of the running crack that differs most from a sharp one, at each step.

    Parameters
    ----------
    lengths : the run beside sharp cracks.
    """
    slab = lengths.slab
    figures = []
    for step, on, row in lengths:
        ell, tau = slab["ell"], f"tau = {slab['tau'][step]:.2f}"
        found, given = depths(slab, step)[on], np.array(row["given"])[on]
        figures.append(
            Figure(
                what=f"{tau}: difference of the one of these {len(on)} that differs most, over the "
                "larger of ell and 3 %",
                source="as above",
                reference=0.0,
                measured=float(np.max(np.abs(found - given) / np.maximum(ell, WITHIN * given))),
                tolerance=1.0,
            )
        )
    return figures


def crossing_figures(lengths: Lengths) -> list[Figure]:
    """Return how many cracks cross a depth at the last compared step, run and sharp ones onward.

    Parameters
    ----------
    lengths : the run beside sharp cracks.
    """
    slab, onward = lengths.slab, np.array(lengths.sharp["rows"][-1]["onward"])
    found = depths(slab, compared_steps(slab)[-1])
    return [
        Figure(
            what=f"cracks that cross {height:g} at the last of these times",
            source=f"{SHARP}, all of them grown since the first of these times",
            reference=float((onward > height).sum()),
            measured=float((found > height).sum()),
            tolerance=max(1.0, 0.15 * float((onward > height).sum())),
        )
        for height in COUNTED
    ]


def even_array() -> list[Figure]:
    """Return lengths of an even array from the same finite elements beside the table's."""
    paths = [CrackPath(x=(k + 0.5) * P, deepest=SHALLOW) for k in (0, 1)]
    body = CrackedBlock(SlabBlock(width=2 * P, right="rollers"), paths, H)
    tau, a = array_growth("fixed")
    lengths, figures = np.full(2, 0.05), []
    for at in (0.04, 0.06, 0.08, 0.10):
        lengths = grown(body, at, lengths)
        figures.append(
            Figure(
                what=f"length in an even array at tau = {at:.2f}, of the sharp cracks here",
                source="verification/common/data/array_growth.csv; lengths here are in steps of h",
                reference=float(np.interp(at, tau, a)),
                measured=float(lengths.mean()),
                tolerance=H,
            )
        )
    return figures


def uneven() -> Found:
    """Return the figures for straight cracks, and a table of the ways beside an even array."""
    lengths = kept_lengths("triangle")
    figures = [*even_array(), *mean_lengths(lengths), *each_length(lengths)]
    draw(lengths, PICTURE)
    text = f"{table(lengths)}\n\n![Lengths against tau](pictures/{PICTURE.name})"
    return Found(figures=[*figures, *crossing_figures(lengths)], text=text)


def even_lengths(slab: dict) -> list[float]:
    """Return the lengths in an even array of the running cracks' spacing, at the compared steps."""
    found = []
    for step in compared_steps(slab):
        places = np.sort([slab["x"][k][step] for k in running(slab, step)])
        spacing = float(np.diff(places).mean())
        found.append(length_at("free", spacing, slab["tau"][step]))
    return found


def table(lengths: Lengths) -> str:
    """Return where the run is from, and mean depths by each way, a row a step.

    Parameters
    ----------
    lengths : the run beside sharp cracks.
    """
    slab, sharp = lengths.slab, lengths.sharp
    lines = [
        f"`{slab['command']}`, {slab['date']}, commit {slab['commit'][:7]}, {slab['seconds']} s. "
        f"Sharp cracks: {sharp['jumps']} jumps at nodes, {sharp['seconds']} s, {sharp['date']}.",
        "",
        "Mean length of the cracks that grow, and by how much it differs from that of sharp ones. "
        "These stand in an even array of the same spacing; at the places of the run, the others as "
        "deep as in the run; or there, all of them sharp since the first of these times. In "
        "brackets: how many of the cracks are within the larger of ell and 3 %.",
        "",
        "| tau | cracks | length | even array | the others as in the run | all sharp |",
        "|" + " --- |" * 6,
    ]
    for (step, on, row), even in zip(lengths, even_lengths(slab), strict=True):
        found = depths(slab, step)[on]
        cells = []
        for way in ("given", "onward"):
            expected = np.array(row[way])[on]
            over = np.abs(found - expected) / np.maximum(slab["ell"], WITHIN * expected)
            share = f"{(over <= 1).sum()} of {len(on)}"
            cells.append(f"{found.mean() / expected.mean() - 1:+.1%} ({share})")
        lines.append(
            f"| {slab['tau'][step]:.2f} | {len(on)} | {found.mean():.4f} | "
            f"{found.mean() / even - 1:+.1%} | {' | '.join(cells)} |"
        )
    return "\n".join(lines)


def draw(lengths: Lengths, picture: Path) -> None:
    """Draw mean lengths beside all references, and each crack at the last compared step.

    Parameters
    ----------
    lengths : the run beside sharp cracks.
    picture : file to write.
    """
    slab = lengths.slab
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    tau = [slab["tau"][step] for step, _, _ in lengths]
    mean = [depths(slab, step)[on].mean() for step, on, _ in lengths]
    given, onward = (
        np.array([np.array(row[way])[on].mean() for _, on, row in lengths])
        for way in ("given", "onward")
    )
    allowed = np.maximum(slab["ell"], WITHIN * given)
    label = "the same, give or take the larger of ell and 3 %"
    left.fill_between(tau, given - allowed, given + allowed, color="C0", alpha=0.15, label=label)
    left.plot(tau, given, "C0-", label="sharp, at the same places, the others as in the run")
    left.plot(tau, onward, "C2-.", label="sharp, all of them since the first of these times")
    left.plot(tau, even_lengths(slab), "C3--", label="sharp, even array of the measured spacing")
    left.plot(tau, mean, "ko", markersize=4, label="staffa, cracks that grow")
    left.set(xlabel="tau", ylabel="length", xlim=(0, 0.33), ylim=(0, None))
    left.legend(frameon=False, fontsize=8)
    x = [[place for place in places if place is not None][-1] for places in slab["x"]]
    step, _, row = list(lengths)[-1]
    right.vlines(x, 0, depths(slab, step), color="k", linewidth=1.5, label="staffa")
    right.plot(x, row["given"], "C0_", markersize=12, label="sharp, the others as in the run")
    right.plot(x, row["onward"], "C2x", markersize=6, label="sharp, onward")
    right.set(xlabel="x", ylabel="depth", title=f"tau = {tau[-1]:.2f}", ylim=(0, None))
    right.set_ylim(0, 0.6)
    right.legend(frameon=False, fontsize=8, ncols=3, loc="upper center")
    figure.savefig(picture, dpi=120)
    plt.close(figure)


def main(names: list[str]) -> None:
    """Make what is named, for the named cells, and keep it; all of it by default."""
    parts = ("slab", "sharp")
    unknown = set(names) - {*MEMBERS, *parts}
    if unknown:
        sys.exit(f"unknown: {', '.join(unknown)}; there are {', '.join([*MEMBERS, *parts])}")
    for cells in [name for name in names if name in MEMBERS] or MEMBERS:
        for part in [name for name in names if name in parts] or parts:
            if part == "slab":
                found = measured_cracks(cells)
            else:
                found = sharp_lengths(cells, json.loads(KEPT.read_text())[cells]["slab"])
            kept = json.loads(KEPT.read_text()) if KEPT.exists() else {}
            kept.setdefault(cells, {})[part] = found
            keep(KEPT, kept)


CHECKS = {
    "uneven": Check(
        title="The paper's slab, free ends: sharp cracks at the same places",
        text=(
            "The same half of a slab as under `slab-growth`, seed 1, on a mesh that follows the "
            "cracks. Sharp cracks stand where those of the run stand, arrested ones included, in "
            "the same body and with the same random toughness. Each grows while its own G reaches "
            "its Gc, and none heals. They are straight: each stands at the mean place of its tip. "
            "At each time the cracks that rest are as deep as in the run, and those that grow "
            "begin 2 ell short of it. (Cracks that grow are deeper at the next step.) And by "
            "another way all go on by themselves from the first of these times. Which of two "
            "neighbors stops may then differ from the run, "
            "so numbers of cracks are compared; mean lengths were planned, until a trial on "
            "coarser cells had other winners. Tolerance: the larger of ell = 0.013 and 3 %; one "
            "crack or 15 %."
        ),
        measure=uneven,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    main(sys.argv[1:])

"""The paper's slab with random toughness, ten seeds for each variation; kept as one small file.

    python -m verification.grain.run

runs the ensembles (half an hour), and keeps what `make verify ONLY=grain` looks at. What is in
runs/verification/grain is taken as it is.
"""

import json
import subprocess
import sys
from pathlib import Path

import matplotlib.pyplot as plt

from staffa.io.ensemble_directory import read_ensemble
from staffa.io.run_directory import Run
from staffa.measure.averages import Average, average
from verification.common.figures import Check, Figure, Found
from verification.common.runs import ROOT, keep, origin, run_once

CASE = "verification/grain/case.toml"
KEPT = Path(__file__).parent / "kept.json"
PICTURE = ROOT / "docs" / "pictures" / "verify-grain.png"
VARIATIONS = ("0.1", "0.2", "0.3")
SEEDS = 10
# What is averaged, by its name in the file.
NUMBERS = {
    "spacing": "spacing of all cracks",
    "spacing at 0.05": "spacing at depth 0.05",
    "spacing at 0.1": "spacing at depth 0.1",
    "depth": "mean depth",
    "deepest": "depth of the deepest",
    "length": "length of all cracks",
}


def run_ensembles() -> dict:
    """Run the ensembles, or take those that are there, and keep the numbers of each member.

    Without variation every seed gives the same rock: one run is all.
    """
    uniform = ["toughness.amplitude=0"]
    run = run_once(CASE, "grain/0", uniform)
    kept = {"0": origin(run, CASE, uniform) | {"members": {"-": numbers(run)}}}
    for variation in VARIATIONS:
        where = ROOT / "runs" / "verification" / "grain" / variation
        given = ["--seeds", f"{SEEDS}", "--first", "1", "--set", f"toughness.amplitude={variation}"]
        if not (where / "ensemble.csv").exists():
            command = [f"{Path(sys.executable).parent}/staffa", "ensemble", f"{ROOT / CASE}"]
            subprocess.run([*command, *given, "--out", f"{where}", "--quiet"], check=True)
        found = read_ensemble(where)
        assert len(found.finished) == SEEDS
        kept[variation] = origin(found.first, CASE, []) | {
            "command": f"staffa ensemble {CASE} {' '.join(given)}",
            "members": {f"{seed}": numbers(run) for seed, run in found.finished.items()},
        }
    keep(KEPT, kept)
    return kept


def numbers(run: Run) -> dict:
    """The numbers of the last step; depths are those of sharp tips."""
    m, measures = run.manifest, run.steps[-1].measures
    assert measures is not None and not any(step.audit.violations for step in run.steps)
    depths = [m.sharp(tip.depth) for tip in measures.tips]
    width = m.size[0]
    at = {f"spacing at {s.height:g}": _spacing(width, s.cracks) for s in measures.sections}
    found = {
        "spacing": _spacing(width, len(depths)),
        **at,
        "depth": sum(depths) / len(depths) if depths else None,
        "deepest": max(depths, default=0.0),
        "length": measures.length_surface,
    }
    return {name: None if v is None else round(v, 5) for name, v in found.items()}


def _spacing(width: float, cracks: int) -> float | None:
    return width / cracks if cracks else None


def averages(kept: dict, name: str) -> dict[str, Average]:
    """Mean and standard error of a number, for each variation."""
    return {v: average([m.get(name) for m in k["members"].values()]) for v, k in kept.items()}


def grain() -> Found:
    """Errors of spacing and depth from ten seeds, and results that no variation changes."""
    kept = json.loads(KEPT.read_text())
    figures = []
    for name in ("spacing", "depth"):
        for variation in VARIATIONS:
            a = averages(kept, name)[variation]
            assert a.mean is not None and a.error is not None
            figures.append(
                Figure(
                    what=f"{NUMBERS[name]}, variation {variation}: standard error over the mean",
                    source=f"ten seeds are enough; the mean is {change(kept, name, variation)}",
                    reference=0.0,
                    measured=a.error / a.mean,
                    tolerance=0.1,
                )
            )
    uniform = averages(kept, "length")["0"].mean
    assert uniform is not None
    for variation in VARIATIONS:
        mean = averages(kept, "length")[variation].mean
        assert mean is not None
        figures.append(
            Figure(
                what=f"{NUMBERS['length']}, variation {variation}",
                source="uniform rock: the mean toughness is the same",
                reference=uniform,
                measured=mean,
                tolerance=0.05,
                relative=True,
            )
        )
    draw(kept)
    return Found(
        figures=figures,
        text=f"{table(kept)}\n\n![Spacing and depth](pictures/{PICTURE.name})",
    )


def change(kept: dict, name: str, variation: str) -> str:
    """A mean beside that of uniform rock, in words."""
    found = averages(kept, name)
    one, other = found["0"].mean, found[variation].mean
    assert one is not None and other is not None
    return f"{100 * (other / one - 1):+.0f} % beside uniform rock"


def table(kept: dict) -> str:
    """A row for each variation, means and standard errors, then the commands."""
    lines = [
        "| variation | seeds | " + " | ".join(NUMBERS.values()) + " |",
        "|" + " --- |" * (2 + len(NUMBERS)),
    ]
    for variation, k in kept.items():
        cells = [said(averages(kept, name)[variation]) for name in NUMBERS]
        lines.append(f"| {variation} | {len(k['members'])} | {' | '.join(cells)} |")
    told = [f"`{k['command']}`, {k['date']}, commit {k['commit'][:7]}" for k in kept.values()]
    return "\n".join(lines) + "\n\n" + "\n\n".join(told)


def said(a: Average) -> str:
    """A mean with its error."""
    if a.mean is None:
        return "-"
    return f"{a.mean:.4f}" + ("" if a.error is None else f" +- {a.error:.4f}")


def draw(kept: dict) -> None:
    """Spacing and depth against variation, with standard errors."""
    figure, panels = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
    for panel, names in zip(
        panels, (("spacing", "spacing at 0.05", "spacing at 0.1"), ("depth", "deepest")),
        strict=True,
    ):  # fmt: skip
        for number, name in enumerate(names):
            found = averages(kept, name)
            x = [float(v) + 0.002 * number for v in found]
            means = [a.mean for a in found.values()]
            errors = [a.error or 0.0 for a in found.values()]
            panel.errorbar(x, means, yerr=errors, fmt="o-", capsize=3, label=NUMBERS[name])
        panel.set(xlabel="coefficient of variation of the toughness", ylim=(0, None))
        panel.legend(frameon=False, fontsize=9)
    panels[0].set_ylabel("spacing")
    panels[1].set_ylabel("depth")
    figure.savefig(PICTURE, dpi=120)
    plt.close(figure)


CHECKS = {
    "grain": Check(
        title="The paper's slab, random toughness",
        text=(
            "A part of the slab of 1.5 x 0.5 with free ends, ell = 0.04 = 3 h, at tau = 0.4 of its "
            "depth (0.2 of the paper's). The toughness is lognormal with correlation length 2 ell: "
            "ten seeds for each coefficient of variation, with standard errors of the mean. "
            "Without variation every seed gives the same rock, whose cracks start from the ends. "
            "The more the toughness varies, the farther apart and the deeper the cracks are. "
            "Depths of sharp tips. `test_rock.py` tests that one seed gives one rock on 1, 2 and 3 "
            "ranks."
        ),
        measure=grain,
        kept="kept.json",
    ),
}


if __name__ == "__main__":
    print(json.dumps(run_ensembles(), indent=1))

"""The cohesive law: strength, softening and cost of bars, cracks that run, and granite."""

from collections.abc import Iterable, Sequence
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import matplotlib.pyplot as plt
import numpy as np

from staffa import parse_case
from staffa.errors import InputError
from staffa.io.run_directory import Run
from staffa.physics.damage import cohesive
from verification.common.figures import Check, Figure, Found
from verification.common.runs import ROOT, fresh_run, ready_case
from verification.common.sharp import DOUBLING, SHARP, array_growth

HERE = Path(__file__).parent
PICTURE = ROOT / "docs" / "pictures" / "verify-cohesive.png"


def bars() -> Found:
    """Strength, softening and dissipated energy of pulled bars, and a picture of the softening."""
    from fem.test_cohesive import ELLS, STRENGTH, E, pull

    strains = STRENGTH / E * np.arange(0.98, 1.01, 0.0025)
    figures = [
        Figure(
            what=f"largest stress over the strength, ell = L/{1 / ell:.0f}, {softening}",
            source="the strength that was asked for",
            reference=1.0,
            measured=float(pull(ell, ell / 5, strains, softening).stress.max()),
            tolerance=0.01,
        )
        for softening in ("linear", "cornelissen")
        for ell in ELLS
    ]
    figures += [*softening_curves(), *costs()]
    return Found(figures=figures, text=f"![Stress against opening](pictures/{PICTURE.name})")


def softening_curves() -> list[Figure]:
    """The largest distance of stress against opening from the given curves; draws both."""
    from fem.test_cohesive import E, cornelissen, linear, pull

    bears, figures = 6.0, []  # so weak that the bar is shorter than one that snaps
    strains = bears / E * np.array([1.02, 1.4, 2.0, 3.0, 4.0, 5.0, 6.0, 9.0, 12.0])
    drawing, axes = plt.subplots(figsize=(6, 4))
    openings = np.linspace(0.02, 5.5, 200)
    for softening, curve, color in (("linear", linear, "C0"), ("cornelissen", cornelissen, "C1")):
        found = pull(0.1, 0.1 / 40, strains, softening, bears)
        figures.append(
            Figure(
                what=f"largest distance from the softening curve over the strength, {softening}",
                source="the curve of the law",
                reference=0.0,
                measured=float(np.abs(found.stress - curve(found.opening)).max()),
                tolerance=0.02,
            )
        )
        axes.plot(openings, curve(openings), color=color, label=f"{softening}, as given")
        axes.plot(found.opening, found.stress, "o", color=color, label=f"{softening}, a bar")
    axes.set_xlabel("opening times strength over Gc")
    axes.set_ylabel("stress over strength")
    axes.legend(frameon=False)
    drawing.savefig(PICTURE, dpi=120, bbox_inches="tight")
    return figures


# Names of the loadings of `tests/fem/test_strength_surface.py` on the page.
STRESSES = {"pulled": "one tension", "biaxial": "two equal tensions", "pressed": "one pressure"}


def strengths() -> list[Figure]:
    """The strengths of squares under three stresses over those that were asked for."""
    from fem.test_strength_surface import ELLS, FACTORS, LOADINGS, largest_stress, loaded

    return [
        Figure(
            what=f"largest stress over the strength, {STRESSES[name]}, ell = L/{1 / ell:.0f}",
            source="the strength that was asked for",
            reference=1.0,
            measured=largest_stress(loaded(name, ell, FACTORS), name),
            tolerance=0.02,
        )
        for name in LOADINGS
        for ell in ELLS
    ]


def costs() -> list[Figure]:
    """The energy of a broken bar over the effective Gc of its cells."""
    from fem.test_cohesive import ELLS, IRWIN, STRENGTH, E, pull
    from staffa.evolution.effective_toughness import effective_gc
    from support.bodies import rock

    figures = []
    strains = STRENGTH / E * np.array([0.9, 1.2, 1.5, 2.0, 4.0, 8.0])
    for ell in ELLS[:2]:
        material = rock(E=E, ell=ell, law=cohesive(irwin=IRWIN, ell=ell))
        effective = effective_gc(material, dim=2, h=ell / 5, cells="quadrilateral")
        spent = float(pull(ell, ell / 5, strains, "linear").surface[-1])
        name = f"ell = L/{1 / ell:.0f} = 5 h"
        for what, source, measured in (
            (f"dissipated energy over effective Gc, {name}", "one crack across", spent / effective),
            (f"effective Gc over 1 + h/(4 c_w ell), {name}", "one layer of broken cells",
             effective / (1 + 1 / (5 * np.pi))),
        ):  # fmt: skip
            figures.append(
                Figure(what=what, source=source, reference=1.0, measured=measured, tolerance=0.01)
            )
    return figures


# Irwin's length over ell of a crack that runs, softening, and cells that it runs.
RIDES = ((4 / 3, "linear", 16), (2.5, "linear", 20))


def tips() -> Found:
    """Cost and speed of a crack that follows the field of a tip, and the table of its sharp tip."""
    from fem.test_surfing import ride
    from staffa.measure.tip import THRESHOLDS, tip_distances

    figures, theory = [], "mode I field of a sharp crack"
    lines = [
        f"| distance of the sharp tip over ell, beyond alpha = | {row(THRESHOLDS, ':g')} |",
        "| --- |" + " --- |" * len(THRESHOLDS),
    ]
    for irwin, softening, length in RIDES:
        law = cohesive(irwin=irwin, ell=1.0, softening=softening)
        found = ride(law, cells_per_ell=4, radius=8, cells=length)
        on = f"{softening}, l_ch = {irwin:.3g} ell, h = ell/4"
        for what, measured in (
            (
                f"energy of a new unit of crack over effective Gc, {on}",
                found.toughness / found.factor,
            ),
            (f"speed over that of the tip, {on}", float(found.speed[3])),
        ):
            figures.append(
                Figure(what=what, source=theory, reference=1.0, measured=measured, tolerance=0.03)
            )
        lines.append(f"| {on} | {row(found.beyond, ':.3f')} |")
        in_use = tip_distances(law, h=1 / 4)
        assert in_use is not None
        lines.append(f"| in use | {row(in_use, ':.3f')} |")
    return Found(figures=figures, text="\n".join(lines))


def row(values: Iterable[float], shape: str) -> str:
    """Numbers as cells of a table."""
    return " | ".join(f"{{{shape}}}".format(value) for value in values)


# With this strength, 4 % above that of AT1, Irwin's length is 2.5 ell, for which the
# sharp tip is known. Gc times the effective Gc of these cells is 1.
SAME = ("damage.law=cohesive", "damage.strength=5.35", "material.Gc=0.9287")


def lengths() -> list[Figure]:
    """Length of an array's cracks with both laws, of the same ell and strength, step by step."""
    runs = {
        "AT1": ready_case("array", "cohesive-array-AT1"),
        "cohesive": ready_case("array", "cohesive-array", *SAME),
    }
    found = {law: depths(run) for law, run in runs.items()}
    tau, a = array_growth("fixed")
    figures = []
    for at, length in found["cohesive"].items():
        if not 0.06 - 1e-9 <= at <= DOUBLING["fixed"][0]:
            continue
        sharp = float(np.interp(at, tau, a))
        figures += [
            Figure(
                what=f"length at tau = {at:.3f}{over}",
                source=source,
                reference=reference,
                measured=length,
                tolerance=runs["AT1"].manifest.ell,
            )
            for over, source, reference in (
                (", beside AT1", "AT1 of the same ell", found["AT1"][at]),
                (", beside sharp cracks", SHARP, sharp),
            )
        ]
    return figures


def depths(run: Run) -> dict[float, float]:
    """Length of the sharp crack by tau."""
    assert run.manifest.tip_reach is not None
    return {
        step.tau: step.measures.front + run.manifest.tip_reach
        for step in run.steps
        if step.tau is not None and step.measures is not None
    }


LENGTH, WIDTH, STRENGTH_GRANITE, GC_GRANITE = 2.0, 0.3, 10e6, 100.0


def pulled_plate(name: str, *settings: str) -> tuple[Run, float, float]:
    """A plate of granite pulled in two; its largest stress, and energy over the effective Gc."""
    run = fresh_run(HERE / "case.toml", name, *settings)
    strains = [step.time * 1e-3 / LENGTH for step in run.steps]
    stress = [
        2 * step.energies.elastic / strain / (LENGTH * WIDTH)
        for step, strain in zip(run.steps, strains, strict=True)
    ]
    spent = run.steps[-1].energies.surface / (GC_GRANITE * WIDTH) / run.manifest.toughness_factor
    return run, max(stress) / STRENGTH_GRANITE, spent


def granite() -> Found:
    """Strength and cost of a plate of granite, and the refusal of cells of 0.1 m."""
    run, strength, spent = pulled_plate("cohesive-granite")
    _, high, all_over = pulled_plate("cohesive-granite-30", *LARGEST)
    reasons = {said: refused(*asked) for said, asked in COARSE.items()}
    asked, m = "the strength that was asked for", run.manifest
    figures = [
        Figure(what=what, source=source, reference=reference, measured=measured, tolerance=within)
        for what, source, reference, measured, within in (
            ("largest stress of 2 m over 10 MPa, ell = 20 mm", asked, 1.0, strength, 0.01),
            ("dissipated energy over effective Gc, ell = 20 mm", "one crack", 1.0, spent, 0.03),
            ("largest stress of 2 m over 10 MPa, ell = 30 mm", asked, 1.0, high, 0.01),
            ("dissipated energy over effective Gc, ell = 30 mm", "one crack", 1.0, all_over, 0.03),
            ("of two ways to ask for cells of 0.1 m, those refused", "both", 2.0,
             float(sum(reason != "" for reason in reasons.values())), 0.0),
        )
    ]  # fmt: skip
    text = [f"h = 0.1 m, {said} is refused: {reason}" for said, reason in reasons.items()]
    text.append(f"The mesh with ell = 20 mm = 3.2 h begins with {m.cells} cells.")
    return Found(figures=figures, text="\n\n".join(text))


LARGEST = ('domain.h="9.375 mm"', 'damage.ell="30 mm"')
# Cells of 0.1 m, and the words that must stand in the reason of the refusal.
COARSE = {
    "ell = 30 mm": (('damage.ell="30 mm"',), "is less than domain.h"),
    "ell = 300 mm": (('damage.ell="300 mm"',), "Irwin's length"),
}


def refused(settings: Sequence[str], words: str) -> str:
    """The sentence by which cells of 0.1 m are refused; empty if these words are not in it."""
    coarse = ('domain.h="100 mm"', "domain.refine=false", *settings)
    try:
        parse_case((HERE / "case.toml").read_text(), coarse)
    except InputError as error:
        return f"`{error}`" if words in str(error) else ""
    return ""


CHECKS = {
    "cohesive-bar": Check(
        title="A strength that does not depend on ell",
        text=(
            "Bars of length 1 with `damage.law = \"cohesive\"` (`tests/fem/test_cohesive.py`): "
            "largest stress at three ell, stress against opening with ell = 40 h, and the energy "
            "of the broken bar. Irwin's length is 0.69 of the bar, and 2.8 of it for the curves. "
            "Tolerances were asked for before the law was built."
        ),
        measure=bars,
    ),
    "cohesive-strengths": Check(
        title="Strengths under other stresses",
        text=(
            "Squares in plane stress with a cohesive law (`tests/fem/test_strength_surface.py`), "
            "`damage.biaxial` 0.95 and `damage.compressive` 8 times the strength. Loads grow in "
            "steps of 1 %, and sides do not rub. Plane strain, 3-D and a cooled face stand in "
            "the tests. Tolerance: 2 %, asked for before this was built."
        ),
        measure=strengths,
    ),
    "cohesive-tip": Check(
        title="A cohesive crack that follows a tip",
        text=(
            "As [the cracks of AT1 and AT2](#a-crack-that-follows-a-tip), by Irwin's length over "
            "ell. The part of a crack that still bears stress lies ahead of the one that is open."
        ),
        measure=tips,
    ),
    "cohesive-array": Check(
        title="An even array with a cohesive law",
        text=(
            "The case `array` with AT1, and with a cohesive law of the same ell and a strength 4 % "
            "above. Lengths are those of sharp tips. Tolerance: ell = 0.013."
        ),
        measure=lengths,
    ),
    "cohesive-granite": Check(
        title="Granite with its strength and its toughness",
        text=(
            "`verification/cohesive/case.toml`: K_Ic = 2 MPa m^1/2, 10 MPa, l_ch = 40 mm, a mesh "
            "that is fine at the crack. A strip of 40 mm is weaker by 1 % in Gc. Tolerance of the "
            "energy: 1 % for that strip, 2 % for triangles that are split. The plate has its "
            "strength with both ell. With 30 mm, 0.75 of Irwin's length, it breaks all over: at "
            "the strength each part of it stores more than broken rock costs, l_ch < pi ell/2. "
            "With the displacement held, damage then spreads from the weak strip through the "
            "plate. Alternate minimization holds the displacement, so it needs ell < 2 l_ch/pi."
        ),
        measure=granite,
    ),
}  # fmt: skip

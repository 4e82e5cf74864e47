"""Captions of the pictures of a run, in words that are true for the current case."""

from collections.abc import Callable, Sequence

from staffa.plot.labels import since_rest
from staffa.records.manifest import Manifest
from staffa.records.step import Step

Steps = Sequence[Step]


def caption(name: str, manifest: Manifest, steps: Steps) -> str:
    """The caption of a picture, by its name, of a run or of the members of an ensemble."""
    found = CAPTIONS.get(name) or CAPTIONS.get(name.split("-", 1)[0], name)
    return found if isinstance(found, str) else found(manifest, steps)


def _cracks(manifest: Manifest, steps: Steps) -> str:
    if not manifest.flat:
        return (
            "The cracks at the last time whose fields are kept: in the rock, its near quarter "
            "cut away, and alone."
        )
    text = "The damage, dark where the rock is cracked, at times whose fields are kept."
    if manifest.profile == "none":
        return text
    lines = f"{text} Colored lines: isotherms"
    if manifest.scaled:
        return f"{lines}, T the change of temperature, ΔT its largest."
    if manifest.reference is None:
        return f"{lines}, T₀ the temperature that the change is counted from."
    return f"{lines}."


def _sections(manifest: Manifest, steps: Steps) -> str:
    return (
        f"Planes below the {manifest.surface}: what is broken is dark, and each cell that cracks "
        f"cut out has the color of the number of its neighbors."
    )


def _mesh(manifest: Manifest, steps: Steps) -> str:
    what = "The cells" if manifest.flat else "The cells in a section"
    text = f"{what} at the last time whose fields are kept, over the damage: fine where cracks are."
    return f"{text} Below: their number at each step." if len(steps) > 1 else text


def _energies(manifest: Manifest, steps: Steps) -> str:
    text = "Energies of each step" + (", per unit thickness." if manifest.plane else ".")
    if not since_rest(steps):
        return text
    which, are = "The elastic energy", "is the change"
    if any(step.energies.loads for step in steps):
        which, are = "The elastic energy and that of the loads", "are changes"
    return (
        f"{text} {which} {are} since the state of rest under the forces, before the first step; "
        f"the surface energy is that of all cracks."
    )


def _reactions(manifest: Manifest, steps: Steps) -> str:
    per = ", per unit thickness" if manifest.plane else ""
    return f"Reactions: the force of each constrained boundary on the body{per}."


def _heat(manifest: Manifest, steps: Steps) -> str:
    per = ", per unit thickness" if manifest.plane else ""
    return f"Heat stored since the start{per}, and from where it came (or, negative, went)."


def _lengths(manifest: Manifest, steps: Steps) -> str:
    parts = ["Length of the cracks" if manifest.plane else "Area of the cracks"]
    if manifest.cooled_side:
        parts.append(f"depth of each tip below the {manifest.surface}")
    if any(step.measures and step.measures.sections for step in steps):
        parts.append("how many cross each depth")
    return " and ".join([", ".join(parts[:-1]), parts[-1]] if len(parts) > 1 else parts) + "."


def _spacing(manifest: Manifest, steps: Steps) -> str:
    theory = manifest.scales.get("ell0")
    lines = " Black lines: the spacings between which parallel cracks double, by theory."
    return (
        "How far apart the cracks are, and how large the cells, at each depth: means and "
        "standard errors of the cells of one plane." + (lines if theory else "")
    )


def _growing(manifest: Manifest, steps: Steps) -> str:
    return "The cracks growing." if manifest.flat else "The cracks growing, in the rock and alone."


def _network(manifest: Manifest, steps: Steps) -> str:
    when = "" if manifest.flat else " at the last time whose fields are kept"
    return f"The crack network{when}, and how far it is open; gray where that is not known."


def _production(manifest: Manifest, steps: Steps) -> str:
    text = (
        "Temperature of the produced water, power above that of the injected water, as the mean of "
        "each step, and pressure in each well. Dotted marks: the times at which the drawdown "
        "passes 1 % and 10 %."
    )
    if _has_shadow(steps):
        text += f" {DASHES}"
    if manifest.reservoir is None or manifest.reservoir.flow is None:
        return text
    spacing = manifest.reservoir.flow.half_spacing
    which = "a fracture" if spacing is None else "parallel fractures"
    return f"{text} Dotted line: {which} in rock without cracks, in closed form."


def _exchange(manifest: Manifest, steps: Steps) -> str:
    text = (
        "Injectivity, the rate of the injectors over their pressure above that of the rock, and "
        "exchange area, one wall of a single fracture that would cool the water so; it is empty "
        "before a drawdown of 1 %."
    )
    if any(step.heat and step.heat.circulation and step.heat.circulation.cracks for step in steps):
        text += " Below: area and volume of the cracks that water flows in."
    return f"{text} {DASHES}" if _has_shadow(steps) else text


def _production_of_all(manifest: Manifest, steps: Steps) -> str:
    text = f"Production temperature, power (the mean of a step) and energy: {BAND}."
    if not _has_shadow(steps):
        return text
    return f"{text} {DASHES} Below: with cracks less without."


def _has_shadow(steps: Steps) -> bool:
    return any(step.heat and step.heat.shadow for step in steps)


def _reservoir(manifest: Manifest, steps: Steps) -> str:
    what = (
        "The temperature of the reservoir's cells"
        if manifest.flat
        else ("The temperature of the reservoir's cells in a section through the wells")
    )
    over = "with the cracks over it"
    if manifest.reservoir and manifest.reservoir.cracks:
        over += ", in the color of their opening: dark ones carry water"
    return f"{what}, {over}. Rings: wells."


DASHES = "Dashed: the same water in rock whose cracks do not change its flow."
BAND = (
    "the mean of the finished members, its standard error as a band, and each member as a thin line"
)
CAPTIONS: dict[str, str | Callable[[Manifest, Steps], str]] = {
    "cracks": _cracks,
    "sections": _sections,
    "mesh": _mesh,
    "spacing": _spacing,
    "growing": _growing,
    "network": _network,
    "energies": _energies,
    "reactions": _reactions,
    "heat": _heat,
    "lengths": _lengths,
    "production": _production,
    "exchange": _exchange,
    "reservoir": _reservoir,
    "quantities": "Quantities that the script of this run has computed at each step.",
    "counts": f"How many cracks cross each depth: {BAND}.",
    "growth": f"Growth of the cracks: {BAND}.",
    "energies-of-both": "Energies of both runs, joined from step to step, and how far apart the "
    "total energies are, over the larger of them, parts below zero counted by size.",
    "growth-of-both": "Growth of the cracks of both runs.",
    "production-of-all": _production_of_all,
    "production-of-both": "Temperature of the produced water, power (the mean of a step) and "
    "highest pressure in a well of both runs.",
    "response": "Results over a parameter: mean of the finished runs of each point, with its "
    "standard error; each run is a small dot.",
    "study-production": "Temperature of the produced water, power (the mean of a step) and energy "
    "of each point: means of its finished runs, their standard errors as bands.",
    "cracks-of-both": "The cracks of both runs at times whose fields both kept.",
}

"""Warnings about cells that are too long for the cracks, in the whole body or in a part of it."""

from collections.abc import Iterator

from staffa.case.scales.surface_cooling import surface_exchanges
from staffa.case.schema.case import Case, Named
from staffa.case.schema.quantity_text import amount, at_least, at_most
from staffa.case.values.damage_law import damage_law
from staffa.geometry.block import broken_layer_thickness
from staffa.physics.damage import effective_gc_factor

RESOLVED = 3.0  # cells in ell that resolve a crack
POOR = 2.0  # cells in ell below which its toughness is so far off that it is a warning
SLACK = 1 + 1e-9  # "0.03 mm" and "30 um" differ in the last digit
# By so much are the edges at a face, in nine tenths of it, longer than the mean of an even mesh.
SCATTER = 1.2


def long_edges(case: Case, h: float) -> Iterator[tuple[bool, str]]:
    """Yield a sentence for edges longer than ell/3, with True if they are longer than ell/2.

    Parameters
    ----------
    case : the case.
    h : edge of the cells where cracks run (m), as the case or its mesh gives it.
    """
    ell = float(case.damage.ell)
    finer = f"h <= ell/3 = {at_most(case, ell / RESOLVED, 'm')}"
    larger = f"damage.ell >= {at_least(case, RESOLVED * h, 'm')}"
    if ell / h < 1 / SLACK:
        yield (
            True,
            f"ell/h = {ell / h:.2g}: the mesh steers the cracks and adds to the toughness "
            f"({_tougher(case, h)}; damage.allow_coarse is set); take {finer}, or {larger}, to be "
            f"free of it",
        )
    elif ell / h < RESOLVED / SLACK:
        much = ell / h < POOR / SLACK
        how = "is not resolved" if much else "is barely resolved"
        yield (
            much,
            f"ell/h = {ell / h:.3g} < 3: a crack {how}: {_tougher(case, h)}; take {finer}, or "
            f"{larger}",
        )
    for where, how, edge in _parts(case):
        if edge > ell / RESOLVED * SLACK and edge > SCATTER * h:
            yield (
                edge > ell / POOR * SLACK,
                f"{where}: the mesh's edges there are {how} {amount(case, edge, 'm')} long, "
                f"{edge / ell:.2g} ell: {_tougher(case, edge)}; mesh it there with {finer}",
            )


def _tougher(case: Case, h: float) -> str:
    """Return in words the change of the toughness by cells of an edge h (m)."""
    layer = h * broken_layer_thickness(case.dim, str(case.domain.cells))
    law = damage_law(case)
    more = effective_gc_factor(law, h=layer, ell=float(case.damage.ell)) - 1
    return f"cracks run as if Gc were about {100 * more:.2g} % larger"


def _parts(case: Case) -> Iterator[tuple[str, str, float]]:
    """Return the parts of a mesh with their edges (m): cooled faces, initial cracks and regions.

    None of a mesh that follows the cracks: its cells are h long wherever cracks run.
    """
    edges = case.outline.edges
    if edges is None or case.domain.halvings:
        return
    for face in _cooled(case):
        yield f"face '{face}', which is cooled", "up to", edges.faces[face]
    for crack in case.cracks:
        if isinstance(crack, Named):
            yield f"crack '{crack.name}'", "up to", edges.cracks[crack.name]
    for region, edge in edges.regions.items():
        yield f"region '{region}'", "at least", edge


def _cooled(case: Case) -> list[str]:
    """Return the faces that get colder."""
    faces = case.outline.faces
    if case.heat is not None:
        return [e.where for e in surface_exchanges(case) if e.drop > 0 and e.where in faces]
    return [case.temperature.face] if case.temperature.cools_a_face else []

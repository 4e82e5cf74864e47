"""Notes on the face from which cracks are measured."""

from collections.abc import Iterator

from staffa.case.scales.surface_cooling import surface_exchanges
from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import inline


def face_notes(case: Case) -> Iterator[str]:
    """Tell that cracks are counted from one face, if others are cooled."""
    face = case.temperature.face
    if case.heat is None:
        return
    others = [e.where for e in surface_exchanges(case) if e.drop > 0 and e.where != face]
    if others := [where for where in others if where in case.outline.faces]:
        yield (
            f"{', '.join(others)}: cooled besides temperature.face = {inline(face)}, from which "
            f"tips and depths are measured; a crack that starts elsewhere counts with its end that "
            f"is farthest from {face}, so look at the network and the pictures for those"
        )

"""Notes on the face from which cracks are measured."""

from collections.abc import Iterator

from staffa.case.scales.surface_cooling import cooled_besides, face_cools
from staffa.case.schema.case import Case
from staffa.case.schema.toml_text import inline


def face_notes(case: Case) -> Iterator[str]:
    """Tell that cracks of other cooled faces are counted apart."""
    if others := cooled_besides(case):
        face = inline(case.temperature.face)
        cooled = "cooled besides" if face_cools(case) else "cooled, unlike"
        yield (
            f"{', '.join(others)}: {cooled} temperature.face = {face}, from which tips and "
            f"depths are measured; a crack that starts elsewhere is in no table of that "
            f"face, and `staffa show` tells how many there are and how deep"
        )

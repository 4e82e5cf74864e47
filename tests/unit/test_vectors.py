"""The one view of PETSc's vectors."""

from pathlib import Path

from staffa.backend.stack import PETSc

import numpy as np
import pytest

import staffa
from staffa.backend.vectors import readable, writable

SOURCE = Path(str(staffa.__file__)).parent


def test_petsc_sees_what_is_written_and_a_reader_cannot_write() -> None:
    """Norms are kept by PETSc until it learns of a change."""
    vector = PETSc.Vec().createSeq(3)
    vector.set(1.0)
    assert vector.norm() == pytest.approx(np.sqrt(3))
    writable(vector)[1:] = 0.0
    assert vector.norm() == 1.0 and readable(vector).tolist() == [1.0, 0.0, 0.0]
    with pytest.raises(ValueError, match="read-only"):
        readable(vector)[0] = 2.0
    vector.destroy()


def test_nothing_else_opens_a_vector() -> None:
    files = [path for path in SOURCE.rglob("*.py") if path.name != "vectors.py"]
    opening = [p.name for p in files if "array_r" in p.read_text() or "array_w" in p.read_text()]
    assert files and not opening

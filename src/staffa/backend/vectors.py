"""The entries of PETSc's vectors that a rank owns, as NumPy arrays."""

from staffa.backend.stack import PETSc

import numpy as np


def readable(vector: PETSc.Vec) -> np.ndarray:
    """Return the owned entries as a read-only view, shape (n_owned,).

    Parameters
    ----------
    vector : one that PETSc may use meanwhile; the view shows what it writes.
    """
    view: np.ndarray = vector.array_r
    return view


def writable(vector: PETSc.Vec) -> np.ndarray:
    """Return the owned entries as a view to write to, shape (n_owned,).

    PETSc learns that the vector has changed, so that norms that it keeps are found again.

    Parameters
    ----------
    vector : the one to change. Write at once, and do not keep the view.
    """
    view: np.ndarray = vector.array_w
    return view

"""The Python of the environment that has the reservoir simulator, and whether it answers."""

import os
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import numpy as np

from staffa.errors import InputError, StaffaError
from staffa.reservoir.darts import Darts
from staffa.reservoir.grid import grid_around
from staffa.reservoir.simulator import ConstantWater, ReservoirModel, Well

VARIABLE = "STAFFA_DARTS"
INSTALL = (
    "install open-DARTS with `make reservoir`, or with `pip install open-darts==2.0.0` into an "
    f"environment of Python 3.11 to 3.13 and `export {VARIABLE}=/path/to/its/bin/python`"
)


def simulator_python(given: str | os.PathLike[str] | None = None) -> Path:
    """Return the Python that has open-DARTS.

    It is named by the environment variable STAFFA_DARTS, or given, or that of `.reservoir` beside
    the environment of this Python, or this one itself. It is not tried.

    Parameters
    ----------
    given : path, as `reservoir.python` of a case says; None for none.

    Raises
    ------
    InputError
        There is none, or no program where one is named by its full path.
    """
    named = {VARIABLE: os.environ.get(VARIABLE), "reservoir.python": given}
    for name, path in named.items():
        if path:
            return _program(name, Path(path))
    beside = Path(sys.prefix).parent / ".reservoir" / "bin" / "python"
    if beside.exists():
        return beside
    try:
        version("open-darts")
    except PackageNotFoundError:
        raise InputError(f"There is no reservoir simulator: {INSTALL}.") from None
    return Path(sys.executable)


def answers(python: str | os.PathLike[str], *, patience: float = 60.0) -> str:
    """Return name and version of the simulator, after a step on five cells.

    Parameters
    ----------
    python : its Python.
    patience : time within which it answers (s).

    Raises
    ------
    InputError
        It does not answer.
    """
    simulator = Darts(_five_cells(), python, patience=patience)
    try:
        flow, account, _ = simulator.advance(simulator.start(), None, 3600.0)
    except StaffaError as error:
        why = error.__cause__ or error
        raise InputError(f"open-DARTS in {python} does not answer ({why}): {INSTALL}.") from None
    finally:
        simulator.close()
    mass = account.wells["in"].mass + account.wells["out"].mass
    if not (np.isfinite(flow.T).all() and abs(mass - account.mass_stored) < 1e-3):
        raise InputError(f"open-DARTS in {python} computes wrongly: {INSTALL}.")
    return simulator.name


def _program(name: str, path: Path) -> Path:
    # A path from the current folder could name a program that came with a case.
    if not path.is_absolute():
        raise InputError(f"{name} = {path} must be a full path, like /home/me/darts/bin/python.")
    if not (path.is_file() and os.access(path, os.X_OK)):
        raise InputError(f"{name} = {path} is no program: {INSTALL}.")
    return path


def _five_cells() -> ReservoirModel:
    grid = grid_around((0.0, 0.0), (5.0, 1.0), 1.0)
    every = np.ones(grid.size)
    return ReservoirModel(
        grid=grid,
        permeability=1e-13 * every,
        porosity=0.1 * every,
        conductivity=2.5 * every,
        rho_c=2.3e6 * every,
        T=473.15 * every,
        p=20e6 * every,
        water=ConstantWater(rho=1000.0, c=4200.0, mu=3e-4),
        wells=[
            Well(name="in", cells=(0,), rate=0.01, T=333.15),
            Well(name="out", cells=(grid.size - 1,), pressure=20e6),
        ],
    )

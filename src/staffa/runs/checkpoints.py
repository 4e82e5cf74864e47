"""Checkpoints of a run: written when they are due, and read again."""

import os
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from errno import ENOENT, ENOTDIR
from pathlib import Path
from time import perf_counter
from typing import Any

from staffa.backend.stack import PETSc

import dolfinx
import numpy as np
from dolfinx import fem

from staffa.backend.jit import chosen_flags
from staffa.backend.parallel import on_root
from staffa.case.schema.checkpoint_keys import CheckpointKeys
from staffa.errors import InputError, StaffaError, StoppedError
from staffa.evolution.restart_state import FACES, MEMORY, RestartState, restart_state
from staffa.evolution.session import Session
from staffa.geometry.simplices import Simplices
from staffa.io import checkpoint
from staffa.io.mesh_arrays import POINTS, mesh_arrays, mesh_of_arrays
from staffa.io.run_directory import Journal
from staffa.model.fields import owned
from staffa.model.numbering import Numbering
from staffa.records.status import Status
from staffa.records.step import Step
from staffa.runs.provenance import version

# Of the cell edge: vertices of the same mesh differ by round-off, on other ranks.
SAME_PLACE = 1e-6
FLAGS = "C compiler flags"  # they decide the last digits of what forms give


def versions() -> dict[str, str]:
    """Return the versions and options that decide the numbers of a run."""
    petsc = ".".join(str(n) for n in PETSc.Sys.getVersion())
    options = os.environ.get("PETSC_OPTIONS", "") or "none"
    return {
        **{"staffa": version(), "dolfinx": dolfinx.__version__, "petsc": petsc},
        "PETSC_OPTIONS": options,
        FLAGS: " ".join(chosen_flags()),
    }


@contextmanager
def on_disk(directory: Path, *, started: bool = True) -> Iterator[None]:
    """Raise an error of rank 0's writing to a run directory on all ranks.

    Parameters
    ----------
    directory : the run directory.
    started : True if it contains a run that can be resumed.

    Raises
    ------
    StoppedError
        It cannot be written to any more: the disk is full, or it has become read-only.
    StaffaError
        It is gone, or no run was started.
    """
    try:
        yield
    except OSError as error:
        why = f"{directory} cannot be written to ({error.strerror or error})"
        if not started:
            raise StaffaError(f"{why}: no run was started; correct that and run again") from None
        if error.errno in (ENOENT, ENOTDIR):
            raise StaffaError(f"{why}: it is gone, and with it the run; start it again") from None
        raise StoppedError(why) from None


class _Order:
    """Orders in which values of one mesh are kept, and the parts of checkpoints that hold them.

    Attributes
    ----------
    vertices, nodes : orders of damage and temperature, and of displacement.
    cells : order of the numbers of faces, if there are any.
    mesh : part that holds the vertices, as soon as one does.
    past : parts that hold earlier states, by the numbers of these.
    """

    def __init__(self, session: Session) -> None:
        spaces, frozen = session.system.spaces, session.system.energy.frozen
        self.vertices = Numbering(session.comm, spaces.alpha)
        self.nodes = self.vertices
        if spaces.quadratic:
            self.nodes = Numbering(session.comm, spaces.nodes)
        self.cells = [Numbering(session.comm, field.function_space) for field in frozen]
        self.mesh: str | None = None
        self.past: dict[int, str] = {}

    def of(self, field: str) -> Numbering:
        """The order of a field."""
        return self.nodes if field == "u" else self.vertices

    def whole(
        self, fields: Mapping[str, np.ndarray], memory: np.ndarray
    ) -> dict[str, np.ndarray | None]:
        """Fields of all ranks on rank 0, None elsewhere; and the memory, where there is one."""
        whole = {name: self.of(name).whole(values) for name, values in fields.items()}
        return whole | ({MEMORY: memory} if memory.size else {})


class CheckpointWriter:
    """Writer of a run's steps, and of its checkpoints when they are due; it also reads these.

    A checkpoint is due after a number of steps or minutes, but never so soon that writing takes
    more time than computing. All is gathered on rank 0, as fields for ParaView are. Collective.
    """

    def __init__(
        self, directory: Path, session: Session, keys: CheckpointKeys, journal: Journal
    ) -> None:
        """Keep a run in its directory.

        Parameters
        ----------
        directory : directory of the run.
        session : owner of the mesh whose values are kept.
        keys : when a checkpoint is due.
        journal : steps that are there.
        """
        self.comm, self.directory, self.journal = session.comm, directory, journal
        self._folder, self._keys, self._session = directory / checkpoint.FOLDER, keys, session
        self._saved_at, self._steps = -1, 0  # how many lines there were, and the steps since
        self._took, self._saved = 0.0, perf_counter()

    def note(self, step: Step) -> None:
        """Write a step's record."""
        with on_disk(self.directory):
            on_root(self.comm, lambda: self.journal.append(step))
        self._steps += step.status != Status.REJECTED

    def keep(self, stands: RestartState, now: bool) -> None:
        """Write the restart state, if a checkpoint is due or must be written now."""
        if on_root(self.comm, lambda: self._is_due(now)):
            began = perf_counter()
            self._keep(stands)
            self._saved_at, self._steps = self.journal.lines, 0
            self._saved = perf_counter()
            self._took = self._saved - began

    @property
    def _order(self) -> _Order:
        """The orders of the current mesh. Collective."""
        return self._session.tool(_Order)

    def _keep(self, stands: RestartState) -> None:
        order = self._order
        if order.mesh is None:
            order.mesh = self._write(self._mesh(order))
        numbers = stands.numbers()
        whole = order.whole(stands.fields(), stands.kept.thermal.memory)
        faces = stands.faces()
        frozen = self._session.system.energy.frozen
        for numbering, field in zip(order.cells, frozen, strict=True):
            assert faces is not None
            width = field.function_space.dofmap.index_map_bs
            whole[FACES] = numbering.whole(faces.reshape(-1, width))
        state = self._write(whole)
        known = {number: order.past.get(number) for number in stands.states}
        for number, name in known.items():
            known[number] = name or self._write(order.whole(*stands.past_fields(number)))
        order.past = {number: str(name) for number, name in known.items()}
        past = list(order.past.values())
        page = {
            **{"version": version(), "versions": versions(), "ranks": self.comm.size},
            **{"lines": self.journal.lines, "steps": self.journal.sum},
            **{"standing": numbers, "mesh": order.mesh, "state": state, "past": past},
        }
        parts = dict.fromkeys([str(order.mesh), state, *past])
        with on_disk(self.directory):
            on_root(
                self.comm,
                lambda: checkpoint.write_page(self._folder, self.journal.lines, page, parts),
            )

    def _mesh(self, order: _Order) -> dict[str, np.ndarray | None]:
        """Points of the mesh on rank 0, with its cells and names where it follows the cracks."""
        source = self._session.domain.source
        if source is None or source.mesh is None:
            return {POINTS: order.vertices.points}
        return dict(mesh_arrays(source.mesh))

    def _is_due(self, now: bool) -> bool:
        """Return True if a checkpoint is due; on rank 0, which alone knows lines and time."""
        if self.journal.lines == self._saved_at:
            return False
        if now:
            return True
        gone = perf_counter() - self._saved
        enough = self._steps >= self._keys.steps or gone >= 60 * self._keys.minutes
        return self._steps > 0 and enough and gone >= self._took

    def _write(self, arrays: dict[str, np.ndarray | None]) -> str:
        def write() -> str:
            return checkpoint.write_part(
                self._folder, {k: v for k, v in arrays.items() if v is not None}
            )

        # Only what rank 0 meets: where another rank's history is lost, that rank ends all of them.
        with on_disk(self.directory):
            return on_root(self.comm, write)

    def take_up(self, page: Mapping[str, Any]) -> RestartState:
        """Return the restart state of a checkpoint, on the current ranks.

        Raises
        ------
        InputError
            The mesh is not that of the checkpoint.
        """
        self._take_up_mesh(page["mesh"])
        order = self._order
        if not on_root(self.comm, lambda: self._is_of_this_mesh(order, page["mesh"])):
            raise InputError(
                f"{self.directory}: the mesh that is made now is not that of the checkpoint; use "
                f"the versions that made it, {listed_versions(page['versions'])}"
            )
        past = (self._shared(name) for name in page["past"])
        found = restart_state(
            page["standing"],
            self._shared(page["state"]),
            past if page["past"] else None,
            self._session.system,
        )
        order.mesh, self._saved_at = page["mesh"], page["lines"]
        order.past = dict(zip(found.states, page["past"], strict=True))
        return found

    def _take_up_mesh(self, name: str) -> None:
        """Put a mesh that has followed the cracks in place of the first one. Collective."""
        if self._session.domain.source is None:
            return
        held: list[Simplices] = []
        on_root(
            self.comm,
            lambda: held.append(mesh_of_arrays(checkpoint.read_part(self._folder, name))),
        )
        self._session.take_up(held[0] if held else None)

    def _is_of_this_mesh(self, order: _Order, name: str) -> bool:
        """Return True if the mesh is that of the checkpoint; on rank 0, which has all points."""
        points, kept = order.vertices.points, checkpoint.read_part(self._folder, name)[POINTS]
        assert points is not None
        if points.shape != kept.shape:
            return False
        return bool(np.abs(points - kept).max() <= SAME_PLACE * self._session.domain.h)

    def _shared(self, name: str) -> dict[str, np.ndarray]:
        """Return the arrays of a part for this rank, ghosts included."""
        arrays: dict[str, np.ndarray] = {}

        def read() -> list[str]:
            arrays.update(checkpoint.read_part(self._folder, name))
            return sorted(arrays)

        names, order = on_root(self.comm, read), self._order
        shared = {
            field: self._with_ghosts(order.of(field).share(arrays.get(field)))
            for field in names
            if field not in (FACES, MEMORY)
        }
        if MEMORY in arrays:  # on rank 0
            shared[MEMORY] = arrays[MEMORY]
        frozen = self._session.system.energy.frozen
        for numbering, field_of_cells in zip(order.cells, frozen, strict=True):
            if FACES in names:
                own = numbering.share(arrays.get(FACES))
                shared[FACES] = self._with_ghosts(own, field_of_cells.function_space)
        return shared

    def _with_ghosts(self, own: np.ndarray, space: fem.FunctionSpace | None = None) -> np.ndarray:
        spaces = self._session.system.spaces
        field = fem.Function(space or (spaces.u if own.ndim == 2 else spaces.alpha))
        owned(field)[:] = own.ravel()
        field.x.scatter_forward()
        return np.asarray(field.x.array.copy())


def listed_versions(found: Mapping[str, str]) -> str:
    """Return versions by their names as text."""
    return ", ".join(f"{name} {version}" for name, version in found.items())

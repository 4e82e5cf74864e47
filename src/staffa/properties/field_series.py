"""Temperature and pressure from files of another simulator: one file a time, linear in between."""

from bisect import bisect_right
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from hashlib import sha256
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from staffa.backend.guarded_reading import read_apart
from staffa.errors import InputError, LoadError
from staffa.properties.mesh_field import Counting, MeshField, field_in, require_field_file

ROUND_OFF = 1e-9  # part of a mesh by which a point of its surface may lie outside
KEPT = 6  # files whose values at the last points are kept


@dataclass(frozen=True, kw_only=True)
class FieldSeries:
    """A temperature, and a pressure where one is named, known beforehand at some times.

    It is a load in closed form. Between two times values are linear. Before the first and after
    the last time nothing is known, and nothing is given. It can be sent to other ranks.

    Attributes
    ----------
    t : times of the files (s), increasing.
    T : absolute temperature (K) at each time.
    p : pressure (Pa) at each time; None if it is not known.
    reference : temperature (K) at points, shape (3, n) -> (n,), from which the change counts; None
        for that of the first time.
    """

    t: tuple[float, ...]
    T: tuple[MeshField, ...]
    p: tuple[MeshField, ...] | None = None
    reference: Callable[[np.ndarray], np.ndarray] | None = None
    _known: dict[tuple[str, int], tuple[np.ndarray, np.ndarray]] = field(
        default_factory=dict, init=False, compare=False, repr=False
    )

    def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
        """Return the change of temperature (K), shape (n,), at points x, shape (3, n), and a time.

        Raises
        ------
        InputError
            A point lies outside of a file's mesh.
        LoadError
            The time lies outside of those of the files.
        """
        known = self.reference
        start = self._of_file("T", self.T, 0, x) if known is None else known(x)
        return np.asarray(self.absolute(x, t) - start)

    def absolute(self, x: np.ndarray, t: float) -> np.ndarray:
        """Return the temperature (K), shape (n,), at points x, shape (3, n), and a time (s)."""
        return self._between("T", self.T, x, t)

    @property
    def pressure(self) -> Callable[[np.ndarray, float], np.ndarray] | None:
        """Return the pressure (Pa) as a function of points and time; None if it is not known."""
        return None if self.p is None else self._pressure

    def _pressure(self, x: np.ndarray, t: float) -> np.ndarray:
        assert self.p is not None
        return self._between("p", self.p, x, t)

    @property
    def identity(self) -> str:
        """Return a text that is the same for the same times and fields."""
        fields = (*self.T, *(self.p or ()))
        told = sha256(repr((self.t, [f.digest for f in fields])).encode()).hexdigest()[:16]
        return f"fields of {len(self.t)} times, {told}"

    @property
    def paths(self) -> tuple[Path, ...]:
        """Return the files, in the order of their times."""
        return tuple(known.path for known in self.T)

    def reaches(self, x: np.ndarray) -> np.ndarray:
        """Return True for each of the points x, shape (3, n), at which every file has values.

        A run asks this on all ranks before it begins, since a value that is missing on one rank
        alone would end them all.
        """
        every = [known(x) for known in (*self.T, *(self.p or ()))]
        return np.asarray(np.all(np.isfinite(every), axis=0))

    def reaching(self, slack: float) -> "FieldSeries":
        """Return the same, whose fields go on beyond their meshes by this distance (m)."""
        p = None if self.p is None else tuple(known.reaching(slack) for known in self.p)
        T = tuple(known.reaching(slack) for known in self.T)
        return FieldSeries(t=self.t, T=T, p=p, reference=self.reference)

    def _between(
        self, name: str, fields: tuple[MeshField, ...], x: np.ndarray, t: float
    ) -> np.ndarray:
        """Return values that are linear between the two files around a time."""
        if not self.t[0] <= t <= self.t[-1]:
            raise LoadError(
                f"no {'temperature' if name == 'T' else 'pressure'} is known at t = {t:g} s: the "
                f"files reach from {self.t[0]:g} s to {self.t[-1]:g} s; keep the run within these "
                f"times, or give a file of that time"
            )
        after = bisect_right(self.t, t)
        before = self._of_file(name, fields, after - 1, x)
        if t == self.t[after - 1]:
            return before.copy()
        share = (t - self.t[after - 1]) / (self.t[after] - self.t[after - 1])
        return np.asarray(before + share * (self._of_file(name, fields, after, x) - before))

    def _of_file(
        self, name: str, fields: tuple[MeshField, ...], k: int, x: np.ndarray
    ) -> np.ndarray:
        """Return values of one file at points; those of the last points are kept."""
        known = self._known.get((name, k))
        if known is not None and np.array_equal(known[0], x):
            return known[1]
        found = fields[k](x)
        _require_reached(fields[k], x, found)
        self._known[name, k] = (x.copy(), found)
        while len(self._known) > KEPT:
            self._known.pop(next(iter(self._known)))
        return found


def _require_reached(known: MeshField, x: np.ndarray, found: np.ndarray) -> None:
    lost = ~np.isfinite(found)
    if not np.any(lost):
        return
    at, low, high = (_place(p) for p in (x[:, np.argmax(lost)], *known.bounds))
    raise InputError(
        f"{known.path}: its mesh does not reach {at}; it reaches from {low} to {high} (m), and "
        f"must cover the body; give files that do, or the unit of their coordinates"
    )


def _place(point: np.ndarray) -> str:
    return f"({', '.join(f'{c:.4g}' for c in point)})"


def read_series(
    files: Sequence[Path],
    t: Sequence[float],
    *,
    T: str,
    p: str | None = None,
    T_counts: Counting | None = None,
    p_counts: Counting | None = None,
    reference: Callable[[np.ndarray], np.ndarray] | None = None,
) -> FieldSeries:
    """Read a series of fields, all files in one separate process.

    Parameters
    ----------
    files : a file for each time, of `mesh_field.FORMATS`; of a case those that
        `case.schema.file_access.FileAccess.file` allows.
    t : times (s), increasing.
    T, p : names of temperature and pressure in the files; p is None where there is none.
    T_counts, p_counts : their units, and that of coordinates; None for K, Pa and m.
    reference : see `FieldSeries`.

    Raises
    ------
    InputError
        Times and files do not fit together; or a file cannot be read, has no such field, or one
        with a temperature below absolute zero.
    """
    _require_times(files, t)
    for file in files:
        require_field_file(file)
    T_counts, p_counts = T_counts or Counting(), p_counts or Counting()
    asked = [("T", T, asdict(T_counts))]
    asked += [] if p is None else [("p", p, asdict(p_counts))]
    first, *others = (path.absolute() for path in files)
    where = f"{files[0]} and {len(others)} more" if others else f"{files[0]}"
    parts = read_apart(
        SeriesParts,
        "staffa.properties.field_series:series_in",
        first,
        [[str(path) for path in others], asked],
        where=where,
        size=sum(path.stat().st_size for path in files),
    )
    fields = {q: tuple(parts.of(q, k, path) for k, path in enumerate(files)) for q, *_ in asked}
    for known in fields["T"]:
        if known.values.min() < 0:
            raise InputError(
                f"{known.path}: '{T}' is {known.values.min():g} K somewhere, below absolute zero; "
                f'give its unit, like "°C", or correct the file'
            )
    return FieldSeries(
        t=tuple(float(time) for time in t),
        T=fields["T"],
        p=fields.get("p"),
        reference=reference,
    )


def _require_times(files: Sequence[Path], t: Sequence[float]) -> None:
    if not files or len(files) != len(t):
        raise InputError(
            f"fields.t has {len(t)} numbers and fields.files has {len(files)}; give as many of "
            f"each, and at least one"
        )
    if not np.all(np.isfinite(t)):
        raise InputError(f"fields.t = {list(t)}: a time is not finite; give numbers in s")
    for before, after in pairwise(t):
        if after <= before:
            raise InputError(
                f"fields.t: {after:g} comes after {before:g}; put the times in increasing order, "
                f"no two of them equal"
            )


@dataclass(frozen=True, kw_only=True)
class SeriesParts:
    """A series as a reading process hands it over.

    Attributes
    ----------
    arrays : points, cells and types of each mesh, and values of each field, by name and number.
    meshes : for each file, number of the file whose mesh is the same.
    per_cell, digests : for each file and field, see `MeshField`.
    """

    arrays: Mapping[str, np.ndarray]
    meshes: tuple[int, ...]
    per_cell: Mapping[str, np.ndarray]
    digests: tuple[str, ...]

    def of(self, quantity: str, k: int, path: Path) -> MeshField:
        """Return a field of a file.

        Parameters
        ----------
        quantity : "T" or "p".
        k : number of the file.
        path : the file.
        """
        mesh = {n: self.arrays[f"{n}{self.meshes[k]}"] for n in ("points", "cells", "types")}
        row = list(self.per_cell).index(f"{quantity}{k}")
        extent = float(np.ptp(mesh["points"], axis=0).max())
        return MeshField(
            **mesh,
            values=self.arrays[f"{quantity}{k}"],
            per_cell=bool(self.per_cell[f"{quantity}{k}"]),
            digest=self.digests[row],
            path=path,
            slack=ROUND_OFF * extent,
        )


def series_in(
    path: Path, others: Sequence[str], asked: Sequence[tuple[str, str, dict[str, Any]]]
) -> SeriesParts:
    """Read the fields of a series in this process.

    Parameters
    ----------
    path : the first file.
    others : the other files.
    asked : for each quantity its key, its name in the files, and the fields of a `Counting`.
    """
    arrays: dict[str, np.ndarray] = {}
    meshes: list[int] = []
    per_cell: dict[str, np.ndarray] = {}
    digests: list[str] = []
    for k, file in enumerate((path, *map(Path, others))):
        for key, known in _fields(file, asked):
            if len(meshes) == k:
                meshes.append(_number_of_mesh(arrays, meshes, known))
            arrays[f"{key}{k}"] = known.values
            per_cell[f"{key}{k}"] = np.array(known.per_cell)
            digests.append(known.digest)
    return SeriesParts(
        arrays=arrays, meshes=tuple(meshes), per_cell=per_cell, digests=tuple(digests)
    )


def _fields(file: Path, asked: Sequence[Any]) -> Iterator[tuple[str, MeshField]]:
    for key, name, counted in asked:
        try:
            yield key, field_in(file, name, counted)
        except InputError as error:
            said = str(error)
            raise InputError(said if str(file) in said else f"{file}: {said}") from None


def _number_of_mesh(arrays: dict[str, np.ndarray], meshes: Sequence[int], known: MeshField) -> int:
    """Return the number of the mesh of a field, which is added where it is a new one."""
    parts = {"points": known.points, "cells": known.cells, "types": known.types}
    for k in sorted(set(meshes), reverse=True):
        if all(np.array_equal(arrays[f"{name}{k}"], part) for name, part in parts.items()):
            return k
    number = len(meshes)
    arrays.update({f"{name}{number}": part for name, part in parts.items()})
    return number

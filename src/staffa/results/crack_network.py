"""Crack networks of a run as files, one pair for each step with fields."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from staffa.display_units import NONE, Unit
from staffa.io.network_files import write_table, write_vtp
from staffa.io.own_files import make_folder
from staffa.io.run_directory import Run
from staffa.io.vtkhdf import VtkMesh, read_vtkhdf
from staffa.measure.network import Network, normals, polylines
from staffa.measure.tip import damage_at_tip, falls
from staffa.measure.tracing import network
from staffa.records.step import Step

STRAINS = ("opening_strain", "intact_strain")
UNKNOWN = 0.01  # a smaller part of the network is not reported
FOLDER, TABLE = "network", "network.csv"
CRACKS = re.compile(r"cracks-\d{4,}\.(vtp|csv)")
OLDER = (
    "openings: an earlier version wrote the fields, without openings; cracks are gray, and tables "
    "of networks that it wrote stay as they are"
)


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """Network of one step.

    Attributes
    ----------
    step : record of the step.
    network : its crack network.
    outline : sides of a 2-D body (m), shape (k, 2, 2).
    """

    step: Step
    network: Network
    outline: np.ndarray = field(default_factory=lambda: np.zeros((0, 2, 2)))


def networks(run: Run) -> tuple[list[Drawing], list[str]]:
    """Return the network of each step with fields, and a message on each unreadable file."""
    found, reasons = [], []
    m = run.manifest
    tip = damage_at_tip(m.law, threshold=m.threshold)
    for step in run.steps:
        if not step.fields or not (run.path / step.fields).exists():
            continue
        try:
            grid, values = read_vtkhdf(run.path / step.fields)
            alpha = values["alpha"]
        except (OSError, KeyError, ValueError, IndexError) as error:
            reasons.append(f"{step.fields} is left out: it cannot be read: {error}")
            continue
        strains = None
        if set(STRAINS) <= set(values):
            strains = np.stack([values[name] for name in STRAINS], axis=1)
        cracks = network(
            grid.points, grid.cells, alpha=alpha, strains=strains, dim=len(m.size), h=m.h,
            ell=m.ell, crack=m.threshold, tip=tip, falls=falls(m.law), axial=m.axial,
        )  # fmt: skip
        outline = _outline(grid) if len(m.size) == 2 else np.zeros((0, 2, 2))
        found.append(Drawing(step=step, network=cracks, outline=outline))
    return found, reasons


def _outline(grid: VtkMesh) -> np.ndarray:
    """Return the sides that belong to one cell only, those of holes included."""
    sides = np.stack([grid.cells, np.roll(grid.cells, -1, axis=1)], axis=2).reshape(-1, 2)
    sides, counts = np.unique(np.sort(sides, axis=1), axis=0, return_counts=True)
    return np.asarray(grid.points[sides[counts == 1]][..., :2])


def write_networks(run: Run, found: Sequence[Drawing]) -> list[Path]:
    """Write `network/cracks-NNNN.vtp`, `.csv` for each step, and `network.csv`; return the paths.

    docs/results.md describes their content. Files of an earlier version, whose openings this
    version cannot find again, are kept.
    """
    folder, written = run.path / FOLDER, []
    if without_openings(found) and (run.path / TABLE).exists():
        return [*sorted(folder.glob("cracks-*")), run.path / TABLE]
    if found or folder.exists():
        make_folder(folder)
    earlier = [old for old in folder.glob("cracks-*") if CRACKS.fullmatch(old.name)]
    for old in (*earlier, run.path / TABLE):
        old.unlink(missing_ok=True)  # of steps that backtracking has superseded since
    for drawn in found:
        path = folder / f"cracks-{drawn.step.index:04d}.vtp"
        _write_vtp(path, drawn.network)
        write_table(path.with_suffix(".csv"), _elements(drawn.network, run))
        written += [path, path.with_suffix(".csv")]
    rows = [list(_numbers(drawn, run)) for drawn in found]
    if rows:
        names = [unit.column(name) for name, unit, _ in rows[0]]
        values = zip(*([value for *_, value in row] for row in rows), strict=True)
        table = {
            name: np.array(column, dtype=object) for name, column in zip(names, values, strict=True)
        }
        write_table(run.path / TABLE, table)
        written.append(run.path / TABLE)
    return written


def without_openings(found: Sequence[Drawing]) -> bool:
    """Return True if there are cracks, and an earlier version wrote all of their fields."""
    volumes = [drawn.network.volume for drawn in found if drawn.network.size]
    return bool(volumes) and bool(np.isnan(volumes).all())


def lines_of(run: Run, found: Sequence[Drawing]) -> tuple[list[str], list[list[str]]]:
    """Return the table of all networks for a page: its header, and a row a step."""
    rows = [list(_numbers(drawn, run)) for drawn in found if drawn.network.size]
    if not rows:
        return [], []
    header = [unit.header(name.replace("_", " ")) for name, unit, _ in rows[0]]
    return header, [[v if isinstance(v, str) else f"{v:.4g}" for *_, v in row] for row in rows]


def words_on_openings(run: Run, found: Sequence[Drawing]) -> list[str]:
    """Return messages on openings that are unknown or negative."""
    said = []
    for drawn in found:
        cracks, step = drawn.network, f"step {drawn.step.index}"
        if not cracks.size:
            continue
        if np.isnan(cracks.volume):
            said.append(f"{step}: an earlier version wrote its fields, without openings")
            continue
        mean = cracks.elements.shape[1]
        opening = np.abs(cracks.opening[cracks.elements].sum(axis=1)) / mean
        unknown = cracks.uncertainty[cracks.elements].sum(axis=1) / mean > opening
        part = cracks.sizes[unknown].sum() / cracks.size
        if part > UNKNOWN:
            said.append(
                f"{step}: on {part:.0%} of the network the bands of cracks are too wide to say how "
                "far they are open: less than their uncertainty"
            )
        if cracks.volume < 0 and run.manifest.split == "none":
            said.append(
                f"{step}: the mean opening is negative: the sides of closed cracks overlap, which "
                "only an energy split (damage.split) prevents"
            )
    return said


def _write_vtp(path: Path, cracks: Network) -> None:
    """Write one cell for each branch in 2-D, for each triangle in 3-D."""
    surface = cracks.elements.shape[1] == 3
    cells = list(cracks.elements) if surface else polylines(cracks)
    crack, size = cracks.cracks, cracks.sizes
    if not surface:
        crack = crack[np.unique(cracks.branches, return_index=True)[1]]
        size = np.bincount(cracks.branches, weights=size)
    write_vtp(
        path,
        cracks.points,
        cells,
        surface=surface,
        at_points={
            "opening": cracks.opening,
            "uncertainty": cracks.uncertainty,
            "alpha": cracks.damage,
        },
        on_cells={"crack": crack, "area" if surface or cracks.axial else "length": size},
    )


def _elements(cracks: Network, run: Run) -> dict[str, np.ndarray]:
    """Return the columns of a network's table, a row a segment or triangle."""
    axes, corners = "xyz"[: len(run.manifest.size)], cracks.elements.shape[1]
    shown = run.manifest.shown
    columns = {"crack": cracks.cracks}
    if corners == 2:
        columns["branch"] = cracks.branches
    for corner in range(corners):
        for k, axis in enumerate(axes):
            places = cracks.points[cracks.elements[:, corner], k]
            columns[shown.length.column(f"{axis}{corner}")] = shown.length.of(places)
    name = "length" if run.manifest.plane else "area"
    columns[shown.crack.column(name)] = shown.crack.of(cracks.sizes)
    across = normals(cracks.points, cracks.elements)
    columns |= {f"n{axis}": across[:, k] for k, axis in enumerate(axes)}
    opening = cracks.opening[cracks.elements].mean(axis=1)
    columns[shown.opening.column("opening")] = shown.opening.of(opening)
    uncertainty = cracks.uncertainty[cracks.elements].mean(axis=1)
    columns[shown.opening.column("uncertainty")] = shown.opening.of(uncertainty)
    return columns


def _numbers(drawn: Drawing, run: Run) -> Iterator[tuple[str, Unit, str | float]]:
    """Yield names, units and numbers of a row of the table of all networks."""
    step, cracks, shown = drawn.step, drawn.network, run.manifest.shown
    yield "step", NONE, step.index
    yield "time", shown.time, shown.time.of(step.time)
    yield "tau", NONE, "" if step.tau is None else step.tau
    yield "cracks", NONE, int(cracks.cracks.max(initial=-1)) + 1
    name = "length" if run.manifest.plane else "area"
    yield name, shown.crack, shown.crack.of(cracks.size)
    yield "volume", shown.volume, shown.volume.of(cracks.volume)
    mean = cracks.volume / cracks.size if cracks.size else 0.0
    largest = float(cracks.opening.max(initial=0.0))
    uncertain = cracks.uncertain_volume / cracks.size if cracks.size else 0.0
    openings = {"mean_opening": mean, "largest_opening": largest, "mean_uncertainty": uncertain}
    for name, opening in openings.items():
        yield name, shown.opening, shown.opening.of(opening)

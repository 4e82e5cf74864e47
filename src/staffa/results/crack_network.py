"""Crack networks of a run as files, one pair for each step with fields."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from staffa.io.network_files import write_vtp
from staffa.io.own_files import NETWORK, make_folder, write_aside
from staffa.io.run_directory import Run
from staffa.io.vtkhdf import VtkMesh, read_vtkhdf
from staffa.measure.network import Network, normals, polylines
from staffa.measure.tip import damage_at_tip, falls
from staffa.measure.tracing import network
from staffa.physics.strength_surface import StrengthSurface
from staffa.records.step import Step
from staffa.results.crack_sizes import APART, LEFT_OUT
from staffa.results.network_exchange import write_outline, write_polygons, write_traces
from staffa.results.series import clock_columns, time_columns
from staffa.results.tables import Cell, Column, Table

STRAINS = ("opening_strain", "intact_strain")
UNKNOWN = 0.01  # a part of the network so small is not worth a word
QUOTED = (
    f"Quote this {{name}} for that of the cracks. It leaves out {LEFT_OUT}. That by energy, the "
    f"surface energy over the effective Gc, counts them, of a crack along a side half; where the "
    f"two differ by more than {100 * APART:g} %, quote both. That by geometry is half the "
    f"variation of the damage, a check."
)
# Splits with which the sides of closed cracks may overlap, and what prevents it.
OVERLAP = {
    "none": "which only an energy split (damage.split) prevents",
    StrengthSurface.name: (
        "since with damage.compressive a crack that is pressed shut keeps no more than its bulk "
        "modulus, and nothing in plane stress; without that key its sides do not overlap"
    ),
}
FOLDER = "network"
BODY = "body.geojson"
OURS = re.compile(r"(cracks|polygons|polygon-corners)-\d{4,}\.(vtp|csv|geojson)|body\.geojson")
OLDER = (
    "openings: the fields hold none, since output.fields leaves them out or an earlier version "
    "wrote them; cracks are gray, and tables of networks that are there stay as they are"
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
    """Write the files of the network of each step, and `network.csv`; return the paths.

    docs/reference/results.md describes their content. Files of an earlier version, whose
    openings this version cannot find again, are kept.
    """
    folder, written = run.path / FOLDER, []
    if without_openings(found) and (run.path / NETWORK).exists():
        return [*sorted(folder.glob("*")), run.path / NETWORK]
    if found or folder.exists():
        make_folder(folder)
    earlier = [old for old in folder.glob("*") if OURS.fullmatch(old.name)]
    for old in (*earlier, run.path / NETWORK):
        old.unlink(missing_ok=True)  # of steps that backtracking has superseded since
    for drawn in found:
        path = folder / f"cracks-{drawn.step.index:04d}.vtp"
        _write_vtp(path, drawn.network)
        write_aside(path.with_suffix(".csv"), _elements(drawn.network, run).csv())
        written += [path, path.with_suffix(".csv")]
        if len(run.manifest.size) == 3:
            written += write_polygons(folder, run, drawn.step, drawn.network)
            continue
        written.append(write_traces(path.with_suffix(".geojson"), run, drawn.step, drawn.network))
    if found and len(found[-1].outline):
        written.append(write_outline(folder / BODY, run, found[-1].outline))
    if found:
        write_aside(run.path / NETWORK, network_table(run, found).csv())
        written.append(run.path / NETWORK)
    return written


def without_openings(found: Sequence[Drawing]) -> bool:
    """True if there are cracks, and the fields of them all hold no openings."""
    volumes = [drawn.network.volume for drawn in found if drawn.network.size]
    return bool(volumes) and bool(np.isnan(volumes).all())


def network_table(run: Run, found: Sequence[Drawing]) -> Table:
    """Return the sizes of the networks, a row a moment.

    Parameters
    ----------
    run : the run.
    found : its networks.
    """
    shown = run.manifest.shown
    openings = ("mean_opening", "largest_opening", "mean_uncertainty")
    return Table(
        title="Crack network",
        columns=(
            *clock_columns(run.manifest),
            Column(name="cracks"),
            Column(name="length" if run.manifest.plane else "area", unit=shown.crack),
            Column(name="volume", unit=shown.volume),
            *(Column(name=n, unit=shown.opening, label=n.replace("_", " ")) for n in openings),
        ),
        rows=tuple((*time_columns(drawn.step), *_sizes(drawn.network)) for drawn in found),
        notes=(
            "One row for each moment whose fields were kept; the volume is the integral of the "
            "opening.",
            QUOTED.format(name="length" if run.manifest.plane else "area"),
            *words_on_openings(run, found),
        ),
    )


def _sizes(cracks: Network) -> tuple[Cell, ...]:
    """Return number, size, volume, and mean and largest opening with the mean uncertainty."""
    count = int(cracks.cracks.max(initial=-1)) + 1
    mean = cracks.volume / cracks.size if cracks.size else 0.0
    largest = float(cracks.opening.max(initial=0.0))
    uncertain = cracks.uncertain_volume / cracks.size if cracks.size else 0.0
    return count, cracks.size, cracks.volume, mean, largest, uncertain


def words_on_openings(run: Run, found: Sequence[Drawing]) -> list[str]:
    """Return messages on openings that are unknown or negative."""
    said = []
    for drawn in found:
        cracks, step = drawn.network, f"step {drawn.step.index}"
        if not cracks.size:
            continue
        if np.isnan(cracks.volume):
            said.append(f"{step}: its fields hold no openings")
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
        if run.manifest.split in OVERLAP and cracks.volume < -_unknown_volume(run, cracks):
            said.append(
                f"{step}: the mean opening is negative: the sides of closed cracks overlap, "
                f"{OVERLAP[run.manifest.split]}"
            )
    return said


def _unknown_volume(run: Run, cracks: Network) -> float:
    """Return the volume of cracks up to which nothing is said of its sign."""
    return 0.0 if run.manifest.split == "none" else cracks.uncertain_volume


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


def _elements(cracks: Network, run: Run) -> Table:
    """Return a network as a table, a row a segment or triangle."""
    axes, corners = "xyz"[: len(run.manifest.size)], cracks.elements.shape[1]
    shown, elements = run.manifest.shown, cracks.elements
    found: list[tuple[Column, np.ndarray]] = [(Column(name="crack"), cracks.cracks)]
    if corners == 2:
        found.append((Column(name="branch"), cracks.branches))
    found += [
        (Column(name=f"{axis}{n}", unit=shown.length), cracks.points[elements[:, n], k])
        for n in range(corners)
        for k, axis in enumerate(axes)
    ]
    size = "length" if run.manifest.plane else "area"
    found.append((Column(name=size, unit=shown.crack), cracks.sizes))
    across = normals(cracks.points, elements)
    found += [(Column(name=f"n{axis}"), across[:, k]) for k, axis in enumerate(axes)]
    found += [
        (Column(name=name, unit=shown.opening), values[elements].mean(axis=1))
        for name, values in (("opening", cracks.opening), ("uncertainty", cracks.uncertainty))
    ]
    columns, values = zip(*found, strict=True)
    return Table(columns=columns, rows=tuple(zip(*(v.tolist() for v in values), strict=True)))

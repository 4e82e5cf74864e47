"""Each crack's tip followed in time, as a table."""

from staffa.geometry.block import face_axis
from staffa.io.run_directory import Run
from staffa.measure.generations import tracks
from staffa.results.release_table import rates, release_at
from staffa.results.series import clock_columns, time_columns
from staffa.results.tables import Cell, Column, Table, columns_of


def tips_table(run: Run) -> Table:
    """Return a row for each crack of the last step and step; none without a cooled face.

    crack: its number along the face, the same at all steps; x, y(, z): the last point above
    measures.threshold; depth: of the sharp tip, which is deeper by `tip_reach` of manifest.json
    (see `measure.tip`), or of that point where that is not known. G, uncertainty: the energy
    release rate, in steps whose fields were kept.
    """
    manifest = run.manifest
    if manifest.cooled_side is None:
        return Table()
    axis = face_axis(manifest.cooled_side, len(manifest.size))
    followed = tracks(run.steps, axis=axis, sharp=manifest.sharp)
    known = any(step.released for step in run.steps)  # not by earlier versions
    rows: list[tuple[Cell, ...]] = []
    for number, track in enumerate(sorted(followed, key=lambda track: track.place)):
        for step, position, depth in zip(run.steps, track.path, track.depths, strict=True):
            if position is not None:
                release = rates(release_at(step, position, manifest.ell)) if known else ()
                rows.append((number, *time_columns(step), *position, depth, *release))
    axes, shown = "xyz"[: len(manifest.size)], manifest.shown
    release_columns = columns_of("G", "uncertainty", unit=shown.release) if known else ()
    return Table(
        columns=(
            Column(name="crack"),
            *clock_columns(manifest),
            *columns_of(*axes, "depth", unit=shown.length),
            *release_columns,
        ),
        rows=tuple(rows),
    )

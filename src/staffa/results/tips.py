"""Tip of each crack followed in time, as a table for a spreadsheet."""

from staffa.geometry.block import face_axis
from staffa.io.run_directory import Run
from staffa.measure.generations import tracks
from staffa.results.release_table import rates, release_at
from staffa.results.series import clock_header, csv_text, time_columns


def tips_table(run: Run) -> str | None:
    """Return CSV with one row for each crack of the last step and step; None without any.

    crack: its number along the face, the same at all steps. x, y(, z): the last point above
    measures.threshold. depth: of the sharp tip, which is deeper by `tip_reach` of manifest.json
    (see `measure.tip`); of that point if `tip_reach` is not known. G, uncertainty: the energy
    release rate, in steps with fields.
    """
    manifest = run.manifest
    if manifest.cooled_side is None:
        return None
    axis = face_axis(manifest.cooled_side, len(manifest.size))
    followed = tracks(run.steps, axis=axis, sharp=manifest.sharp)
    if not followed:
        return None
    unit = manifest.shown.length
    places = [unit.column(name) for name in (*"xyz"[: len(manifest.size)], "depth")]
    known = any(step.released for step in run.steps)  # not by earlier versions
    if known:
        places += [manifest.shown.release.column(name) for name in ("G", "uncertainty")]
    rows: list[list[object]] = []
    for number, track in enumerate(sorted(followed, key=lambda track: track.place)):
        for step, position, depth in zip(run.steps, track.path, track.depths, strict=True):
            if position is not None:
                where = map(unit.of, (*position, depth))
                release = rates(run, release_at(step, position, manifest.ell)) if known else []
                rows.append([number, *time_columns(manifest, step), *where, *release])
    return csv_text(["crack", *clock_header(manifest), *places], rows)

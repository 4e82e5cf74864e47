"""Refusal of a study by a command that works on one run or ensemble."""

from pathlib import Path

from staffa.errors import InputError
from staffa.io.ensemble_directory import is_ensemble, read_ensemble
from staffa.io.study_directory import has_started, is_study


def require_no_study(path: Path, *, ensembles: bool) -> None:
    """Refuse the directory of a study, and name a part of it that can take its place.

    Parameters
    ----------
    path : the directory.
    ensembles : True if a point, which is an ensemble, can take its place; else a run alone can.

    Raises
    ------
    InputError
        It is a study.
    """
    if not is_study(path):
        return
    if not has_started(path):
        raise InputError(f"{path} is a study of which no run has started; run it first")
    point = next(inside for inside in sorted(path.iterdir()) if is_ensemble(inside))
    if ensembles:
        raise InputError(f"{path} is a study; name one of its points, like {point}, or of its runs")
    run = read_ensemble(point).first.path
    raise InputError(f"{path} is a study; name one of its runs, like {run}")

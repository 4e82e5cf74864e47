"""The page of a study: its parameters, the means of each point, response curves."""

from collections.abc import Sequence
from pathlib import Path

from staffa.io.study_directory import Study
from staffa.report.page import PLAIN, origin, rendered_page
from staffa.results.study_table import study_facts, study_sheets, study_title

STUDY_PRODUCTION = "study-production"


def study_page(study: Study, pictures: Sequence[Path], skipped: Sequence[str]) -> str:
    """Return the page of a study.

    Parameters
    ----------
    study : the study.
    pictures : files of pictures, which are embedded.
    skipped : a sentence on each that could not be drawn.
    """
    first = min(study.ensembles)
    return rendered_page(
        study.first,
        pictures,
        title=study_title(study),
        facts=tuple(study_facts(study)),
        tables=[(sheet, PLAIN) for sheet in study_sheets(study)],
        skipped=skipped,
        cases=[(f"Case of point {first}", study.first.case)],
        origins=[f"of the first run: {origin(study.first)}"],
    )

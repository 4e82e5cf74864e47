"""The page of a study: its parameters, the means of each point, response curves."""

from collections.abc import Sequence

from staffa.io.study_directory import Study
from staffa.report.page import PLAIN, Picture, origin, rendered_page
from staffa.report.provenance_tables import study_again, versions_table
from staffa.results.study_table import study_facts, study_sheets, study_title

STUDY_PRODUCTION = "study-production"


def study_page(
    study: Study, pictures: Sequence[Picture], skipped: Sequence[str], *, grows: int | None = None
) -> str:
    """Return the page of a study.

    Parameters
    ----------
    study : the study.
    pictures : pictures with their curves.
    skipped : a sentence on each that could not be drawn.
    grows : seconds after which the page is read again; None for that of a study that is over.
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
        repeated=study_again(study),
        made_by=versions_table({"version, of the first run": study.first}),
        grows=grows,
    )

"""Warnings and notes on a case that can run: warnings ask for a change, notes explain."""

from staffa.case.check.axis_warnings import axis_cautions
from staffa.case.check.cooling_warnings import cooling_cautions, cooling_notes
from staffa.case.check.force_warnings import force_cautions
from staffa.case.check.load_warnings import load_cautions
from staffa.case.check.mesh_warnings import mesh_cautions, mesh_notes
from staffa.case.check.sliding_warnings import sliding_cautions
from staffa.case.check.support_warnings import hinge_cautions, holding_notes
from staffa.case.check.temperature_warnings import temperature_cautions
from staffa.case.scales.case_scales import Numbers
from staffa.case.schema.case import Case


def warnings(case: Case, derived: Numbers) -> list[str]:
    """Sentences on what is off, each with the number to take."""
    found = [*mesh_cautions(case), *hinge_cautions(case)]
    found += [*load_cautions(case, derived), *force_cautions(case, derived)]
    found += [*axis_cautions(case, derived), *temperature_cautions(case), *sliding_cautions(case)]
    return [*found, *cooling_cautions(case, derived)] if derived.cooled else found


def notes(case: Case, derived: Numbers) -> list[str]:
    """Sentences on what is a choice, and what it means."""
    always = [*mesh_notes(case)]
    if not derived.cooled:
        return always
    return [*always, *cooling_notes(case, derived), *holding_notes(case, derived)]

"""Warnings and notes on a case that can run: warnings ask for a change, notes explain."""

from staffa.case.check.axis_warnings import axis_warnings
from staffa.case.check.cohesive_warnings import cohesive_warnings
from staffa.case.check.cooling_warnings import cooling_notes, cooling_warnings
from staffa.case.check.face_notes import face_notes
from staffa.case.check.force_warnings import force_warnings
from staffa.case.check.front_facts import front_notes, front_warnings
from staffa.case.check.load_warnings import load_warnings
from staffa.case.check.mesh_warnings import mesh_notes, mesh_warnings
from staffa.case.check.reservoir_warnings import reservoir_notes, reservoir_warnings
from staffa.case.check.sliding_warnings import sliding_warnings
from staffa.case.check.support_warnings import hinge_warnings, holding_notes
from staffa.case.check.temperature_change import formula_warnings
from staffa.case.check.temperature_warnings import temperature_warnings
from staffa.case.scales.case_scales import Numbers
from staffa.case.schema.case import Case


def warnings(case: Case, derived: Numbers) -> list[str]:
    """Return a sentence on each likely mistake, with the number to take."""
    found = [*mesh_warnings(case), *cohesive_warnings(case), *hinge_warnings(case)]
    found += [*load_warnings(case, derived), *force_warnings(case, derived)]
    found += [*axis_warnings(case, derived), *temperature_warnings(case), *sliding_warnings(case)]
    found += reservoir_warnings(case, derived)
    found += [*formula_warnings(case, derived), *front_warnings(case, derived)]
    return [*found, *cooling_warnings(case, derived)] if derived.cooled else found


def notes(case: Case, derived: Numbers) -> list[str]:
    """Return a sentence on each choice that may not be intended, with its meaning."""
    always = [*mesh_notes(case), *reservoir_notes(case, derived), *front_notes(case, derived)]
    if not derived.cooled:
        return always
    return [
        *always,
        *cooling_notes(case, derived),
        *face_notes(case),
        *holding_notes(case, derived),
    ]

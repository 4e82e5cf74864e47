"""Warnings and notes on a case that can run: warnings ask for a change, notes explain."""

from staffa.cases.axis_cautions import axis_cautions
from staffa.cases.cooling_cautions import cooling_cautions, cooling_notes
from staffa.cases.force_cautions import force_cautions
from staffa.cases.holding import hinge_cautions, holding_notes
from staffa.cases.load_cautions import load_cautions
from staffa.cases.mesh_cautions import mesh_cautions, mesh_notes
from staffa.cases.model import Case
from staffa.cases.numbers import Numbers
from staffa.cases.sliding_cautions import sliding_cautions
from staffa.cases.temperature_cautions import temperature_cautions


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

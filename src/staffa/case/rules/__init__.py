"""The rules of a case that involve more than one key: small functions, each with its sentence."""

from typing import Any

from staffa.case.rules.anisotropy_rules import (
    axes_are_directions,
    lists_have_a_number_an_axis,
    stiffness_is_complete,
)
from staffa.case.rules.axis_rules import (
    axis_is_no_face,
    loads_fit_the_axis,
    rock_fits_the_axis,
    section_is_possible,
)
from staffa.case.rules.body_rules import (
    bands_are_inside,
    cracks_are_inside,
    dimension_agrees,
    elements_fit_the_cells,
    mesh_can_be_numbered,
    mesh_carries_cracks,
)
from staffa.case.rules.contact_rules import CONTACT, contact_is_possible
from staffa.case.rules.cooling_rules import (
    cooling_is_complete,
    cooling_is_one,
    depth_has_a_meaning,
    film_is_convective,
    formula_of_temperature_gives_numbers,
    measures_are_inside,
)
from staffa.case.rules.damage_rules import cohesive_is_possible, strengths_agree
from staffa.case.rules.feedback_rules import feedback_is_possible
from staffa.case.rules.file_rules import files_count_as_the_case, files_cover_the_body
from staffa.case.rules.force_rules import (
    forces_fit_the_body,
    forces_say_something,
    formulas_of_forces_give_numbers,
    split_fits_the_rock,
)
from staffa.case.rules.heat_rules import (
    formulas_give_numbers,
    heat_enters_or_leaves,
    heat_fits_the_body,
    heat_has_its_profile,
    heat_is_complete,
)
from staffa.case.rules.initial_stress import rest_is_borne
from staffa.case.rules.name_rules import cracks_are_there, faces_are_there, files_are_called_apart
from staffa.case.rules.output_rules import output_fields_are_possible
from staffa.case.rules.probe_rules import probes_are_inside
from staffa.case.rules.refine_rules import refinement_is_possible
from staffa.case.rules.reservoir_rules import (
    reservoir_fits_the_body,
    reservoir_has_its_profile,
    reservoir_is_complete,
    reservoir_is_the_only_water,
    reservoir_sides_are_there,
)
from staffa.case.rules.reservoir_values import (
    fields_reach_the_end,
    fractures_are_inside,
    reservoir_values_are_possible,
    single_describes_it,
    water_is_liquid,
)
from staffa.case.rules.rock_rules import (
    elasticity_is_definite,
    properties_have_values,
    random_fields_are_possible,
    regions_are_places,
)
from staffa.case.rules.support_rules import (
    edges_agree,
    is_moved,
    prescribed_agree,
    rollers_are_flat,
    section_can_stretch,
    section_owns_its_sides,
    something_happens,
)
from staffa.case.rules.temperature_rules import (
    formulas_of_temperature_give_numbers,
    laws_fit_the_rock,
    tables_of_temperature_agree,
    temperature_is_known,
)
from staffa.case.rules.time_rules import (
    adaptive,
    adaptive_steps_are_possible,
    cooling_has_started,
    outputs_are_within,
    outputs_count_as_times_do,
    times_given,
    times_increase,
)
from staffa.case.rules.unit_rules import nothing_is_one_by_default, units_are_not_mixed
from staffa.case.rules.well_rules import wells_are_apart, wells_are_complete, wells_are_inside
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import is_scaled, unit
from staffa.case.values.default_split import GAMMA, default_split
from staffa.case.values.elements import cells_of, displacement_unknowns, elements_of
from staffa.geometry.block import SIDES
from staffa.units import Quantity

__all__ = [
    "RULES",
    "adaptive",
    "is_moved",
    "is_scaled",
    "obey",
    "require_loaded",
    "times_given",
    "unit",
]

# In an order in which each may rely on those before.
RULES = (
    outputs_count_as_times_do,
    units_are_not_mixed,
    reservoir_has_its_profile,
    heat_has_its_profile,
    nothing_is_one_by_default,
    dimension_agrees,
    section_is_possible,
    axis_is_no_face,
    elements_fit_the_cells,
    refinement_is_possible,
    faces_are_there,
    cracks_are_there,
    regions_are_places,
    files_are_called_apart,
    stiffness_is_complete,
    axes_are_directions,
    lists_have_a_number_an_axis,
    rock_fits_the_axis,
    random_fields_are_possible,
    files_count_as_the_case,
    files_cover_the_body,
    temperature_is_known,
    laws_fit_the_rock,
    tables_of_temperature_agree,
    properties_have_values,
    elasticity_is_definite,
    cohesive_is_possible,
    strengths_agree,
    mesh_carries_cracks,
    mesh_can_be_numbered,
    bands_are_inside,
    cracks_are_inside,
    cooling_is_one,
    depth_has_a_meaning,
    film_is_convective,
    heat_fits_the_body,
    heat_is_complete,
    heat_enters_or_leaves,
    measures_are_inside,
    probes_are_inside,
    output_fields_are_possible,
    times_increase,
    adaptive_steps_are_possible,
    formulas_give_numbers,
    formula_of_temperature_gives_numbers,
    formulas_of_temperature_give_numbers,
    reservoir_fits_the_body,
    reservoir_sides_are_there,
    reservoir_is_complete,
    wells_are_complete,
    wells_are_apart,
    wells_are_inside,
    fractures_are_inside,
    reservoir_values_are_possible,
    water_is_liquid,
    fields_reach_the_end,
    single_describes_it,
    feedback_is_possible,
    reservoir_is_the_only_water,
    forces_say_something,
    forces_fit_the_body,
    split_fits_the_rock,
    contact_is_possible,
    formulas_of_forces_give_numbers,
    outputs_are_within,
    loads_fit_the_axis,
    rollers_are_flat,
    section_owns_its_sides,
    section_can_stretch,
    prescribed_agree,
    edges_agree,
    rest_is_borne,
)
# Those of a case for which no script gives a load.
LOADED = (cooling_is_complete, cooling_has_started, something_happens)

# Numbers of the rock that are 1 where nothing else is said.
ONES = {"expansion": "1/K", "kappa": "m^2/s"}
ONES_OF_HEAT = {"expansion": "1/K", "k": "W/(m K)", "rho": "kg/m^3", "c": "J/(kg K)"}


def obey(case: Case) -> Case:
    """Return the case with its derived defaults written out, if it breaks no rule.

    Raises
    ------
    InputError
        It breaks one.
    """
    for rule in RULES:
        rule(case)
    update = {
        name: getattr(case, name).model_copy(update=keys) for name, keys in _defaults(case).items()
    }
    if case.damage.split is None:  # written out, it is still no choice of the case
        update["damage"].model_fields_set.discard("split")
    if case.domain.elements is None:
        update["domain"].model_fields_set.discard("elements")
    return case.model_copy(update=update)


def require_loaded(case: Case) -> None:
    """Refuse a case that does not load the body by itself.

    Raises
    ------
    InputError
        Its cooling is incomplete, or nothing acts on the body.
    """
    for rule in LOADED:
        rule(case)


# Displacement unknowns of a 3-D body up to which a factorization serves splits: where a crack keeps
# its stiffness against compaction and no other, multigrid took thousands of iterations a sweep.
FEW = 30_000


def _defaults(case: Case) -> dict[str, dict[str, Any]]:
    """Return the defaults that depend on other keys: table -> keys."""
    two, keys = case.dim == 2, case.material
    absent = set(SIDES[3]) - set(case.outline.faces)
    found: dict[str, dict[str, Any]] = {
        "domain": {"cells": cells_of(case), "elements": elements_of(case)},
        "supports": dict.fromkeys(absent, None),
        "material": {"plane": (keys.plane or "stress") if two and not case.axial else None},
    }
    if keys.stiffness is not None:
        found["material"] |= {"E": None, "nu": None}
    if case.toughness.amplitude and case.toughness.correlation_length is None:
        found["toughness"] = {"correlation_length": _times(case.damage.ell, 2)}
    found["damage"] = {"split": case.damage.split or default_split(case)}
    if found["damage"]["split"] == "star-convex" and case.damage.gamma is None:
        found["damage"]["gamma"] = GAMMA
    found["solver"] = {}
    if found["damage"]["split"] == CONTACT:
        found["damage"]["friction"] = case.damage.friction or 0.0
        if case.damage.friction:  # see `contact_is_possible`
            found["solver"]["stability"] = "none"
    if case.solver.displacement == "auto":
        split = found["damage"]["split"]
        small = displacement_unknowns(case) <= FEW and split != "none"
        found["solver"]["displacement"] = "direct" if two or small else "iterative"
    ones = ONES_OF_HEAT if case.conducts else ONES
    if case.forces is not None and case.forces.gravity is not None:
        ones = ones | {"rho": "kg/m^3"}
    for name, one_unit in ones.items():  # in units only those without effect can have been left out
        if name not in keys.model_fields_set:
            one = Quantity(1.0) if is_scaled(case) else Quantity(1.0, f"1 {one_unit}")
            found["material"][name] = one
    return found


def _times(quantity: Quantity, factor: float) -> Quantity:
    value = factor * quantity
    return Quantity(value, f"{value!r} m" if quantity.has_units else value)

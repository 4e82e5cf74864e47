"""Rules on units: which numbers a case gives, and that all of them have a unit or none."""

from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import is_scaled, quantities
from staffa.errors import InputError
from staffa.units import EXAMPLES, Temperature


def units_are_not_mixed(case: Case) -> None:
    """Require that all quantities have units, or none has.

    Zero is zero in any unit but of temperature, and tau has no unit.
    """
    in_tau = case.time.tau is not None
    written = [(key, q) for key, q in quantities(case) if not (in_tau and key == "output.at")]
    bare = [
        (key, q)
        for key, q in written
        if not q.has_units and (float(q) != 0.0 or isinstance(q, Temperature))
    ]
    with_units = [(key, q) for key, q in written if q.has_units]
    if bare and with_units:
        (key, value), (other, text) = bare[0], with_units[0]
        raise InputError(
            f'{key} = {value.given} has no unit but {other} = "{text.given}" has one; give every '
            f"number a unit, or none"
        )


def nothing_is_one_by_default(case: Case) -> None:
    """Require the rock's numbers of a case in units: their default 1 is for scaled cases."""
    if is_scaled(case):
        return
    needed = {"E": "stress", "Gc": "toughness"}
    if case.material.stiffness is not None:
        del needed["E"]
    if case.conducts:
        needed |= {"expansion": "thermal expansion"}
        needed |= {"k": "conductivity", "rho": "density", "c": "heat capacity"}
    elif case.temperature.acts:
        needed |= {"expansion": "thermal expansion"}
        needed |= {"kappa": "diffusivity"} if case.temperature.cools_a_face else {}
    if case.forces is not None and case.forces.gravity is not None:
        needed |= {"rho": "density"}
    for name, dimension in needed.items():
        if name not in case.material.model_fields_set:
            raise InputError(
                f"material.{name} is missing: only a scaled case has a default for it, 1, and this "
                f'one has units; write it like {name} = "{EXAMPLES[dimension]}"'
            )

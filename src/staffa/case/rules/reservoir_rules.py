"""Rules on the table [reservoir]: what goes with it, and what each simulator needs."""

from staffa.case.schema.case import Case
from staffa.case.schema.fracture_keys import FractureSide
from staffa.case.schema.heat_keys import Even
from staffa.case.schema.quantity_text import is_scaled
from staffa.case.schema.toml_text import as_toml, inline
from staffa.case.values.reservoir_places import beyond, reservoir_cells
from staffa.errors import InputError, choices
from staffa.geometry.block import SIDES

# Where another table gives the pressure of the same water.
PRESSURES = ("pore_pressure", "crack_pressure", "crack_volume")
# What a simulator computes with; files have all of it already.
OF_SIMULATORS = (
    *("temperature", "pressure", "h", "beyond", "thickness", "permeability", "porosity", "boxes"),
    *("water", "fractures", "wells", "tolerance"),
)
NEEDED = {
    "darts": ("temperature", "pressure", "permeability", "porosity", "wells"),
    "single": ("temperature", "pressure", "fractures", "wells"),
    "fields": ("fields",),
}
EXAMPLES = {
    "temperature": '"200 °C"',
    "pressure": '"20 MPa"',
    "permeability": '"1e-15 m^2"',
    "porosity": "0.01",
    "wells": '[{ name = "in", at = [...], rate = "5 kg/s", T = "60 °C" }, ...]',
    "fractures": '[{ side = "bottom", opening = "0.2 mm", height = "0.1 m" }]',
    "fields": '{ t = [...], files = [...], T = "temperature", p = "pressure" }',
}
MOST_CELLS = 2_000_000  # of the reservoir: a step of darts would take hours


def reservoir_has_its_profile(case: Case) -> None:
    """Require the table exactly with temperature.profile = "reservoir", in seconds and SI units."""
    profile = f'temperature.profile = "{case.temperature.profile}"'
    if case.temperature.profile != "reservoir":
        if case.reservoir is not None:
            raise InputError(
                f"[reservoir] has no meaning with {profile}; leave it out or take "
                f'temperature.profile = "reservoir"'
            )
        return
    if case.reservoir is None:
        raise InputError(
            f"[reservoir] is missing: {profile} needs rock, water and wells; "
            f"`staffa new doublet` writes a case with them"
        )
    if case.time.tau is not None:
        raise InputError(
            f"time.tau = {as_toml(case.time.tau)}: the wells of [reservoir] count in seconds; give "
            f"time.t, with units"
        )
    if is_scaled(case):
        raise InputError(
            "[reservoir] needs units, since water has its own properties, and this case is scaled; "
            'give every number a unit, like h = "0.5 m"'
        )


def reservoir_fits_the_body(case: Case) -> None:
    """Require a body that the simulator's cells fill, and rock that conducts alike everywhere."""
    keys = case.reservoir
    if keys is None:
        return
    if case.axial:
        raise InputError(
            f"domain.symmetry = {inline(case.domain.symmetry)}: the cells of [reservoir] do not "
            f"run around an axis; leave it out, or take a 3-D body"
        )
    if keys.simulator == "fields":
        return
    if not case.domain.is_block:
        given = "mesh" if case.domain.mesh else "shape"
        raise InputError(
            f"domain.{given}: the cells of [reservoir] fill a rectangle or a box, and no other "
            f'body; take domain.size, or reservoir.simulator = "fields"'
        )
    if case.dim == 3 and keys.thickness is not None:
        raise InputError(
            f"reservoir.thickness = {inline(keys.thickness)} is of a 2-D body, and this one is "
            f"3-D; leave it out"
        )
    tables = [("material", case.material), *((f"regions.{n}", r) for n, r in case.regions.items())]
    for where, table in tables:
        if isinstance(table.k, tuple):
            raise InputError(
                f"{where}.k = {inline(table.k)}: the cells of [reservoir] conduct alike in all "
                f"directions; give one number"
            )
    for name in ("temperature", "pressure"):
        value = getattr(keys, name)
        if isinstance(value, Even) and len(value.gradient) != case.dim:
            raise InputError(
                f"reservoir.{name}.gradient = {inline(value.gradient)}: it needs {case.dim} "
                f"numbers, as the body is {case.dim}-D"
            )


def reservoir_is_complete(case: Case) -> None:
    """Require what the simulator computes with, and refuse what it does not read."""
    keys = case.reservoir
    if keys is None:
        return
    simulator = f'reservoir.simulator = "{keys.simulator}"'
    for name in NEEDED[keys.simulator]:
        if not getattr(keys, name):
            raise InputError(
                f"reservoir.{name} is missing, which {simulator} needs; write it like {name} = "
                f"{EXAMPLES[name]}"
            )
    refused = OF_SIMULATORS if keys.simulator == "fields" else ("fields",)
    for name in refused:
        if name in keys.model_fields_set and getattr(keys, name):
            why = "whose files tell all of it" if keys.simulator == "fields" else "which computes"
            raise InputError(
                f"reservoir.{name} = {as_toml(getattr(keys, name), 40)} has no meaning with "
                f"{simulator}, {why}; leave one of them out"
            )


def reservoir_is_the_only_water(case: Case) -> None:
    """Refuse another pressure of the same water, and pores that press a plate apart."""
    keys, forces = case.reservoir, case.forces
    if keys is None:
        return
    for name in PRESSURES:
        if forces is not None and getattr(forces, name) is not None:
            raise InputError(
                f"forces.{name} = {as_toml(getattr(forces, name), 40)}: [reservoir] gives the "
                f"pressure of the water, in pores and in cracks; leave it out"
            )
    if forces is not None and forces.biot is not None:
        raise InputError(
            f"forces.biot = {forces.biot:g} goes with forces.pore_pressure; give reservoir.biot"
        )
    if case.plane_stress and keys.biot:
        raise InputError(
            f"reservoir.biot = {keys.biot:g}: in plane stress pores would press the plate apart; "
            f'leave it out (then it is 0), or take material.plane = "strain", or a 3-D body'
        )


def reservoir_sides_are_there(case: Case) -> None:
    """Require known sides in beyond and fractures, each for one of them, and cells to number."""
    keys = case.reservoir
    if keys is None or keys.simulator == "fields":
        return
    sides = SIDES[case.dim]
    for side in keys.beyond:
        if side not in sides:
            raise InputError(
                f"reservoir.beyond.{side}: the body has no such side; {choices(side, sides)}"
            )
    along: set[str] = set()
    for number, fracture in enumerate(keys.fractures, start=1):
        if isinstance(fracture, FractureSide):
            _side_of_fracture(case, f"reservoir.fractures, entry {number}", fracture, along)
            along.add(fracture.side)
    if (cells := reservoir_cells(case)) > MOST_CELLS:
        raise InputError(
            f"reservoir.h gives {cells:.2g} cells of the reservoir, more than the {MOST_CELLS:.0e} "
            f"that it may have; take a larger h, or go less far beyond the body"
        )


def _side_of_fracture(case: Case, where: str, fracture: FractureSide, along: set[str]) -> None:
    side, sides = fracture.side, SIDES[case.dim]
    if side not in sides:
        raise InputError(
            f"{where}, side = {inline(side)}: the body has no such side; {choices(side, sides)}"
        )
    if side in along:
        raise InputError(f"{where}: an entry before it has side = {inline(side)}; leave one out")
    if sides[side] in beyond(case):
        raise InputError(
            f"{where}: the fracture is the end of the reservoir there, and reservoir.beyond.{side} "
            f"goes on; leave one out"
        )
    if fracture.opening >= fracture.height:
        raise InputError(
            f"{where}: opening = {inline(fracture.opening)} does not fit into cells of height = "
            f"{inline(fracture.height)}; take higher ones"
        )

"""Case -> Problem: the objects that a case file stands for."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from staffa.backend.stack import MPI

import numpy as np

from staffa.arguments import require, told
from staffa.case.reading.inspect_mesh import mesh_of
from staffa.case.rules import require_loaded
from staffa.case.scales.case_scales import Numbers, derived_numbers, load
from staffa.case.scales.pace import plan
from staffa.case.scales.surface_cooling import cooled_besides, face_cools
from staffa.case.schema.case import Case, Prescribed
from staffa.case.schema.refine_keys import multiple
from staffa.case.schema.support_keys import DisplacementFile, DisplacementHistory
from staffa.case.values.applied_forces import forces
from staffa.case.values.default_split import for_any_load
from staffa.case.values.elements import elements_of
from staffa.case.values.given_files import factors, in_body
from staffa.case.values.heat_equation import conduction
from staffa.case.values.property_functions import in_space
from staffa.errors import InputError
from staffa.evolution.carry import refined_at_cracks
from staffa.evolution.coupling import in_closed_form
from staffa.evolution.problem import (
    Backtracking,
    Irreversibility,
    Measuring,
    Problem,
    Refinement,
    SecondOrder,
    Solvers,
    Temperatures,
)
from staffa.evolution.schedule import Schedule
from staffa.geometry.shapes import Round, Shape, meshed
from staffa.heat.thermal_body import Conduction
from staffa.loads.closed_form import CoupledLoad, Load, pressure_of
from staffa.loads.forces import Forces
from staffa.model.domain import Domain, block, body
from staffa.model.supports import (
    Displacement,
    GeneralizedPlaneStrain,
    SideSupport,
    clamped,
    no_displacement,
    rollers,
)
from staffa.physics.damage import DamageLaw
from staffa.physics.scales import tau_of_time
from staffa.physics.split import EnergySplit
from staffa.records.step import Stop
from staffa.setup.field_coverage import check_files
from staffa.setup.rock import check_rock, materials, region_boxes, toughness_boxes
from staffa.setup.simulators import reservoir_load
from staffa.setup.user_objects import Given, known_load, try_given

CASE = "give a Case, as staffa.read_case(path) or staffa.ready_case(name) makes one"
COMM = "give a communicator of mpi4py, like MPI.COMM_WORLD"


def problem(
    case: Case,
    *,
    comm: MPI.Comm = MPI.COMM_WORLD,
    damage: DamageLaw | None = None,
    split: EnergySplit | None = None,
    temperature: Load | CoupledLoad | None = None,
) -> Problem:
    """Build the mesh and everything else that a case describes. Collective.

    Parameters
    ----------
    case : the case.
    comm : the ranks that share the mesh.
    damage, split, temperature : a law, an energy split, a load of your own, in place of the case's.
        They are tried at samples; with a load of your own the case need not load the body itself,
        and takes the split that is safe whatever the load does, unless the case gives one.

    Raises
    ------
    InputError
        One of them is not what the theory needs, or nothing loads the body.
    """
    require(case, Case, "case", CASE)
    require(comm, MPI.Comm, "comm", COMM)
    if temperature is None:
        require_loaded(case)
    else:
        case = for_any_load(case)
    try_given(Given(damage=damage, split=split), case)
    derived = derived_numbers(case, law=damage, split=split, own_load=temperature is not None)
    keys = case.solver
    domain = body_of(case, comm)
    material, regions = materials(case, derived, domain.h, split)
    check_rock(case, domain)
    check_files(case, domain)
    times = plan(case, derived)
    found = Problem(
        domain=domain,
        elements=elements_of(case),
        material=material,
        regions=regions,
        load=_load(case, derived, temperature, domain, times),
        temperatures=_temperatures(case),
        forces=_forces(case, temperature),
        schedule=times,
        sides=side_supports(case, domain),
        section=_section(case),
        anchor=_anchor(case),
        face=derived.face,
        tau_of=None if temperature is not None else _tau(case, derived),
        irreversibility=Irreversibility(
            crack_set_only=case.damage.irreversibility == "crack set",
            threshold=case.damage.crack_set_threshold,
        ),
        solvers=Solvers(
            displacement=keys.displacement,
            damage=keys.damage,
            acceleration=keys.acceleration,
            guess=keys.guess,
            stop=Stop(change=keys.change, residual=keys.residual, sweeps=keys.sweeps),
        ),
        backtracking=(
            Backtracking(tolerance=keys.backtracking_tolerance) if keys.backtracking else None
        ),
        second_order=None if keys.stability == "none" else SecondOrder(kind=keys.stability),
        measuring=Measuring(
            depths=tuple(float(d) for d in case.measures.depths),
            threshold=case.measures.threshold,
            cooled=cooled_besides(case) if temperature is None else (),
            cools=temperature is not None or face_cools(case),
        ),
        refinement=_refinement(case, material.ell),
    )
    return refined_at_cracks(found)


def _forces(case: Case, own: Load | CoupledLoad | None) -> Forces:
    """Return the forces of a case, and of the pressure that a script's load gives."""
    if case.reservoir is not None and own is not None and in_closed_form(own):
        raise InputError(
            f"temperature = {told(own)}: it takes the place of [reservoir], whose water would then "
            f'press nowhere; take that table out of the case, with temperature.profile = "none"'
        )
    found = forces(case)
    if pressure_of(own) is None:
        return found
    if found.pore_pressure is not None or found.in_cracks:
        raise InputError(
            f"temperature = {told(own)}: it gives the pressure of the fluid in pores and cracks, "
            f"and so does [forces] of the case; leave one of them out"
        )
    # In plane stress pores would press the plate apart.
    biot = 0.0 if case.plane_stress else found.biot
    return replace(found, fluid=True, biot=biot, balanced=found.prestress is None)


def _load(
    case: Case, derived: Numbers, own: Load | CoupledLoad | None, domain: Domain, plan: Schedule
) -> Load | CoupledLoad | Conduction:
    """Return the source of the temperature; one of a script's own is tried. Collective."""
    if own is None and case.reservoir is not None:
        return reservoir_load(case)
    if own is None:
        return conduction(case) if case.heat else load(case, derived)
    known_load(own, domain, (plan.times[0], plan.times[-1]))
    return own


def _temperatures(case: Case) -> Temperatures | None:
    """Return the temperatures from which the body changes, where the case knows them."""
    keys = case.heat
    if keys is None:
        return None
    initial = in_space(keys.initial, case.dim)
    given = keys.stress_free
    return Temperatures(
        initial=initial, stress_free=initial if given is None else in_space(given, case.dim)
    )


def body_of(case: Case, comm: MPI.Comm) -> Domain:
    """Return the body of a case, from its block, its shape or its mesh. Collective."""
    keys = case.domain
    if keys.file is not None:
        h = None if keys.h is None else float(keys.h)
        make = partial(mesh_of, keys.file, float(keys.unit or 1.0), str(keys.mesh))
        return body(comm, make, h=h, graded=True, axial=case.axial, halvings=keys.halvings)
    assert keys.h is not None
    if keys.shape is not None:
        return _shaped(comm, keys.shape.shape(), float(keys.h), case.axial, keys.halvings)
    assert keys.size is not None
    size = tuple(float(s) for s in keys.size)
    return block(
        comm,
        size=size,
        h=float(keys.h),
        cells=str(keys.cells),
        parts=region_boxes(case),
        axial=case.axial,
        hole=float(keys.hole or 0.0),
        halvings=keys.halvings,
        uneven=toughness_boxes(case),
    )


def _shaped(comm: MPI.Comm, shape: Shape, h: float, axial: bool, halvings: int = 0) -> Domain:
    """Return a shape with cells of mean edge h, at first or after some halvings.

    Points on the surface of a round one lie outside of its coarser cells, so that nothing can be
    brought from these; around a hole they lie inside.
    """
    coarser = None
    if not halvings and not isinstance(shape, Round):
        coarser = partial(_shaped, comm, shape, 2 * h, axial)
    make = partial(meshed, shape, 2**halvings * h, "domain.shape")
    return body(comm, make, coarser, axial=axial, halvings=halvings)


def _refinement(case: Case, ell: float) -> Refinement | None:
    """Return when cells are split, where they may be."""
    keys = case.domain.refining
    if not case.domain.halvings or keys is None:
        return None
    return Refinement(ahead=multiple(keys.ahead) * ell, drive=keys.drive, drop=keys.drop)


def _anchor(case: Case) -> str | None:
    """Return the boundary across from the face that depths count from, None without one."""
    keys = case.temperature
    return case.outline.across(keys.face) if keys.has_face else None


def _tau(case: Case, derived: Numbers) -> Callable[[float], float] | None:
    """Return tau of a time; None where nothing is known to diffuse below a face."""
    if derived.face is None or not derived.cooled:
        return None
    return lambda t: tau_of_time(t, kappa=derived.kappa, L=derived.L)


def _section(case: Case) -> GeneralizedPlaneStrain | None:
    if case.supports.section in ("stretch", "free"):
        return GeneralizedPlaneStrain(bending=case.supports.section == "free")
    return None


def side_supports(case: Case, domain: Domain) -> tuple[SideSupport, ...]:
    """Return the supports of a case, side by side; a section's rollers included."""
    held_by_section = {"none": (), "fixed": ("left", "right")}.get(case.supports.section, ("left",))
    found = []
    for side in domain.boundaries:
        support = case.supports.on(side)
        if side in held_by_section or support == "rollers":
            found.append(rollers(domain, side))
        elif support == "clamped":
            found.append(clamped(domain, side))
        elif isinstance(support, Prescribed):
            found.append(SideSupport(side=side, components=_components(case, support)))
    return tuple(found)


def _components(case: Case, support: Prescribed) -> dict[int, Displacement]:
    given = {axis: getattr(support, name) for axis, name in enumerate("xyz")}
    return {axis: _in_time(case, value) for axis, value in given.items() if value is not None}


def _in_time(case: Case, value: float | DisplacementHistory | DisplacementFile) -> Displacement:
    if isinstance(value, DisplacementFile):
        (t, u), field = factors(value), in_body(case, value)
        return lambda x, time: float(np.interp(time, t, u)) * field(x)
    if isinstance(value, DisplacementHistory):
        t, u = np.array(value.t, dtype=float), np.array(value.u, dtype=float)
        return lambda x, time: float(np.interp(time, t, u))
    constant = float(value)
    return (lambda x, time: constant) if constant else no_displacement

"""Facts on the cost of a run: cells, unknowns, steps, memory and time."""

from staffa.case.check.circulation_facts import reservoir_cost
from staffa.case.check.cost import WITHIN, Steps, duration, memory, steps, unknowns_of
from staffa.case.check.mesh_warnings import cell_edge
from staffa.case.check.refined_cells import CELLS_WITHIN, MeshGrowth, MeshSize, mesh_growth
from staffa.case.rules import adaptive
from staffa.case.rules.refine_rules import refinement_is_possible
from staffa.case.scales.case_scales import Numbers
from staffa.case.scales.pace import prescribed_knots
from staffa.case.scales.prescribed import visited_times
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount, as_duration
from staffa.case.schema.toml_text import inline
from staffa.errors import InputError
from staffa.geometry.block import section_raster

Fact = tuple[str, str, str]
# A mesh that follows the cracks is named if a run with it is as many times shorter.
PAYS = 2.0
SHOWN = 6  # times of a table that are listed


def cost_facts(case: Case, derived: Numbers) -> list[Fact]:
    """Return cells, unknowns, steps, memory and time of a run."""
    planned, growth = steps(case, derived), mesh_growth(case)
    refined = growth.start != growth.most
    more = " or more" if planned.open else ""
    return [
        *(_growing(case, growth) if refined else _cells(case, growth.most)),
        (
            "steps",
            f"{planned.number}{more}",
            "each of tens to hundreds of sweeps where cracks move",
        ),
        *_knots(case),
        *_planes(case),
        ("memory", f"about {memory(case) / 1e9:.2g} GB", f"{case.solver.displacement} solver"),
        ("time", *_time(case, planned)),
        *_with_refinement(case, planned),
        *reservoir_cost(case, planned),
    ]


def _cells(case: Case, size: MeshSize) -> list[Fact]:
    """Return cells and unknowns of a mesh that stays as it is."""
    about = "about " if case.domain.has_simplices and case.domain.mesh is None else ""
    unknowns, fields = _unknowns(case, size)
    return [
        ("cells", f"{about}{size.cells:,}", str(case.domain.cells)),
        ("unknowns", about + unknowns, fields),
    ]


def _growing(case: Case, growth: MeshGrowth) -> list[Fact]:
    """Return cells and unknowns at the start and the end of a mesh that follows the cracks."""
    many, most = f"{growth.end.cells:,}", f"{growth.most.cells:,}"
    end, how = f"at most {many}", "only the run can tell where it cracks"
    if growth.known:
        end = f"about {many}"
        how = f"from the depth of the cooling, within a factor of {CELLS_WITHIN:g}"
    unknowns, fields = _unknowns(case, growth.end)
    begin = f"{case.domain.cells}, the coarse mesh"
    if case.regions and case.domain.is_block:
        begin += "; more at the boundaries of regions"
    return [
        ("cells, start", f"about {growth.start.cells:,}", begin),
        ("cells, end", end, f"{how}; {most} if all were h long"),
        ("unknowns, end", f"{end.split(many)[0]}{unknowns}", fields),
    ]


def _unknowns(case: Case, size: MeshSize) -> tuple[str, str]:
    """Return the numbers of unknowns on a mesh, and of which fields."""
    unknowns, fields = f"{unknowns_of(case, size):,} + {size.vertices:,}", "displacement and damage"
    if case.heat is not None:
        return f"{unknowns} + {size.vertices:,}", "displacement, damage and temperature"
    return unknowns, fields


def _knots(case: Case) -> list[Fact]:
    """Return the times at which steps that adapt end because something prescribed turns there."""
    if adaptive(case) is None:
        return []
    visited, facts = visited_times(case), []
    for where, told in prescribed_knots(case).items():
        times = [t for t in told.times.tolist() if t > 0 and t not in visited]
        if times:
            listed = ", ".join(amount(case, t, "s") for t in times[:SHOWN])
            more = f" and {len(times) - SHOWN} more" if len(times) > SHOWN else ""
            turns = f"jumps, extremes and kinks of {where}"
            within = f", linear between them within {told.depart:.2g} of its range"
            facts.append(("steps end at", listed + more, turns + (within if told.depart else "")))
    return facts


def _time(case: Case, planned: Steps) -> tuple[str, str]:
    """Return the time of the run in words, and how well it is known."""
    seconds = duration(case, planned.number)
    low, high = (as_duration(seconds * factor) for factor in (1 / WITHIN, WITHIN))
    slower = {
        "stability": case.solver.stability in ("report", "follow"),
        "backtracking": case.solver.backtracking,
    }
    asked = [f"solver.{name}" for name, given in slower.items() if given]
    beyond = [*(["each step that cracks make shorter"] if planned.open else []), *asked]
    more = f"; more for {' and '.join(beyond)}" if beyond else ""
    return f"about {as_duration(seconds)}", f"on one core: between {low} and {high}{more}"


def _with_refinement(case: Case, planned: Steps) -> list[Fact]:
    """Return the cost on a mesh that follows the cracks, where a run is much shorter with it."""
    keys = case.domain
    if keys.refining is not None:
        return []
    change: dict[str, object] = {"refine": True}
    if keys.is_block and not keys.has_simplices:
        change["cells"] = {2: "triangle", 3: "tetrahedron"}[case.dim]
    other = case.model_copy(update={"domain": keys.model_copy(update=change)})
    try:
        refinement_is_possible(other)
    except InputError:
        return []
    growth, seconds = mesh_growth(other), duration(other, planned.number)
    if not growth.known or PAYS * seconds > duration(case, planned.number):
        return []
    cells = f"about {growth.end.cells:,} cells at the end, {as_duration(seconds)}"
    keys_given = " and ".join(f"domain.{key} = {inline(value)}" for key, value in change.items())
    return [("if refined", cells, f"with {keys_given}, which follows the cracks")]


def _planes(case: Case) -> list[Fact]:
    """Return the sections of a 3-D body at which columns are measured."""
    depths = case.measures.depths
    if case.dim == 2 or not depths:
        return []
    axis = case.outline.axis(case.temperature.face)
    one, other = (length for k, length in enumerate(case.outline.size) if k != axis)
    across, along = section_raster((one, other), cell_edge(case)).counts
    counted = f"{len(depths)} of {across} x {along} pixels"
    return [("sections", counted, "the cells that cracks cut out there, at every step")]

"""The house: imports point down, packages on a floor are strangers, the light half stays light."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(__file__).parent.parent / "src" / "staffa"

# The floors of docs/architecture.md. A package is named by its folder, a module by its file.
FLOORS = [
    {"errors", "arguments", "units", "display_units", "records", "backend", "geometry"},
    {"physics"},
    {"loads", "properties"},
    {"model"},
    {"minimize", "heat", "measure", "io"},
    {"evolution"},
    {"case.schema", "case.ready"},
    {"case.values"},
    {"case.rules"},
    {"case.reading"},
    {"case.scales"},
    {"case.check"},
    {"setup"},
    {"runs"},
    {"plot", "doctor"},
    {"results"},
    {"compare"},
    {"report"},
    {"cli"},
]
# Modules of one floor that serve others of it.
WITHIN = {
    "arguments": ["errors"],
    "units": ["display_units", "errors"],
    "records": ["display_units"],
    "backend": ["errors"],
    "geometry": ["errors"],
}
LIGHT = [
    "staffa",
    "staffa.arguments",
    "staffa.errors",
    "staffa.backend.isolation",
    "staffa.backend.guarded_reading",
    "staffa.units",
    "staffa.display_units",
    "staffa.records.step",
    "staffa.records.json_form",
    "staffa.records.tip_release",
    "staffa.records.manifest",
    "staffa.geometry.block",
    "staffa.geometry.block_simplices",
    "staffa.geometry.shapes",
    "staffa.geometry.layer",
    "staffa.physics.damage",
    "staffa.physics.doubling",
    "staffa.physics.elasticity",
    "staffa.physics.locking",
    "staffa.physics.material",
    "staffa.physics.scales",
    "staffa.physics.split",
    "staffa.physics.trial",
    "staffa.loads.forces",
    "staffa.loads.closed_form",
    "staffa.heat.thermal_body",
    "staffa.measure.statistics",
    "staffa.measure.generations",
    "staffa.measure.tip",
    "staffa.measure.cells",
    "staffa.measure.patterns",
    "staffa.measure.averages",
    "staffa.measure.tracing",
    "staffa.io.network_files",
    "staffa.io.run_directory",
    "staffa.io.ensemble_directory",
    "staffa.io.checkpoint",
    "staffa.io.lock",
    "staffa.io.vtkhdf",
    "staffa.evolution.output_fields",
    "staffa.evolution.schedule",
    "staffa.case.reading.ready_cases",
    "staffa.case.check.preview",
    "staffa.case.check.warnings",
    "staffa.properties.formula",
    "staffa.case.values.heat_equation",
    "staffa.case.scales.surface_cooling",
    "staffa.case.values.subdomains",
    "staffa.properties.random_field",
    "staffa.properties.mesh_field",
    "staffa.case.reading.read",
    "staffa.case.rules",
    "staffa.case.schema.toml_text",
    "staffa.plot",
    "staffa.report",
    "staffa.results.sections",
    "staffa.results.ensemble_means",
    "staffa.results.spacing",
    "staffa.compare.open_pair",
    "staffa.compare.side_by_side",
    "staffa.doctor",
    "staffa.cli",
]


def room(parts: list[str]) -> str:
    """The room of the floors that a module belongs to, by its name's parts after `staffa`."""
    return ".".join(parts[: 2 if parts[0] == "case" else 1])


def place(path: Path) -> str:
    return room(list(path.relative_to(SOURCE).with_suffix("").parts))


def floor(name: str) -> int:
    return next(number for number, names in enumerate(FLOORS) if name in names)


def imports(path: Path) -> set[str]:
    """Rooms of staffa that a file imports from, wherever in it the import stands."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are written in full"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        found |= {room(name.split(".")[1:]) for name in names if name.startswith("staffa.")}
    return found


FILES = sorted(
    path
    for path in SOURCE.rglob("*.py")
    if path.parent != SOURCE / "case" and path != SOURCE / "__init__.py"
)


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(SOURCE)))
def test_imports_point_down(path: Path) -> None:
    here = place(path)
    for there in imports(path) - {here}:
        allowed = floor(there) < floor(here) or there in WITHIN.get(here, [])
        assert allowed, f"{here} (floor {floor(here)}) imports {there} (floor {floor(there)})"


def test_every_module_has_a_floor() -> None:
    assert {place(path) for path in FILES} <= set().union(*FLOORS)


def test_light_half_loads_without_the_finite_element_stack() -> None:
    code = (
        "import sys, importlib\n"
        f"for name in {LIGHT!r}: importlib.import_module(name)\n"
        "heavy = {'dolfinx', 'petsc4py', 'mpi4py', 'ufl', 'dolfinx_solver'} & set(sys.modules)\n"
        "sys.exit(', '.join(sorted(heavy)) or 0)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.returncode == 0, f"the light half loads {done.stderr}"


@pytest.mark.parametrize("path", FILES, ids=lambda path: str(path.relative_to(SOURCE)))
def test_no_file_is_long(path: Path) -> None:
    lines = len(path.read_text().splitlines())
    assert lines <= 400, f"{lines} lines: split it"

"""The house: imports point down, packages on a floor are strangers, the light half stays light."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

SOURCE = Path(__file__).parent.parent / "src" / "staffa"

# The floors of docs/architecture.md. A package is named by its folder, a module by its file.
FLOORS = [
    {
        *(
            "errors",
            "units",
            "display_units",
            "records",
            "cell_records",
            "json_form",
            "release",
            "manifest",
            "options",
            "parallel",
            "stack",
            "grid",
            "jit",
        ),
        *("unstructured", "geometry", "arguments", "surroundings", "apart", "one_file"),
    },
    {"physics"},
    {"axis", "domain", "fields", "cut", "quadrature"},
    {
        "energy",
        "contact",
        "densities",
        "external",
        "openings",
        "strain",
        "supports",
        "loads",
        "thermal",
    },
    {"minimize", "heat", "measure", "io"},
    {"evolution"},
    {"cases"},
    {"report", "plot", "doctor"},
    {"cli"},
]
# Modules of one floor that serve others of it.
WITHIN = {
    "apart": ["errors", "surroundings"],
    "arguments": ["errors"],
    "units": ["display_units", "errors"],
    "records": ["cell_records", "json_form", "release"],
    "manifest": ["display_units", "records"],
    "stack": ["errors", "surroundings"],
    "parallel": ["errors", "stack"],
    "options": ["errors", "parallel", "stack"],
    "jit": ["errors", "parallel", "stack", "surroundings"],
    "unstructured": ["errors", "geometry"],
    "geometry": ["errors", "grid", "one_file", "surroundings"],
    "one_file": ["errors"],
    "axis": ["domain", "fields"],
    "fields": ["domain"],
    "cut": ["fields"],
    "quadrature": ["axis", "domain"],
    "external": ["loads", "strain"],
    "densities": ["strain"],
    "energy": ["contact", "densities", "external", "loads", "openings", "strain", "thermal"],
    "report": ["plot"],
}
LIGHT = [
    "staffa",
    "staffa.arguments",
    "staffa.errors",
    "staffa.surroundings",
    "staffa.apart",
    "staffa.units",
    "staffa.display_units",
    "staffa.records",
    "staffa.json_form",
    "staffa.release",
    "staffa.manifest",
    "staffa.grid",
    "staffa.unstructured",
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
    "staffa.heat.body",
    "staffa.measure.statistics",
    "staffa.measure.generations",
    "staffa.measure.tip",
    "staffa.measure.cells",
    "staffa.measure.patterns",
    "staffa.measure.averages",
    "staffa.measure.tracing",
    "staffa.io.network",
    "staffa.io.run_directory",
    "staffa.io.ensemble_directory",
    "staffa.io.checkpoint",
    "staffa.io.lock",
    "staffa.io.vtkhdf",
    "staffa.evolution.schedule",
    "staffa.cases.catalog",
    "staffa.cases.preview",
    "staffa.cases.cautions",
    "staffa.cases.formula",
    "staffa.cases.heat",
    "staffa.cases.exchange",
    "staffa.cases.pieces",
    "staffa.cases.random_field",
    "staffa.cases.field_file",
    "staffa.cases.reading",
    "staffa.cases.rules",
    "staffa.cases.writing",
    "staffa.plot",
    "staffa.report",
    "staffa.report.planes",
    "staffa.report.ensemble",
    "staffa.report.spacing",
    "staffa.report.pair_reading",
    "staffa.report.results",
    "staffa.doctor",
    "staffa.cli",
]


def place(path: Path) -> str:
    """The package or module of the top level that a file belongs to."""
    return path.relative_to(SOURCE).parts[0].removesuffix(".py")


def floor(name: str) -> int:
    return next(number for number, names in enumerate(FLOORS) if name in names)


def imports(path: Path) -> set[str]:
    """Top-level parts of staffa that a file imports, wherever in it the import stands."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: imports are written in full"
            names = [node.module or ""]
            if node.module == "staffa":
                names = [f"staffa.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        found |= {name.split(".")[1] for name in names if name.startswith("staffa.")}
    return found


FILES = sorted(path for path in SOURCE.rglob("*.py") if path != SOURCE / "__init__.py")


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

"""The floors of the house, and the imports of a module that break them."""

import ast
from collections.abc import Iterator
from pathlib import Path

# The floors of docs/development/architecture.md. A package is named by its folder, a module by its
# file.
FLOORS = [
    {"errors", "arguments", "units", "display_units", "records", "backend"},
    {"geometry"},
    {"physics"},
    {"loads", "properties"},
    {"model"},
    {"minimize", "heat", "measure", "io", "reservoir"},
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
    "backend": ["errors", "records"],
}
LIGHT = [
    "staffa",
    "staffa.arguments",
    "staffa.errors",
    "staffa.backend.isolation",
    "staffa.backend.guarded_reading",
    "staffa.units",
    "staffa.display_units",
    "staffa.records.status",
    "staffa.records.case_about",
    "staffa.records.step",
    "staffa.records.json_form",
    "staffa.records.tip_release",
    "staffa.records.circulation",
    "staffa.records.crack_flow",
    "staffa.records.manifest",
    "staffa.records.reservoir_facts",
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
    "staffa.reservoir.grid",
    "staffa.reservoir.simulator",
    "staffa.reservoir.describe_model",
    "staffa.measure.statistics",
    "staffa.measure.generations",
    "staffa.measure.tip",
    "staffa.measure.cells",
    "staffa.measure.patterns",
    "staffa.measure.averages",
    "staffa.measure.tracing",
    "staffa.io.network_files",
    "staffa.io.production_rows",
    "staffa.io.reservoir_fields",
    "staffa.io.run_directory",
    "staffa.io.ensemble_directory",
    "staffa.io.study_directory",
    "staffa.io.run_progress",
    "staffa.io.checkpoint",
    "staffa.backend.lock",
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
    "staffa.properties.mesh_parts",
    "staffa.properties.vtk_mesh",
    "staffa.case.reading.read",
    "staffa.case.reading.study_points",
    "staffa.case.rules",
    "staffa.case.schema.toml_text",
    "staffa.plot",
    "staffa.report",
    "staffa.results.sections",
    "staffa.results.ensemble_means",
    "staffa.results.study_curves",
    "staffa.results.spacing",
    "staffa.compare.open_pair",
    "staffa.compare.side_by_side",
    "staffa.doctor",
    "staffa.cli",
]


def room(parts: list[str]) -> str:
    """Return the room of the floors that a module belongs to.

    Parameters
    ----------
    parts
        Parts of its full name after `staffa`.
    """
    return ".".join(parts[: 2 if parts[0] == "case" else 1])


def place(path: Path, package: Path) -> str:
    """Return the room of a file.

    Parameters
    ----------
    path
        The file.
    package
        Folder of the package that it belongs to.
    """
    return room(list(path.relative_to(package).with_suffix("").parts))


def floor(name: str) -> int:
    """Return the number of the floor of a room."""
    return next(number for number, names in enumerate(FLOORS) if name in names)


def files(package: Path) -> list[Path]:
    """Return the files that stand on a floor: all but `__init__` of the package and of `case`."""
    return sorted(
        path
        for path in package.rglob("*.py")
        if path.parent != package / "case" and path != package / "__init__.py"
    )


def imports(path: Path) -> Iterator[tuple[int, str]]:
    """Yield line and room of each import from staffa, wherever in a file it stands."""
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            if node.level:
                raise SyntaxError(f"{path}:{node.lineno}: imports are written in full")
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        for name in names:
            if name.startswith("staffa."):
                yield node.lineno, room(name.split(".")[1:])


def pointing_up(path: Path, package: Path) -> list[tuple[int, str]]:
    """Return line and sentence of each import that does not point down.

    Parameters
    ----------
    path
        The file.
    package
        Folder of the package that it belongs to.
    """
    here = place(path, package)
    return [
        (line, f"{here} (floor {floor(here)}) imports {there} (floor {floor(there)})")
        for line, there in imports(path)
        if there != here and floor(there) >= floor(here) and there not in WITHIN.get(here, [])
    ]

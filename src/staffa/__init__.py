"""staffa predicts how cooling cracks rock: where cracks start, which way they run, which stop."""

from importlib import import_module
from typing import Any

# Loaded when first used, so that `import staffa` needs no finite-element stack.
_WHERE = {
    "Case": "staffa.case.schema.case",
    "read_case": "staffa.case.reading.read",
    "parse_case": "staffa.case.reading.read",
    "ready_case": "staffa.case.reading.ready_cases",
    "problem": "staffa.setup.build",
    "run": "staffa.runs.run",
    "resume": "staffa.runs.resume",
    "build": "staffa.evolution.system",
    "march": "staffa.evolution.march",
    "read_run": "staffa.io.run_directory",
    "StepQuantity": "staffa.evolution.step_quantities",
}
__all__ = sorted(_WHERE)


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"staffa has no '{name}'; it has {', '.join(__all__)}")
    return getattr(import_module(_WHERE[name]), name)

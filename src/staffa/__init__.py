"""staffa predicts how cooling cracks rock: where cracks start, which way they run, which stop."""

from importlib import import_module
from typing import Any

# Loaded when first used, so that `import staffa` needs no finite-element stack.
_WHERE = {
    "Case": "staffa.cases.model",
    "read_case": "staffa.cases.reading",
    "parse_case": "staffa.cases.reading",
    "ready_case": "staffa.cases.catalog",
    "problem": "staffa.cases.build",
    "run": "staffa.cases.experiment",
    "resume": "staffa.cases.resume",
    "build": "staffa.evolution.system",
    "march": "staffa.evolution.march",
    "read_run": "staffa.io.run_directory",
}
__all__ = sorted(_WHERE)


def __getattr__(name: str) -> Any:
    if name not in _WHERE:
        raise AttributeError(f"staffa has no '{name}'; it has {', '.join(__all__)}")
    return getattr(import_module(_WHERE[name]), name)

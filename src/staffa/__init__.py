"""staffa predicts how cooling cracks rock: where cracks start, which way they run, which stop."""

from importlib import import_module
from typing import TYPE_CHECKING

# Editors and type checkers read the first part. Python runs the second one, which loads a name
# when it is first used, so that `import staffa` needs no finite-element stack.
if TYPE_CHECKING:
    from staffa.case.reading.read import parse_case as parse_case
    from staffa.case.reading.read import read_case as read_case
    from staffa.case.reading.ready_cases import ready_case as ready_case
    from staffa.case.schema.case import Case as Case
    from staffa.evolution.march import march as march
    from staffa.evolution.step_quantities import StepQuantity as StepQuantity
    from staffa.evolution.system import build as build
    from staffa.io.run_directory import open_run as open_run
    from staffa.report.inline import Pictures as Pictures
    from staffa.report.inline import pictures_of as pictures_of
    from staffa.results.crack_effect import crack_effect as crack_effect
    from staffa.runs.resume import resume as resume
    from staffa.runs.run import run as run
    from staffa.setup.build import problem as problem
else:
    _WHERE = {
        "Case": "staffa.case.schema.case",
        "Pictures": "staffa.report.inline",
        "StepQuantity": "staffa.evolution.step_quantities",
        "build": "staffa.evolution.system",
        "crack_effect": "staffa.results.crack_effect",
        "march": "staffa.evolution.march",
        "open_run": "staffa.io.run_directory",
        "parse_case": "staffa.case.reading.read",
        "pictures_of": "staffa.report.inline",
        "problem": "staffa.setup.build",
        "read_case": "staffa.case.reading.read",
        "ready_case": "staffa.case.reading.ready_cases",
        "resume": "staffa.runs.resume",
        "run": "staffa.runs.run",
    }
    __all__ = sorted(_WHERE)

    def __getattr__(name: str) -> object:
        if name not in _WHERE:
            raise AttributeError(f"staffa has no '{name}'; it has {', '.join(__all__)}")
        return getattr(import_module(_WHERE[name]), name)

    def __dir__() -> list[str]:
        return sorted({*globals(), *__all__})

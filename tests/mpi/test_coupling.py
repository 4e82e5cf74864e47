"""A source of temperatures from outside on several ranks."""

import sys
from pathlib import Path

from fem.test_coupling import WaterBath
from staffa.io.run_directory import open_run
from staffa.runs.run import run as run_case
from support.paths import TESTS
from support.restarting import assert_same, launch, small

RANKS = """
from fem.test_coupling import *

directory, bath = Path({directory!r}), WaterBath(rate=800.0, felt=0.5)
watcher = Watcher(stop=After(20))
stopped(lambda: run_case(small(), directory, temperature=bath, watcher=watcher))
resume(directory, temperature=bath)
"""


def test_on_two_ranks_a_source_remembers_on_the_first_alone(tmp_path: Path) -> None:
    """Started, stopped and finished there, against one rank without a cut."""
    run_case(small(), tmp_path / "whole", temperature=WaterBath(rate=800.0, felt=0.5))
    code = f"import sys\nsys.path.insert(0, {str(TESTS)!r})\n"
    code += RANKS.format(directory=str(tmp_path / "cut"))
    done = launch(Path(sys.executable).name, "-c", code, ranks=2)
    assert done.returncode == 0, done.stderr
    assert_same(open_run(tmp_path / "cut"), open_run(tmp_path / "whole"), rel=1e-6)

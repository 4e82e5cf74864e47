"""`staffa doctor` of an installation that is whole: it starts mpiexec."""

import os
from pathlib import Path

from run.test_doctor import doctor
from staffa.doctor import OK
from support.paths import BIN


def test_a_sound_installation_passes_and_leaves_nothing(tmp_path: Path) -> None:
    code, found = doctor(tmp_path, PATH=f"{BIN}{os.pathsep}{os.environ['PATH']}")
    wrong = {name: said for name, (verdict, said) in found.items() if verdict != OK}
    # A sound installation may be without a simulator; then it says so.
    absent = "There is no reservoir simulator" in wrong.get("reservoir", "")
    assert set(wrong) <= ({"reservoir"} if absent else set()) and code == 0, wrong
    assert found["ranks"] == (OK, "the ready case bar, 441 unknowns, breaks as it should")
    assert not list(tmp_path.iterdir())

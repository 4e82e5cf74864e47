"""The ready cases with the heat equation, coarse and short, from the command line."""

import pytest

from run.test_run import CASES, launch
from staffa.io.run_directory import open_run

COARSE = {
    "granite-face": (
        "domain.h=0.1 m", "damage.ell=0.3 m", 't={start="1 hour", stop="12 hours", steps=3}',
        'at=["12 hours"]',
    ),
    "glass-slab": (
        "domain.h=1 mm", "damage.ell=3 mm", 't=["1 s", "5 s", "12 s"]', 'at=["12 s"]',
    ),
    "ceramic-strip": (
        "domain.h=0.2 mm", "damage.ell=0.6 mm", "tau=[0.1, 0.3, 0.5]", "at=[0.5]",
    ),
    "ceramic-quench": (
        "domain.h=1 mm", "damage.ell=3 mm", "tau=[0.3, 0.5]", "at=[0.5]",
    ),
    "wellbore": (
        "domain.h=3 cm", "damage.ell=9 cm", 't=["10 min", "1 hour"]', 'at=["1 hour"]',
    ),
}  # fmt: skip


def settings(name: str, *more: str) -> list[str]:
    h, ell, times, at = COARSE[name]
    given = (h, ell, "measures.depths=[]", f"time={{{times}}}", f"output.{at}", *more)
    return [f"--set={setting}" for setting in given]


@pytest.mark.slow
@pytest.mark.parametrize("cracks", ['{h="1000 W/(m^2 K)", T="150 °C"}', "{conductivity=1e-3}"])
def test_cracks_that_heat_feels_from_a_case_file(cracks: str, tmp_path) -> None:
    out = tmp_path / "run"
    given = settings("granite-face", f"heat.cracks={cracks}", "solver.backtracking=true")
    done = launch(1, "run", CASES / "granite-face.toml", "--quiet", "--out", out, *given)
    assert done.returncode == 0, done.stderr
    run = open_run(out)
    assert all(step.audit.violations == () for step in run.steps)
    if "h=" in cracks:
        assert run.steps[-1].heat.entered["cracks"] != 0

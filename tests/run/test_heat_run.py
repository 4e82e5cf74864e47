"""The ready cases with the heat equation, coarse and short, from the command line."""

import pytest

from run.test_run import CASES, launch
from staffa.io.run_directory import read_run
from staffa.io.vtkhdf import read_vtkhdf
from support.bodies import needs_gmsh

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


BEHIND_FILMS = ("glass-slab", "wellbore")
NAMES = [
    "granite-face",
    pytest.param("wellbore", marks=[needs_gmsh, pytest.mark.long]),
    *(
        pytest.param(name, marks=pytest.mark.long)
        for name in ("glass-slab", "ceramic-strip", "ceramic-quench")
    ),
]


@pytest.mark.mpi
@pytest.mark.parametrize("name", NAMES)
def test_a_ready_case_runs_in_units_on_one_and_two_ranks(name: str, tmp_path) -> None:
    runs = []
    for ranks in (1, 2):
        out = tmp_path / f"{ranks}"
        done = launch(ranks, "run", CASES / f"{name}.toml", "--out", out, *settings(name))
        assert done.returncode == 0, done.stderr
        assert "heat" in done.stdout and (out / "pictures" / "heat.png").exists()
        runs.append(read_run(out))
    for one, two in zip(runs[0].steps, runs[1].steps, strict=True):
        assert one.audit.violations == () and one.heat.imbalance < 1e-8
        assert two.heat.stored == pytest.approx(one.heat.stored, rel=1e-7)
        assert two.energies.total == pytest.approx(one.energies.total, rel=1e-5)
    _, fields = read_vtkhdf(runs[0].path / runs[0].steps[-1].fields)
    drop = runs[0].manifest.scales["dT"]
    assert fields["T"].min() == pytest.approx(-drop, rel=0.4 if name in BEHIND_FILMS else 1e-6)
    assert runs[0].steps[-1].heat.entered["hole" if name == "wellbore" else "bottom"] < 0


@pytest.mark.slow
@pytest.mark.parametrize("cracks", ['{h="1000 W/(m^2 K)", T="150 °C"}', "{conductivity=1e-3}"])
def test_cracks_that_heat_feels_from_a_case_file(cracks: str, tmp_path) -> None:
    out = tmp_path / "run"
    given = settings("granite-face", f"heat.cracks={cracks}", "solver.backtracking=true")
    done = launch(1, "run", CASES / "granite-face.toml", "--quiet", "--out", out, *given)
    assert done.returncode == 0, done.stderr
    run = read_run(out)
    assert all(step.audit.violations == () for step in run.steps)
    if "h=" in cracks:
        assert run.steps[-1].heat.entered["cracks"] != 0

"""The ready cases of layered and of squeezed rock, coarse and short, from the command line."""

import pytest

import staffa
from run.test_run import CASES, launch
from staffa.case.reading import ready_cases
from staffa.io.run_directory import read_run

COARSE = {
    "layered": (
        "domain.h=0.04", "damage.ell=0.12", "time.tau=[0.1, 0.3]", "output.at=[0.3]",
    ),
    "squeezed": (
        "domain.h=0.1 m", "damage.ell=0.3 m", "output.at=['12 hours']",
        'time.t={start="1 hour", stop="12 hours", steps=3}',
    ),
}  # fmt: skip


@pytest.mark.mpi
@pytest.mark.long
@pytest.mark.parametrize("name", ["layered", "squeezed"])
def test_a_ready_case_runs_on_one_and_two_ranks(name: str, tmp_path) -> None:
    settings = [f"--set={setting}" for setting in (*COARSE[name], "measures.depths=[]")]
    runs = []
    for ranks in (1, 2):
        out = tmp_path / f"{ranks}"
        done = launch(ranks, "run", CASES / f"{name}.toml", "--out", out, *settings)
        assert done.returncode == 0, done.stderr
        assert (out / "pictures" / "cracks.png").exists()
        runs.append(read_run(out))
    for one, two in zip(runs[0].steps, runs[1].steps, strict=True):
        assert one.audit.violations == () and two.audit.violations == ()
        assert two.energies.total == pytest.approx(one.energies.total, rel=1e-5)
    assert runs[0].steps[-1].energies.surface > 0, "cooling must have broken something"


@pytest.mark.long
def test_no_energy_rises_while_many_cracks_open_and_close(tmp_path) -> None:
    case = staffa.parse_case(
        ready_cases.text("slab"),
        [
            "domain.size=[0.6,0.6]", "domain.h=0.03", "damage.ell=0.09", "damage.split=no-tension",
            "temperature.profile=slab", "supports.left=rollers", "supports.right=rollers",
            "time.tau=[0.1,0.2,0.3]", "output.at=[0.3]", "measures.depths=[]",
        ],
    )  # fmt: skip
    steps = staffa.run(case, tmp_path / "run")
    assert sum(step.effort.moves for step in steps) > 3, "Newton must have been at work"
    for step in steps:
        assert step.audit.violations == (), f"tau = {step.tau}: {step.audit.violations}"

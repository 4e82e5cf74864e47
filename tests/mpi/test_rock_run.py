"""The ready cases of layered and of squeezed rock, on one rank and two."""

import pytest

from run.test_run import CASES
from staffa.io.run_directory import open_run
from support.ranks import staffa_on

COARSE = {
    "layered": (
        "domain.h=0.04", "damage.ell=0.12", "time.tau=[0.1, 0.3]", "output.at=[0.3]",
    ),
    "squeezed": (
        "domain.h=0.1 m", "damage.ell=0.3 m", "output.at=['12 hours']",
        'time.t={start="1 hour", stop="12 hours", steps=3}',
    ),
}  # fmt: skip


@pytest.mark.long
@pytest.mark.parametrize("name", ["layered", "squeezed"])
def test_a_ready_case_runs_on_one_and_two_ranks(name: str, tmp_path) -> None:
    settings = [f"--set={setting}" for setting in (*COARSE[name], "measures.depths=[]")]
    runs = []
    for ranks in (1, 2):
        out = tmp_path / f"{ranks}"
        staffa_on(ranks, "run", CASES / f"{name}.toml", "--out", out, *settings)
        assert (out / "pictures" / "cracks.png").exists()
        runs.append(open_run(out))
    for one, two in zip(runs[0].steps, runs[1].steps, strict=True):
        assert one.audit.violations == () and two.audit.violations == ()
        assert two.energies.total == pytest.approx(one.energies.total, rel=1e-5)
    assert runs[0].steps[-1].energies.surface > 0, "cooling must have broken something"

"""The ready cases with the heat equation, on one rank and two."""

import pytest

from run.test_heat_run import settings
from run.test_run import CASES
from staffa.io.run_directory import open_run
from staffa.io.vtkhdf import read_vtkhdf
from support.bodies import needs_gmsh
from support.ranks import staffa_on

BEHIND_FILMS = ("glass-slab", "wellbore")

NAMES = [
    "granite-face",
    pytest.param("wellbore", marks=[needs_gmsh, pytest.mark.long]),
    *(
        pytest.param(name, marks=pytest.mark.long)
        for name in ("glass-slab", "ceramic-strip", "ceramic-quench")
    ),
]


@pytest.mark.parametrize("name", NAMES)
def test_a_ready_case_runs_in_units_on_one_and_two_ranks(name: str, tmp_path) -> None:
    runs = []
    for ranks in (1, 2):
        out = tmp_path / f"{ranks}"
        said = staffa_on(ranks, "run", CASES / f"{name}.toml", "--out", out, *settings(name))
        assert "heat" in said and (out / "pictures" / "heat.png").exists()
        runs.append(open_run(out))
    for one, two in zip(runs[0].steps, runs[1].steps, strict=True):
        assert one.audit.violations == () and one.heat.imbalance < 1e-8
        assert two.heat.stored == pytest.approx(one.heat.stored, rel=1e-7)
        assert two.energies.total == pytest.approx(one.energies.total, rel=1e-5)
    _, fields = read_vtkhdf(runs[0].path / runs[0].steps[-1].fields)
    drop = runs[0].manifest.scales["dT"]
    assert fields["T"].min() == pytest.approx(-drop, rel=0.4 if name in BEHIND_FILMS else 1e-6)
    assert runs[0].steps[-1].heat.entered["hole" if name == "wellbore" else "bottom"] < 0

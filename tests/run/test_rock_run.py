"""The ready cases of layered and of squeezed rock, coarse and short, from the command line."""

import pytest

import staffa
from staffa.case.reading import ready_cases


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

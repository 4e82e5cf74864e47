"""The paper's slab, narrower and on a coarser mesh: parallel cracks that stop by generations."""

from pathlib import Path

import numpy as np
import pytest

import staffa
from staffa.measure.generations import arrests

# The paper's numbers but for the width and the mesh: ell = 0.04, h = ell/3. It ends at tau = 0.44:
# the slowest crack of the second generation stops at about 0.36 with AT2.
SMALL = [
    "domain.size=[2.0, 1.0]",
    "domain.h=0.0134",
    "damage.ell=0.04",
    "toughness.correlation_length=0.08",
    "time.tau={start=0.02,stop=0.44,steps=22}",
    "output.at=[0.2, 0.36]",
]


@pytest.mark.long
@pytest.mark.parametrize("law", ["AT1", "AT2"])
def test_slab_cracks_and_cracks_stop(law: str, tmp_path: Path) -> None:
    from staffa.case.reading.ready_cases import text

    case = staffa.parse_case(text("slab"), [*SMALL, f"damage.law={law}"])
    steps = staffa.run(case, tmp_path / "run")
    assert all(step.audit.violations == () for step in steps)
    last = steps[-1].measures
    counts = [section.cracks for section in last.sections]
    assert counts[0] >= 8, f"{counts} cracks cross the depths {case.measures.depths}"
    assert counts[0] > counts[1] > counts[2] >= 3, f"cracks stop on the way: {counts}"
    found = arrests(steps, axis=1, ell=0.04)
    assert len(found.generations) >= 2, f"generations {found.generations}"
    # A height apart, an uncracked slab would have shed none of its energy.
    totals = np.array([step.energies.total for step in steps])
    assert np.all(np.diff(totals) > 0), "cooling goes on: the total energy grows"

"""A smeared insulating crack beside a real slit: `make verify ONLY=heat-cracks`, small."""

import pytest

from verification.heat.run import APART, smeared
from verification.heat.slit import slit


@pytest.mark.slow
def test_the_jump_across_a_crack_nears_that_across_a_slit_with_ell() -> None:
    reference = slit(200)
    found = [smeared(ell) for ell in (0.08, 0.04)]
    jumps = [crack.jump(APART) / reference.jump(APART) - 1 for crack in found]
    flows = [crack.flow / reference.flow - 1 for crack in found]
    assert 0 < jumps[1] < 0.65 * jumps[0] < 0.05, jumps
    assert 0.7 * flows[0] < flows[1] < 0 and flows[0] > -0.025, flows

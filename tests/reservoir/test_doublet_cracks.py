"""The ready case doublet-cracks, coarse: water that takes the cracks which cooling opens."""

from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from staffa.case.reading.ready_cases import ready_case
from staffa.io.production_rows import paired_production
from staffa.io.run_directory import open_run
from staffa.results.crack_effect import Effect, crack_effect
from staffa.runs.run import run

COARSE = (
    "domain.h=1 m",
    "damage.ell=2.5 m",
    "reservoir.h=2 m",
    "reservoir.openings.spread=5 m",
    'time.t=["20 days","60 days","120 days","200 days"]',
    "output.at=[]",
)


@pytest.mark.slow
@pytest.mark.usefixtures("darts_python")
def test_cracks_that_join_the_wells_bring_the_cold_early(tmp_path: Path) -> None:
    """The sign that the case shows, and its cause: the cracks are closed at first, and grow."""
    run(ready_case("doublet-cracks", COARSE), tmp_path / "run")
    found = open_run(tmp_path / "run")
    effect = crack_effect(found)
    assert effect is not None and effect.kind is Effect.SHORT_CIRCUIT, effect
    pairs = paired_production(found.manifest.reservoir, found.steps)
    cooler = np.array([bare.T - water.T for water, bare in pairs])
    assert abs(cooler[0]) < 1.0 and np.all(np.diff(cooler) > 0) and cooler[-1] > 5.0
    energy, bare_energy = (of.heat for of in pairs[-1])
    assert energy < 0.98 * bare_energy
    cracks = [water.cracks for water, _ in pairs]
    areas = [of.area for of in cracks if of is not None]
    assert np.all(np.diff(areas) > 0) and areas[-1] > 1.5 * areas[0]

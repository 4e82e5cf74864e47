"""Ensembles of cases in which water circulates: their seeds, and a real one in closed form."""

import csv
from pathlib import Path

from staffa.backend.stack import MPI

import pytest

from staffa.io.ensemble_directory import read_ensemble
from staffa.report.drawing import draw_ensemble
from staffa.results.members_production import members_production
from staffa.runs.ensemble import ensemble_members, member, seeds_from
from staffa.runs.member_runs import run_members
from support.circulation_cases import STRONG, wall

RANDOM = 'reservoir.permeability={mean="1e-16 m^2", variation=0.5, length="3 m", seed=5}'
SINGLE = ('reservoir.simulator="single"', 'damage.split="none"', 'time.t=["1 d","3 d"]')


def test_random_permeability_gets_another_seed_in_each_member() -> None:
    case = wall(RANDOM, "toughness.amplitude=0.0")
    assert list(seeds_from(case, count=2)) == [1, 2], "its permeability alone makes it random"
    assert member(case, 4).reservoir.permeability.seed == 8
    assert member(case, 1) == case


@pytest.mark.slow
def test_members_of_one_flow_have_its_production_and_no_error(tmp_path: Path) -> None:
    """One way in closed form, the flow is the same in each rock."""
    case = wall(*STRONG, *SINGLE)
    members = ensemble_members(case, seeds_from(case, count=2), tmp_path)
    assert run_members(members, comm=MPI.COMM_WORLD) == {}
    found = read_ensemble(tmp_path)
    drawn = draw_ensemble(found)
    assert "production-of-all" in {path.stem for path in drawn.pictures}
    one, other = members_production(found).values()
    assert one == other and len(one) == 7
    rows = list(csv.DictReader((tmp_path / "production_means.csv").open()))
    frame = found.first.to_frame()
    assert [float(row["T_K"]) for row in rows] == pytest.approx(frame["production_T"].tolist())
    assert [float(row["heat_error_J"]) for row in rows] == [0.0, 0.0]

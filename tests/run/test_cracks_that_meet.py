"""A run of a body cooled on two faces, whose cracks meet."""

from itertools import pairwise
from pathlib import Path

import pytest

from staffa.case.reading.read import parse_case
from staffa.io.run_directory import Run, open_run
from staffa.results.summary import summary
from staffa.runs.resume import resume
from staffa.runs.run import Watcher, run
from support.restarting import stopped

# Granite between two cold faces; a crack along its left end goes through between the last steps.
BOTH = """
[domain]
size = ["0.4 m", "0.3 m"]
h = "10 mm"
[material]
plane = "stress"
E = "65 GPa"
nu = 0.3
Gc = "61.5 J/m^2"
expansion = "6e-6 1/K"
k = "3.05 W/(m K)"
rho = "2750 kg/m^3"
c = "790 J/(kg K)"
[damage]
ell = "30 mm"
[toughness]
amplitude = 0.1
seed = 1
[temperature]
profile = "heat"
face = "bottom"
[heat]
initial = "200 °C"
bottom = { T = "40 °C" }
top = { T = "20 °C" }
[supports]
left = "rollers"
right = "rollers"
top = "rollers"
[time]
t = { start = "2 min", stop = "1 hour", steps = 4 }
[output]
at = ["1 hour"]
"""


def facts(found: Run) -> dict[str, str]:
    return {fact.name: fact.text for fact in summary(found)}


@pytest.mark.slow
def test_the_front_never_falls_where_cracks_of_two_faces_meet(tmp_path: Path) -> None:
    """Also in a run that was stopped before, which knows the depths from its records."""
    case, seen = parse_case(BOTH), []
    run(case, tmp_path / "whole")
    whole = open_run(tmp_path / "whole")
    found = [step.measures for step in whole.steps if step.measures]
    assert [any(tip.met for tip in one.tips) for one in found] == [False, False, False, True]
    for one, other in pairwise(found):
        assert other.front >= one.front
        assert whole.manifest.deepest(other) >= whole.manifest.deepest(one)
    assert found[-1].front == found[-2].front > 0.2
    watcher = Watcher(stepped=seen.append, stop=lambda: "enough" if len(seen) == 3 else None)
    stopped(lambda: run(case, tmp_path / "cut", watcher=watcher))
    assert [step.measures for step in resume(tmp_path / "cut")] == found
    told = facts(whole)
    assert "1 of them joined with cracks of other faces" in told["cracks"]
    assert "by step 3" in told["opposite boundary"] and "0.3 of 0.3 m" in told["opposite boundary"]


@pytest.mark.slow
def test_a_face_that_is_not_cooled_changes_no_crack_of_those_that_are(tmp_path: Path) -> None:
    run(parse_case(BOTH, ("temperature.face=left",)), tmp_path / "left")
    found = open_run(tmp_path / "left")
    last = found.steps[-1].measures
    assert last is not None and last.tips == () and not found.manifest.cools
    assert [(one.face, one.cracks) for one in last.others] == [("bottom", 3), ("top", 3)]
    assert facts(found)["cracks"].startswith("0 from no cooled face; 3 from 'bottom'")
    assert "depths from face 'left'" in facts(found)["body"]

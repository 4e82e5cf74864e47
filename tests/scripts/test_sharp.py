"""Small versions of what `make verify` holds against sharp-crack finite elements.

The pair of cracks lies on two planes of symmetry, half an even array of spacing p = .257, coarse
(ell = p/10): sharp cracks go on together up to tau = .2187, a = .3217, then every other one stops.
`make verify ONLY="doubling energies"` says on finer cells that the second order finds this, and
that energies are lower then. These cells are too coarse for it: where growth starts from the ends
of the initial cracks, at tau = .14, the second order is lost already. The state that a run goes on
to has a short branch beside one crack, 1.5 ell from it, and which branch is not determined.
"""

import tomllib
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

import staffa
from staffa.case.reading.read import parse_case
from staffa.measure.tip import reach
from staffa.model.fields import vertices
from staffa.records.step import Step
from verification.common.sharp import first_doubling, length_at
from verification.pairs.run import pairs

P, COLUMNS, ELL = 0.257, 40, 0.026
H = P / COLUMNS
# A crack on a side costs 1.126 Gc on cells of ell/4 (`make verify ONLY=surfing`): 1 with this.
PAIR = f"""
[domain]
size = [{P}, 1.0]
h = {H}
[material]
Gc = 0.888
[damage]
ell = {ELL}
[toughness]
bands = [
    {{ lower = [0.0, 0.0], upper = [{P}, 0.17], factor = 110.0 }},
    {{ lower = [{3 * ELL}, 0.17], upper = [{P - 3 * ELL}, 1.0], factor = 110.0 }},
]
[temperature]
profile = "slab"
dT = 54.0
[supports]
section = "fixed"
[[cracks]]
start = [{H / 2}, 0.0]
end = [{H / 2}, 0.2]
[[cracks]]
start = [{P - H / 2}, 0.0]
end = [{P - H / 2}, 0.2]
[time]
tau = {{ start = 0.14, stop = 0.24, steps = 21 }}
"""


def pair() -> tuple[list[Step], np.ndarray]:
    """The steps, and the lengths of both cracks at each, shape (steps, 2)."""
    problem = staffa.problem(parse_case(PAIR, ["solver.stability=none"]))
    system = staffa.build(problem)
    x, alpha = vertices(system.spaces.alpha), system.state.alpha.x.array
    beyond = reach("AT1", threshold=0.8, ell=ELL, h=H)
    assert beyond is not None
    steps, lengths = [], []
    for step in staffa.march(problem, system):
        cracked = x[alpha > 0.8]
        beside = np.minimum(cracked[:, 0], P - cracked[:, 0]) > ELL + 1.5 * H
        assert not beside.any(), f"side cracks at {cracked[beside]}"
        sides = (cracked[:, 0] < P / 4, cracked[:, 0] > 3 * P / 4)
        steps.append(step)
        # Both layers of cells beside a plane of symmetry are broken: half a cell more.
        lengths.append([cracked[side, 1].max() + beyond + H / 2 for side in sides])
    system.destroy()
    return steps, np.array(lengths)


@pytest.mark.slow
def test_an_even_array_grows_as_sharp_cracks_do() -> None:
    steps, lengths = pair()
    assert all(step.audit.violations == () for step in steps)
    for step, (left, right) in zip(steps, lengths, strict=True):
        expected = length_at("fixed", P, step.tau)
        if step.tau > first_doubling("fixed", P)[0]:
            continue
        tolerance = max(ELL, 0.03 * expected)
        assert left == pytest.approx(right, abs=1.01 * H), "nothing tells the two apart"
        assert abs(left - expected) < tolerance, f"{left:.4f} at {step.tau:.3f}, sharp {expected}"


def test_nothing_but_the_two_cracks_breaks() -> None:
    """The walls of the ready case reach through the whole depth, 3 ell from each crack."""
    case = tomllib.loads(
        (Path(staffa.__file__).parent / "case" / "ready" / "two-cracks.toml").read_text()
    )
    quiet, wall = case["toughness"]["bands"][:2]
    ell, (width, height) = case["damage"]["ell"], case["domain"]["size"]
    assert quiet["upper"][0] == width and quiet["lower"] == [0.0, 0.0]
    assert wall["lower"] == [pytest.approx(3 * ell), quiet["upper"][1]]
    assert wall["upper"] == [pytest.approx(width - 3 * ell), height]


def test_kept_pairs_broke_nothing_beside_their_cracks_and_tend_to_sharp_ones() -> None:
    """The kept runs of pairs: at ell = 0 within 2 %, against sharp cracks in a body as deep."""
    figures = pairs().figures
    assert [figure.what for figure in figures if not figure.met] == []

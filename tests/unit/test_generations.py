"""Drawn crack histories whose generations are known: what `arrests` must find in them."""

from dataclasses import replace

import numpy as np
import pytest

from staffa.measure.generations import arrests, tracks
from staffa.records.status import Status
from staffa.records.step import Audit, Energies, Measures, Step, Tip

ELL = 0.02


def drawn_step(index: int, tau: float | None, depths: dict[float, float] | None) -> Step:
    """A step whose cracks are at the places x and have the depths given; None: not measured."""
    measures = None
    if depths is not None:
        found = tuple(Tip(position=(x, d), depth=d) for x, d in sorted(depths.items()))
        measures = Measures(
            sections=(),
            tips=found,
            front=max(depths.values(), default=0.0),
            length_surface=sum(depths.values()),
            length_geometry=sum(depths.values()),
        )
    return Step(
        index=index,
        time=0.25 * tau**2 if tau is not None else float(index),
        tau=tau,
        energies=Energies(elastic=1.0, surface=1.0),
        sweeps=3,
        status=Status.CONVERGED,
        reason="converged",
        audit=Audit(
            largest_rise=0.0, healing=0.0, optimality=0.0, balance=0.0, work=0.0, released=0.0
        ),
        measures=measures,
    )


def doubling(n: int, arrest_taus: tuple[float, ...], end: float, steps: int = 100) -> list[Step]:
    """n cracks that grow as depth = tau; at each arrest every other one of those left stops."""
    history = []
    for index in range(steps):
        tau = end * (index + 1) / steps
        depths = {}
        for crack in range(n):
            stop = end
            for k, arrest in enumerate(arrest_taus):
                if (crack + 1) % 2 ** (k + 1) != 0:
                    stop = arrest
                    break
            depths[0.1 * crack] = min(tau, stop)
        history.append(drawn_step(index, tau, depths))
    return history


def test_two_doublings_are_two_generations_with_their_depths_and_taus():
    found = arrests(doubling(16, (0.1, 0.3), 0.5), axis=1, ell=ELL)
    counted = [(g.number, g.cracks) for g in found.generations]
    assert counted == [(1, 8), (2, 4)], f"generations {counted}, drawn (1, 8), (2, 4)"
    for generation, tau in zip(found.generations, (0.1, 0.3), strict=True):
        assert generation.depth == pytest.approx(tau)
        # Arrest is when the tip was within ell/2 of its end: that much earlier, up to a step.
        assert generation.tau == pytest.approx(tau - ELL / 2, abs=0.0051)
    assert (found.left, found.growing) == (4, 4)
    assert found.depth == pytest.approx(0.5)


def test_cracks_that_all_grow_have_no_generation():
    found = arrests(doubling(6, (), 0.4), axis=1, ell=ELL)
    assert found.generations == ()
    assert (found.left, found.growing) == (6, 6)


def test_an_arrest_in_the_last_moments_is_not_claimed():
    found = arrests(doubling(8, (0.1, 0.49), 0.5), axis=1, ell=ELL)
    assert len(found.generations) == 1, f"{found.generations} of an arrest at .1 and one at the end"
    assert found.growing == 4


def test_cracks_that_stop_at_one_depth_are_one_generation_and_not_halved():
    steps = doubling(8, (), 0.3) + [
        drawn_step(100 + i, 0.3 + 0.01 * i, {0.1 * c: 0.3 for c in range(8)}) for i in range(1, 30)
    ]
    found = arrests(steps, axis=1, ell=ELL)
    assert [g.cracks for g in found.generations] == [8]
    assert (found.left, found.growing, found.depth) == (0, 0, None)


def test_two_seeded_cracks_give_the_first_doubling():
    found = arrests(doubling(2, (0.12,), 0.4), axis=1, ell=ELL)
    assert [(g.cracks, g.depth) for g in found.generations] == [(1, pytest.approx(0.12))]
    assert (found.left, found.growing) == (1, 1)


@pytest.mark.parametrize(("short", "long"), [(4, 6), (6, 4), (3, 5), (1, 2), (2, 1)])
def test_uneven_halves_are_split_at_the_gap(short, long):
    history = []
    for index in range(60):
        tau = 0.01 * (index + 1)
        shallow = {0.1 * c: min(tau, 0.15 + 0.003 * c) for c in range(short)}
        deep = {0.1 * (short + c): tau - 0.003 * c for c in range(long)}
        history.append(drawn_step(index, tau, shallow | deep))
    found = arrests(history, axis=1, ell=ELL)
    assert [g.cracks for g in found.generations] == [short]
    assert found.left == long


def test_a_crack_that_curves_is_followed_to_its_start():
    steps = [
        drawn_step(i, 0.01 * (i + 1), {0.5 + 0.02 * i: 0.01 * (i + 1), 3.0: 0.01})
        for i in range(50)
    ]
    curved = tracks(steps, axis=1)[0]
    assert curved.place == pytest.approx((0.5 + 0.02 * 49,))
    assert curved.depths == pytest.approx([0.01 * (i + 1) for i in range(50)])


def test_a_crack_that_is_born_later_takes_no_neighbors_past():
    steps = [
        drawn_step(0, 0.1, {0.0: 0.1, 1.0: 0.1}),
        drawn_step(1, 0.2, {0.0: 0.2, 0.9: 0.05, 1.0: 0.2}),
    ]
    _, late, old = tracks(steps, axis=1)
    assert late.depths == (None, 0.05)
    assert old.depths == (0.1, 0.2)


def test_two_tips_above_one_another_are_two_cracks():
    step = drawn_step(0, 0.1, {0.5: 0.1})
    assert step.measures is not None
    both = (Tip(position=(0.5, 0.1), depth=0.1), Tip(position=(0.5, 0.3), depth=0.3))
    forked = replace(step, measures=replace(step.measures, tips=both))
    assert [track.final for track in tracks([step, forked], axis=1)] == [0.1, 0.3]


def test_nucleation_is_the_first_step_with_half_of_the_cracks():
    steps = [
        drawn_step(0, 0.01, {}),
        drawn_step(1, 0.02, {0.0: 0.03}),
        drawn_step(2, 0.03, {0.0: 0.04, 0.2: 0.02, 0.4: 0.03}),
        drawn_step(3, 0.04, {0.1 * c: 0.05 for c in range(6)}),
    ]
    start = arrests(steps, axis=1, ell=ELL).nucleation
    assert start is not None
    assert (start.cracks, start.tau) == (3, 0.03)
    assert start.depth == pytest.approx(0.03)
    assert start.spacing == pytest.approx(0.1), f"spacing {start.spacing}, six cracks .1 apart"


def test_without_tau_arrests_are_told_in_time():
    steps = [
        drawn_step(i, None, {0.0: 0.01 * min(i + 1, 10), 1.0: 0.01 * (i + 1)}) for i in range(50)
    ]
    (only,) = arrests(steps, axis=1, ell=0.025).generations
    assert only.tau is None
    assert only.time == pytest.approx(8.0)  # the tenth less ell/2 = 1.25 steps


@pytest.mark.parametrize(
    "steps",
    [
        [],
        [drawn_step(0, 0.1, None)],
        [drawn_step(0, 0.1, {})],
        [drawn_step(0, 0.1, {}), drawn_step(1, 0.2, None)],
    ],
)
def test_runs_without_cracks_have_no_arrests(steps):
    found = arrests(steps, axis=1, ell=ELL)
    assert (found.nucleation, found.generations, found.left) == (None, (), 0)


def test_one_crack_alone_is_left_and_no_generation():
    found = arrests(
        [drawn_step(0, 0.1, {0.3: 0.1}), drawn_step(1, 0.2, {0.3: 0.2})], axis=1, ell=ELL
    )
    assert (found.nucleation, found.generations, found.left) == (None, (), 1)


def test_a_step_that_was_not_measured_is_passed_over():
    steps = doubling(4, (0.1,), 0.4)
    gaps = [drawn_step(s.index, s.tau, None) if s.index % 7 == 3 else s for s in steps]
    found = arrests(gaps, axis=1, ell=ELL)
    assert [g.cracks for g in found.generations] == [2]


def test_in_three_dimensions_tips_are_told_apart_in_both_directions():
    def step(index: int) -> Step:
        depth = 0.01 * (index + 1)
        places = [(0.0, 0.0), (0.0, 1.0), (1.0, 0.0), (1.0, 1.0)]
        found = tuple(Tip(position=(*place, depth), depth=depth) for place in places)
        whole = drawn_step(index, depth, {}).to_record()
        whole["measures"]["tips"] = [{"position": t.position, "depth": t.depth} for t in found]
        return Step.from_record(whole)

    found = arrests([step(i) for i in range(20)], axis=2, ell=ELL)
    assert found.left == 4
    assert found.nucleation is not None and found.nucleation.spacing is None


def test_the_way_to_the_sharp_tip_is_added_to_every_depth():
    steps = doubling(4, (0.1,), 0.4)
    raw = arrests(steps, axis=1, ell=ELL)
    sharp = arrests(steps, axis=1, ell=ELL, sharp=lambda depth, room: depth + 0.015)
    assert raw.generations and raw.nucleation and raw.depth is not None
    assert sharp.nucleation is not None and sharp.depth is not None
    assert sharp.generations[0].depth == pytest.approx(raw.generations[0].depth + 0.015)
    assert sharp.nucleation.depth == pytest.approx(raw.nucleation.depth + 0.015)
    assert sharp.depth == pytest.approx(raw.depth + 0.015)
    assert sharp.generations[0].tau == raw.generations[0].tau


def test_a_tip_is_followed_as_a_path():
    steps = [drawn_step(i, 0.01 * (i + 1), {0.5 + 0.01 * i: 0.01 * (i + 1)}) for i in range(5)]
    (only,) = tracks([drawn_step(0, 0.005, {}), *steps], axis=1)
    assert only.path[0] is None and only.depths[0] is None
    assert np.array(only.path[1:]) == pytest.approx(
        np.array([(0.5 + 0.01 * i, 0.01 * (i + 1)) for i in range(5)])
    )


def test_cracks_that_have_met_those_of_another_face_are_followed_but_in_no_generation():
    history = doubling(16, (0.1, 0.3), 0.5)
    last = history[-1]
    found = tuple(replace(tip, met=k == 0) for k, tip in enumerate(last.measures.tips))
    ended = [*history[:-1], replace(last, measures=replace(last.measures, tips=found))]
    whole, some = (arrests(steps, axis=1, ell=ELL) for steps in (history, ended))
    assert [g.cracks for g in whole.generations] == [8, 4]
    assert [g.cracks for g in some.generations] == [7, 4] and some.left == whole.left == 4
    assert some.nucleation == whole.nucleation, "spacings are those of all"
    assert [track.met for track in tracks(ended, axis=1)] == [True] + [False] * 15


def test_a_crack_that_passes_below_an_arrested_one_is_not_lost():
    """One stops at x = 0, its neighbor goes on, turns below it, and leaves on the other side."""
    history = []
    for index in range(40):
        deep = 0.05 + 0.01 * index
        depths = {0.0: min(deep, 0.06), round(0.0623 - 0.003 * index, 4): deep, 0.3: deep}
        history.append(drawn_step(index, 0.01 * (index + 1), depths))
    _, *found = sorted(tracks(history, axis=1), key=lambda track: track.final)
    for track in found:
        assert track.depths == pytest.approx([0.05 + 0.01 * index for index in range(40)])

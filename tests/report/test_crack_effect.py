"""The paragraph on the effect of cracks, from numbers alone, and what warns after a run."""

from dataclasses import replace
from pathlib import Path

import pytest

import staffa
from staffa.records.crack_flow import CrackFlow, SideOpening
from staffa.results.crack_effect import Effect, crack_effect
from staffa.results.crack_warnings import crack_warnings
from staffa.results.summary import summary
from support.circulating import CRACKS, RULE, fracture_run, shadowed_run

FALLS = [0.0, 0.5, 2.0, 6.0, 12.0, 20.0, 28.0]  # of 140 K, at the end of each 10 days


def times(factor: float) -> list[float]:
    return [factor * fall for fall in FALLS]


def told(path: Path, falls: list[float], **changes) -> tuple[Effect, str]:
    effect = staffa.crack_effect(shadowed_run(path / "run", falls, FALLS, **changes))
    assert effect is not None and str(effect) == effect.text
    return effect.kind, effect.text


def test_a_one_way_run_says_which_key_lets_cracks_change_the_flow(tmp_path: Path) -> None:
    effect = crack_effect(fracture_run(tmp_path))
    assert effect is not None and effect.kind is Effect.ONE_WAY
    assert "did not change the flow in this run" in effect.text
    assert "reservoir.feedback = true" in effect.text


def test_a_run_without_a_shadow_says_how_to_get_one(tmp_path: Path) -> None:
    run = shadowed_run(tmp_path, FALLS, FALLS)
    steps = [replace(s, heat=replace(s.heat, shadow=None)) for s in run.steps if s.heat]
    effect = crack_effect(replace(run, steps=tuple(steps)))
    assert effect is not None and effect.kind is Effect.NO_SHADOW
    assert "reservoir.shadow = true" in effect.text


def test_a_run_without_water_has_no_paragraph(tmp_path: Path) -> None:
    run = shadowed_run(tmp_path, FALLS, FALLS)
    assert crack_effect(replace(run, steps=())) is None
    assert crack_effect(replace(run, manifest=replace(run.manifest, reservoir=None))) is None


def test_without_cracks_there_is_nothing_to_tell_apart(tmp_path: Path) -> None:
    kind, text = told(tmp_path, FALLS, cracks=CrackFlow(area=0.0, volume=0.0))
    assert kind is Effect.NO_CRACKS and "No crack took water" in text
    assert "at most 0 K" in text and "short" not in text


def test_dead_ends_change_less_than_the_simulator_resolves_and_both_sizes_are_told(
    tmp_path: Path,
) -> None:
    """0.02 K of 140 K, where two runs of tolerance 1e-3 can differ by 0.28 K."""
    kind, text = told(tmp_path, [fall + 0.02 for fall in FALLS])
    assert kind is Effect.NOTHING and "consistent with dead ends" in text
    assert "at most 0.02 K" in text and "what two runs can differ by is 0.28 K and 0.2 %" in text
    assert "an area of 240 m²" in text and "openings of up to 1.2 mm" in text
    finer, _ = told(tmp_path / "finer", [fall + 0.02 for fall in FALLS], tolerance=1e-5)
    assert finer is not Effect.NOTHING


def test_a_lower_pressure_alone_is_a_wider_way(tmp_path: Path) -> None:
    kind, text = told(tmp_path, FALLS, dp=(2e5, 5e5))
    assert kind is Effect.PRESSURE and "a wider way" in text and "did not change the heat" in text
    assert "is 200 kPa with cracks and 500 kPa without (impedance -60 %)" in text
    kind, text = told(tmp_path / "higher", FALLS, dp=(8e5, 5e5))
    assert kind is Effect.PRESSURE and "a narrower way" in text


def test_more_area_and_a_later_breakthrough_are_more_rock(tmp_path: Path) -> None:
    """28 - 19.6 K at the end; 14 K after 52.5 d without, and after 60 d with cracks."""
    kind, text = told(tmp_path, times(0.7), dp=(3e5, 5e5))
    assert kind is Effect.MORE_ROCK and "consistent with water that goes through more rock" in text
    assert "made the produced water warmer, by at most 8.4 K at the end" in text
    assert "A drawdown of 10 % came at 60 d with cracks, and at 52.5 d without" in text
    assert "(impedance -40 %)" in text and "The exchange area is 89.9 m² with cracks" in text


def test_an_earlier_breakthrough_at_a_lower_pressure_is_a_short_circuit(tmp_path: Path) -> None:
    kind, text = told(tmp_path, times(1.5), dp=(3e5, 5e5))
    assert kind is Effect.SHORT_CIRCUIT and "consistent with a short circuit" in text
    assert "colder, by at most 14 K at the end" in text and "(-3.76 %)" in text


def test_colder_water_without_a_lower_pressure_is_not_explained(tmp_path: Path) -> None:
    kind, text = told(tmp_path, times(1.5), dp=(6e5, 5e5))
    assert kind is Effect.UNTOLD and text.endswith("These numbers alone do not tell why.")
    assert "consistent" not in text


def test_warmer_water_that_breaks_through_as_before_is_not_explained(tmp_path: Path) -> None:
    kind, text = told(tmp_path, [*FALLS[:-1], 26.0])
    assert kind is Effect.UNTOLD and "warmer, by at most 2 K at the end" in text


@pytest.mark.parametrize(
    "falls, first, later",
    [
        ([0, 3, 6, 8, 12, 18, 24], "colder, by at most 4 K at 30 d", "warmer, by at most 4 K"),
        ([0, 0, 1, 5, 12, 22, 31], "warmer, by at most 1 K at 30 d", "colder, by at most 3 K"),
    ],
)
def test_a_sign_that_changes_is_told_in_the_order_of_time(
    tmp_path: Path, falls: list[float], first: str, later: str
) -> None:
    kind, text = told(tmp_path, falls)
    assert kind is Effect.CHANGING and f"{first}, and later {later}" in text


def test_more_water_at_the_same_temperature_is_more_water(tmp_path: Path) -> None:
    kind, text = told(tmp_path, FALLS, rates=(0.03, 0.02))
    assert kind is Effect.WATER and "50 % more water" in text and "(+50 %)" in text


def test_fractures_along_sides_are_named(tmp_path: Path) -> None:
    side = SideOpening(narrowest=-1e-4, widest=0.017)
    only = CrackFlow(area=0.0, volume=1.0, sides={"bottom": side})
    kind, text = told(tmp_path, FALLS, dp=(1e4, 5e5), cracks=only)
    assert kind is Effect.PRESSURE and text.startswith("The opening of fractures along sides did")
    assert "'bottom' is then open by -0.1 to 17 mm" in text and "Cracks" not in text


def test_the_paragraph_begins_the_table_of_the_production(tmp_path: Path, capsys) -> None:
    from staffa.cli.results import print_summary
    from staffa.results.production_table import production_numbers_table

    run = shadowed_run(tmp_path, times(0.7), FALLS)
    lead = production_numbers_table(run).lead
    assert lead == crack_effect(run).text
    print_summary(run)
    printed = " ".join(capsys.readouterr().out.split())
    assert lead in printed and printed.index(lead) < printed.index("thermal breakthrough: first")


# ---- warnings -----------------------------------------------------------------------------------


def warned(path: Path, cracks: CrackFlow) -> list[str]:
    run = shadowed_run(path, FALLS, FALLS, cracks=cracks)
    found = crack_warnings(run)
    assert [f.text for f in summary(run) if f.name == "flow in cracks" and f.alarm] == found
    return found


def test_a_run_within_its_limits_warns_of_nothing(tmp_path: Path) -> None:
    assert warned(tmp_path, replace(CRACKS, spacing=4 * RULE.spread)) == []
    assert crack_warnings(fracture_run(tmp_path / "one way")) == []


def test_cracks_nearer_than_four_spreads_are_told(tmp_path: Path) -> None:
    (text,) = warned(tmp_path, replace(CRACKS, spacing=3.9 * RULE.spread))
    assert text.startswith("Cracks are 31.2 m apart at 10 d (31.2 m at the end), nearer than four")
    assert "reservoir.h" in text and "reservoir.openings.spread" in text


def test_bounds_that_act_are_told_with_the_share(tmp_path: Path) -> None:
    side = SideOpening(narrowest=0.0, widest=0.017, at_smallest=0.004, at_largest=0.5)
    cracks = replace(CRACKS, at_smallest=0.3, at_largest=0.0, sides={"bottom": side})
    _, lower, upper = warned(tmp_path, cracks)
    assert "lower bound of the opening acts on 30% of the cracks' area at 10 d" in lower
    assert "0.02 mm open" in lower and "reservoir.openings.smallest" in lower
    assert "upper bound of the opening acts on 50% of the fracture along the side 'bottom'" in upper
    assert "up to 17 mm" in upper and "2 mm open" in upper


def test_cracks_as_wide_as_the_fracture_they_end_in_are_told(tmp_path: Path) -> None:
    def beside(name: str, narrowest: float) -> list[str]:
        side = SideOpening(narrowest=narrowest, widest=1.9e-3)
        return warned(tmp_path / name, replace(CRACKS, widest=8e-4, sides={"bottom": side}))

    assert beside("wide", 1.8e-3) == []  # the cube of 8/18 is 0.088
    (text,) = beside("narrow", 1.6e-3)
    assert "the side 'bottom' that they end in, 0.8 mm beside 1.6 mm at 10 d" in text
    assert "docs/how-to/circulation.md" in text


def test_water_in_cracks_is_told_from_a_hundredth_of_the_injected_water(tmp_path: Path) -> None:
    """0.02 kg/s inject 17,280 kg in 10 d: a hundredth is 0.1728 m³."""
    assert warned(tmp_path / "less", replace(CRACKS, volume=0.17)) == []
    (text,) = warned(tmp_path / "more", replace(CRACKS, volume=0.18))
    assert text.startswith("The water in cracks is 1.04% of the water injected by 10 d (0.15% at")

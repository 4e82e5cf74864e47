"""The memory, steps and time that `staffa check` says, against runs that were measured."""

import json

import pytest

from staffa.case.check.cost import WITHIN, coarser_for, duration, memory, steps
from staffa.case.check.preview import preview
from staffa.case.reading import ready_cases
from staffa.case.scales.case_scales import derived_numbers
from staffa.case.schema.case import Case
from support.kept_runs import as_run
from support.paths import ROOT

MEASURED = ("squeezed", "layers", "neighbors", "columns", "quench")


def kept() -> dict[str, dict]:
    """The runs of one command that are kept in verification/, with their commands and seconds."""
    slabs = (ROOT / "verification" / "slabs" / "kept").iterdir()
    found = {file.stem: json.loads(file.read_text()) for file in slabs}
    for name in MEASURED:
        runs = json.loads((ROOT / f"verification/{name}/kept.json").read_text())
        named = {name: runs} if "command" in runs else {f"{name} {k}": v for k, v in runs.items()}
        found |= {key: run for key, run in named.items() if "staffa run" in run["command"]}
    return found


def estimated(case: Case) -> float:
    return duration(case, steps(case, derived_numbers(case)).number)


def test_the_kept_runs_took_as_long_as_is_said() -> None:
    """Within the factor that is said beside it; on two ranks, taken as half as long."""
    factors = {}
    for name, run in kept().items():
        case, ranks = as_run(run["command"])
        factors[name] = ranks * run["seconds"] / estimated(case)
    assert len(factors) > 40
    wrong = {name: f"{f:.2f}" for name, f in factors.items() if not 1 / WITHIN < f < WITHIN}
    assert not wrong, wrong
    near = sum(1 / 2 < f < 2 for f in factors.values()) / len(factors)
    assert near > 0.7, f"{near:.0%} lie within a factor of two"


def test_so_did_the_slabs_and_the_brick_of_the_bench() -> None:
    runs = json.loads((ROOT / "bench/yardstick/results.json").read_text())["runs"]
    slab, brick = ready_cases.ready_case("slab"), ready_cases.ready_case("brick")
    for name in ("A30k:1", "A120k:1", "B30k:1", "B480k:1", "D300k:1"):
        edge = {"A30k": 122, "A120k": 244, "B30k": 122, "B480k": 489, "D300k": 45}[name[:-2]]
        like = slab if name[0] in "AB" else brick
        size = "[1.0,1.0]" if like is slab else "[1.0,1.0,1.0]"
        case = ready_cases.ready_case(
            "slab" if like is slab else "brick",
            [
                f"domain={{size={size}, h={1 / edge}}}",
                *(["damage.ell=0.15", "measures.depths=[0.2]"] if like is brick else []),
                "damage.allow_coarse=true",
            ],
        )
        number = int(runs[name]["steps_run"].split()[0])
        found = runs[name]["staffa"]["cpu_s"] / duration(case, number)
        assert 1 / WITHIN < found < WITHIN, f"{name}: {found:.2f}"


def test_a_split_and_more_cells_take_longer() -> None:
    cold, squeezed = ready_cases.ready_case("granite-face"), ready_cases.ready_case("squeezed")
    finer = ready_cases.ready_case("granite-face", ["domain.h=5 mm"])
    one = estimated(cold)
    assert estimated(squeezed) > 2 * one
    assert 4 <= estimated(finer) / one < 8, "four times the cells"


def test_adaptive_steps_are_counted_as_the_cold_alone_makes_them() -> None:
    """tau grows by a quarter a step from .01: .01 * 1.25^n = .08 at n = 9.3, then by .02."""
    text = "time={tau={start=0.01,stop=0.4,shortest=0.0005,longest=0.02}}"
    case = ready_cases.ready_case("slab", [text, "output.at=[]"])
    found = steps(case, derived_numbers(case))
    grown = next(n for n in range(99) if 0.01 * 1.25**n >= 0.08)
    rest = (0.4 - 0.01 * 1.25**grown) / 0.02
    assert found.open and found.number == 1 + grown + int(rest) + 1 == 27


def test_what_is_said_of_the_time_names_its_range_and_what_it_leaves_out() -> None:
    facts = {name: (value, meaning) for name, value, meaning in preview(backtracked()).facts}
    value, meaning = facts["time"]
    seconds = estimated(backtracked())
    assert 240 < seconds < 360 and value == "about 5 min"
    assert meaning == "on one core: between 1 min and 20 min; more for solver.backtracking"


def backtracked() -> Case:
    return ready_cases.ready_case("slab", ["solver.backtracking=true"])


def test_the_cell_edge_that_fits_the_memory_is_told() -> None:
    case = ready_cases.ready_case("ceramic-quench")
    half = (memory(case) + 3.2e8) / 2
    edge = coarser_for(case, half)
    fitting = ready_cases.ready_case("ceramic-quench", [f"domain.h={edge} m"])
    assert memory(fitting) == pytest.approx(half, rel=0.05)
    assert edge == pytest.approx(15.3e-6 * 2**0.5, rel=0.01)

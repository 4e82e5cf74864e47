"""Facts and warnings on a temperature that a formula gives."""

from collections.abc import Iterator

from staffa.case.check.cracking import first_and_last, other_causes
from staffa.case.scales.case_scales import Numbers
from staffa.case.schema.case import Case
from staffa.case.schema.quantity_text import amount
from staffa.case.values.temperature_formula import change_range


def formula_facts(case: Case, derived: Numbers) -> list[tuple[str, str, str]]:
    """Return facts on temperature.T, none without it: each a name, a value and a meaning."""
    if case.temperature.T is None:
        return []
    least, most = change_range(case, first_and_last(derived)[1])
    low, high = amount(case, least, "K", digits=4), amount(case, most, "K", digits=4)
    told = "temperature.T over the body and the run; the body starts at 0"
    facts = [("change of temperature", f"{low} to {high}", told)]
    if derived.dT_c is None:
        why = f"{derived.law.name} has no threshold: any drop damages"
        return [*facts, ("dT/dT_c", "none", why), ("will it crack", *_verdict(case, derived))]
    needed = amount(case, derived.dT_c, "K", digits=4)
    return [
        *facts,
        ("dT_c", needed, "drop at which damage starts in rock that is held along a face"),
        ("will it crack", *_verdict(case, derived)),
    ]


def _verdict(case: Case, derived: Numbers) -> tuple[str, str]:
    """Return if the temperature may crack the body, and why."""
    causes = other_causes(case)
    if derived.dT_c is None:
        return "cannot be told", "; ".join(["only a run can tell", *causes])
    if temperature_span(case, derived) < derived.dT_c:
        return "hardly", "; ".join(["the changes span less than dT_c", *causes])
    why = "the changes span dT_c or more; what the body is free to do decides"
    return "perhaps", "; ".join([why, *causes])


def formula_warnings(case: Case, derived: Numbers) -> Iterator[str]:
    """Yield warnings on temperature.T."""
    if case.temperature.T is None:
        return
    least, most = change_range(case, first_and_last(derived)[1])
    if most - least == 0:
        yield (
            "temperature.T is 0 at all places and times that were looked at: it loads nothing; it "
            "counts changes since the start, of x, y (and z) and t"
        )
    elif derived.dT_c is not None and most - least < derived.dT_c and not other_causes(case):
        yield (
            f"hardly anything will crack: temperature.T spans {amount(case, most - least, 'K')} "
            f"over the body and the run, and damage starts at a drop of "
            f"{amount(case, derived.dT_c, 'K')}; larger changes crack it, or a larger damage.ell "
            f"(a lower strength)"
        )


def temperature_span(case: Case, derived: Numbers) -> float:
    """Return the largest less the least change of temperature over the body and the run (K)."""
    least, most = change_range(case, first_and_last(derived)[1])
    return most - least

"""The errors a user meets, each one sentence that names what is wrong and the way out."""

from collections.abc import Iterable
from difflib import get_close_matches


class StaffaError(Exception):
    """A failure whose message is written for the user; shown without a traceback, on one line."""

    exit_code = 1

    def __init__(self, sentence: str) -> None:
        super().__init__(printable(sentence))


class InputError(StaffaError):
    """Error of input that cannot work; nothing has been computed or written."""

    exit_code = 2


class SolveError(StaffaError):
    """A solver did not reach what it promises; its result was not used."""


class LoadError(SolveError):
    """A load gives what no solver can use, at any time step."""


class PartedError(SolveError):
    """The load cannot be carried any more: the body is in two. Steps before it stand."""

    exit_code = 4


class AuditError(StaffaError):
    """The run is finished, but a step of it is not what its audit asks for."""

    exit_code = 5


# How a command ends, for its help.
EXIT_CODES = (
    "Exit codes: 0 finished; 1 a step failed; 2 what was asked for cannot work; 3 stopped, resume "
    "goes on; 4 the load cannot be carried any more; 5 finished, but the audit is violated."
)


class AloneError(StaffaError):
    """An error that one rank meets alone: the others wait for it, and nothing collective may follow
    but the end of all."""

    def __init__(self, sentence: str, exit_code: int = 1) -> None:
        super().__init__(sentence)
        self.exit_code = exit_code


class StoppedError(StaffaError):
    """The run ended before its end, and can go on from where it is."""

    exit_code = 3


class StaffaWarning(UserWarning):
    """Something a user should know, in one sentence; the work goes on."""


def printable(text: str) -> str:
    """Return the text on one line, with what cannot be printed (a user may write anything) spelled
    out."""
    return "".join(c if c.isprintable() else ascii(c)[1:-1] for c in text)


def did_you_mean(name: str, valid: Iterable[str]) -> str:
    """Return the question after a wrong name, " Did you mean 'face'?"; nothing if none is close."""
    names = {valid_name.casefold(): valid_name for valid_name in valid}
    near = get_close_matches(name.casefold(), names, n=1, cutoff=0.6)
    return f" Did you mean '{names[near[0]]}'?" if near else ""


def choices(name: str, valid: Iterable[str]) -> str:
    """Return the sentence end that lists the valid names and proposes one that is close."""
    names = sorted(valid)
    if not names:
        return "it has none"
    return f"it has {', '.join(names)}.{did_you_mean(name, names)}"

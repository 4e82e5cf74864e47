"""Checks an installation: a verdict and a sentence for each thing that staffa needs."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from staffa.doctor import checks
from staffa.errors import StaffaError, printable

OK, WRONG, LACKING, UNTRIED = "ok", "wrong", "lacking", "untried"
# Each tells what it found, or raises a StaffaError that tells what is wrong and the way out.
NEEDED: dict[str, Callable[[], str]] = {
    "Python": checks.python,
    "compiler": checks.compiler,
    "headers": checks.headers,
    "libraries": checks.libraries,
    "PETSc": checks.petsc,
    "partitioner": checks.partitioner,
    "cache": checks.cache,
    "mpiexec": checks.mpiexec,
    "folder": checks.folder,
}
USEFUL: dict[str, Callable[[], str]] = {
    "disk": checks.disk,
    "locks": checks.locks,
    "threads": checks.threads,
    "Gmsh": checks.gmsh,
    "pictures": checks.pictures,
    "reservoir": checks.reservoir,
}
LAST: dict[str, Callable[[], str]] = {"two ranks": checks.two_ranks}


@dataclass(frozen=True, kw_only=True)
class Finding:
    """The result of a check.

    Attributes
    ----------
    name : name of the check.
    verdict : "ok", "wrong", "lacking" (of what can be done without), or "untried".
    said : the sentence.
    """

    name: str
    verdict: str
    said: str


def checkup() -> Iterator[Finding]:
    """Give the result of each check as soon as it is there."""
    wrong = False
    for name, check in (NEEDED | USEFUL | LAST).items():
        if wrong and name in LAST:
            said = "not tried; see to what is wrong above first"
            yield Finding(name=name, verdict=UNTRIED, said=said)
            continue
        found = _found(name, check)
        wrong = wrong or found.verdict == WRONG
        yield found


def _found(name: str, check: Callable[[], str]) -> Finding:
    try:
        return Finding(name=name, verdict=OK, said=printable(check()))
    except Exception as error:  # what is broken may show in any way
        said = str(error) if isinstance(error, StaffaError) else f"{type(error).__name__}: {error}"
        bad = LACKING if name in USEFUL else WRONG
        return Finding(name=name, verdict=bad, said=printable(said))

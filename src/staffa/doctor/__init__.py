"""Whether this installation can do what staffa needs, one look after the other."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from staffa.doctor import compiling, machine, solving
from staffa.errors import StaffaError, printable

OK, WRONG, LACKING, UNTRIED = "ok", "wrong", "lacking", "untried"


@dataclass(frozen=True, kw_only=True)
class Look:
    """look: gives what was found, or raises a StaffaError that says what is wrong and the way out.

    needed: nothing runs without it. last: not tried if something needed is wrong.
    """

    name: str
    look: Callable[[], str]
    needed: bool = True
    last: bool = False


@dataclass(frozen=True, kw_only=True)
class Finding:
    """verdict: "ok", "wrong", "lacking" (of what can be done without), or "untried"."""

    name: str
    verdict: str
    said: str


LOOKS = (
    Look(name="Python", look=machine.python),
    Look(name="compiler", look=compiling.compiler),
    Look(name="headers", look=compiling.headers),
    Look(name="libraries", look=solving.libraries),
    Look(name="PETSc", look=solving.petsc),
    Look(name="partitioner", look=solving.partitioner),
    Look(name="cache", look=compiling.cache),
    Look(name="mpiexec", look=solving.mpiexec),
    Look(name="folder", look=machine.folder),
    Look(name="disk", look=machine.disk, needed=False),
    Look(name="locks", look=machine.locks, needed=False),
    Look(name="threads", look=machine.threads, needed=False),
    Look(name="Gmsh", look=machine.gmsh, needed=False),
    Look(name="pictures", look=machine.pictures, needed=False),
    Look(name="two ranks", look=solving.two_ranks, last=True),
)


def checkup() -> Iterator[Finding]:
    """What each look finds, as soon as it is found; what may crash does so in another process."""
    healthy = True
    for look in LOOKS:
        if look.last and not healthy:
            said = "not tried; see to what is wrong above first"
            yield Finding(name=look.name, verdict=UNTRIED, said=said)
            continue
        found = _found(look)
        healthy = healthy and found.verdict != WRONG
        yield found


def _found(look: Look) -> Finding:
    bad = WRONG if look.needed else LACKING
    try:
        return Finding(name=look.name, verdict=OK, said=printable(look.look()))
    except StaffaError as error:
        return Finding(name=look.name, verdict=bad, said=str(error))
    except Exception as error:  # a doctor does not fall ill: what is broken may show in any way
        said = printable(f"{type(error).__name__}: {error}")
        return Finding(name=look.name, verdict=bad, said=said)

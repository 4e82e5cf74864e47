"""Terminal to which all output is printed."""

import os
import sys
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from typing import Any, TextIO

from rich.console import Console
from rich.segment import Segment

from staffa.errors import StaffaError, printable


class Terminal(Console):
    """Console that escapes what cannot be printed.

    A name of a mesh or a file may contain sequences that rewrite the screen.
    """

    def render(self, *arguments: Any, **options: Any) -> Iterable[Segment]:
        """Render with escapes, see `rich.console.Console.render`."""
        for segment in super().render(*arguments, **options):
            yield segment if segment.control else segment._replace(text=_lines(segment.text))


def _lines(text: str) -> str:
    return "\n".join(printable(line) for line in text.split("\n"))


# A pipe has no width; rich would take 80 columns and wrap every table.
out = Terminal(highlight=False, width=None if sys.stdout and sys.stdout.isatty() else 120)


class _Lossy:
    """Stream that drops output which can no longer be written, so that a run continues."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self.problem: OSError | None = None

    def write(self, text: str) -> int:
        if self.problem is None:
            try:
                return self._stream.write(text)
            except OSError as error:
                self.problem = error
        return len(text)

    def flush(self) -> None:
        if self.problem is None:
            try:
                self._stream.flush()
            except OSError as error:
                self.problem = error

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)


@contextmanager
def to_a_terminal_that_may_close() -> Iterator[None]:
    """Drop output in this context if its reader is gone (`| head`), or if there is none.

    Raises
    ------
    StaffaError
        Output was lost for another reason, such as a full disk; raised in the end.
    """
    for number in range(3):  # or a file of the run would get this number, and the output
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)
    stdout = sys.stdout or open(os.devnull, "w")  # noqa: SIM115 (till the end)
    sys.stderr = sys.stderr or open(os.devnull, "w")  # noqa: SIM115
    lossy = _Lossy(stdout)
    sys.stdout = lossy
    try:
        yield
    except SystemExit as end:
        if end.code:
            raise
    finally:
        lossy.flush()
        if lossy.problem is not None:  # nothing more is tried as the interpreter ends
            os.dup2(os.open(os.devnull, os.O_WRONLY), stdout.fileno())
    if lossy.problem is not None and not isinstance(lossy.problem, BrokenPipeError):
        raise StaffaError(
            f"output to the terminal was lost ({lossy.problem.strerror}); the files are complete"
        )

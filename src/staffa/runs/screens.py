"""Screens on which a run shows its progress: a terminal, a notebook, or none."""

import sys
from html import escape
from textwrap import fill
from time import perf_counter
from types import TracebackType
from typing import Any, Protocol, Self

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

# Seconds between two refreshments of a line in a notebook; each one is a message to a browser.
REFRESH = 0.25
COLUMNS = 80  # of a message in a notebook


class Screen(Protocol):
    """Place where progress is shown, entered as a context while a run goes on."""

    @property
    def each_step(self) -> bool:
        """True if it shows a line for each step."""

    def __enter__(self) -> Self:
        """Begin the live line."""

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End the live line."""

    def say(self, line: str) -> None:
        """Show a line that stays."""

    def show(self, done: float | None, text: str) -> None:
        """Refresh the live line.

        Parameters
        ----------
        done : finished part of the run, from 0 to 1; None if not known.
        text : text beside the bar.
        """


class NoScreen:
    """Screen of a run that nobody looks at."""

    each_step = False

    def __enter__(self) -> Self:
        """Begin nothing."""
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """End nothing."""

    def say(self, line: str) -> None:
        """Drop a line."""

    def show(self, done: float | None, text: str) -> None:
        """Drop the live line, as `Screen.show`."""


class TerminalScreen:
    """Live line of a terminal below lines that stay; in a file or a pipe the latter alone."""

    def __init__(self, console: Console, *, each_step: bool) -> None:
        """Prepare the line.

        Parameters
        ----------
        console : console of the terminal.
        each_step : True to show a line for each step.
        """
        self.each_step, self._console = each_step, console
        self._progress = Progress(
            BarColumn(bar_width=10),
            TextColumn("{task.description}", markup=False),
            console=console,
            transient=True,
            disable=not console.file.isatty(),  # FORCE_COLOR, as in a notebook, is no terminal
        )
        self._task = self._progress.add_task("starting", total=None)

    def __enter__(self) -> Self:
        """Begin the live line."""
        self._progress.start()
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Remove the live line."""
        self._progress.stop()

    def say(self, line: str) -> None:
        """Print a line above the live one."""
        self._console.print(line, markup=False, soft_wrap=True)

    def show(self, done: float | None, text: str) -> None:
        """Refresh the live line, as `Screen.show`."""
        total = None if done is None else 1.0
        self._progress.update(self._task, total=total, completed=done or 0.0, description=text)


class NotebookScreen:
    """Live line in the output of a notebook's cell; the last one stays."""

    each_step = False

    def __init__(self, display: Any) -> None:
        """Prepare the line; `display` is the function of IPython."""
        self._display = display
        self._handle: Any = None
        self._latest: tuple[float | None, str] = (None, "starting")
        self._shown = 0.0

    def __enter__(self) -> Self:
        """Show the line for the first time."""
        self._handle = self._display(self._bundle(), raw=True, display_id=True)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        """Show the last state."""
        self._refresh()

    def say(self, line: str) -> None:
        """Print a message; a page does not wrap it."""
        print(fill(line, COLUMNS, subsequent_indent="    "))

    def show(self, done: float | None, text: str) -> None:
        """Refresh the live line, as `Screen.show`, some times a second."""
        self._latest = (done, text)
        if perf_counter() - self._shown > REFRESH:
            self._refresh()

    def _refresh(self) -> None:
        self._shown = perf_counter()
        if self._handle is not None:
            self._handle.update(self._bundle(), raw=True)

    def _bundle(self) -> dict[str, str]:
        done, text = self._latest
        value = "" if done is None else f' value="{done:.3f}"'
        bar = f'<progress{value} aria-label="finished part of the run"></progress>'
        line = escape(text) if done == 1.0 else f"{bar} {escape(text)}"
        return {"text/plain": text, "text/html": f"<div>{line}</div>"}


def screen_of_python(*, speaks: bool) -> Screen:
    """Return the screen of a Python session: of a notebook or a terminal, else none.

    Parameters
    ----------
    speaks : True on rank 0, which alone shows.
    """
    if not speaks:
        return NoScreen()
    if (display := _notebook_display()) is not None:
        return NotebookScreen(display)
    if sys.stdout is not None and sys.stdout.isatty():
        return TerminalScreen(Console(highlight=False), each_step=False)
    return NoScreen()


def _notebook_display() -> Any:
    """Return IPython's `display` if a kernel, that of a notebook, runs this process; else None."""
    ipython = sys.modules.get("IPython")  # loaded by whoever began the notebook
    shell = ipython.get_ipython() if ipython else None
    if getattr(shell, "kernel", None) is None:
        return None
    from IPython.display import display

    return display

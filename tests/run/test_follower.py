"""A run from Python is logged as one from the command line, and shows its progress."""

import io
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest
from rich.console import Console

import staffa
from staffa.errors import InputError
from staffa.runs.follower import Follower
from staffa.runs.run import Watcher
from staffa.runs.screens import NoScreen, NotebookScreen, TerminalScreen, screen_of_python

SHORT = ("domain.h=0.04", "time.tau=[0.1,0.2]", "output.at=[]")


class Display:
    """Browser that keeps all that IPython's `display` sends."""

    def __init__(self) -> None:
        self.bundles: list[dict[str, str]] = []

    def __call__(self, bundle: dict[str, str], *, raw: bool, display_id: bool) -> "Display":
        assert raw and display_id
        self.bundles.append(bundle)
        return self

    def update(self, bundle: dict[str, str], *, raw: bool) -> None:
        assert raw
        self.bundles.append(bundle)


def notebook(monkeypatch: pytest.MonkeyPatch) -> Display:
    """Let this process look like the kernel of a notebook."""
    display = Display()
    shell = SimpleNamespace(kernel=object())
    ipython = SimpleNamespace(get_ipython=lambda: shell, display=None)
    monkeypatch.setitem(sys.modules, "IPython", ipython)
    monkeypatch.setitem(sys.modules, "IPython.display", SimpleNamespace(display=display))
    return display


def test_a_notebook_sees_messages_and_one_line_that_ends_as_the_result(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    display = notebook(monkeypatch)
    steps = staffa.run(staffa.ready_case("notched", SHORT), tmp_path / "run")
    first, last = display.bundles[0], display.bundles[-1]
    assert "<progress" in first["text/html"] and "starting" in first["text/plain"]
    assert last["text/plain"].startswith("finished: 2 steps, 0:"), last
    assert f"{len(steps[-1].tips)} cracks to" in last["text/plain"]
    assert "<progress" not in last["text/html"]
    said = capsys.readouterr().out.splitlines()
    assert "1,248 unknowns, 2 steps, AT1" in said[0]
    assert not [line for line in said if "sweeps" in line]


def test_a_script_without_a_terminal_prints_nothing_and_leaves_a_log(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    steps = staffa.run(staffa.ready_case("notched", SHORT), tmp_path / "run")
    assert capsys.readouterr().out == ""
    log = (tmp_path / "run" / "run.log").read_text(encoding="utf-8").splitlines()
    assert len([line for line in log if " sweeps" in line]) == len(steps) == 2
    assert any(line.startswith("  warning: ell/h = 1") for line in log), log


def test_a_watcher_of_a_script_stands_in_place_of_log_and_progress(tmp_path: Path) -> None:
    staffa.run(staffa.ready_case("notched", SHORT), tmp_path / "run", watcher=Watcher())
    assert not (tmp_path / "run" / "run.log").exists()
    with pytest.raises(InputError, match="watcher"):
        staffa.run(staffa.ready_case("notched", SHORT), tmp_path / "other", watcher=print)


def test_a_resumed_run_shows_where_it_goes_on(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    seen: list[object] = []
    watcher = Watcher(stepped=seen.append, stop=lambda: "enough" if seen else None)
    with pytest.raises(staffa.errors.StoppedError):
        staffa.run(staffa.ready_case("notched", SHORT), tmp_path / "run", watcher=watcher)
    display = notebook(monkeypatch)
    staffa.resume(tmp_path / "run")
    assert "goes on after step 0" in capsys.readouterr().out
    assert display.bundles[-1]["text/plain"].startswith("finished: 2 steps")


def test_the_screen_is_that_of_the_session(monkeypatch: pytest.MonkeyPatch) -> None:
    assert isinstance(screen_of_python(speaks=True), NoScreen)  # pytest has the output
    monkeypatch.setattr(sys, "stdout", SimpleNamespace(isatty=lambda: True, write=len, flush=int))
    assert isinstance(screen_of_python(speaks=True), TerminalScreen)
    assert isinstance(screen_of_python(speaks=False), NoScreen)
    notebook(monkeypatch)
    assert isinstance(screen_of_python(speaks=True), NotebookScreen)


def test_what_cannot_be_printed_is_spelled_out(tmp_path: Path) -> None:
    shown = io.StringIO()
    screen = TerminalScreen(Console(file=shown), each_step=True)
    Follower(directory=tmp_path, speaks=True, screen=screen).said("a \x1b[2J name")
    assert "\x1b" not in shown.getvalue() and r"\x1b[2J" in shown.getvalue()

"""Pictures of a run in a session of Python: figures by name, shown by a notebook."""

import subprocess
import sys
from pathlib import Path

import pytest
from matplotlib.figure import Figure

import staffa
from staffa.errors import InputError
from staffa.io.run_directory import Run
from staffa.report.captions import caption

SHORT = ("domain.h=0.04", "time.tau=[0.1,0.4]", "output.at=[0.1]")


@pytest.fixture(scope="module")
def run(tmp_path_factory: pytest.TempPathFactory) -> Run:
    """A short run."""
    folder = tmp_path_factory.mktemp("inline") / "run"
    staffa.run(staffa.ready_case("notched", SHORT), folder)
    return staffa.open_run(folder)


def test_a_run_draws_its_standard_pictures(run) -> None:
    pictures = run.plot()
    assert list(pictures) == ["cracks", "network", "energies", "reactions", "lengths"]
    assert len(pictures) == 5 and not pictures.skipped
    assert isinstance(pictures["cracks"], Figure)
    assert repr(pictures) == "pictures: cracks, network, energies, reactions, lengths"


def test_a_notebook_shows_each_picture_with_its_caption_for_those_who_do_not_see(run) -> None:
    page = run.plot("cracks", "energies")._repr_html_()
    assert page.count('<img src="data:image/png;base64,') == 2
    text = caption("energies", run.manifest, run.steps)
    assert page.count(text) == 2  # below the picture, and instead of it


def test_an_unknown_picture_is_refused_with_those_that_there_are(run) -> None:
    for ask in (lambda: run.plot("crack"), lambda: run.plot("cracks")["energies"]):
        with pytest.raises(InputError, match=r"the run has no picture '.*'; it has .*cracks"):
            ask()


def test_a_run_without_steps_says_why_there_is_no_picture(run, tmp_path: Path) -> None:
    from dataclasses import replace

    pictures = replace(run, steps=()).plot()
    assert len(pictures) == 0 and "no step is finished yet" in pictures._repr_html_()


def test_opening_a_run_loads_no_matplotlib(run) -> None:
    asked = (
        f"import sys, staffa; staffa.open_run({str(run.path)!r}); "
        "print([name for name in ('matplotlib', 'pyvista', 'dolfinx') if name in sys.modules])"
    )
    said = subprocess.run([sys.executable, "-c", asked], capture_output=True, text=True, check=True)
    assert said.stdout.strip() == "[]"

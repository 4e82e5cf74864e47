"""A script's own quantities: recorded at each step, shown, asked for again, refused if wrong."""

import csv
import io
from collections.abc import Callable
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
import pytest
from dolfinx import fem

import staffa
from staffa.errors import InputError
from staffa.evolution.session import Session
from staffa.io.run_directory import open_run
from staffa.model.fields import State, owned
from staffa.plot.quantity_curves import quantities_figure
from staffa.results.series import quantities_table
from staffa.results.summary import summary
from staffa.runs.resume import resume
from staffa.runs.run import run
from staffa.runs.run_observers import Watcher
from support.restarting import After, small, stopped

SHORT = ("time.tau=[0.1,0.2,0.3]", "output.at=[]")


def damaged_area(session: Session, state: State) -> float:
    """Integral of the damage, from a form that is compiled once for each mesh."""
    form = session.tool(_integral)
    return float(session.comm.allreduce(fem.assemble_scalar(form), op=MPI.SUM))


def _integral(session: Session) -> fem.Form:
    import ufl

    return fem.form(session.state.alpha * ufl.dx)


def extremes(session: Session, state: State) -> list[float]:
    """Least and largest temperature."""
    T = owned(state.T)
    low, high = T.min(initial=np.inf), T.max(initial=-np.inf)
    comm = session.comm
    return [comm.allreduce(low, op=MPI.MIN), comm.allreduce(high, op=MPI.MAX)]


extremes.name, extremes.unit = "extremes", "K"  # a plain function will do
AREA = staffa.StepQuantity(name="damaged_area", unit="m²", value=damaged_area)
BOTH = (AREA, extremes)


def constant(value: object, name: str = "x", unit: str = "") -> staffa.StepQuantity:
    """A quantity that always gives this."""
    return staffa.StepQuantity(name=name, unit=unit, value=lambda session, state: value)


def test_quantities_are_recorded_tabled_shown_and_drawn(tmp_path: Path) -> None:
    """Also through a stop: what resume gives is what the whole run gave."""
    whole = run(small(*SHORT), tmp_path / "whole", quantities=BOTH)
    said = stopped(
        lambda: run(
            small(*SHORT), tmp_path / "cut", quantities=BOTH, watcher=Watcher(stop=After(8))
        )
    )
    assert "staffa resume" in said
    steps = resume(tmp_path / "cut", quantities=reversed(BOTH))
    assert [step.quantities for step in steps] == [step.quantities for step in whole]
    found = open_run(tmp_path / "cut")
    assert [q.name for q in found.manifest.quantities] == ["damaged_area", "extremes"]
    areas = [step.quantities["damaged_area"][0] for step in found.steps]
    assert 0 < areas[0] < areas[-1] < 0.4, "within the body of 1 x 0.4, and growing"
    low, high = found.steps[-1].quantities["extremes"]
    assert low < high <= 0
    rows = list(csv.DictReader(io.StringIO(quantities_table(found).csv())))
    assert list(rows[0])[3:] == ["damaged_area_m2", "extremes_1_K", "extremes_2_K"]
    assert [float(row["damaged_area_m2"]) for row in rows] == areas
    assert found.to_frame()["quantities_damaged_area"].tolist() == areas
    shown = {fact.name: fact.text for fact in summary(found)}
    assert shown["damaged_area"] == f"{areas[-1]:.5g} m²"
    assert shown["extremes"] == f"{low:.5g}, {high:.5g} K"
    figure = quantities_figure(found.manifest, found.steps)
    assert [axes.get_ylabel() for axes in figure.axes[:2]] == ["damaged_area (m²)", "extremes (K)"]
    assert list(figure.axes[0].lines[0].get_ydata()) == areas


def test_a_run_asks_for_its_quantities_again(tmp_path: Path) -> None:
    watcher = Watcher(stop=After(8))
    stopped(lambda: run(small(*SHORT), tmp_path / "r", quantities=[AREA], watcher=watcher))
    other_unit = staffa.StepQuantity(name="damaged_area", unit="mm²", value=damaged_area)
    for given, words in {
        (): ("records the quantity 'damaged_area'", "go on from Python"),
        BOTH: ("does not record the quantity 'extremes'", "leave it out"),
        (other_unit,): ("in 'm²', not in 'mm²'", "the same unit"),
        (constant([1.0, 2.0], name="damaged_area", unit="m²"),): ("gives 2 numbers, and gave 1",),
    }.items():
        with pytest.raises(InputError) as caught:
            resume(tmp_path / "r", quantities=given)
        assert all(word in str(caught.value) for word in words), str(caught.value)


def fails(session: Session, state: State) -> float:
    """As a user's function may."""
    raise KeyError("no such thing")


@pytest.mark.parametrize(
    ("quantities", "words"),
    [
        (3, ("quantities = 3 is an int", "give a list")),
        ("area", ("quantities = 'area'", "give a list")),
        ([staffa.StepQuantity], ("is a class", "give an object")),
        ([damaged_area], ("has no name and no unit", "staffa.StepQuantity")),
        ([constant(1.0, name="my area")], ("the name 'my area'", "choose another")),
        ([constant(1.0, name="elastic")], ("'elastic' is that of a number", "another name")),
        ([constant(1.0), constant(2.0)], ("two have the name 'x'", "rename one")),
        (
            [constant([1.0, 2.0]), constant(3.0, name="x_1")],
            ("'x' and 'x_1' both have the column 'x_1'", "rename one"),
        ),
        ([constant(1.0, unit="$m$")], ("the unit '$m$' of 'x'", "shorten it")),
        ([constant(1.0, unit=1)], ("its unit = 1", "give a text")),
        ([constant(np.nan)], ("the quantity 'x' gives nan", "finite numbers")),
        ([constant("much")], ("gives an array of shape ()", "give a number")),
        ([constant([])], ("gives an array of shape (0,)", "give a number")),
        ([constant(np.ones((2, 2)))], ("shape (2, 2)", "a list of 1 to 100")),
        (
            [staffa.StepQuantity(name="x", unit="", value=fails)],
            ("the quantity 'x' fails (KeyError: 'no such thing')", "fix it"),
        ),
    ],
)
def test_a_wrong_quantity_is_refused_before_anything_is_written(
    quantities: object, words: tuple[str, ...], tmp_path: Path
) -> None:
    with pytest.raises(InputError) as caught:
        run(small(*SHORT), tmp_path / "run", quantities=quantities)
    assert all(word in str(caught.value) for word in words), str(caught.value)
    assert not (tmp_path / "run").exists() and caught.value.exit_code == 2


def in_time(sound: Callable[[], float], late: Callable[[], object]) -> staffa.StepQuantity:
    """A quantity that is sound before the rock cools, and then is not."""

    def value(session: Session, state: State) -> object:
        return late() if np.abs(state.T.x.array).max() > 0 else sound()

    return staffa.StepQuantity(name="x", unit="", value=value)


@pytest.mark.parametrize(
    ("late", "words"),
    [
        (lambda: np.inf, "the quantity 'x' gives inf"),
        (lambda: [1.0, 2.0], "gives 2 numbers, and gave 1 before"),
        (lambda: 1 / 0, "fails (ZeroDivisionError: division by zero)"),
    ],
)
def test_one_that_turns_wrong_stops_the_run_and_the_right_one_goes_on(
    late: Callable[[], object], words: str, tmp_path: Path
) -> None:
    """Nothing of the current step is on record, and resume takes it again."""
    said = stopped(
        lambda: run(small(*SHORT), tmp_path / "run", quantities=[in_time(lambda: 1.0, late)])
    )
    assert words in said and "before its first step was finished" in said, said
    steps = resume(tmp_path / "run", quantities=[constant(1.0)])
    assert [step.quantities for step in steps] == [{"x": (1.0,)}] * 3
    expected = run(small(*SHORT), tmp_path / "whole")
    assert [step.energies for step in steps] == [step.energies for step in expected]

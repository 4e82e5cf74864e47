"""The session owns what is built for one mesh: another can take its place between two steps."""

import gc
import weakref
from pathlib import Path

from staffa.backend.stack import MPI  # noqa: F401

import numpy as np
import pytest

from staffa.backend.parallel import on_root
from staffa.case.schema.toml_text import to_toml
from staffa.evolution.effective_toughness import effective_gc_ratio
from staffa.evolution.march import march_session
from staffa.evolution.session import Session, interpolated
from staffa.evolution.system import build
from staffa.io import run_directory
from staffa.io.run_directory import Run, open_run
from staffa.io.vtkhdf import read_vtkhdf
from staffa.model.fields import vertices
from staffa.runs.checkpoints import CheckpointWriter
from staffa.runs.run import describe, open_session
from staffa.runs.run_observers import Watcher, observers
from staffa.setup.build import problem
from support.restarting import small

TRIANGLE, QUADRILATERAL = 5, 9  # vtkCellType.h
WELL = 'output.probes=[{name="well",point=[0.3,0.1]}]'
FIRST, SECOND = "domain.cells=triangle", "domain.cells=quadrilateral"
PLAIN = ("output.steps=all", WELL)
CHANGED_AFTER = 3
FEW = ("time.tau=[0.1,0.3]", "output.at=[]", "solver.stability=none")  # ranks are slow


def run_with_change(directory: Path, *settings: str, after: int = CHANGED_AFTER) -> Run:
    """The small run, on quadrilaterals from the end of a step on."""
    case, other = small(FIRST, *PLAIN, *settings), small(SECOND, *PLAIN, *settings)
    setup = problem(case)
    opening = open_session(setup, effective_gc_ratio(setup))
    del setup
    with opening as session:
        manifest = on_root(session.comm, lambda: describe(case, session, {}))
        text = to_toml(case)
        on_root(session.comm, lambda: run_directory.create(directory, text, manifest))
        journal = run_directory.Journal(directory)
        writer = CheckpointWriter(directory, session, case.output.checkpoint, journal)
        looking_on = observers(case, session, manifest, Watcher(), writer, ())
        old = None
        for step in march_session(session, looking_on):
            writer.note(step)
            if old is not None:
                gc.collect()
                held = [name for name, thing in old.items() if thing() is not None]
                assert not held, f"of the first mesh there still is {held}"
                old = None
            if step.index == after:
                old = {"system": weakref.ref(session.system), "mesh": weakref.ref(session.domain)}
                new = problem(other)
                session.replace(new, interpolated(session, new))
        assert session.changes == 1 and step.index > after
    return open_run(directory)


@pytest.mark.slow
@pytest.mark.parametrize("settings", [(), ("solver.backtracking=true",)], ids=["plain", "back"])
def test_observers_writer_probes_and_measures_use_the_new_mesh(tmp_path, settings) -> None:
    """Nothing of the first mesh is left, and the run goes on as without the change."""
    from staffa.runs.run import run

    changed = run_with_change(tmp_path / "changed", *settings)
    run(small(FIRST, *PLAIN, *settings), tmp_path / "same")
    same = open_run(tmp_path / "same")
    assert changed.finished and len(changed.steps) == len(same.steps) == 6
    for one, other in zip(changed.steps, same.steps, strict=True):
        grid, values = read_vtkhdf(changed.path / one.fields)
        expected = TRIANGLE if one.index <= CHANGED_AFTER else QUADRILATERAL
        assert grid.type == expected, f"step {one.index} was written on cells {grid.type}"
        assert len(values["alpha"]) == len(grid.points) and len(values["stress"]) == len(grid.cells)
        assert one.audit.violations == (), one.audit.violations
        assert one.energies.total == pytest.approx(other.energies.total, rel=0.03)
        assert one.measures.length_surface == pytest.approx(other.measures.length_surface, rel=0.05)
        T, *u, alpha = (abs(a - b) for a, b in zip(one.probed[0], other.probed[0], strict=True))
        assert T < 1e-9 and alpha < 1e-9, "a vertex of both, where no crack grows any more"
        assert max(u) < 0.1, "of 7, beside a crack, on other cells"


def test_a_tool_is_built_once_for_each_mesh() -> None:
    built = []

    def tool(session: Session, name: str) -> str:
        built.append((session.changes, name))
        return f"{name} of mesh {session.changes}"

    setup = problem(small(FIRST))
    session = Session(setup, build(setup))
    assert [session.tool(tool, "gauge") for _ in range(2)] == ["gauge of mesh 0"] * 2
    first = session.toughness_factor
    new = problem(small(SECOND))
    session.replace(new, interpolated(session, new))
    assert session.tool(tool, "gauge") == "gauge of mesh 1"
    assert built == [(0, "gauge"), (1, "gauge")]
    assert session.toughness_factor != first and session.domain is new.domain
    session.destroy()


def test_a_state_is_interpolated_with_its_bound() -> None:
    """Linear fields are the same on the other mesh, and the damage stays above its bound."""
    setup = problem(small(FIRST))
    session = Session(setup, build(setup))
    state, bounds = session.state, session.system.bounds
    state.u.interpolate(lambda x: (1 + 2 * x[0] - x[1], x[0] + 3 * x[1]))
    state.T.interpolate(lambda x: -1 - x[0])
    state.alpha.interpolate(lambda x: 0.2 + 0.5 * x[0])
    bounds.lower.interpolate(lambda x: 0.1 + 0.5 * x[0])
    new = problem(small(SECOND))
    system = interpolated(session, new)
    x = vertices(system.spaces.alpha)
    assert system.state.T.x.array == pytest.approx(-1 - x[:, 0], abs=1e-12)
    assert system.state.alpha.x.array == pytest.approx(0.2 + 0.5 * x[:, 0], abs=1e-12)
    assert system.bounds.lower.x.array == pytest.approx(0.1 + 0.5 * x[:, 0], abs=1e-12)
    u = system.state.u.x.array.reshape(-1, 2)
    expected = np.column_stack([1 + 2 * x[:, 0] - x[:, 1], x[:, 0] + 3 * x[:, 1]])
    assert u == pytest.approx(expected, abs=1e-12)
    session.replace(new, system)
    session.destroy()

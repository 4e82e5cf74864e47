"""Series of every step: reactions in equilibrium, fields at points, on any ranks."""

import csv
from dataclasses import replace
from io import StringIO
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
import pytest

from report.test_report import drawn_manifest, drawn_step
from staffa.errors import InputError
from staffa.evolution.march import Observers, march
from staffa.evolution.system import build
from staffa.io.run_directory import Journal, create, open_run
from staffa.measure.probes import Probes
from staffa.model.domain import block
from staffa.model.fields import linear_spaces, vertices, zero_state
from staffa.model.supports import SideSupport, clamped, rollers
from staffa.records.manifest import Probe
from staffa.records.step import Step
from staffa.results.series import probes_table, reactions_table
from support.bodies import UNSTRUCTURED, body, rock

PULL = 0.01
CELLS = {
    "quadrilateral": (1.0, 0.6),
    "triangle": (1.0, 0.6),
    "hexahedron": (1.0, 0.6, 0.4),
    "tetrahedron": (1.0, 0.6, 0.4),
}
LINE = Probe(name="axis", points=((0.0, 0.0), (0.31, 0.2), (1.0, 0.6)))
SPOT = Probe(name="well", points=((0.5, 0.3),))


def held(size, cells: str, *sides: str, h: float = 0.2) -> Step:
    """A block pulled along x at its right side, held by these; nu = 0.2."""
    domain = block(MPI.COMM_WORLD, size=size, h=h, cells=cells)
    ways = {"rollers": rollers, "clamped": clamped}
    supports = [ways[way](domain, side) for way, side in (pair.split() for pair in sides)]
    pull = SideSupport(side="right", components={0: lambda x, t: PULL * t})
    state = "plane stress" if len(size) == 2 else "solid"
    problem = body(size, h, cells=cells, sides=(*supports, pull), material=rock(state=state))
    system = build(problem)
    (step,) = march(problem, system, Observers())
    system.destroy()
    return step


@pytest.mark.parametrize("cells", CELLS)
def test_a_bar_pulled_carries_its_stress_times_its_section(cells: str) -> None:
    size = CELLS[cells]
    step = held(size, cells, "rollers left", "rollers bottom")
    stiffness = 1 + 1e-6  # E = 1, and what is left in a crack
    force = stiffness * PULL / size[0] * np.prod(size[1:])  # free to contract
    assert step.reactions["right"][0] == pytest.approx(force, rel=1e-9)
    assert step.reactions["left"][0] == pytest.approx(-force, rel=1e-9)
    assert step.reactions["bottom"] == pytest.approx([0.0] * len(size), abs=1e-12)


@pytest.mark.parametrize("cells", ["quadrilateral", "hexahedron", UNSTRUCTURED])
def test_reactions_balance_and_no_corner_counts_twice(cells: str) -> None:
    """Sides that share vertices, all clamped: what they carry together is nothing."""
    size = CELLS.get(cells, (1.0, 0.6))
    step = held(size, cells, "clamped left", "clamped bottom", "clamped top")
    total = np.sum([*step.reactions.values()], axis=0)
    largest = np.abs([*step.reactions.values()]).max()
    assert largest > 1e-3 and np.abs(total).max() < 1e-9 * largest


def test_reactions_and_probes_survive_the_record() -> None:
    step = replace(
        drawn_step(1, (1.0, 1.0), None), reactions={"left": (1.0, -2.0)}, probed=((0.5,),)
    )
    assert Step.from_record(step.to_record()) == step
    record = step.to_record()
    del record["reactions"], record["probed"]
    assert Step.from_record(record) == replace(step, reactions={}, probed=())


@pytest.mark.parametrize("cells", CELLS)
def test_probes_read_linear_fields_exactly_on_sides_and_corners_too(cells: str) -> None:
    size = CELLS[cells]
    dim = len(size)
    domain = block(MPI.COMM_WORLD, size=size, h=0.1, cells=cells)
    state = zero_state(linear_spaces(domain))
    x = vertices(state.alpha.function_space)
    state.u.x.array[:] = (x * [1.0, 2.0, 3.0])[:, :dim].ravel()
    state.alpha.x.array[:] = x[:, 0]
    state.T.x.array[:] = 7 * x[:, 0] - x[:, 1]
    points = np.array([[0.0] * dim, size, [0.33 * s for s in size], [0.0, *size[1:]]])
    looks = Probes(domain, [Probe(name="p", points=tuple(map(tuple, points)))])
    expected = np.column_stack(
        [7 * points[:, 0] - points[:, 1], points * [1.0, 2.0, 3.0][:dim], points[:, 0]]
    )
    assert np.array(looks(state)) == pytest.approx(expected, abs=1e-13)
    assert Probes(domain, [])(state) == ()


def test_a_probe_in_no_cell_is_refused() -> None:
    domain = block(MPI.COMM_WORLD, size=(1.0, 0.6), h=0.1, cells="quadrilateral")
    with pytest.raises(InputError, match=r"'well' has a point at \(0.5, 0.7, 0\).*move it"):
        Probes(domain, [LINE, Probe(name="well", points=((0.5, 0.7),))])


def test_tables_have_a_row_for_each_step_side_and_point(tmp_path: Path) -> None:
    create(tmp_path, "", replace(drawn_manifest((1.0, 0.6)), probes=(SPOT, LINE)))
    for index in (1, 2):
        step = drawn_step(index, (1.0, 0.6), None)
        probed = tuple((float(row), 0.1, 0.2, 0.9) for row in range(4))
        Journal(tmp_path).append(replace(step, reactions={"left": (1.0, -2.0)}, probed=probed))
    run = open_run(tmp_path)
    assert run.manifest.probes == (SPOT, LINE)
    rows = list(csv.DictReader(StringIO(probes_table(run).csv())))
    assert [row["name"] for row in rows] == ["well", "axis", "axis", "axis"] * 2
    assert float(rows[3]["s"]) == pytest.approx(np.hypot(1, 0.6))
    assert [row["T"] for row in rows[:4]] == ["0.0", "1.0", "2.0", "3.0"]
    assert rows[3]["x"] == "1.0" and rows[3]["alpha"] == "0.9"
    rows = list(csv.DictReader(StringIO(reactions_table(run).csv())))
    assert [(row["step"], row["side"], row["fy"]) for row in rows] == [
        ("1", "left", "-2.0"),
        ("2", "left", "-2.0"),
    ]


def test_without_supports_and_probes_there_are_no_tables(tmp_path: Path) -> None:
    create(tmp_path, "", drawn_manifest((1.0, 0.6)))
    Journal(tmp_path).append(drawn_step(1, (1.0, 0.6), None))
    run = open_run(tmp_path)
    assert reactions_table(run).rows == () and probes_table(run).rows == ()

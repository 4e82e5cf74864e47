"""Output fields: one registry, a key of the case, and values that are known in closed form."""

import re
from dataclasses import replace
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
import pytest
import pyvista

from staffa.evolution.march import march_session
from staffa.evolution.output_fields import DEFAULT, FIELDS, field_values
from staffa.evolution.problem import Problem
from staffa.evolution.session import Session
from staffa.evolution.system import build
from staffa.io.field_output import FieldWriter
from staffa.io.run_directory import open_run
from staffa.io.vtkhdf import read_vtkhdf
from staffa.model.domain import block
from staffa.model.supports import SideSupport, no_displacement
from staffa.runs.resume import resume
from staffa.runs.run import run
from support.bodies import Unbreakable, body, rock
from support.paths import DOCS
from support.restarting import small

STRETCH, RESIDUAL = 0.01, 1 + 1e-6  # of the displacement; stiffness with its residual

SHAPES = {"vertices": {"u": (3,)}, "cells": {"stress": (9,), "strain": (9,)}}


def layers(x: np.ndarray) -> np.ndarray:
    """Young's modulus that varies across the direction of the pull."""
    return 1 + x[1]


def pulled(size=(1.0, 0.5), state="plane stress", **more) -> Problem:
    """Rock without lateral contraction, pulled along x alone: every layer has its own stress."""
    sides = (
        SideSupport(side="left", components={0: no_displacement}),
        SideSupport(side="right", components={0: lambda x, t: STRETCH * t}),
        SideSupport(side="bottom" if len(size) == 2 else "front", components={1: no_displacement}),
    )
    if len(size) == 3:
        sides += (SideSupport(side="bottom", components={2: no_displacement}),)
    material = rock(E=layers, nu=0.0, Gc=2.5, law=Unbreakable(), state=state)
    return body(size, 0.1, sides=sides, material=material, **more)


def written(problem: Problem, path: Path) -> Path:
    """The file of every field after one step."""
    session = Session(problem, build(problem))
    list(march_session(session))
    at_vertices, in_cells = field_values(session, FIELDS)
    FieldWriter(session.comm, session.system.spaces).write(path, at_vertices, in_cells)
    session.destroy()
    return path


@pytest.mark.parametrize("size", [(1.0, 0.5), (1.0, 0.5, 0.3)])
def test_uniaxial_stress_is_read_back_by_paraviews_reader(tmp_path: Path, size) -> None:
    """Stress E e, energy density E e^2/2, and E, layer by layer, to the residual stiffness."""
    state = "plane stress" if len(size) == 2 else "solid"
    grid = pyvista.read(written(pulled(size, state), tmp_path / "pulled.vtkhdf"))
    middles = grid.cell_centers().points
    E = 1 + middles[:, 1]
    expected = np.zeros((len(E), 9))
    expected[:, 0] = RESIDUAL * E * STRETCH
    assert grid.cell_data["stress"] == pytest.approx(expected, rel=1e-9, abs=1e-12)
    assert grid.cell_data["energy_density"] == pytest.approx(RESIDUAL * E * STRETCH**2 / 2)
    strain = np.zeros((len(E), 9))
    strain[:, 0] = STRETCH
    assert grid.cell_data["strain"] == pytest.approx(strain, rel=1e-9, abs=1e-12)
    assert grid.cell_data["E"] == pytest.approx(E)
    assert grid.cell_data["Gc"] == pytest.approx(np.full(len(E), 2.5))
    assert grid.point_data["u"][:, 0] == pytest.approx(STRETCH * grid.points[:, 0], abs=1e-12)


def test_strain_around_the_axis_is_u_over_r() -> None:
    domain = block(MPI.COMM_WORLD, size=(1.0, 0.5), h=0.1, cells="triangle", axial=True, hole=0.5)
    problem = replace(pulled(), domain=domain, material=rock(state="axisymmetric"), sides=())
    session = Session(problem, build(problem))
    session.state.u.interpolate(lambda x: (0.02 * x[0], -0.01 * x[1]))
    strain = field_values(session, ["strain"])[1]["strain"]
    expected = np.diag([0.02, -0.01, 0.02]).ravel()
    assert strain == pytest.approx(np.tile(expected, (len(strain), 1)), abs=1e-12)
    session.destroy()


def test_every_field_has_its_shape_and_a_row_in_the_docs() -> None:
    problem = pulled()
    session = Session(problem, build(problem))
    at_vertices, in_cells = field_values(session, FIELDS)
    counts = {
        "vertices": session.system.spaces.alpha.dofmap.index_map.size_local,
        "cells": problem.domain.mesh.topology.index_map(2).size_local,
    }
    for name, field in FIELDS.items():
        values = {**at_vertices, **in_cells}[name]
        assert values.shape == (counts[field.at], *SHAPES[field.at].get(name, ())), name
    session.destroy()
    page = (DOCS / "reference" / "files.md").read_text()
    rows = re.findall(r"^\| `(\w+)` \| (vertices|cells) \| ([^|]*) \|", page, re.MULTILINE)
    assert rows == [(f.name, f.at, f.unit) for f in FIELDS.values()]


def test_a_run_writes_the_fields_of_its_case_and_by_default_those_of_ever(tmp_path: Path) -> None:
    few = 'output.fields=["alpha","T","energy_density"]'
    for name, settings in {"default": (), "few": (few,)}.items():
        run(small("time.tau=[0.1]", "output.at=[]", *settings), tmp_path / name)
    ever = {"u", "alpha", "T", "stress", "opening_strain", "intact_strain"}
    assert set(DEFAULT) == ever and set(_names(tmp_path / "default")) == ever
    assert set(_names(tmp_path / "few")) == {"alpha", "T", "energy_density"}


def _names(directory: Path) -> list[str]:
    found = open_run(directory)
    return list(read_vtkhdf(directory / found.steps[-1].fields)[1])


def test_a_run_directory_of_0_1_0_is_gone_on_with(tmp_path: Path) -> None:
    """There `output.fields` told of which steps the fields are kept."""
    directory = tmp_path / "run"
    run(small("time.tau=[0.1]", "output.at=[]", "output.steps=all"), directory)
    case = directory / "case.toml"
    lines = [line for line in case.read_text().splitlines() if not line.startswith("fields = ")]
    earlier = "\n".join(lines).replace('steps = "all"', 'fields = "all"')
    assert 'fields = "all"' in earlier
    case.write_text(earlier)
    steps = resume(directory, settings=["time.tau=[0.1,0.2,0.3]"])
    assert [bool(step.fields) for step in steps] == [True] * 3
    assert 'steps = "all"' in case.read_text()


def in_order(path: Path) -> dict[str, np.ndarray]:
    """The fields of a file, vertices and cells in the order of their places."""
    grid, values = read_vtkhdf(path)
    places = {
        "vertices": np.round(grid.points, 9),
        "cells": np.round(grid.points[grid.cells].mean(axis=1), 9),
    }
    order = {at: np.lexsort(x.T) for at, x in places.items()}
    return {name: found[order[FIELDS[name].at]] for name, found in values.items()}

"""Openings leave out what intact rock would strain: cold, elastic, and prestressed."""

from dataclasses import dataclass
from pathlib import Path

from staffa.backend.stack import MPI

import numpy as np
import pytest

from staffa.evolution.march import march
from staffa.evolution.output_fields import field_values
from staffa.evolution.problem import Problem
from staffa.evolution.session import Session
from staffa.evolution.system import build
from staffa.io.field_output import FieldWriter
from staffa.io.vtkhdf import read_vtkhdf
from staffa.loads.closed_form import HalfSpace
from staffa.loads.forces import Forces
from staffa.measure.crack import Gauge, crack_volume
from staffa.measure.network import Network, normals
from staffa.measure.opening import evened
from staffa.measure.tracing import network
from staffa.model.initial_cracks import FlatCrack
from staffa.model.supports import SideSupport
from staffa.physics.split import SPLITS
from support.bodies import BOTTOM, body, rock
from support.jumps import jumps

LONG, SHORT, NU = 0.4, 0.2, 0.3
AT = {LONG: 0.6, SHORT: 1.4}  # where on the cooled face


@dataclass(frozen=True, kw_only=True)
class Seen:
    """A state: its network, the middles and openings of its elements, the volume of the step."""

    fields: Path
    network: Network
    middles: np.ndarray
    opening: np.ndarray
    uncertainty: np.ndarray
    volume: float

    def reference(self, **how) -> np.ndarray:
        """The jumps at the middles."""
        across = normals(self.network.points, self.network.elements)
        return jumps(self.fields, self.middles, across, **how)


def cooled(
    ell: float, state: str, *, prestress: float = 0.0, split: str = "none", cells=None
) -> Problem:
    """A plate, or a slice of rock, between rollers, cold from below, with two cracks."""
    solid, h = state == "solid", ell / 4
    size = (2.0, 0.8, 2 * h) if solid else (2.0, 0.8)
    cracks = tuple(
        FlatCrack(center=(x + h / 4, 0.0, h), normal=(1.0, 0.0, 0.0), radius=length)
        for length, x in AT.items()
    )
    held = [("left", 0), ("right", 0), ("top", 1)] + [("front", 2), ("back", 2)] * solid
    sides = tuple(SideSupport(side=s, components={k: lambda x, t: 0.0}) for s, k in held)

    def squeezed(x: np.ndarray) -> np.ndarray:
        return np.tile([[prestress]] * 3 + [[0.0]] * 3, (1, x.shape[1]))

    return body(
        size, h, cells=cells, sides=sides, times=(0.01,),
        load=HalfSpace(dT=1e-3, kappa=1.0, face=BOTTOM),
        material=rock(nu=NU, Gc=1e6, ell=ell, state=state, split=SPLITS[split], cracks=cracks),
        forces=Forces(prestress=squeezed) if prestress else Forces(),
    )  # fmt: skip


def seen(problem: Problem, file: Path) -> Seen:
    """The last state of a problem, as files show it."""
    system = build(problem)
    (_,) = march(problem, system)
    energy, ell, h = system.energy, problem.material.ell, problem.domain.h
    at_vertices, in_cells = field_values(Session(problem, system))
    FieldWriter(MPI.COMM_WORLD, system.spaces).write(file, at_vertices, in_cells)
    gauge = Gauge(face=BOTTOM, depths=(), threshold=0.8, prominence=ell, h=h, toughness_factor=1.0)
    volume = crack_volume(problem.domain, system.state, energy, gauge)
    system.destroy()
    grid, values = read_vtkhdf(file)
    found = network(
        grid.points, grid.cells, alpha=values["alpha"], dim=problem.domain.dim, h=h, ell=ell,
        strains=np.stack([values["opening_strain"], values["intact_strain"]], axis=1),
        crack=0.8, tip=0.25,
    )  # fmt: skip
    return Seen(
        fields=file,
        network=found,
        middles=found.points[found.elements].mean(axis=1),
        opening=found.opening[found.elements].mean(axis=1),
        uncertainty=found.uncertainty[found.elements].mean(axis=1),
        volume=volume,
    )


@pytest.mark.parametrize("prestress", [0.0, -2e-4])
@pytest.mark.parametrize("state", ["plane stress", "plane strain"])
def test_openings_in_cold_rock_are_the_jump_less_intact_strain(
    state: str, prestress: float, tmp_path: Path
) -> None:
    """To 3 %, or 1 % of the largest; two independent references, for a narrow and a wide band."""
    for over, rocks in ((20, (None, (1.0, NU, state))), (5, ((1.0, NU, state),))):
        ell = LONG / over
        found = seen(cooled(ell, state, prestress=prestress), tmp_path / "fields.vtkhdf")
        assert found.network.volume == pytest.approx(found.volume, rel=0.003)
        for given in rocks:
            right = found.reference(reach=2 * ell, expansion=1.0, rock=given, rest=prestress)
            for x in AT.values():
                here = np.isfinite(right) & (np.abs(found.middles[:, 0] - x) < 0.2)
                size = found.network.sizes[here]
                mean, expected = size @ found.opening[here], size @ right[here]
                assert mean == pytest.approx(expected, rel=0.03), (over, given, x)
                inner = here & (found.middles[:, 1] > ell)  # at the face it is evened one-sidedly
                off = np.abs(found.opening - right)[inner] - found.uncertainty[inner]
                allowed = np.maximum(0.03 * np.abs(right[inner]), 0.01 * found.opening.max())
                assert over == 5 or (off < allowed).all(), (given, x, (off / allowed).max())


@pytest.mark.slow
@pytest.mark.parametrize("prestress", [0.0, -2e-4])
def test_openings_in_a_slice_of_rock(prestress: float, tmp_path: Path) -> None:
    """In 3-D, held across: crack by crack."""
    ell = LONG / 10
    found = seen(cooled(ell, "solid", prestress=prestress), tmp_path / "fields.vtkhdf")
    right = found.reference(reach=2 * ell, expansion=1.0, rock=(1.0, NU, "solid"), rest=prestress)
    for x in AT.values():
        here = np.isfinite(right) & (np.abs(found.middles[:, 0] - x) < 0.2)
        size = found.network.sizes[here]
        assert size @ found.opening[here] == pytest.approx(size @ right[here], rel=0.03)


@pytest.mark.parametrize(("state", "share"), [("plane stress", 1.0), ("plane strain", 1.0 + NU)])
def test_free_thermal_strain_is_no_opening(state: str, share: float, tmp_path: Path) -> None:
    """A plate cut in two, whose halves shrink freely: open by expansion T times its length, in
    plane strain by (1 + nu) of that."""
    held = tuple(
        SideSupport(side=side, components={0: lambda x, t: 0.0}) for side in ("left", "right")
    )
    crack = FlatCrack(center=(0.51, 0.0, 0.0), normal=(1.0, 0.0, 0.0), radius=2.0)
    problem = body(
        (1.0, 0.4), 0.02, sides=held, load=Uniform(), times=(1.0,),
        material=rock(nu=NU, Gc=1e6, ell=0.08, state=state, cracks=(crack,)),
    )  # fmt: skip
    found = seen(problem, tmp_path / "fields.vtkhdf")
    assert found.network.volume == pytest.approx(share * 1e-3 * 0.4, rel=0.005)
    assert found.opening == pytest.approx(share * 1e-3, rel=0.02)
    assert found.uncertainty.max() < 0.02e-3


class Uniform:
    """Cold by 1e-3 everywhere."""

    def temperature(self, x: np.ndarray, t: float) -> np.ndarray:
        """At points of shape (3, n)."""
        return np.full(x.shape[1], -1e-3)


@pytest.mark.parametrize(("split", "within"), [("none", 0.035), ("no-tension", 0.055)])
def test_a_pressed_crack_holds_what_its_energy_says(
    split: str, within: float, tmp_path: Path
) -> None:
    """V = 2 (elastic energy)/p; and open like a sharp crack of this volume, an ellipse."""
    a, ell, p = 0.3, 0.03, 0.1
    crack = FlatCrack(center=(0.0, 0.802, 0.0), normal=(0.0, 1.0, 0.0), radius=a)
    left = SideSupport(side="left", components={0: lambda x, t: 0.0})
    problem = body(
        (1.2, 1.6), 0.01, sides=(left,), forces=Forces(crack_pressure=lambda t: p * t),
        material=rock(
            nu=NU, Gc=1e6, ell=ell, state="plane strain", split=SPLITS[split], cracks=(crack,)
        ),
    )  # fmt: skip
    system = build(problem)
    (step,) = march(problem, system)
    fluid = system.energy.crack_volume()
    system.destroy()
    assert 2 * step.energies.elastic / p == pytest.approx(fluid, rel=1e-4)
    found = seen(problem, tmp_path / "fields.vtkhdf")
    assert found.network.volume == pytest.approx(fluid, rel=within)
    assert found.opening.max() == pytest.approx(4 * fluid / (np.pi * a), rel=0.09)


def test_a_closed_crack_has_no_opening_strain() -> None:
    """Round-off does not decide whether the strain beside it counts."""
    system = build(cooled(LONG / 5, "plane stress", split="no-tension"))
    system.state.u.interpolate(lambda x: -1e-4 * np.stack([x[0] + x[1] / 3, x[1]]))
    system.state.alpha.interpolate(lambda x: np.maximum(0, 1 - np.abs(x[0] - 0.61) / 0.1) ** 2)
    openings = system.energy.openings
    round_off = np.abs(openings.volumes() / openings.sizes)
    strains = openings.strains()
    system.destroy()
    assert 0 < round_off.max() < 1e-16
    assert not strains["opening_strain"].any()
    assert not strains["intact_strain"].any()


def test_a_point_of_a_network_without_a_size_has_no_opening() -> None:
    """Networks that are cut off may leave a point of no element, or of one without length."""
    points = np.array(
        [[0.0, 0, 0], [1.0, 0, 0], [2.0, 0, 0], [3.0, 1, 0], [3.0, 1, 0], [5.0, 0, 0]]
    )
    elements, sizes = np.array([[0, 1], [1, 2], [3, 4]]), np.array([1.0, 1.0, 0.0])
    gathered = np.array([0.5, 1.0, 0.5, 0.0, 0.0, 0.0])[:, None]
    even = evened(gathered, points, elements, sizes, 0.3)[:, 0]
    assert even == pytest.approx([1.0, 1.0, 1.0, 0.0, 0.0, 0.0], abs=1e-12)


def test_a_corner_that_hangs_on_slivers_alone_has_no_opening() -> None:
    """Surfaces have triangles of no area, up to round-off: a volume over that is no opening."""
    points = np.array([[0.0, 0, 0], [1.0, 0, 0], [0.0, 1, 0], [0.5, -1e-20, 0], [0.5, 0, 0]])
    elements, sizes = np.array([[0, 1, 2], [0, 1, 3], [3, 4, 0]]), np.array([0.5, 5e-21, 1e-21])
    gathered = np.array([0.2, 0.2, 0.1, 1e-4, 0.0])[:, None]
    even = evened(gathered, points, elements, sizes, 0.3)[:, 0]
    assert even[:3].min() > 0.5 and even[:3].max() < 1.5
    assert even[3:].tolist() == [0.0, 0.0]

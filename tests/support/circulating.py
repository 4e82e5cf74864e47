"""Runs whose circulation is given: wells, rock and water in numbers that a hand can follow."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from scipy.special import erfc

from staffa.display_units import Unit
from staffa.io.reservoir_fields import cell_mesh, write_reservoir
from staffa.io.run_directory import Journal, Run, create, fields_name, open_run
from staffa.io.vtkhdf import write_vtkhdf
from staffa.records.circulation import Circulation, WellAccount
from staffa.records.crack_flow import CrackFlow
from staffa.records.manifest import Manifest
from staffa.records.reservoir_facts import (
    CrackRule,
    FractureFlow,
    ReservoirFacts,
    WellFacts,
)
from staffa.records.status import Status
from staffa.records.step import Energies, Heat, Measures, Step

DAY = 86400.0
HOT, COLD, FAR = 473.15, 333.15, 20e6
K, RHO_C, WATER = 2.5, 2.3e6, 4.2e6
SIZE = (60.0, 30.0)
EDGES = (np.linspace(0.0, 60.0, 31), np.array([-0.05, *np.linspace(0.0, 30.0, 16), 34.0, 42.0]))
BOX = ((-20.0, 60.0, 41), (0.0, 30.0, 16), (0.0, 40.0, 21))  # ends and faces along each axis
RULE = CrackRule(smallest=2e-5, largest=2e-3, spread=8.0)
CRACKS = CrackFlow(area=240.0, volume=0.08, widest=1.2e-3, permeability=4e-12)
UNITS = {
    "length": Unit(name="m"),
    "opening": Unit(name="mm", size=1e-3),
    "time": Unit(name="d", size=DAY),
    "stress": Unit(name="MPa", size=1e6),
    "temperature": Unit(name="°C", zero=273.15),
}
LENGTH, FLOW = 60.0, 2e-5  # of the fracture (m), and in it (m^2/s)


def facts(**changes: object) -> ReservoirFacts:
    """A layer of 1 m of 60 m x 30 m, an injector at its left end and a producer at its right."""
    whole = ReservoirFacts(
        simulator="tried 1.0", thickness=1.0, T=HOT, T_injected=COLD, pressure=FAR,
        conductivity=K, rho_c=RHO_C, water_rho=1000.0, water_c=4200.0, heat_in_place=1e9,
        wells={
            "in": WellFacts(at=(0.5, -0.025, 0.5), T_rock=HOT, p_rock=FAR, rate=0.02, T=COLD),
            "out": WellFacts(at=(59.5, -0.025, 0.5), T_rock=HOT, p_rock=FAR, pressure=FAR),
        },
        flow=FractureFlow(q=FLOW, length=LENGTH),
        edges=(*(tuple(map(float, edges)) for edges in EDGES), (0.0, 1.0)),
    )  # fmt: skip
    return replace(whole, **changes)  # type: ignore[arg-type]


def manifest(times: Sequence[float], **changes: object) -> Manifest:
    whole = Manifest(
        version="0.2.0", commit=None, created="2026-12-01T00:00:00+00:00", ranks=1,
        title="A wall & its <wells>", law="AT1", scaled=False, size=SIZE, face="bottom", h=1.0,
        ell=2.0, L=SIZE[-1], cells=450, unknowns=1500, mesh="0123456789abcdef",
        toughness_factor=1.1, times=tuple(times), taus=(None,) * len(times),
        requested=(True,) * len(times), scales={"dT": HOT - COLD}, versions={}, petsc_options={},
        reservoir=facts(),
    )  # fmt: skip
    return replace(whole, **changes)  # type: ignore[arg-type]


def step(index: int, time: float, circulation: Circulation | None, **changes: object) -> Step:
    heat = Heat(circulation=circulation) if circulation else None
    whole = Step(
        index=index, time=time, tau=None, energies=Energies(elastic=1.0, surface=0.0), sweeps=1,
        status=Status.CONVERGED, reason="converged", heat=heat,
        measures=Measures(sections=(), tips=(), front=0.0, length_surface=0.0, length_geometry=0.0),
    )  # fmt: skip
    return replace(whole, **changes)  # type: ignore[arg-type]


def account(
    duration: float, T_out: float, *, rate: float = 0.02, p_in: float = 20.5e6
) -> Circulation:
    """Water of constant heat capacity, in at COLD and out at T_out; its heat is of the rock."""
    mass = rate * duration
    wells = {
        "in": WellAccount(mass=mass, heat=4200 * mass * COLD, T=COLD, pressure=p_in),
        "out": WellAccount(mass=-mass, heat=-4200 * mass * T_out, T=T_out, pressure=FAR),
    }
    return Circulation(duration=duration, wells=wells, heat_stored=-4200 * mass * (T_out - COLD))


def fracture_temperature(time: float) -> float:
    """The temperature at the end of a single fracture in unbounded rock (Lauwerier)."""
    theta = erfc(K * LENGTH / (WATER * FLOW * np.sqrt(K / RHO_C * time)))
    return float(HOT - theta * (HOT - COLD))


def fracture_run(path: Path, steps: int = 12, *, every: float = 10 * DAY, **changes: object) -> Run:
    """A run of a fracture in 2-D: steps of equal length, fields of every fourth and of the last."""
    times = [every * (n + 1) for n in range(steps)]
    of = manifest(times, **changes)
    create(path, 'title = "A wall"\n', of)
    for n, time in enumerate(times):
        kept = n % 4 == 3 or n == steps - 1
        if kept:
            write_both(path, n, time)
        water = account(every, fracture_temperature(time), p_in=FAR + 5e5 / (n + 1))
        Journal(path).append(step(n, time, water, fields=fields_name(n) if kept else None))
    return open_run(path)


def write_both(path: Path, index: int, time: float) -> None:
    """Write fields of the rock, cracked every 6 m, and of the reservoir, cold at its fracture."""
    grid = cell_mesh([np.linspace(0, length, round(length) + 1) for length in SIZE])
    x, y = grid.points[:, 0], grid.points[:, 1]
    depth = np.sqrt(K / RHO_C * time)
    off = np.hypot((x + 3) % 6 - 3, np.maximum(y - 3 * depth, 0))
    fields = {
        "alpha": np.clip(1 - off / 2, 0, 1),
        "T": np.zeros_like(x),
        "u": np.zeros((len(x), 3)),
    }
    write_vtkhdf(path / fields_name(index), grid, fields)
    X, Y = np.meshgrid(*((e[1:] + e[:-1]) / 2 for e in EDGES), indexing="ij")
    T = HOT - (HOT - COLD) * erfc((np.maximum(Y, 0) + X / 20) / (2 * depth))
    flat = T.ravel(order="F")
    write_reservoir(
        path, index, EDGES, T=flat, p=np.full_like(flat, FAR), k=np.full_like(flat, 1e-18)
    )


def boxed_run(path: Path, *, cracks: bool = False) -> Run:
    """A run of one step of a 3-D body, in a larger reservoir that is cold around its injector.

    cracks: with planes across x every 6 m, whose opening falls with depth, as the water meets them.
    """
    size, edges = (40.0, 30.0, 20.0), [np.linspace(*ends) for ends in BOX]
    wells = {
        "in $a$": WellFacts(at=(5.0, 15.0, 10.0), T_rock=HOT, p_rock=FAR, rate=0.02, T=COLD),
        "out": WellFacts(at=(35.0, 15.0, 18.0), T_rock=HOT, p_rock=FAR, pressure=FAR),
    }
    sides = tuple(tuple(map(float, axis)) for axis in edges)
    rule = RULE if cracks else None
    known = facts(wells=wells, flow=None, thickness=None, edges=sides, cracks=rule)
    create(
        path, 'title = "A box"\n', manifest([10 * DAY], size=size, h=2.0, L=20.0, reservoir=known)
    )
    mesh = cell_mesh([np.linspace(0, length, round(length / 2) + 1) for length in size])
    x, _, z = mesh.points.T
    off = np.hypot((x + 3) % 6 - 3, np.maximum(z - 6, 0))
    fields = {
        "alpha": np.clip(1 - off / 4, 0, 1),
        "T": np.zeros_like(x),
        "u": np.zeros((len(x), 3)),
    }
    write_vtkhdf(path / fields_name(0), mesh, fields)
    middles = np.meshgrid(*((axis[1:] + axis[:-1]) / 2 for axis in edges), indexing="ij")
    apart = [axis - at for axis, at in zip(middles, wells["in $a$"].at, strict=True)]
    T = (HOT - 140 * np.exp(-np.square(apart).sum(axis=0) / 64)).ravel(order="F")
    w = A = None
    if cracks:
        X, _, Z = (axis.ravel(order="F") for axis in middles)
        A = np.maximum(0, 1 - np.abs((X + 3) % 6 - 3) / 2) / 2 * ((Z > 0) & (Z < 8) & (X > 0))
        w = np.where(A > 0, 1e-3 * np.exp(-Z / 2), 0.0)
    write_reservoir(path, 0, edges, T=T, p=np.full_like(T, FAR), k=np.full_like(T, 1e-18), w=w, A=A)
    made = account(10 * DAY, HOT)
    water = replace(made, wells=dict(zip(wells, made.wells.values(), strict=True)))
    Journal(path).append(step(0, 10 * DAY, water, fields=fields_name(0)))
    return open_run(path)


def shadowed_run(
    path: Path,
    falls: Sequence[float],
    without: Sequence[float],
    *,
    dp: tuple[float, float] = (5e5, 5e5),
    rates: tuple[float, float] = (0.02, 0.02),
    cracks: CrackFlow | None = CRACKS,
    every: float = 10 * DAY,
    **changes: object,
) -> Run:
    """A run of equal steps without fields, whose water falls by given degrees (K).

    Parameters
    ----------
    path : its directory.
    falls, without : fall of the production temperature at the end of each step (K), with cracks
        and without.
    dp : pressure of the injector above that of the producer (Pa), with cracks and without.
    rates : mass rate (kg/s), with cracks and without.
    cracks : cracks at each step.
    every : length of a step (s).
    changes : of the reservoir's facts.
    """
    times = [every * (n + 1) for n in range(len(falls))]
    known = facts(**({"cracks": RULE, "flow": None} | changes))
    create(path, "", manifest(times, units=UNITS, reservoir=known))
    for n, (time, *fall) in enumerate(zip(times, falls, without, strict=True)):
        water, shadow = (
            account(every, HOT - lost, rate=rate, p_in=FAR + drop)
            for lost, rate, drop in zip(fall, rates, dp, strict=True)
        )
        heat = Heat(circulation=replace(water, cracks=cracks), shadow=shadow)
        Journal(path).append(replace(step(n, time, None), heat=heat))
    return open_run(path)

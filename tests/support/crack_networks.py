"""Runs written by hand whose water flows in cracks of known openings, with and without them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from staffa.io.reservoir_fields import cell_mesh, write_reservoir
from staffa.io.run_directory import Journal, Run, create, fields_name, open_run
from staffa.io.vtkhdf import write_vtkhdf
from staffa.records.crack_flow import CrackFlow
from staffa.records.reservoir_facts import WellFacts
from staffa.records.step import Heat
from support.circulating import COLD, DAY, FAR, HOT, RULE, UNITS, account, facts, manifest, step

SPREAD, ELL, THICK = RULE.spread, 6.0, 50.0
PLAN = (300.0, 200.0)
WELLS = {"injector": (75.0, 100.0), "producer": (225.0, 100.0)}
# Ends (m) of cracks in plan view, and their opening (m): two connected ways and a dead end.
NETWORK = (
    ((75, 100), (140, 125), 1.2e-3),
    ((140, 125), (230, 104), 4e-4),
    ((140, 125), (150, 185), 1e-4),
    ((75, 100), (120, 60), 6e-4),
    ((120, 60), (215, 70), 2e-5),
    ((60, 100), (20, 150), 2e-4),
)  # fmt: skip
PLAN_EDGES = (
    np.concatenate([[-100.0, -40.0], np.linspace(0, 300, 76), [340.0, 400.0]]),
    np.concatenate([[-60.0], np.linspace(0, 200, 51), [260.0]]),
)


def distances(points: np.ndarray, grown: float = 1.0) -> np.ndarray:
    """The distance of points (n, 2) to each crack, of which a part has grown, shape (cracks, n)."""
    found = []
    for start, end, _ in NETWORK:
        a, b = np.array(start, float), np.array(end, float)
        along = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0, grown)
        found.append(np.linalg.norm(points - a - along[:, None] * (b - a), axis=1))
    return np.array(found)


def cell_cracks(points: np.ndarray, grown: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """Opening (m) and area per volume (1/m) of cracks spread over SPREAD at points, (n,) each."""
    area = np.maximum(0, 1 - distances(points, grown) / SPREAD) / SPREAD
    volume = np.array([w for *_, w in NETWORK]) @ area
    A = area.sum(axis=0)
    return np.where(A > 0, volume / np.where(A > 0, A, 1), 0.0), A


def network_run(path: Path, steps: int = 8, *, every: float = 365 * DAY) -> Run:
    """A doublet in plan view, whose cracks grow and bring the cold earlier than without them."""
    wells = {
        name: WellFacts(
            at=(*at, THICK / 2), T_rock=HOT, p_rock=FAR,
            rate=5.0 if name == "injector" else -5.0, T=COLD if name == "injector" else None,
        )
        for name, at in WELLS.items()
    }  # fmt: skip
    sides = (*(tuple(map(float, edges)) for edges in PLAN_EDGES), (0.0, THICK))
    known = facts(
        wells=wells, flow=None, thickness=THICK, edges=sides, cracks=RULE, heat_in_place=1e15
    )
    times = [every * (n + 1) for n in range(steps)]
    of = manifest(times, size=PLAN, h=3.0, ell=ELL, L=PLAN[1], units=UNITS, face=None,
                  reservoir=known, title="A doublet")  # fmt: skip
    create(path, "", of)
    for n, time in enumerate(times):
        grown, kept = min(1.0, (n + 1) / 5), n % 2 == 1
        if kept:
            write_network(path, n, time, grown)
        heat = Heat(
            circulation=replace(
                renamed(account(every, HOT - 9.0 * n, rate=5.0, p_in=FAR + 2e6 / (1 + 4 * grown))),
                cracks=CrackFlow(
                    area=2e4 * grown, volume=9.0 * grown, widest=1.2e-3, at_smallest=0.2,
                    spacing=30.0, permeability=4e-12,
                ),
            ),
            shadow=renamed(account(every, HOT - 0.9 * n**2, rate=5.0, p_in=FAR + 2e6)),
        )  # fmt: skip
        fields = fields_name(n) if kept else None
        Journal(path).append(replace(step(n, time, None), heat=heat, fields=fields))
    return open_run(path)


def renamed(water):
    return replace(water, wells=dict(zip(WELLS, water.wells.values(), strict=True)))


def middles(edges: Sequence[np.ndarray]) -> np.ndarray:
    """Middles of cells, the first axis fastest, shape (n, dim)."""
    axes = np.meshgrid(*((e[1:] + e[:-1]) / 2 for e in edges), indexing="ij")
    return np.stack([axis.ravel(order="F") for axis in axes], axis=1)


def write_network(path: Path, index: int, time: float, grown: float) -> None:
    """Write fields of the rock and of the reservoir in plan view."""
    grid = cell_mesh([np.linspace(0, length, round(length / 3) + 1) for length in PLAN])
    alpha = np.clip(1.2 - distances(grid.points[:, :2], grown).min(axis=0) / ELL, 0, 1)
    zero = np.zeros(len(alpha))
    write_vtkhdf(
        path / fields_name(index), grid,
        {"alpha": alpha, "T": zero, "u": np.zeros((len(alpha), 3))},
    )  # fmt: skip
    at = middles(PLAN_EDGES)
    w, A = cell_cracks(at, grown)
    from_well = np.linalg.norm(at - np.array(WELLS["injector"]), axis=1)
    reach = 25 * np.sqrt(time / (365 * DAY))
    near = np.minimum(from_well, 2 * distances(at, grown).min(axis=0) + from_well / 2)
    T = HOT - (HOT - COLD) / (1 + np.exp((near - reach) / 8))
    inside = ((at > 0) & (at < PLAN)).all(axis=1)
    w, A = np.where(inside, w, 0.0), np.where(inside, A, 0.0)
    k = 1e-15 + A * w**3 / 12
    write_reservoir(path, index, PLAN_EDGES, T=T, p=np.full_like(T, FAR), k=k, w=w, A=A)

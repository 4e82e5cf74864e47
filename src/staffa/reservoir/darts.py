"""open-DARTS in a separate process: the engine for any reservoir."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from staffa.errors import InputError, SolveError, StaffaError, StoppedError
from staffa.records.circulation import Circulation, WellAccount
from staffa.reservoir.child import PATIENCE, Child, ChildError
from staffa.reservoir.simulator import Flow, ReservoirModel
from staffa.reservoir.two_point import connections, well_indices

SERVER = Path(__file__).with_name("serve_darts.py")
STANDARD_GRAVITY = 9.80665  # m/s^2, with which open-DARTS multiplies depths


class Darts:
    """The simulator open-DARTS.

    The state is kept here, so a process that ends is replaced and asked again, once a step.

    Parameters
    ----------
    model : the reservoir.
    python : Python of the environment that has open-DARTS.
    patience : time within which a step ends (s).
    server : the program that it runs.
    """

    def __init__(
        self,
        model: ReservoirModel,
        python: str | os.PathLike[str],
        *,
        patience: float = PATIENCE,
        server: Path = SERVER,
    ) -> None:
        self.model = model
        # Without the settings and folders of this user and of the current folder.
        self.command = [os.fspath(python), "-I", os.fspath(server)]
        self.patience = patience
        self.faces = connections(model.grid)
        self.child: Child | None = None
        self.first: Flow | None = None
        self.name = "open-darts"

    def start(self) -> Flow:
        """Return the state before the first step; see `Simulator`."""
        if self.first is None:
            self._ask_twice(None)
        assert self.first is not None
        return self.first

    def advance(
        self, flow: Flow, permeability: np.ndarray | None, duration: float
    ) -> tuple[Flow, Circulation, int]:
        """Return the state after a time, its account, and the inner steps; see `Simulator`.

        Parameters
        ----------
        flow : state to begin with.
        permeability : permeability (m^2) of each cell, shape (n_cells,) or (n_cells, 3); None for
            the model's.
        duration : time to advance (s).
        """
        k = self.model.permeability if permeability is None else permeability
        question = {"do": "step", "duration": float(duration)}
        told, arrays = self._ask_twice((question, [flow.hidden, *self._flow(k)]))
        wells = {name: WellAccount(**account) for name, account in told["wells"].items()}
        mass, heat = told["stored"]
        account = Circulation(duration=duration, wells=wells, mass_stored=mass, heat_stored=heat)
        return _flow(arrays), account, told["steps"]

    def close(self) -> None:
        """End the process; a later question starts another one."""
        if self.child is not None:
            self.child.close()
            self.child = None

    def _ask_twice(
        self, question: tuple[Any, Sequence[np.ndarray]] | None
    ) -> tuple[Any, list[np.ndarray]]:
        """Ask, and ask a new process if the first one ends; no question only opens one.

        Raises
        ------
        InputError
            None starts, before there is a first state.
        StoppedError
            The second one ends as well.
        """
        try:
            return self._ask(question)
        except ChildError:
            try:
                return self._ask(question)
            except ChildError as error:
                name = f"the reservoir simulator {self.command[0]}"
                if self.first is None:
                    raise InputError(
                        f"{name} does not start: {error}; `staffa doctor` tells what to install"
                    ) from error
                raise StoppedError(
                    f"{name} failed twice in one step: {error}; `staffa doctor` tells whether it "
                    f"works"
                ) from error

    def _ask(
        self, question: tuple[Any, Sequence[np.ndarray]] | None
    ) -> tuple[Any, list[np.ndarray]]:
        """Ask the process, which is started before if there is none.

        Raises
        ------
        ChildError
            It ended.
        """
        told: Any = {}
        arrays: list[np.ndarray] = []
        try:
            if self.child is None:
                self.child = Child(self.command, patience=self.patience)
                told, arrays = _answer(self.child.ask(self._opening(), self._arrays()))
                self.first, self.name = _flow(arrays), told["name"]
            if question is not None:
                told, arrays = _answer(self.child.ask(*question))
        except (ChildError, KeyError, ValueError):
            self.close()
            raise
        return told, arrays

    def _opening(self) -> dict[str, Any]:
        """Return the question that makes the reservoir in the process."""
        model = self.model
        wells = [
            {
                "name": well.name,
                "cells": list(well.cells),
                "rate": well.rate,
                "pressure": well.pressure,
                "T": well.T,
                "radius": well.radius,
                "length": float(model.grid.sizes[list(well.cells)].max(axis=1).max()),
            }
            for well in model.wells
        ]
        return {
            "do": "open",
            "water": self._water(),
            "wells": wells,
            "tolerance": model.tolerance,
            "drop": self._drop(),
        }

    def _water(self) -> dict[str, float] | None:
        """Return the constants of the water, which is nearly incompressible around a pressure."""
        water = self.model.water
        if water is None:
            return None
        return {"rho": water.rho, "c": water.c, "mu": water.mu, "p": float(self.model.p.mean())}

    def _drop(self) -> float:
        """Return the largest temperature difference of rock and injected water (K), or 1."""
        injected = [well.T for well in self.model.wells if well.T is not None]
        rock = [float(self.model.T.min()), float(self.model.T.max())]
        values = rock + injected
        return max(values) - min(values) or 1.0

    def _arrays(self) -> list[np.ndarray]:
        """Return the arrays of the reservoir, in the order of the server's `NAMES`."""
        model, faces = self.model, self.faces
        gravity = np.asarray(model.gravity) / STANDARD_GRAVITY
        flow, index = self._flow(model.permeability)
        conduction = faces.conductance(model.conductivity)
        depth = model.grid.nodes @ gravity
        return [
            faces.lower, faces.upper, flow, conduction, index, model.grid.volumes, model.porosity,
            model.rho_c, depth, model.p, model.T,
        ]  # fmt: skip

    def _flow(self, permeability: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return flow through faces and well indices (m^3)."""
        indices = [well_indices(self.model, well, permeability) for well in self.model.wells]
        return self.faces.conductance(permeability), np.concatenate([*indices, np.zeros(0)])


def _answer(answer: tuple[Any, list[np.ndarray]]) -> tuple[Any, list[np.ndarray]]:
    """Return an answer, or raise what the process could not do."""
    told, arrays = answer
    if not isinstance(told, dict) or "ok" not in told:
        raise ChildError("it sent a message that is no answer")
    if not told["ok"] and not told["converged"]:
        raise SolveError(f"The reservoir simulator did not converge: {told['why']}.")
    if not told["ok"]:
        raise StaffaError(f"The reservoir simulator failed: {told['why']}.")
    return told, arrays


def _flow(arrays: Sequence[np.ndarray]) -> Flow:
    hidden, p, T = arrays
    return Flow(hidden=hidden, p=p, T=T)

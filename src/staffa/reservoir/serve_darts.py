"""open-DARTS as a pure function of a state that another program owns.

The simulator's own Python runs this file; nothing of staffa is imported. It hears and answers on
file 0, a socket, in the messages of `message_frames`. What open-DARTS prints goes to files 1 and 2.

open {water, wells, drop, tolerance}, arrays   ->  {name, ...}, [state, p, T]
step {duration}, [state, flow, index]          ->  {wells, stored, steps}, [state, p, T]

An answer has "ok": false and "why" if there is none; "converged": false if a shorter step may help.
"""

import sys
from pathlib import Path

FOLDER = str(Path(__file__).parent)
sys.path.append(FOLDER)  # at the end: no file beside this one hides a library
from darts_model import Reservoir  # noqa: E402  isort: skip

import os  # noqa: E402
import socket  # noqa: E402
import traceback  # noqa: E402
from importlib.metadata import version  # noqa: E402
from typing import Any  # noqa: E402

import numpy as np  # noqa: E402
from message_frames import pack, unpack  # noqa: E402

NAMES = (
    "lower", "upper", "flow", "conduction", "index", "volume", "porosity", "rho_c", "depth",
    "p", "T",
)  # fmt: skip
FIRST = 1.0  # s, the first inner step
SHORTEST = 1e-3  # s: a shorter inner step is of no use
# Bounds of the next inner step over the last one.
LEAST, MOST, SAFETY = 0.2, 3.0, 0.9


class ConvergenceError(Exception):
    """No inner step of any length converges."""


class Server:
    """A reservoir that is asked for steps.

    Parameters
    ----------
    head : water, wells, drop and tolerance.
    arrays : arrays in the order of `NAMES`.
    """

    def __init__(self, head: dict[str, Any], arrays: list[np.ndarray]) -> None:
        named = dict(zip(NAMES, arrays, strict=True))
        self.model = Reservoir(head, named)
        self.allowed = head["tolerance"] * head["drop"]
        self.names = [well["name"] for well in head["wells"]]
        self.flow, self.index = named["flow"], named["index"]
        # Water that runs into a fracture fills it in minutes, of which no rock knows.
        self.rock = named["rho_c"] > 0

    def start(self) -> tuple[dict[str, Any], list[np.ndarray]]:
        """Return the first state."""
        told = {"name": f"open-darts {version('open-darts')}"}
        return told, self._fields(FIRST)

    def step(
        self, head: dict[str, Any], arrays: list[np.ndarray]
    ) -> tuple[dict[str, Any], list[np.ndarray]]:
        """Return the state after a time, and the account of it.

        Parameters
        ----------
        head : the duration (s).
        arrays : the state, the flow through faces and the indices of wells.
        """
        state, flow, index = arrays
        if not (np.array_equal(flow, self.flow) and np.array_equal(index, self.index)):
            self.model.set_flow(flow, index)
            self.flow, self.index = flow, index
        self.model.put(state[1:])
        before = self.model.stored()
        sums = np.zeros((len(self.names), 2))
        wanted, steps = self._inner_steps(head["duration"], float(state[0]), sums)
        after = self.model.stored()
        wells = {}
        for name, (mass, heat), now in zip(
            self.names, sums.tolist(), self.model.wells_now(), strict=True
        ):
            wells[name] = {**now, "mass": mass, "heat": heat}
        stored = [late - early for late, early in zip(after, before, strict=True)]
        return {"wells": wells, "stored": stored, "steps": steps}, self._fields(wanted)

    def _inner_steps(self, duration: float, wanted: float, sums: np.ndarray) -> tuple[float, int]:
        """Advance, add to the sums of the wells, and return the next inner step and the count."""
        left, steps = duration, 0
        while left > 1e-12 * duration:
            # The last steps are of equal length, and none is a small rest.
            length = left / np.ceil(left / wanted * (1 - 1e-9)) if wanted < left else left
            if left < 2 * wanted < 2 * left:
                length = left / 2
            before = self.model.state()
            error, account = self._two_halves(before, length)
            factor = SAFETY * np.sqrt(self.allowed / max(error, 1e-3 * self.allowed))
            if error > self.allowed and length > SHORTEST:
                self.model.put(before)
                wanted = length * max(min(factor, 0.5), LEAST)
                continue
            if account is None:
                raise ConvergenceError(
                    f"no step of {length:.1e} s converges, as where the rock at a well does not "
                    f"take its rate, or water comes to boil"
                )
            sums += account
            left, steps = left - length, steps + 2
            # A step that was cut short by the end says little of the one that was wanted.
            wanted = max(length * min(max(factor, LEAST), MOST), wanted if length < wanted else 0.0)
        return wanted, steps

    def _two_halves(self, before: np.ndarray, length: float) -> tuple[float, Any]:
        """Take a step at once and in two halves; return the difference (K), and the account.

        The difference is that of rock. It is infinite, and there is no account, if one of them
        does not converge.
        """
        if not self.model.step(length):
            return np.inf, None
        at_once = self.model.fields()[1]
        self.model.put(before)
        account = np.zeros((len(self.names), 2))
        for _ in range(2):
            if not self.model.step(length / 2):
                return np.inf, None
            now = [(well["mass"], well["heat"]) for well in self.model.wells_now()]
            account += length / 2 * np.array(now).reshape(-1, 2)
        apart = np.abs(self.model.fields()[1] - at_once)
        return float(apart[self.rock].max(initial=0.0)), account

    def _fields(self, wanted: float) -> list[np.ndarray]:
        p, T = self.model.fields()
        return [np.concatenate([[wanted], self.model.state()]), p, T]


def serve() -> None:
    """Answer until nobody asks any more."""
    line = socket.socket(fileno=0)
    stream = line.makefile("rb")

    def read(n: int) -> bytes:
        got: bytes = stream.read(n)
        if len(got) < n:
            os._exit(0)  # the other program has ended, or closed its side
        return got

    server = None
    while True:
        head, arrays = unpack(read)
        try:
            if head["do"] == "open":
                server = Server(head, arrays)
                told, fields = server.start()
            else:
                assert server is not None
                told, fields = server.step(head, arrays)
        except Exception as error:
            traceback.print_exc()
            converged = not isinstance(error, ConvergenceError)
            told = {"ok": False, "converged": converged, "why": f"{error}"}
            fields = []
        line.sendall(pack({"ok": True, **told}, fields))


if __name__ == "__main__":
    serve()

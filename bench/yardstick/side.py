"""One side of the yardstick: the hand script or staffa, step by step, in turn with the other.

    side.py script|staffa|alone CASE FOLDER STEPS

The sides talk through files in FOLDER, one a rank: the script starts a step where its last one
ended, writes down where that was, and waits until staffa has done the same step from there.
`alone` is staffa without a script, for the first step: what more ranks gain.
"""

import json
import os
import resource
import sys
from pathlib import Path
from time import perf_counter, process_time, sleep

from staffa.backend.stack import MPI

import numpy as np

from bench.common.cases import CASES, BenchCase


class ScriptSide:
    """The script marches on from its own state."""

    def __init__(self, case: BenchCase) -> None:
        from bench.yardstick.script import Script

        self.script = Script(case, MPI.COMM_WORLD)

    def start(self) -> dict[str, np.ndarray]:
        """The start of the next step."""
        return {key: values.copy() for key, values in self.script.state().items()}

    def step(self, time: float) -> dict:
        """Minimize at a time; what is to be recorded of it."""
        before = dict(self.script.phases)
        sweeps = self.script.step(time)
        phases = {k: v - before.get(k, 0.0) for k, v in self.script.phases.items()}
        return {"sweeps": sweeps, "energy": self.script.total_energy, "phases": phases}


class StaffaSide:
    """staffa with its defaults, put at the script's state before each step."""

    def __init__(self, case: BenchCase) -> None:
        from bench.common.ours import Ours

        self.libraries_MB = peak_MB()
        self.ours = Ours(case, MPI.COMM_WORLD)

    def put(self, state: dict[str, np.ndarray], time: float | None) -> None:
        """Take over a state reached at a time."""
        self.ours.put(state, time)

    def step(self, time: float) -> dict:
        """Minimize at a time; what is to be recorded of it."""
        return self.ours.step(time)


def wait_for(path: Path) -> None:
    """Sleep until a file is there; end if the other side has failed."""
    while not path.exists():
        if (path.parent / "failed").exists():
            sys.exit(1)
        sleep(0.02)


def finish(path: Path, write) -> None:
    """Write a file aside and rename it, so that whoever waits for it finds it whole."""
    aside = path.with_suffix(".part")
    with aside.open("wb") as file:
        write(file)
    os.replace(aside, path)


def peak_MB() -> float:
    """Largest resident memory of this rank so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024


def timed(side, time: float, index: int) -> dict:
    """One step with its wall seconds and the CPU seconds of all ranks."""
    comm = MPI.COMM_WORLD
    comm.Barrier()
    wall, cpu = perf_counter(), process_time()
    result = side.step(time)
    wall, cpu = perf_counter() - wall, process_time() - cpu
    energy = result.pop("energy")()
    record = {"index": index, "time": time, "wall_s": comm.allreduce(wall, op=MPI.MAX)}
    record |= {"cpu_s": comm.allreduce(cpu), "energy": energy}
    record |= {"peak_MB": comm.allreduce(peak_MB())}
    return record | result


def main(who: str, name: str, folder: Path, steps: int) -> None:
    """Run the first steps of a case, in turn with the other side."""
    case, rank = CASES[name], MPI.COMM_WORLD.rank
    if who == "alone":
        side = StaffaSide(case)
        side.ours.put_at_rest()
        libraries = MPI.COMM_WORLD.allreduce(side.libraries_MB)
        record = timed(side, case.times[0], 0) | {"libraries_MB": libraries}
        text = json.dumps(record).encode()
        finish(folder / f"alone-0-{rank}.json", lambda file: file.write(text))
        return
    side = ScriptSide(case) if who == "script" else StaffaSide(case)
    for index, time in enumerate(case.times[:steps]):
        started_at = folder / f"state-{index}-{rank}.npz"
        if who == "script":
            if index:
                wait_for(folder / f"staffa-{index - 1}-{rank}.json")
            state = side.start()
            record = timed(side, time, index)
            finish(started_at, lambda file, state=state: np.savez(file, **state))
        else:
            wait_for(started_at)
            with np.load(started_at) as state:
                side.put(dict(state), case.times[index - 1] if index else None)
            started_at.unlink()
            record = timed(side, time, index)
        text = json.dumps(record).encode()
        finish(folder / f"{who}-{index}-{rank}.json", lambda file, text=text: file.write(text))


if __name__ == "__main__":
    folder = Path(sys.argv[3])
    try:
        main(sys.argv[1], sys.argv[2], folder, int(sys.argv[4]))
    except BaseException:
        (folder / "failed").touch()
        raise

"""One side of the yardstick: the hand script or staffa, step by step, in turn with the others.

    side.py script|staffa|refined|alone CASE FOLDER STEPS

The sides talk through files in FOLDER, one a rank. In each step, one after the other:

- the script starts where its last step ended, and writes down where that was;
- staffa takes the same step from there, on the same mesh;
- staffa takes it on a mesh that follows the cracks (`refined`), and writes down its damage on the
  script's mesh;
- staffa minimizes from that damage on the script's mesh: energies of two meshes cannot be compared.

Only steps are timed. `alone` is staffa without a script, for the first step: what more ranks gain.
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


class RefinedSide:
    """The same on a mesh that follows the cracks."""

    def __init__(self, case: BenchCase) -> None:
        from bench.common.followed import Followed

        self.ours = Followed(case, MPI.COMM_WORLD)

    def put(self, state: dict[str, np.ndarray], time: float | None) -> None:
        """Take over a state reached at a time, on a mesh that is fine enough for it."""
        self.ours.put(state, time)
        self.cells_at_start = self.ours.mesh_facts()["cells"]

    def step(self, time: float) -> dict:
        """Take the step with its refinements; what is to be recorded of it."""
        return self.ours.step(time) | {"cells_at_start": self.cells_at_start}


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


def write_json(path: Path, record: dict) -> None:
    """Write a record for those who wait for it."""
    text = json.dumps(record).encode()
    finish(path, lambda file: file.write(text))


class Turns:
    """The turns that the sides take through the steps of a case."""

    def __init__(self, case: BenchCase, folder: Path, steps: int) -> None:
        self.case, self.folder = case, folder
        self.times = case.times[:steps]

    def at(self, what: str, index: int, kind: str = "json") -> Path:
        """The file of this rank for a step."""
        return self.folder / f"{what}-{index}-{MPI.COMM_WORLD.rank}.{kind}"

    def before(self, index: int) -> float | None:
        """Time at which a step starts; None at the very start."""
        return self.times[index - 1] if index else None

    def state(self, index: int) -> dict[str, np.ndarray]:
        """Return the state from which the script took a step."""
        with np.load(self.at("state", index, "npz")) as state:
            return dict(state)

    def script(self) -> None:
        """March on, a step at each turn."""
        side = ScriptSide(self.case)
        for index, time in enumerate(self.times):
            if index:
                wait_for(self.at("basin", index - 1))
            state = side.start()
            record = timed(side, time, index)
            write_json(self.at("script", index), record)
            finish(self.at("state", index, "npz"), lambda file, s=state: np.savez(file, **s))

    def staffa(self) -> None:
        """Take the script's steps on its mesh, and judge the damage of the refined side there."""
        side = StaffaSide(self.case)
        for index, time in enumerate(self.times):
            wait_for(self.at("state", index, "npz"))
            state = self.state(index)
            side.put(state, self.before(index))
            write_json(self.at("staffa", index), timed(side, time, index))
            wait_for(self.at("refined", index))
            damage = np.load(self.at("damage", index, "npy"))
            write_json(self.at("basin", index), side.ours.basin(state, time, damage))
            for path in (self.at("state", index, "npz"), self.at("damage", index, "npy")):
                path.unlink()

    def refined(self) -> None:
        """Take the script's steps on a mesh that follows the cracks."""
        side = RefinedSide(self.case)
        for index, time in enumerate(self.times):
            wait_for(self.at("staffa", index))
            side.put(self.state(index), self.before(index))
            record = timed(side, time, index) | side.ours.mesh_facts()
            damage = side.ours.damage()
            finish(self.at("damage", index, "npy"), lambda file, a=damage: np.save(file, a))
            write_json(self.at("refined", index), record)

    def alone(self) -> None:
        """Take the first step from the very start, without a script."""
        side = StaffaSide(self.case)
        side.ours.put_at_rest()
        libraries = MPI.COMM_WORLD.allreduce(side.libraries_MB)
        record = timed(side, self.times[0], 0) | {"libraries_MB": libraries}
        write_json(self.at("alone", 0), record)


def main(who: str, name: str, folder: Path, steps: int) -> None:
    """Run the first steps of a case, in turn with the other sides."""
    turns = Turns(CASES[name], folder, steps)
    {
        "script": turns.script,
        "staffa": turns.staffa,
        "refined": turns.refined,
        "alone": turns.alone,
    }[who]()


if __name__ == "__main__":
    folder = Path(sys.argv[3])
    try:
        main(sys.argv[1], sys.argv[2], folder, int(sys.argv[4]))
    except BaseException:
        (folder / "failed").touch()
        raise

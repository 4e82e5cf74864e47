"""Runs from the command line, as a user starts them, kept in runs/verification."""

import json
import os
import shlex
import shutil
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from staffa.io.run_directory import Run, open_run

ROOT = Path(__file__).parent.parent.parent
READY = ROOT / "src" / "staffa" / "case" / "ready"


def command(case: Path, where: Path, settings: Sequence[str]) -> list[str]:
    """The command that runs a case, into a folder that is new."""
    run = [f"{Path(sys.executable).parent}/staffa", "run", f"{case}", "--out", f"{where}"]
    return [*run, "--quiet", *(f"--set={s}" for s in settings)]


def staffa(case: Path, where: Path, settings: Sequence[str]) -> None:
    """Run a case as from the command line, into a folder that is new."""
    subprocess.run(command(case, where, settings), check=True)


@dataclass(frozen=True, kw_only=True)
class Cost:
    """CPU time (s) and peak memory (GiB) of a process."""

    cpu: float
    memory: float


def run_with_cost(case: Path, where: Path, settings: Sequence[str], ranks: int = 1) -> Cost:
    """Run a case into a folder that is new, and return its cost; CPU time is that of all ranks."""
    mpiexec = [f"{Path(sys.executable).parent}/mpiexec", "-n", f"{ranks}"] if ranks > 1 else []
    process = subprocess.Popen([*mpiexec, *command(case, where, settings)], cwd=ROOT)
    _, status, used = os.wait4(process.pid, 0)
    assert status == 0, f"{where} failed"
    return Cost(cpu=used.ru_utime + used.ru_stime, memory=used.ru_maxrss / 2**20)


def as_typed(run: Run, case: str, settings: Sequence[str]) -> str:
    """The command that made a run."""
    ranks = f"mpiexec -n {run.manifest.ranks} " if run.manifest.ranks > 1 else ""
    given = [word for s in settings for word in ("--set", s)]
    return ranks + shlex.join(["staffa", "run", case, *given])


def run_once(case: str, folder: str, settings: Sequence[str]) -> Run:
    """A run in runs/verification as it is there, by hand say, or made now."""
    where = ROOT / "runs" / "verification" / folder
    if not where.exists():
        staffa(ROOT / case, where, settings)
    run = open_run(where)
    assert run.finished, f"{where} is not finished"
    return run


def origin(run: Run, case: str, settings: Sequence[str]) -> dict:
    """The source of the numbers that are kept of a run."""
    return {
        "command": as_typed(run, case, settings),
        "commit": run.manifest.commit,
        "date": run.manifest.created[:10],
        "unknowns": run.manifest.unknowns,
        "seconds": round(sum(step.seconds for step in run.steps)),
    }


def keep(file: Path, found: dict) -> None:
    """Write what is kept as one small file."""
    file.write_text(json.dumps(found, indent=1) + "\n")


def ready_case(name: str, folder: str, *settings: str) -> Run:
    """A ready case run afresh, in runs/verification."""
    return fresh_run(READY / f"{name}.toml", folder, *settings)


def fresh_run(case: Path, folder: str, *settings: str) -> Run:
    """A case run afresh, in runs/verification."""
    where = ROOT / "runs" / "verification" / folder
    shutil.rmtree(where, ignore_errors=True)
    staffa(case, where, settings)
    return open_run(where)

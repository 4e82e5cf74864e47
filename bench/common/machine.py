"""The machine, the versions and the environment of a benchmark."""

import os
import subprocess
from importlib.metadata import version
from pathlib import Path

ROOT = Path(__file__).parent.parent.parent


def environment() -> dict[str, str]:
    """One thread a process, so that a second one does not slow it down; compilers optimize."""
    kept = {key: value for key, value in os.environ.items() if key != "STAFFA_CFLAGS"}
    return kept | {"OMP_NUM_THREADS": "1"}


def machine() -> dict:
    """Return processor, cores and memory (GiB) of this machine."""
    cpu = [line for line in Path("/proc/cpuinfo").read_text().splitlines() if "model name" in line]
    gib = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30
    return {"cpu": cpu[0].split(":")[1].strip(), "cores": os.cpu_count(), "GiB": round(gib, 1)}


def versions() -> dict[str, str]:
    """Return the versions of staffa and of the libraries that do the work, and the commit."""
    command = ["git", "describe", "--always", "--dirty"]
    commit = subprocess.run(command, cwd=ROOT, capture_output=True, text=True).stdout.strip()
    names = ("staffa", "dolfinx-solver-real", "numpy")
    return {name: version(name) for name in names} | {"commit": commit}

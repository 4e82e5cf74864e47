"""How the forms are compiled: with the vector instructions that every rank's processor has."""

import os
from pathlib import Path
from typing import Any

from staffa.stack import MPI

from staffa.parallel import any_over_ranks

# Sums may be reordered, which vector instructions need; NaN and infinity keep their meaning.
# Measured on the bricks of the benchmark: the stiffness is assembled 2.2 times faster than by
# DOLFINx's own "-O2", vectors 3 times.
FLAGS = [
    "-O3",
    "-fno-math-errno",
    "-fno-trapping-math",
    "-fno-signed-zeros",
    "-fassociative-math",
]
# How long to wait for another process that compiles the same form (s).
PATIENCE = 300
# In place of these, for tests: they compile hundreds of forms and compute little with each.
INSTEAD = "STAFFA_CFLAGS"
VECTOR = {"avx2": "-mavx2", "fma": "-mfma"}


def jit_options(comm: MPI.Comm) -> dict[str, Any]:
    """Options for `dolfinx.fem.form`. Compiled code is cached by its flags. Collective."""
    here = _features()
    flags = os.environ[INSTEAD].split() if INSTEAD in os.environ else FLAGS
    vector = [flag for name, flag in VECTOR.items() if not any_over_ranks(comm, name not in here)]
    return {"cffi_extra_compile_args": [*flags, *vector], "timeout": PATIENCE}


def _features() -> set[str]:
    """Those of `VECTOR` that this processor has, as Linux lists them; none elsewhere."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return set()
    words = next((line.split() for line in lines if line.startswith("flags")), [])
    return set(VECTOR) & set(words)

"""Reading of files in a separate process, since they may come from a stranger.

Libraries that read meshes and fields were written for files of friends: one that is damaged may
crash them, hang them, or have them ask for all memory there is. What is read comes back as numbers
and texts, never as code.
"""

import json
import os
import resource
import signal
import subprocess
import sys
from collections.abc import Mapping, Sequence
from dataclasses import fields
from importlib import import_module
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np

from staffa.backend.isolation import isolated_python
from staffa.errors import InputError

# Limits: of any file, and more for each of its bytes.
MEMORY, MEMORY_A_BYTE = 4 << 30, 200
SECONDS, SECONDS_A_BYTE = 60.0, 1e-6
NO_MEMORY = 3  # exit code


def read_apart[Read](
    kind: type[Read],
    function: str,
    file: Path,
    arguments: Sequence[Any],
    *,
    where: str,
    size: int | None = None,
) -> Read:
    """Call a function that reads a file in another process, and give what it returns.

    Parameters
    ----------
    kind : the dataclass that it returns, of arrays, mappings of names to arrays, texts and numbers.
    function : "module:name"; it is called with the file and then the arguments.
    file : the file.
    arguments : numbers, texts, None, and lists and dictionaries of these.
    where : the key and its value, with which a sentence about a crash begins.
    size : bytes of all files, where the arguments name more of them; None for those of the file.

    Raises
    ------
    InputError
        The function raises one; or it crashes, takes too long, or too much memory.
    """
    if size is None:
        size = file.stat().st_size if file.is_file() else 0
    memory, seconds = MEMORY + MEMORY_A_BYTE * size, SECONDS + SECONDS_A_BYTE * size
    asked = {"function": function, "arguments": [str(file.absolute()), *arguments]}
    job = json.dumps(asked | {"memory": memory, "seconds": int(seconds) + 1}).encode()
    process = subprocess.Popen(
        isolated_python(module="staffa.backend.guarded_reading"),
        cwd="/",
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
    )
    try:
        reply, _ = process.communicate(job, timeout=seconds)
    except subprocess.TimeoutExpired:
        process.kill()
        process.communicate()
        raise InputError(
            f"{where}: reading it took more than {seconds:.0f} s; save it again"
        ) from None
    if process.returncode:
        how = _ended(process.returncode, memory)
        raise InputError(f"{where}: what reads it {how}: the file is damaged; save it again")
    head, _, content = reply.partition(b"\n")
    told = json.loads(head)
    if "refused" in told:
        raise InputError(told["refused"])
    with np.load(BytesIO(content)) as arrays:
        return kind(**{name: _made(name, value, arrays) for name, value in told.items()})


def _ended(code: int, memory: int) -> str:
    if code == NO_MEMORY:
        return f"asked for more than {memory / 2**30:.0f} GiB of memory"
    if code == -signal.SIGXCPU:
        return "took too long"
    return f"was ended by {signal.Signals(-code).name}" if code < 0 else "failed"


def _made(name: str, value: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    """Return a value of a dataclass, from what `_told` made of it."""
    kind, content = value
    if kind == "array":
        return arrays[name]
    if kind == "arrays":
        return {key: arrays[f"{name}/{i}"] for i, key in enumerate(content)}
    if kind == "path":
        return Path(content)
    return tuple(content) if isinstance(content, list) else content


def _told(found: Any) -> tuple[dict[str, Any], dict[str, Any]]:
    """Return a dataclass as JSON holds it, and its arrays by their names."""
    head: dict[str, Any] = {}
    arrays: dict[str, Any] = {}
    for name in (field.name for field in fields(found)):
        value = getattr(found, name)
        if isinstance(value, np.ndarray):
            head[name], arrays[name] = ["array", None], value
        elif isinstance(value, Mapping):
            head[name] = ["arrays", list(value)]
            arrays |= {f"{name}/{i}": array for i, array in enumerate(value.values())}
        elif isinstance(value, Path):
            head[name] = ["path", str(value)]
        else:
            head[name] = ["value", value]
    return head, arrays


def _answer() -> None:
    """Do the job that standard input tells, and write the answer to standard output."""
    job, out = json.load(sys.stdin), os.dup(1)
    os.dup2(os.open(os.devnull, os.O_WRONLY), 1)  # libraries print there
    resource.setrlimit(resource.RLIMIT_AS, (job["memory"],) * 2)
    resource.setrlimit(resource.RLIMIT_CPU, (job["seconds"],) * 2)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    module, _, name = job["function"].partition(":")
    path, *arguments = job["arguments"]
    try:
        head, arrays = _told(getattr(import_module(module), name)(Path(path), *arguments))
    except InputError as error:
        head, arrays = {"refused": str(error)}, {}
    except MemoryError:
        sys.exit(NO_MEMORY)
    content = BytesIO()
    np.savez(content, **arrays)
    with os.fdopen(out, "wb") as reply:
        reply.write(json.dumps(head).encode() + b"\n" + content.getvalue())


if __name__ == "__main__":
    _answer()

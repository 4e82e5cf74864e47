"""Messages between two programs: a line of JSON, then the bytes of arrays.

Nothing in a message is code. The reservoir simulator's own Python loads this file beside its
server, so it uses NumPy and the standard library alone, and the language of Python 3.11.

A message is the length of the line in 8 bytes, lowest first; the line, which says
{"head": ..., "arrays": [[type, shape], ...]}; and the arrays, one after another, in C order.
"""

import json
import struct
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

LONGEST_LINE = 2**24  # bytes
LARGEST_ARRAY = 2**36  # bytes
TYPES = ("<f8", "<i8")


class FrameError(Exception):
    """Bytes that are no message."""


def pack(head: Any, arrays: Sequence[np.ndarray] = ()) -> bytes:
    """Return the bytes of a message.

    Parameters
    ----------
    head : content of the line, in which JSON can write everything.
    arrays : real or whole numbers.
    """
    plain = [np.asarray(a) for a in arrays]
    typed = [np.ascontiguousarray(a, TYPES[a.dtype.kind in "iu"]) for a in plain]
    told = {"head": head, "arrays": [[a.dtype.str, list(a.shape)] for a in typed]}
    line = json.dumps(told).encode()
    return b"".join([struct.pack("<Q", len(line)), line, *(a.tobytes() for a in typed)])


def unpack(read: Callable[[int], bytes]) -> tuple[Any, list[np.ndarray]]:
    """Read a message and return its head and its arrays.

    Parameters
    ----------
    read : function that returns as many bytes as asked for.

    Raises
    ------
    FrameError
        The bytes are no message.
    """
    (length,) = struct.unpack("<Q", read(8))
    if length > LONGEST_LINE:
        raise FrameError(f"a line of {length} bytes")
    try:
        told = json.loads(read(length))
        head, arrays = told["head"], told["arrays"]
        kinds = [(str(kind), tuple(int(n) for n in shape)) for kind, shape in arrays]
    except (ValueError, TypeError, KeyError) as error:
        raise FrameError(f"a line that cannot be read ({error})") from None
    return head, [_array(read, kind, shape) for kind, shape in kinds]


def _array(read: Callable[[int], bytes], kind: str, shape: tuple[int, ...]) -> np.ndarray:
    count = 1
    for n in shape:
        count *= n
    if kind not in TYPES or min(shape, default=0) < 0 or 8 * count > LARGEST_ARRAY:
        raise FrameError(f"an array of type {kind[:20]!r} and shape {shape}")
    # A copy, which may be written to.
    return np.frombuffer(read(8 * count), kind).reshape(shape).copy()

"""Messages to and from the process of a simulator."""

import io
import struct

import numpy as np
import pytest

from staffa.reservoir.message_frames import FrameError, pack, unpack


def reader(data: bytes):
    stream = io.BytesIO(data)

    def read(n: int) -> bytes:
        got = stream.read(n)
        if len(got) < n:
            raise EOFError
        return got

    return read


def test_heads_and_arrays_come_back_to_the_bit() -> None:
    arrays = [np.array([1.0, np.pi, -0.0, np.nan]), np.arange(6).reshape(2, 3), np.empty((0, 3))]
    head, back = unpack(reader(pack({"do": "step", "names": ["in", "Förder"]}, arrays)))
    assert head == {"do": "step", "names": ["in", "Förder"]}
    assert [a.tobytes() for a in back] == [a.tobytes() for a in arrays]
    assert [a.shape for a in back] == [a.shape for a in arrays]
    back[0][0] = 2.0  # they can be written to


@pytest.mark.parametrize(
    "line",
    [
        b"no JSON",
        b"[]",
        b'{"head": 1}',
        b'{"head": 1, "arrays": [["|O", [1]]]}',
        b'{"head": 1, "arrays": [["<f8", [-1]]]}',
        b'{"head": 1, "arrays": [["<f8", [99999999999999]]]}',
        b'{"head": 1, "arrays": [["<f8", "x"]]}',
    ],
)
def test_other_bytes_are_refused(line: bytes) -> None:
    with pytest.raises(FrameError):
        unpack(reader(struct.pack("<Q", len(line)) + line))


def test_a_line_of_gigabytes_is_not_read() -> None:
    with pytest.raises(FrameError, match="bytes"):
        unpack(reader(b"Traceback (most recent call last)"))

"""Messages as bytes: CDR, written field by field, arrays in one piece."""

from __future__ import annotations

import struct
from typing import Final

import numpy as np
from numpy.typing import ArrayLike

SECOND: Final = 1_000_000_000


class CdrWriter:
    """A message in little-endian CDR that grows by its fields in their order.

    Numbers are aligned to their size, counted from behind the encapsulation.
    """

    def __init__(self) -> None:
        self._data = bytearray()

    def number(self, kind: str, *values: float) -> CdrWriter:
        """Add numbers of one kind, named as in `struct`: `i`, `I`, `f`, `d`, `B` or `?`."""
        form = struct.Struct(f"<{kind}")
        for value in values:
            self._align(form.size)
            self._data += form.pack(value)
        return self

    def string(self, text: str) -> CdrWriter:
        """Add a string."""
        data = text.encode() + b"\0"
        self.number("I", len(data))
        self._data += data
        return self

    def header(self, stamp: int, frame: str) -> CdrWriter:
        """Add a std_msgs/Header; stamp in nanoseconds."""
        return self.number("i", stamp // SECOND).number("I", stamp % SECOND).string(frame)

    def doubles(self, values: ArrayLike) -> CdrWriter:
        """Add the float64 numbers of an array of any shape, row by row."""
        data = np.ascontiguousarray(values, dtype="<f8").tobytes()
        if data:
            self._align(8)
        self._data += data
        return self

    def message(self) -> bytes:
        """What was added, as a message."""
        return b"\0\1\0\0" + bytes(self._data)  # plain CDR, little-endian

    def _align(self, size: int) -> None:
        self._data += bytes(-len(self._data) % size)

"""Messages as little-endian CDR, written field by field, where no ROS is installed."""

from __future__ import annotations

import struct

import numpy as np
from numpy.typing import ArrayLike

ENCAPSULATION = b"\x00\x01\x00\x00"
"""Plain CDR, little-endian."""


class CdrWriter:
    """A message that grows by its fields in their order.

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

    def doubles(self, values: ArrayLike) -> CdrWriter:
        """Add the float64 numbers of an array of any shape, row by row."""
        data = np.ascontiguousarray(values, dtype="<f8").tobytes()
        if data:
            self._align(8)
        self._data += data
        return self

    def message(self) -> bytes:
        """What was added, as a message."""
        return ENCAPSULATION + bytes(self._data)

    def _align(self, size: int) -> None:
        self._data += bytes(-len(self._data) % size)

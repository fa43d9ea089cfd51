# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""Messages as bytes: CDR by fields, and markers without an object for every corner."""

import struct
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from ....base.text import SECOND
from ....core.records import Array


class CdrWriter:
    """A little-endian CDR message by its fields; numbers are aligned to their size."""

    def __init__(self) -> None:
        self._data = bytearray()

    def number(self, kind: str, *values: float) -> "CdrWriter":
        """Add numbers of one kind of `struct`: `i`, `I`, `f`, `d`, `B` or `?`."""
        form = struct.Struct(f"<{kind}")
        for value in values:
            self._align(form.size)
            self._data += form.pack(value)
        return self

    def string(self, text: str) -> "CdrWriter":
        """Add a string."""
        data = text.encode() + b"\0"
        self.number("I", len(data))
        self._data += data
        return self

    def header(self, stamp: int, frame: str) -> "CdrWriter":
        """Add a std_msgs/Header; stamp in nanoseconds."""
        return (
            self.number("i", stamp // SECOND).number("I", stamp % SECOND).string(frame)
        )

    def doubles(self, values: ArrayLike) -> "CdrWriter":
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


CUBE = 1
TEXT_VIEW_FACING = 9
TRIANGLE_LIST = 11
"""Kinds of markers, as in visualization_msgs/Marker."""

# What is done with a marker.
ADD = 0
DELETE_ALL = 3

NO_CORNERS = np.empty((0, 3))


class Marker(NamedTuple):
    """A visualization_msgs/Marker; its other fields stay empty."""

    frame: str = ""
    name: str = ""
    kind: int = 0
    # position in the frame, metres, and quaternion x y z w
    pose: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    color: tuple[float, ...] = (0.0,) * 4  # red, green, blue and opacity, 0 to 1
    corners: Array = NO_CORNERS  # (3 T, 3), metres; three to a triangle
    text: str = ""
    number: int = 0  # of the marker among those of the name
    action: int = ADD
    stamp: int = 0  # nanoseconds
    is_locked: bool = False  # whether it moves with its frame


def marker_array_message(markers: list[Marker]) -> bytes:
    """A visualization_msgs/MarkerArray, serialised."""
    message = CdrWriter().number("I", len(markers))
    for marker in markers:
        message.header(marker.stamp, marker.frame).string(marker.name)
        message.number("i", marker.number, marker.kind, marker.action)
        message.doubles(marker.pose).doubles(marker.scale).number("f", *marker.color)
        message.number("i", 0).number("I", 0)  # shown for ever
        message.number("?", marker.is_locked)
        message.number("I", marker.corners.size // 3).doubles(marker.corners)
        # No colors of corners, no texture.
        message.number("I", 0).string("").header(0, "").string("").number("I", 0)
        message.number("I", 0).string(marker.text)
        message.string("").string("").number("I", 0).number("?", False)  # no file
    return message.message()

"""Markers as messages, written without an object for every corner of a mesh."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from .cdr import CdrWriter

Array = NDArray[np.float64]

CUBE, TEXT_VIEW_FACING, TRIANGLE_LIST = 1, 9, 11
"""Kinds of markers, as in visualization_msgs/Marker."""

ADD, DELETE_ALL = 0, 3
"""What is done with a marker."""

NO_CORNERS = np.empty((0, 3))


class Marker(NamedTuple):
    """A visualization_msgs/Marker; its other fields stay empty."""

    frame: str = ""
    name: str = ""
    kind: int = 0
    # position in the frame, metres, and quaternion x y z w
    place: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0)
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    color: tuple[float, ...] = (0.0, 0.0, 0.0, 0.0)  # red, green, blue and opacity, 0 to 1
    corners: Array = NO_CORNERS  # three coordinates a corner, three corners a triangle, metres
    text: str = ""
    number: int = 0  # of the marker among those of the name
    action: int = ADD
    stamp: int = 0  # nanoseconds
    locked: bool = False  # whether it moves with its frame


def marker_array_message(markers: list[Marker]) -> bytes:
    """A visualization_msgs/MarkerArray, serialised."""
    message = CdrWriter().number("I", len(markers))
    for marker in markers:
        _append(message, marker)
    return message.message()


def _append(message: CdrWriter, one: Marker) -> None:
    message.header(one.stamp, one.frame).string(one.name)
    message.number("i", one.number, one.kind, one.action)
    message.doubles(one.place).doubles(one.scale).number("f", *one.color)
    message.number("i", 0).number("I", 0).number("?", one.locked)  # shown for ever
    message.number("I", one.corners.size // 3).doubles(one.corners).number("I", 0).string("")
    message.header(0, "").string("").number("I", 0)  # no texture
    message.number("I", 0).string(one.text)
    message.string("").string("").number("I", 0).number("?", False)  # no file

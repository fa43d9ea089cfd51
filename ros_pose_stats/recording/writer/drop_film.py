"""A drop as an MCAP file that Foxglove and RViz play: transforms, markers, energy."""

from __future__ import annotations

import struct
from collections.abc import Callable
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...records import Part
from ...resting.decimation import visible_triangles
from ...resting.orientation import rotation_matrices
from ...simulation.frames import RATE, DropFrames
from .bag_file import BagFile
from .message_types import MessageType, definition

Array = NDArray[np.float64]

TF, BODY, ENERGY, REACH = "/tf", "/drop/markers", "/drop/energy", "/drop/within_reach"
PLATE, FRAME = "plate", "part"
"""Frames: the plate, z up, and the part's own."""

FINEST = 10_000
"""Triangles of the marker; a larger mesh is shown as its convex hull, made coarser."""

SECOND: Final = 1_000_000_000
START: Final = SECOND
"""Time [ns] of the release in the file; 0 has a meaning of its own in ROS."""

EVERY: Final = SECOND // 4
"""Between two copies of the markers, for viewers that begin anywhere."""

TRIANGLE_LIST, CUBE = 11, 1

_TIME = "int32 sec\nuint32 nanosec\n"
_VECTOR = "float64 x\nfloat64 y\nfloat64 z\n"
_TEXTS: Final = {
    "builtin_interfaces/msg/Time": _TIME,
    "builtin_interfaces/msg/Duration": _TIME,
    "std_msgs/msg/Float64": "float64 data\n",
    "std_msgs/msg/String": "string data\n",
    "std_msgs/msg/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "std_msgs/msg/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n",
    "geometry_msgs/msg/Vector3": _VECTOR,
    "geometry_msgs/msg/Point": _VECTOR,
    "geometry_msgs/msg/Quaternion": f"{_VECTOR}float64 w\n",
    "geometry_msgs/msg/Pose": "Point position\nQuaternion orientation\n",
    "geometry_msgs/msg/Transform": "Vector3 translation\nQuaternion rotation\n",
    "geometry_msgs/msg/TransformStamped":
        "std_msgs/Header header\nstring child_frame_id\nTransform transform\n",
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms\n",
    "sensor_msgs/msg/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data\n",
    "visualization_msgs/msg/UVCoordinate": "float32 u\nfloat32 v\n",
    "visualization_msgs/msg/MeshFile": "string filename\nuint8[] data\n",
    "visualization_msgs/msg/Marker": (
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n"
        "geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n"
        "builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n"
        "std_msgs/ColorRGBA[] colors\nstring texture_resource\n"
        "sensor_msgs/CompressedImage texture\nUVCoordinate[] uv_coordinates\nstring text\n"
        "string mesh_resource\nMeshFile mesh_file\nbool mesh_use_embedded_materials\n"),
    "visualization_msgs/msg/MarkerArray": "Marker[] markers\n",
}
"""Names, order and kinds of the fields are those of ROS 2 Jazzy, which need not be installed."""

TYPES: Final = {topic: MessageType(name, definition(name, _TEXTS.__getitem__), "")
                for topic, name in ((TF, "tf2_msgs/msg/TFMessage"),
                                    (BODY, "visualization_msgs/msg/MarkerArray"),
                                    (ENERGY, "std_msgs/msg/Float64"),
                                    (REACH, "std_msgs/msg/String"))}


def write_film(file: Path, part: Part, frames: DropFrames, within: Callable[[float], str]) -> None:
    """Write a drop to a new MCAP file, in true time.

    Parameters
    ----------
    file : Path
        Must not exist.
    part : Part
    frames : DropFrames
        Of a drop of that part.
    within : callable
        The poses that an energy (joules) leaves within reach, in words.

    Notes
    -----
    Topics: `/tf` (`plate` to `part`), `/drop/markers` (the part, in its own frame, and the
    plate), `/drop/energy` [J] and `/drop/within_reach`.
    """
    film = BagFile(file, TYPES)
    places = -(rotation_matrices(frames.orientations) @ part.center_of_mass)
    places[:, 2] += frames.heights
    still = np.maximum(np.arange(len(frames.times)) - frames.rest, 0) / RATE
    drawn = -EVERY
    for k, time in enumerate((frames.times + still).tolist()):
        stamp = START + round(SECOND * time)
        if stamp - drawn >= EVERY:
            drawn = stamp
            film.append(BODY, memoryview(_markers(part, stamp)), stamp)
        energy = float(frames.energies[k])
        film.append(TF, memoryview(_transform(places[k], frames.orientations[k], stamp)), stamp)
        film.append(ENERGY, memoryview(CdrWriter().number("d", energy).message()), stamp)
        film.append(REACH, memoryview(CdrWriter().string(within(energy)).message()), stamp)
    film.finish()


def _header(message: CdrWriter, stamp: int, frame: str) -> CdrWriter:
    return message.number("i", stamp // SECOND).number("I", stamp % SECOND).string(frame)


def _transform(place: Array, orientation: Array, stamp: int) -> bytes:
    message = _header(CdrWriter().number("I", 1), stamp, PLATE).string(FRAME)
    return message.doubles(place).doubles(orientation).message()


def _markers(part: Part, stamp: int) -> bytes:
    """The part in its own frame, which the transforms move, and the plate below it."""
    corners = visible_triangles(part, FINEST).reshape(-1, 3)
    about = corners - part.center_of_mass
    reach = float(np.sqrt((about * about).sum(axis=1).max()))
    message = CdrWriter().number("I", 2)
    _marker(message, stamp, FRAME, (part.part_id, TRIANGLE_LIST), (1.0, 1.0, 1.0), 0.0,
            (0.42, 0.64, 0.92, 1.0), corners)
    thin = 0.02 * reach
    _marker(message, stamp, PLATE, (PLATE, CUBE), (3.0 * reach, 3.0 * reach, thin), -0.5 * thin,
            (0.8, 0.8, 0.8, 1.0), np.empty((0, 3)))
    return message.message()


def _marker(message: CdrWriter, stamp: int, frame: str, kind: tuple[str, int],
            scale: tuple[float, float, float], z: float, color: tuple[float, ...],
            points: Array) -> None:
    """A visualization_msgs/Marker; what is not needed stays empty."""
    name, number = kind
    _header(message, stamp, frame).string(name).number("i", 0, number, 0)
    message.doubles((0.0, 0.0, z, 0.0, 0.0, 0.0, 1.0)).doubles(scale).number("f", *color)
    message.number("i", 0).number("I", 0).number("?", True)  # for ever, and moved by its frame
    message.number("I", len(points)).doubles(points).number("I", 0).string("")
    _header(message, 0, "").string("").number("I", 0)  # no texture
    message.number("I", 0).string("").string("").string("").number("I", 0).number("?", False)


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

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

"""A drop as an MCAP file that Foxglove and RViz play: transforms, markers, energy."""

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
from mcap import records

from ....base.text import SECOND
from ....core.mesh import decimation, vectors
from ....core.records import Part
from ....core.simulation.frames import RATE, DropFrames
from . import mcap_layout, message_types
from .cdr import CUBE, TRIANGLE_LIST, CdrWriter, Marker, marker_array_message
from .indexed_file import IndexedFile

TF = "/tf"
BODY = "/drop/markers"
ENERGY = "/drop/energy"
REACH = "/drop/within_reach"
PLATE = "plate"  # frame of the plate, z up
FRAME = "part"  # the part's own
MAX_TRIANGLES = 10_000  # triangles of the marker
# Time [ns] of the release in the file; 0 has a meaning of its own in ROS.
START = SECOND
# Between two copies of the markers [ns], for viewers that begin anywhere.
MARKER_INTERVAL = SECOND // 4
_TIME = "int32 sec\nuint32 nanosec\n"
_VECTOR = "float64 x\nfloat64 y\nfloat64 z\n"
_TEXTS = {
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
    "geometry_msgs/msg/TransformStamped": (
        "std_msgs/Header header\nstring child_frame_id\nTransform transform\n"
    ),
    "tf2_msgs/msg/TFMessage": "geometry_msgs/TransformStamped[] transforms\n",
    "sensor_msgs/msg/CompressedImage": (
        "std_msgs/Header header\nstring format\nuint8[] data\n"
    ),
    "visualization_msgs/msg/UVCoordinate": "float32 u\nfloat32 v\n",
    "visualization_msgs/msg/MeshFile": "string filename\nuint8[] data\n",
    "visualization_msgs/msg/Marker": (
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n"
        "geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\n"
        "std_msgs/ColorRGBA color\nbuiltin_interfaces/Duration lifetime\n"
        "bool frame_locked\ngeometry_msgs/Point[] points\nstd_msgs/ColorRGBA[] colors\n"
        "string texture_resource\nsensor_msgs/CompressedImage texture\n"
        "UVCoordinate[] uv_coordinates\nstring text\nstring mesh_resource\n"
        "MeshFile mesh_file\nbool mesh_use_embedded_materials\n"
    ),
    "visualization_msgs/msg/MarkerArray": "Marker[] markers\n",
}
"""Definitions of ROS 2 Jazzy, which need not be installed, without comments."""

TYPES = {
    topic: message_types.MessageType(
        name, message_types.used_texts(name, _TEXTS.__getitem__)
    )
    for topic, name in (
        (TF, "tf2_msgs/msg/TFMessage"),
        (BODY, "visualization_msgs/msg/MarkerArray"),
        (ENERGY, "std_msgs/msg/Float64"),
        (REACH, "std_msgs/msg/String"),
    )
}


def write_film(
    file: Path, part: Part, frames: DropFrames, describe_reach: Callable[[float], str]
) -> None:
    """Write a drop to a new MCAP file with an index, in true time.

    `describe_reach`: the poses in reach of an energy [J], as a text.
    """
    topics = mcap_layout.describe_topics(TYPES)
    channels = {channel.topic: number for number, channel in topics.channels.items()}
    with file.open("xb") as target:
        film = IndexedFile(target)
        for description in topics.descriptions:
            film.describe(description)
        for topic, data, stamp in _messages(part, frames, describe_reach):
            channel = channels[topic]
            number = film.contents.counts[channel]
            film.append(records.Message(channel, stamp, data, stamp, number))
        film.finish(file.name)


def _messages(
    part: Part, frames: DropFrames, describe_reach: Callable[[float], str]
) -> Iterator[tuple[str, bytes, int]]:
    """Topic, message and time [ns] of all that is in the film, in its order."""
    positions = -(vectors.rotation_matrices(frames.orientations) @ part.center_of_mass)
    positions[:, 2] += frames.heights
    rest_seconds = (
        np.maximum(np.arange(len(frames.times)) - frames.rest_frame, 0) / RATE
    )
    marker_stamp = -MARKER_INTERVAL
    for k, time in enumerate((frames.times + rest_seconds).tolist()):
        stamp = START + round(SECOND * time)
        if stamp - marker_stamp >= MARKER_INTERVAL:
            marker_stamp = stamp
            yield BODY, _markers(part, stamp), stamp
        energy = float(frames.energies[k])
        transform = (
            CdrWriter()
            .number("I", 1)
            .header(stamp, PLATE)
            .string(FRAME)
            .doubles(positions[k])
            .doubles(frames.orientations[k])
        )
        for topic, message in (
            (TF, transform),
            (ENERGY, CdrWriter().number("d", energy)),
            (REACH, CdrWriter().string(describe_reach(energy))),
        ):
            yield topic, message.message(), stamp


def _markers(part: Part, stamp: int) -> bytes:
    """The part in its own frame, which the transforms move, and the plate below it."""
    corners = decimation.visible_triangles(part, MAX_TRIANGLES).reshape(-1, 3)
    offsets = corners - part.center_of_mass
    reach = float(np.sqrt((offsets * offsets).sum(axis=1).max()))
    thickness = 0.02 * reach
    return marker_array_message(
        [
            Marker(
                FRAME,
                part.part_id,
                TRIANGLE_LIST,
                color=(0.42, 0.64, 0.92, 1.0),
                corners=corners,
                stamp=stamp,
                is_locked=True,
            ),
            Marker(
                PLATE,
                PLATE,
                CUBE,
                (0.0, 0.0, -0.5 * thickness, 0.0, 0.0, 0.0, 1.0),
                (3.0 * reach, 3.0 * reach, thickness),
                (0.8, 0.8, 0.8, 1.0),
                stamp=stamp,
                is_locked=True,
            ),
        ]
    )

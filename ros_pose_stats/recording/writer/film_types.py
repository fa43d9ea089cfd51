"""The message types of a recorded drop, as a file describes them without ROS at hand.

Names, order and kinds of the fields are those of the ROS 2 Jazzy interfaces.
"""

from __future__ import annotations

from typing import Final

from .definitions import SEPARATOR
from .message_types import MessageType

_TIME = "int32 sec\nuint32 nanosec\n"
_VECTOR = "float64 x\nfloat64 y\nfloat64 z\n"
_TEXTS: Final = {
    "builtin_interfaces/Time": _TIME,
    "builtin_interfaces/Duration": _TIME,
    "std_msgs/Header": "builtin_interfaces/Time stamp\nstring frame_id\n",
    "std_msgs/ColorRGBA": "float32 r\nfloat32 g\nfloat32 b\nfloat32 a\n",
    "geometry_msgs/Vector3": _VECTOR,
    "geometry_msgs/Point": _VECTOR,
    "geometry_msgs/Quaternion": f"{_VECTOR}float64 w\n",
    "geometry_msgs/Pose": "Point position\nQuaternion orientation\n",
    "geometry_msgs/Transform": "Vector3 translation\nQuaternion rotation\n",
    "geometry_msgs/TransformStamped":
        "std_msgs/Header header\nstring child_frame_id\nTransform transform\n",
    "sensor_msgs/CompressedImage": "std_msgs/Header header\nstring format\nuint8[] data\n",
    "visualization_msgs/UVCoordinate": "float32 u\nfloat32 v\n",
    "visualization_msgs/MeshFile": "string filename\nuint8[] data\n",
    "visualization_msgs/Marker": (
        "std_msgs/Header header\nstring ns\nint32 id\nint32 type\nint32 action\n"
        "geometry_msgs/Pose pose\ngeometry_msgs/Vector3 scale\nstd_msgs/ColorRGBA color\n"
        "builtin_interfaces/Duration lifetime\nbool frame_locked\ngeometry_msgs/Point[] points\n"
        "std_msgs/ColorRGBA[] colors\nstring texture_resource\n"
        "sensor_msgs/CompressedImage texture\nUVCoordinate[] uv_coordinates\nstring text\n"
        "string mesh_resource\nMeshFile mesh_file\nbool mesh_use_embedded_materials\n"),
}


def _described(name: str, text: str, *used: str) -> MessageType:
    package, _, short = name.partition("/")
    others = [f"{SEPARATOR}\nMSG: {one}\n{_TEXTS[one]}" for one in used]
    return MessageType(f"{package}/msg/{short}", "\n".join([text, *others]), "")


TRANSFORMS: Final = _described(
    "tf2_msgs/TFMessage", "geometry_msgs/TransformStamped[] transforms\n",
    "geometry_msgs/TransformStamped", "std_msgs/Header", "builtin_interfaces/Time",
    "geometry_msgs/Transform", "geometry_msgs/Vector3", "geometry_msgs/Quaternion")

MARKERS: Final = _described(
    "visualization_msgs/MarkerArray", "Marker[] markers\n", "visualization_msgs/Marker",
    "std_msgs/Header", "builtin_interfaces/Time", "geometry_msgs/Pose", "geometry_msgs/Point",
    "geometry_msgs/Quaternion", "geometry_msgs/Vector3", "std_msgs/ColorRGBA",
    "builtin_interfaces/Duration", "sensor_msgs/CompressedImage",
    "visualization_msgs/UVCoordinate", "visualization_msgs/MeshFile")

NUMBER: Final = _described("std_msgs/Float64", "float64 data\n")
WORDS: Final = _described("std_msgs/String", "string data\n")

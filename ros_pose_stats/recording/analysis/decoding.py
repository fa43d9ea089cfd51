"""Messages of this package's types, decoded by the definition in the file."""

import math
from collections.abc import Callable
from hashlib import blake2b
from typing import Any, NamedTuple

import numpy as np
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory
from numpy.typing import NDArray

from ...errors import BagError
from ...records import Array, scene as scenes
from ..reader import RawMessage

PACKAGE = "ros_pose_stats_msgs"
PART_MESH, POSE_STATISTICS, JOB_EVENT, POSE_COUNTS, DROP_RECORDS = (
    "PartMesh", "PoseStatistics", "JobEvent", "PoseCounts", "DropRecords")
CONVERT = "`ros2 bag convert` makes a plain MCAP bag of it"
KINDS = frozenset((PART_MESH, POSE_STATISTICS, JOB_EVENT, POSE_COUNTS, DROP_RECORDS))
SECOND = 1_000_000_000
PACKED = b"\x28\xb5\x2f\xfd"  # how data compressed by zstd begins; a message begins with a zero


def kind_of(type_name: str) -> str:
    """Name of a message type that the analysis reads, without the package; empty for others."""
    package, _, rest = type_name.partition("/")
    name = rest.removeprefix("msg/")
    return name if package == PACKAGE and name in KINDS else ""


class Decoders:
    """Decodes by the definitions that come with messages; `failed` did not fit theirs."""

    def __init__(self) -> None:
        self._known: dict[tuple[str, str], Callable[[bytes], Any] | None] = {}
        self.failed = 0

    def decode(self, message: RawMessage) -> Any | None:
        """The message with the fields of its definition; None if broken, BagError if packed."""
        if message.data.startswith(PACKED):
            raise BagError("messages that are not compressed one by one",
                           f"such on {message.topic}", CONVERT)
        definition = message.type_name, message.definition
        if definition not in self._known:
            self._known[definition] = _decoder(*definition)
        decoder = self._known[definition]
        try:
            if decoder is not None:
                return decoder(message.data)
        except Exception:
            # struct, Unicode, index and memory errors alike: the bytes are not what was said.
            pass
        self.failed += 1
        return None


def _decoder(type_name: str, text: str) -> Callable[[bytes], Any] | None:
    schema = Schema(id=1, name=type_name, encoding="ros2msg", data=text.encode())
    try:
        return DecoderFactory().decoder_for("cdr", schema)
    except Exception:
        return None  # a definition that does not parse


def numbering_of(message: Any) -> scenes.Numbering:
    """What a message says, the tolerance to 12 digits; older ones took round surfaces as given."""
    tolerance = float(f"{float(getattr(message, 'cluster_tolerance', math.nan)):.12g}")
    # One object for all that are not known: a NaN as a key equals itself alone.
    return scenes.Numbering(tolerance if math.isfinite(tolerance) else math.nan,
                     int(getattr(message, "round_sides", 0)))


def stamp_of(message: Any) -> int:
    """Time stamp of a message's header, nanoseconds since 1970; 0 where there is none."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return 0 if stamp is None else int(stamp.sec) * SECOND + int(stamp.nanosec)


def fingerprint(*values: Any) -> bytes:
    """Sixteen bytes that stand for plain values and numpy arrays."""
    digest = blake2b(digest_size=16)
    for value in values:
        digest.update(value.tobytes() if isinstance(value, np.ndarray) else repr(value).encode())
        digest.update(b"\0")
    return digest.digest()


class PartMeshRecord(NamedTuple):
    """A part as it was recorded; see the message PartMesh."""

    part_id: str
    vertices: Array  # (V, 3); in `unit`
    triangles: NDArray[np.uint32]  # (T, 3)
    unit: float  # metres
    mass: float  # kilograms; 0 where all of it is from the mesh
    center_of_mass: Array  # (3,); metres
    inertia: Array  # (3, 3); kg m²; zero where it is from the mesh


def part_mesh_of(message: Any) -> PartMeshRecord | None:
    """A PartMesh; None where the definition is of another kind under our name."""
    try:
        corners, numbers = list(message.vertices), list(message.triangles)
        if not numbers:
            nested = message.mesh
            corners = [x for p in nested.vertices for x in (p.x, p.y, p.z)]
            numbers = [k for triangle in nested.triangles for k in triangle.vertex_indices]
        vertices = np.array(corners, dtype=np.float64).reshape(-1, 3)
        triangles = np.array(numbers, dtype=np.uint32).reshape(-1, 3)
        given = message.inertia
        tensor = np.array([[given.ixx, given.ixy, given.ixz], [given.ixy, given.iyy, given.iyz],
                           [given.ixz, given.iyz, given.izz]], dtype=np.float64)
        center = np.array([given.com.x, given.com.y, given.com.z], dtype=np.float64)
        return PartMeshRecord(str(message.part_id), vertices, triangles, float(message.unit),
                              float(given.m), center, tensor)
    except (AttributeError, TypeError, ValueError):
        return None

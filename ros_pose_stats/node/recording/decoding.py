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

"""Messages of this package's types, decoded by the definition in the file."""

from collections.abc import Callable
from contextlib import redirect_stderr, suppress
from hashlib import blake2b
from io import StringIO
from types import SimpleNamespace
from typing import Any

import numpy as np
from mcap.records import Schema
from mcap_ros2.decoder import DecoderFactory

from ...base.errors import BagError, PoseStatsError
from ...base.text import SECOND
from ...core.records import Part
from ...core.records.notes import note_of_sentence
from .reader import RawMessage

PACKAGE = "ros_pose_stats_msgs"
KINDS = PART_MESH, POSE_STATISTICS, JOB_EVENT, POSE_COUNTS, DROP_RECORDS = (
    "PartMesh",
    "PoseStatistics",
    "JobEvent",
    "PoseCounts",
    "DropRecords",
)
CONVERT = "`ros2 bag convert` makes a plain MCAP bag of it"

# Of a definition: ours have some kilobytes, and as many texts as nodes had versions.
# The parser takes time by the square of the lines.
MOST_CHARACTERS = 65536
MOST_LINES = 1000
MOST_DEFINITIONS = 500
# How data compressed by zstd begins; a message begins with a zero.
ZSTD_START = b"\x28\xb5\x2f\xfd"


def kind_of(type_name: str) -> str:
    """Short name of a message type that the analysis reads; empty for others."""
    package, _, path = type_name.partition("/")
    name = path.removeprefix("msg/")
    return name if package == PACKAGE and name in KINDS else ""


class Decoders:
    """Decodes by the definitions that come with messages; `failures` did not fit."""

    def __init__(self) -> None:
        self._by_definition: dict[tuple[str, str], Callable[[bytes], Any] | None] = {}
        self.failures = 0

    def decode(self, message: RawMessage) -> Any | None:
        """The message by its definition; None if broken, BagError if compressed.

        What version 0.2.0 said otherwise is said as today.
        """
        if message.data.startswith(ZSTD_START):
            raise BagError(
                "messages that are not compressed one by one",
                f"such on {message.topic}",
                CONVERT,
            )
        definition = message.type_name, message.definition
        if definition not in self._by_definition:
            self._by_definition[definition] = (
                _decoder_for(*definition)
                if len(self._by_definition) < MOST_DEFINITIONS
                else None
            )
        decoder = self._by_definition[definition]
        # struct, Unicode, index and memory errors alike: the bytes are not what they
        # should be.
        with suppress(Exception):
            if decoder is not None:
                return modernised(decoder(message.data))
        self.failures += 1
        return None


def _decoder_for(type_name: str, text: str) -> Callable[[bytes], Any] | None:
    """What decodes messages of a definition; None for one that does not parse."""
    if len(text) > MOST_CHARACTERS:
        return None
    # The parser looks for units in comments, by the square of their length.
    lines = [line.partition("#")[0].rstrip() for line in text.splitlines()]
    lines = [line for line in lines if line]
    if len(lines) > MOST_LINES:
        return None
    schema = Schema(1, "\n".join(lines).encode(), "ros2msg", type_name)
    # The parser prints lines that it refuses, whatever a terminal makes of them.
    with suppress(Exception), redirect_stderr(StringIO()):
        return DecoderFactory().decoder_for("cdr", schema)
    return None


OLD_FORGOTTEN = 0  # the event of 0.2.0 that was none of a simulation
OLD_CODES = {4: 9, 5: 8}
"""Codes of how simulations ended that were cancelled or failed, by their state."""


def modernised(message: Any) -> Any:
    """A decoded message with the fields of today in place of those of 0.2.0.

    The states of a simulation had the same numbers then.
    """
    if hasattr(message, "event") and not hasattr(message, "status"):
        is_forgotten = message.event == OLD_FORGOTTEN
        message.part_forgotten = is_forgotten
        message.status = SimpleNamespace(
            job_id=message.job_id,
            part_id=getattr(message, "part_id", ""),
            state=message.event,
            code=OLD_CODES.get(message.event, 0),
            drops_done=getattr(message, "drops_done", 0),
            drops_total=getattr(message, "drops", 0),
        )
    sentences = [*getattr(message, "warnings", ()), *getattr(message, "notes", ())]
    if sentences and all(isinstance(sentence, str) for sentence in sentences):
        message.warnings = [note_of_sentence(sentence) for sentence in sentences]
    return message


def stamp_of(message: Any) -> int:
    """Time stamp of a message's header [ns since 1970]; 0 where there is none."""
    stamp = getattr(getattr(message, "header", None), "stamp", None)
    return 0 if stamp is None else int(stamp.sec) * SECOND + int(stamp.nanosec)


def fingerprint(*values: Any) -> bytes:
    """Sixteen bytes that stand for plain values and numpy arrays."""
    digest = blake2b(digest_size=16)
    for value in values:
        digest.update(
            value.tobytes() if isinstance(value, np.ndarray) else repr(value).encode()
        )
        digest.update(b"\0")
    return digest.digest()


def part_of(message: Any) -> Part | None:
    """The part of a PartMesh; None if a node refused it too, or it has other fields."""
    from ...core.mesh.bodies import separation
    from ...core.mesh.parts import part_from_mesh

    try:
        corners = list(message.vertices)
        indices = list(message.triangles)
        if not indices:
            nested = message.mesh
            corners = [x for p in nested.vertices for x in (p.x, p.y, p.z)]
            indices = [
                k for triangle in nested.triangles for k in triangle.vertex_indices
            ]
        inertia = message.inertia
        has_mass = inertia.m != 0.0
        tensor = np.array(
            [
                [inertia.ixx, inertia.ixy, inertia.ixz],
                [inertia.ixy, inertia.iyy, inertia.iyz],
                [inertia.ixz, inertia.iyz, inertia.izz],
            ],
            dtype=np.float64,
        )
        return part_from_mesh(
            np.array(corners, dtype=np.float64).reshape(-1, 3),
            np.array(indices, dtype=np.uint32).reshape(-1, 3),
            (inertia.com.x, inertia.com.y, inertia.com.z) if has_mass else None,
            float(inertia.m) if has_mass else None,
            tensor if has_mass and tensor.any() else None,
            part_id=str(message.part_id),
            unit=float(message.unit),
            # A bag of before there were bodies: they were one rigid part.
            body=separation.choice_of_number(getattr(message, "body", separation.ALL)),
        )
    except (AttributeError, TypeError, ValueError, PoseStatsError):
        return None

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

"""What tests read of an answer, and files that they write without the package's
help.
"""

from pathlib import Path

import numpy as np

METHODS = (
    "area",
    "csae",
    "adre",
    "qse",
    "pqse",
    "nqse",
    "eae",
    "meae",
    "combined",
    "split",
)


def write_stl(path: Path, surface) -> Path:
    """Binary STL, written without the help of the package under test."""
    vertices, triangles = surface
    record = np.zeros(
        len(triangles),
        dtype=[("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")],
    )
    record["corners"] = np.asarray(vertices)[triangles]
    path.write_bytes(
        bytes(80) + len(triangles).to_bytes(4, "little") + record.tobytes()
    )
    return path


def codes(statistics):
    """What the warnings of a part or an answer are about."""
    return [warning.code for warning in statistics.warnings]


def notes(statistics):
    """Warnings of a record or a message as plain values."""
    return [
        (warning.code, warning.text, warning.acts) for warning in statistics.warnings
    ]


def acting_codes(statistics):
    """Of these, what somebody should act on."""
    return [warning.code for warning in statistics.warnings if warning.acts]


def counts(statistics):
    """Drops in each pose, by index."""
    return [
        pose.count for pose in sorted(statistics.poses, key=lambda pose: pose.index)
    ]


def by_index(statistics, name="probability"):
    """A value of all poses, in the order of their numbers."""
    return np.array(
        [getattr(pose, name) for _, pose in sorted(statistics.by_index.items())]
    )

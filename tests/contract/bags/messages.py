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

"""Messages of a run, made and serialised by ROS itself, with their definitions by
`rosbags`.
"""

import struct
import sys
import warnings
from array import array
from functools import cache
from hashlib import sha256
from pathlib import Path

import numpy as np
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import (
    DropRecords,
    JobEvent,
    JobStatus,
    Note,
    PartMesh,
    PoseCounts,
    PoseStatistics,
    StablePose,
)
from rosbags.typesys import Stores, get_types_from_msg, get_typestore
from scipy.stats import beta

with warnings.catch_warnings():
    # Loaded with the first message; its parser's library uses a module that Python
    # deprecates.
    warnings.simplefilter("ignore", DeprecationWarning)
    import rosidl_generator_py  # noqa: F401

SECOND = 1_000_000_000
START = 1_770_000_000 * SECOND
DIGEST = "3fa9c1d2" * 8
PROBABILITY = (0.55, 0.25, 0.12, 0.06, 0.02)
GROUP = (0, 1, 0, 2, 3)
SIMULATED = (1120, 470, 250, 120, 40)
COUNTED = (230, 98, 52, 16, 4)
SHARE = Path(sys.prefix) / "share" / "ros_pose_stats_msgs" / "msg"
PACKAGE = "ros_pose_stats_msgs/msg"


def stamped(message, seconds):
    """Set the header's stamp, seconds after the start."""
    time = START + round(seconds * SECOND)
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(time, SECOND)
    return message


def filled(message, defaults, fields):
    for name, value in {**defaults, **fields}.items():
        setattr(message, name, value)
    return message


def result(
    seconds,
    probability=PROBABILITY,
    method="combined",
    count=None,
    group=GROUP,
    error=0.0,
    **fields,
):
    """A PoseStatistics, its poses most probable first as in the contract.

    That of an estimate says that every pose has this error, none by default.
    """
    nan = float("nan")
    settled = 0 if count is None else int(sum(count))
    numbered = {"part_digest": DIGEST, "cluster_tolerance": 0.005, "round_sides": 192}
    numbered.update({name: fields[name] for name in numbered if name in fields})
    message = filled(
        stamped(PoseStatistics(), seconds),
        {
            "part_id": "clamp",
            **numbered,
            "numbering": numbering_of(*numbered.values()),
            "radius": 0.02,
            "method": method,
            "restitution": 0.5,
            "drop_height": 0.4 if settled else nan,
            "drops": settled,
            "plate_error": 0.05,
            "expected_error": nan,
            "final": True,
            "version": "0.1.0",
        },
        fields,
    )
    if settled:
        count = np.asarray(count, dtype=float)
        probability = count / settled
        low, high = beta.ppf([[0.05], [0.95]], count + 0.5, settled - count + 0.5)
        smoothed = (count + 0.5) / (settled + len(count) / 2)
        errors = np.sqrt(smoothed * (1.0 - smoothed) / settled)
        message.expected_error = float(np.sqrt(np.mean(errors**2)))
    for index in np.argsort(-np.asarray(probability), kind="stable").tolist():
        pose = StablePose(
            index=index,
            group=group[index],
            pose_id=f"{message.part_id}/{index}",
            height=0.005 + 0.001 * index,
            top=0.02,
            margin=0.3,
            barrier=0.002,
            probability=float(probability[index]),
            probability_low=nan,
            probability_high=nan,
            standard_error=error,
            outline=array("d", range(20)),
        )
        pose.down.z = -1.0
        if settled:
            pose.count = int(count[index])
            pose.standard_error = float(errors[index])
            pose.probability_low = float(low[index])
            pose.probability_high = float(high[index])
        message.poses.append(pose)
    return message


def numbering_of(digest=DIGEST, tolerance=0.005, sides=192):
    """The number under which poses have their index, as PoseStatistics.msg says it."""
    data = digest.encode() + struct.pack("<dII", tolerance, sides, 1)
    return int.from_bytes(sha256(data).digest()[:8], "little")


def counts(seconds, count, index=None, **fields):
    """A PoseCounts; without a stamp where `seconds` is None."""
    message = PoseCounts() if seconds is None else stamped(PoseCounts(), seconds)
    return filled(
        message,
        {
            "part_id": "clamp",
            "numbering": numbering_of(),
            "plate": "steel",
            "drop_height": 0.4,
            "index": array("I", range(len(count)) if index is None else index),
            "count": array("Q", map(int, count)),
        },
        fields,
    )


def event(seconds, kind, job_id="job_1", **fields):
    """A JobEvent; fields of its status are told by their names."""
    of_status = {
        name: fields.pop(name)
        for name in JobStatus.get_fields_and_field_types()
        if name in fields
    }
    status = filled(
        JobStatus(),
        {
            "state": getattr(JobStatus, kind, JobStatus.UNKNOWN),
            "job_id": job_id,
            "part_id": "clamp",
            "drops_total": 1000,
        },
        of_status,
    )
    return filled(
        stamped(JobEvent(), seconds),
        {
            "status": status,
            "part_forgotten": kind == "PART_FORGOTTEN",
            "part_digest": DIGEST,
            "restitution": 0.5,
            "drop_height": 0.4,
            "cluster_tolerance": 0.005,
            "round_sides": 192,
            "seed": 7,
        },
        fields,
    )


def drop_records(poses):
    n = len(poses)
    return DropRecords(
        job_id="job_1",
        part_digest=DIGEST,
        pose_index=array("i", poses),
        start_down=array("f", [0.0] * (3 * n)),
        impacts=array("I", [12] * n),
        seconds=array("f", [0.5] * n),
        energy_left=array("f", [0.0] * n),
    )


def mesh(vertices=3):
    """A PartMesh of one triangle."""
    return PartMesh(
        part_id="clamp",
        vertices=array("d", bytes(24 * vertices)),
        triangles=array("I", [0, 1, 2]),
    )


def run_of_a_node():
    """What one run has to say: pairs of topic and message; it ended before its second
    job.
    """
    simulation = result(
        4.0, method="simulation", count=SIMULATED, job_id="job_1", seed=7
    )
    return [
        ("part_mesh", mesh()),
        ("pose_statistics", result(0.0)),
        ("job_events", event(1.0, "QUEUED")),
        ("job_events", event(1.1, "RUNNING")),
        (
            "pose_statistics",
            result(
                2.0,
                method="simulation",
                job_id="job_1",
                final=False,
                seed=7,
                count=(60, 20, 12, 7, 1),
            ),
        ),
        ("drop_records", drop_records([0, 1, 1, 2, -1])),
        (
            "answers",
            result(
                3.0,
                (0.5, 0.3, 0.1, 0.08, 0.02),
                "meae",
                warnings=[Note(code="LOW_DROP", text="released low.", acts=True)],
            ),
        ),
        ("pose_statistics", simulation),
        ("answers", simulation),
        ("job_events", event(4.1, "DONE", drops_done=2000)),
        ("job_events", event(5.0, "QUEUED", "job_2")),
        ("job_events", event(5.1, "RUNNING", "job_2", drops_done=0)),
        ("pose_counts", counts(6.0, COUNTED, unclassified=9)),
        ("pose_counts", counts(7.0, (46, 20, 10, 4, 0), unclassified=1)),
    ]


def serialised(message):
    """CDR bytes."""
    return bytes(serialize_message(message))


def type_name(message):
    """`package/msg/Type`."""
    return f"{type(message).__module__.partition('.')[0]}/msg/{type(message).__name__}"


@cache
def definition(name):
    """The text of a type and of all that it uses, as MCAP wants it."""
    return _types().generate_msgdef(name, ros_version=2)[0]


@cache
def _types():
    store = get_typestore(Stores.ROS2_JAZZY)
    kinds = {}
    for file in SHARE.glob("*.msg"):
        kinds.update(get_types_from_msg(file.read_text(), f"{PACKAGE}/{file.stem}"))
    store.register(kinds)
    return store

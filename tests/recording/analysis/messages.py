"""Messages of this package for test bags, made and serialised by ROS itself."""

from __future__ import annotations

import re
import sys
import warnings
from array import array
from pathlib import Path

import numpy as np
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import (
    DropRecords,
    JobEvent,
    PartMesh,
    PoseCounts,
    PoseStatistics,
    StablePose,
)

from ros_pose_stats.statistics.errors import standard_errors
from ros_pose_stats.statistics.intervals import jeffreys_interval

with warnings.catch_warnings():
    # Loaded with the first message; its parser's library uses a module that Python deprecates.
    warnings.simplefilter("ignore", DeprecationWarning)
    import rosidl_generator_py  # noqa: F401

SECOND = 1_000_000_000
START = 1_770_000_000 * SECOND
SHARE = Path(sys.prefix) / "share"
DIGEST = "3fa9c1d2" * 8
PROBABILITY = (0.55, 0.25, 0.12, 0.06, 0.02)
GROUP = (0, 1, 0, 2, 3)
PRIMITIVES = ("bool", "byte", "char", "float32", "float64", "int8", "uint8", "int16", "uint16",
              "int32", "uint32", "int64", "uint64", "string", "wstring")


def stamped(message, seconds):
    """Set the header's stamp, seconds after the start."""
    time = START + round(seconds * SECOND)
    message.header.stamp.sec, message.header.stamp.nanosec = divmod(time, SECOND)
    return message


def result(seconds, probability=PROBABILITY, method="combined", count=None, group=GROUP,
           error=0.0, **fields):
    """A PoseStatistics, its poses most probable first as in the contract.

    That of an estimate says that every pose has this error, none by default.
    """
    message = stamped(PoseStatistics(), seconds)
    settled = 0 if count is None else int(sum(count))
    defaults = {"part_id": "clamp", "part_digest": DIGEST, "radius": 0.02, "method": method,
                "restitution": 0.5, "drop_height": 0.4 if settled else float("nan"),
                "cluster_tolerance": 0.005, "round_sides": 192, "drops": settled,
                "plate_error": 0.05, "expected_error": float("nan"), "final": True,
                "version": "0.1.0"}
    for name, value in {**defaults, **fields}.items():
        setattr(message, name, value)
    if settled:
        probability = np.asarray(count) / settled
        errors = standard_errors(count, settled)
        low, high = jeffreys_interval(count, settled)
        message.expected_error = float(np.sqrt(np.mean(errors ** 2)))
    for index in np.argsort(-np.asarray(probability), kind="stable").tolist():
        pose = StablePose(index=index, group=group[index], pose_id=f"{message.part_id}/{index}",
                          height=0.005 + 0.001 * index, top=0.02, margin=0.3, barrier=0.002,
                          probability=float(probability[index]))
        pose.down.z = -1.0
        pose.outline = array("d", np.arange(20.0))
        nan = float("nan")
        pose.probability_low = float(low[index]) if settled else nan
        pose.probability_high = float(high[index]) if settled else nan
        pose.standard_error = float(errors[index]) if settled else error
        pose.count = int(count[index]) if settled else 0
        message.poses.append(pose)
    return message


def counts(seconds, count, index=None, **fields):
    """A PoseCounts; without a stamp where `seconds` is None."""
    message = PoseCounts() if seconds is None else stamped(PoseCounts(), seconds)
    defaults = {"part_id": "clamp", "part_digest": DIGEST, "cluster_tolerance": 0.005,
                "round_sides": 192, "plate": "steel", "drop_height": 0.4}
    for name, value in {**defaults, **fields}.items():
        setattr(message, name, value)
    message.index = array("I", range(len(count)) if index is None else index)
    message.count = array("Q", [int(one) for one in count])
    return message


def event(seconds, kind, job_id="job_1", **fields):
    """A JobEvent."""
    message = stamped(JobEvent(), seconds)
    defaults = {"part_id": "clamp", "part_digest": DIGEST, "drops": 1000, "restitution": 0.5,
                "drop_height": 0.4, "cluster_tolerance": 0.005, "round_sides": 192,
                "seed": 7}
    for name, value in {**defaults, **fields}.items():
        setattr(message, name, value)
    message.event, message.job_id = getattr(JobEvent, kind), job_id
    return message


def drop_records(first, poses, impacts=12, seconds=0.5):
    """A DropRecords."""
    n = len(poses)
    return DropRecords(
        job_id="job_1", part_digest=DIGEST, first_drop=first, pose_index=array("i", poses),
        start_down=array("f", [0.0] * (3 * n)), impacts=array("I", [impacts] * n),
        seconds=array("f", [seconds] * n), energy_left=array("f", [0.0] * n))


def mesh():
    """A PartMesh of one triangle."""
    return PartMesh(part_id="clamp", vertices=array("d", [0.0] * 9),
                    triangles=array("I", [0, 1, 2]))


def serialised(message):
    """CDR bytes."""
    return bytes(serialize_message(message))


def type_name(message):
    """`package/msg/Type`."""
    return f"{type(message).__module__.partition('.')[0]}/msg/{type(message).__name__}"


def definition(name):
    """The text of a type and of all that it uses, as MCAP wants it."""
    package, _, short = name.split("/")
    texts = {f"{package}/{short}": _text(package, short)}
    waiting = list(texts)
    while waiting:
        of = waiting.pop(0)
        for line in texts[of].splitlines():
            kind = re.match(r"\s*([A-Za-z][\w/]*)(?:\[[^]]*\])?\s+[a-z]", line.partition("#")[0])
            if kind and kind[1] not in PRIMITIVES:
                used = kind[1] if "/" in kind[1] else f"{of.partition('/')[0]}/{kind[1]}"
                if used not in texts:
                    texts[used] = _text(*used.split("/"))
                    waiting.append(used)
    first, *others = texts
    return "\n".join([texts[first], *("=" * 80 + f"\nMSG: {of}\n{texts[of]}" for of in others)])


def _text(package, short):
    return (SHARE / package / "msg" / f"{short}.msg").read_text()

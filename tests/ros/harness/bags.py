"""What the node has recorded."""

from __future__ import annotations

from contextlib import suppress

from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs import msg

from ros_pose_stats.recording.reader.raw_reader import raw_messages


def recorded(log_directory, topic):
    """Messages of one topic in all bags of a folder, in the order of the runs."""
    found = []
    for bag in sorted(log_directory.glob("pose_stats_*")):
        for raw in raw_messages(bag):
            if raw.topic == f"/pose_stats/{topic}":
                kind = getattr(msg, raw.type_name.rpartition("/")[2])
                found.append(deserialize_message(raw.data, kind))
    return found


def ends(log_directory):
    """Events that end a job, by job."""
    found = {}
    for event in recorded(log_directory, "job_events"):
        if event.event in (msg.JobEvent.DONE, msg.JobEvent.CANCELLED, msg.JobEvent.FAILED):
            found.setdefault(event.job_id, []).append(event)
    return found


def size_of(log_directory):
    """Bytes of all files in a folder; what is deleted meanwhile counts nothing."""
    found = 0
    for path in log_directory.rglob("*"):
        with suppress(FileNotFoundError):
            found += path.stat().st_size if path.is_file() else 0
    return found

"""Parts that a camera sees: found to lie in their poses, and recorded as a camera's counts."""

from __future__ import annotations

import math
import signal
import time
from types import SimpleNamespace

import numpy as np
import pytest
from geometry_msgs.msg import Point, Pose, Quaternion
from ros_pose_stats_msgs.msg import ObservedParts
from scipy.spatial.transform import Rotation

from .harness.bags import recorded
from .harness.cell import Health, MeshPublisher, cell_of
from .harness.client import until
from .harness.parts import WEDGE, flat

NODE = {"plate": "glass", "plate_frame": "table"}


@pytest.fixture
def cell(domain, tmp_path):
    """A node that knows one part, its client, a camera's publisher and the part's result."""
    with cell_of(domain, tmp_path, "seeing", **NODE) as (node, client):
        found = client.good("estimate", part=flat(WEDGE, "wedge")).statistics
        camera = MeshPublisher(client, f"{client.prefix}/observed_parts", ObservedParts).matched()
        yield SimpleNamespace(node=node, client=client, camera=camera, statistics=found,
                              folder=tmp_path)


def lying(pose, yaw=0.0, lean=0.0):
    """A part that lies in a stable pose somewhere on the plate, turned, and leaning."""
    turn = pose.pose.orientation
    seen = (Rotation.from_euler("z", yaw) * Rotation.from_euler("x", lean)
            * Rotation.from_quat([turn.x, turn.y, turn.z, turn.w]))
    x, y, z, w = seen.as_quat().tolist()
    return Pose(position=Point(x=0.1, y=-0.2, z=0.03), orientation=Quaternion(x=x, y=y, z=z, w=w))


def picture(*poses, part_id="wedge", frame="table", **fields):
    message = ObservedParts(part_id=part_id, poses=list(poses), **fields)
    message.header.frame_id = frame
    message.header.stamp.sec = 1_700_000_000
    return message


def counts_of(folder, number=1):
    """The recorded counts, once there are so many."""
    def found():
        read = recorded(folder, "pose_counts")
        return read if len(read) >= number else None
    return until(found, f"{number} counts in the bag")


def test_each_part_seen_is_counted_in_the_bag(cell):
    poses = {pose.index: pose for pose in cell.statistics.poses}
    first, last = min(poses), max(poses)
    unknown = Pose(orientation=Quaternion(x=math.nan, y=0.0, z=0.0, w=0.0))
    yaws = np.linspace(-3.0, 3.0, 7).tolist()
    cell.camera.publish(picture(
        *(lying(poses[first], yaw, math.radians(4.0)) for yaw in yaws),
        lying(poses[last], 1.0), lying(poses[last], 2.0), unknown,
        confidence=[0.9] * 7 + [0.8, 0.3, 1.0]))
    (counts,) = counts_of(cell.folder)
    assert dict(zip(counts.index, counts.count, strict=True)) == {first: 7, last: 1}
    assert counts.unclassified == 2
    assert (counts.part_id, counts.plate, counts.header.frame_id) == ("wedge", "glass", "table")
    assert counts.header.stamp.sec == 1_700_000_000
    for name in ("part_digest", "cluster_tolerance", "round_sides"):
        assert getattr(counts, name) == getattr(cell.statistics, name)
    assert counts.drop_height == -1.0  # the node was told none
    assert "recorded, but" not in cell.node.log


def test_the_height_that_the_node_was_told_goes_along(cell):
    assert cell.client.set(drop_height=0.25) == {}
    cell.client.good("estimate", part_id="wedge", method="split")
    until(lambda: cell.client.good("get_statistics").statistics[0].drop_height == 0.25)
    cell.camera.publish(picture(lying(cell.statistics.poses[0])))
    (counts,) = counts_of(cell.folder)
    assert counts.drop_height == 0.25


def test_what_cannot_be_counted_is_refused_and_the_next_one_served(cell):
    pose = lying(cell.statistics.poses[0])
    twice = lying(cell.statistics.poses[0])
    twice.orientation.w *= 2.0
    twice.orientation.x *= 2.0
    twice.orientation.y *= 2.0
    twice.orientation.z *= 2.0
    refused = {
        "a serialised ObservedParts": b"\0\1\0\0" + b"\xee" * 40,
        "at most 1048576 bytes": b"\0\1\0\0" + bytes(2**20),
        "'nobody'; publish its mesh": picture(pose, part_id="nobody"),
        "a confidence for each": picture(pose, pose, confidence=[1.0]),
        "confidences from 0 to 1, got 87": picture(pose, confidence=[87.0]),
        "length 2 in row 1": picture(pose, twice),
        "frame 'table'": picture(pose, frame="camera_optical_frame"),
    }
    for said, message in refused.items():
        cell.camera.publish(message)
        cell.node.says(said)
    _, values = Health(cell.client).line("parts")
    assert int(values["refused"]) == len(refused)
    cell.camera.publish(picture(), picture(pose, frame=""))
    (counts,) = counts_of(cell.folder)
    assert list(counts.count) == [1]


def test_all_are_counted_or_told_as_lost(cell):
    """A flood while the node stands still."""
    pose = lying(cell.statistics.poses[0])
    cell.camera.publish(picture(pose))
    counts_of(cell.folder)
    cell.node.send(signal.SIGSTOP)
    cell.camera.publish(*[picture(*[pose] * 3)] * 3999)
    time.sleep(0.2)
    cell.node.send(signal.SIGCONT)
    health = Health(cell.client)

    def all_there():
        lost = int(health.line("recording")[1]["counts lost"])
        return lost and lost + len(recorded(cell.folder, "pose_counts")) == 4000

    until(all_there, "all counts")
    cell.node.says("~/observed_parts: ")
    assert "messages on ~/observed_parts" in health.line("parts")[1]["floods"]
    cell.client.good("estimate", part_id="wedge")


def test_what_is_received_when_the_node_ends_is_counted(cell):
    pose = lying(cell.statistics.poses[0])
    cell.camera.publish(*[picture(pose)] * 300)
    time.sleep(0.2)
    cell.node.stop(signal.SIGTERM)
    assert sum(sum(one.count) for one in recorded(cell.folder, "pose_counts")) == 300

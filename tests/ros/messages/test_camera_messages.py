"""What a camera sends is read as rclpy reads it, whatever its byte order."""

from __future__ import annotations

import math

import numpy as np
import pytest
from geometry_msgs.msg import Point, Pose, Quaternion
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import ObservedParts

from ros_pose_stats.errors import RequestError
from ros_pose_stats.ros.messages.camera_messages import MOST_BYTES, observed_of_bytes
from tests.fuzz.messages.message_bytes import BIG, LITTLE, encoded


def picture(parts, confidences=0, name="part"):
    rng = np.random.default_rng(parts)
    poses = [Pose(position=Point(x=a, y=b, z=c), orientation=Quaternion(x=d, y=e, z=f, w=g))
             for a, b, c, d, e, f, g in rng.uniform(-1.0, 1.0, (parts, 7)).tolist()]
    message = ObservedParts(part_id=name, poses=poses,
                            confidence=rng.uniform(0.0, 1.0, confidences).tolist())
    message.header.frame_id = "plate"
    message.header.stamp.sec, message.header.stamp.nanosec = -5, 7
    return message


@pytest.mark.parametrize("order", [LITTLE, BIG])
@pytest.mark.parametrize("name", ["", "p", "par", "parts"])
@pytest.mark.parametrize(("parts", "confidences"), [(0, 0), (1, 0), (1, 1), (5, 5)])
def test_what_was_written_is_read(order, name, parts, confidences):
    message = picture(parts, confidences, name)
    for data in (encoded(message, order), bytes(serialize_message(message))):
        found = observed_of_bytes(data)
        assert (found.stamp, found.frame_id, found.part_id) == (-5 * 10**9 + 7, "plate", name)
        turns = [pose.orientation for pose in message.poses]
        assert found.orientations.tolist() == [[q.x, q.y, q.z, q.w] for q in turns]
        assert found.confidence.tolist() == (list(message.confidence) or [1.0] * parts)


def test_a_camera_that_does_not_know_how_sure_it_is_may_say_so():
    message = picture(2, 2)
    message.confidence = [math.nan, 1.0]
    assert np.isnan(observed_of_bytes(bytes(serialize_message(message))).confidence[0])


@pytest.mark.parametrize(("confidence", "said"), [
    ([0.5], "1 for 2 poses"), ([0.5] * 3, "3 for 2 poses"), ([0.5, 1.01], "1.01"),
    ([-0.1, 0.5], "-0.1"), ([math.inf, 0.5], "inf"),
])
def test_confidences_that_are_none_are_refused(confidence, said):
    message = picture(2)
    message.confidence = confidence
    with pytest.raises(RequestError, match=said):
        observed_of_bytes(bytes(serialize_message(message)))


@pytest.mark.parametrize("data", [b"", b"\0\1", b"\0\1\0\0", b"\0\1\0\0" + b"\xff" * 64,
                                  bytes(serialize_message(picture(3)))[:100],
                                  b"\0\1\0\0" + bytes(MOST_BYTES)],
                         ids=["empty", "half a header", "header", "lengths", "cut", "large"])
def test_other_bytes_are_refused(data):
    with pytest.raises(RequestError, match="ObservedParts"):
        observed_of_bytes(data)

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

"""A camera over the plate: what it counts and where it sees parts lie."""

import itertools

from geometry_msgs.msg import Point, Pose, Quaternion
from ros_pose_stats_msgs.msg import ObservedParts, PoseCounts
from scipy.spatial.transform import Rotation

from .cell import MeshPublisher, latched
from .client import until

SECONDS = itertools.count(1_700_000_000)
"""No two pictures have the same time: a message that comes twice counts once."""


def stamped(message, frame_id=""):
    """The message as of a time of its own."""
    message.header.stamp.sec = next(SECONDS)
    message.header.frame_id = frame_id
    return message


def counted(model, numbers, **fields):
    """Counts of the poses of a result, in its order, with its numbering."""
    index = [pose.index for pose in model.poses][: len(numbers)]
    return stamped(
        PoseCounts(
            **{
                "part_id": model.part_id,
                "numbering": model.numbering,
                "plate": model.plate,
                "index": index,
                "count": numbers,
                **fields,
            }
        ),
        "camera",
    )


def lying(pose, yaw=0.0, lean=0.0):
    """Where a part is seen in a stable pose, turned and leaning."""
    turn = pose.pose.orientation
    measured = (
        Rotation.from_euler("z", yaw)
        * Rotation.from_euler("x", lean)
        * Rotation.from_quat([turn.x, turn.y, turn.z, turn.w])
    )
    x, y, z, w = measured.as_quat().tolist()
    return Pose(
        position=Point(x=0.1, y=-0.2, z=0.03),
        orientation=Quaternion(x=x, y=y, z=z, w=w),
    )


def picture(part_id, *poses, frame="", **fields):
    """A part seen in each of some poses."""
    return stamped(ObservedParts(part_id=part_id, poses=list(poses), **fields), frame)


def counting(client):
    """Publishes on ~/pose_counts."""
    return MeshPublisher(client, f"{client.prefix}/pose_counts", PoseCounts).matched()


def seeing(client):
    """Publishes on ~/observed_parts."""
    return MeshPublisher(
        client, f"{client.prefix}/observed_parts", ObservedParts
    ).matched()


def learnt(client, part_id, parts):
    """What is latched, once it has learnt from so many parts."""

    def told():
        result = latched(client, part_id)
        return result if result.counted_parts == parts else None

    return until(told, f"a result of {parts} parts")

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

"""The markers of all parts: each with its most probable poses side by side."""

import math
from collections.abc import Sequence

from ros_pose_stats_msgs.msg import PoseStatistics

from ...core.records import Array
from ..recording.writer import cdr
from .known_part import KnownPart

MOST_POSES = 16  # poses drawn of a part, the most probable ones
MOST_DRAWN = 400  # poses drawn in all; with many parts fewer of each

MOST_TRIANGLES = 32_000  # of the whole array: 2.3 MB, at most once a second
# triangles of a part, few numbers of them, so that it is seldom made anew
FINENESS = (4000, 2000, 1000, 500, 250, 100)
GAP = 0.6  # between the parts, in radii
LETTER = 0.35  # height of the labels, in radii


def markers_of(parts: Sequence[tuple[PoseStatistics, KnownPart]]) -> bytes:
    """The serialised array of markers of parts with their results, a row each."""
    most_poses = max(1, min(MOST_POSES, MOST_DRAWN // max(len(parts), 1)))
    drawn = sum(min(len(result.poses), most_poses) for result, _ in parts)
    most_triangles = next(
        (fineness for fineness in FINENESS if fineness * drawn <= MOST_TRIANGLES),
        FINENESS[-1],
    )
    markers = [cdr.Marker(action=cdr.DELETE_ALL)]
    y = 0.0
    for number, (result, part) in enumerate(parts):
        half_row = result.radius * (1.0 + 0.5 * GAP)
        if number:
            y -= half_row
        triangles = part.draw(most_triangles)
        if triangles is not None:
            markers += _row(result, triangles, y, most_poses)
        y -= half_row
    return cdr.marker_array_message(markers)


def _row(
    result: PoseStatistics, triangles: Array, y: float, most_poses: int
) -> list[cdr.Marker]:
    """The name of a part, and its poses on a line."""
    corner = (-2.0 * result.radius, y, LETTER * result.radius)
    markers = [_label(result, 0, result.part_id, corner)]
    step = (2.0 + GAP) * result.radius
    for number, pose in enumerate(result.poses[:most_poses]):
        x = number * step
        position = pose.pose.position
        turn = pose.pose.orientation
        if math.isnan(pose.probability):
            blue = 0.0
            share = "-"
        else:
            blue = float(min(max(pose.probability, 0.0), 1.0)) ** 0.5
            share = f"{100.0 * pose.probability:.1f} %"
        markers.append(
            cdr.Marker(
                result.header.frame_id,
                f"{result.part_id}/poses",
                cdr.TRIANGLE_LIST,
                (
                    position.x + x,
                    position.y + y,
                    position.z,
                    turn.x,
                    turn.y,
                    turn.z,
                    turn.w,
                ),
                color=(0.85 - 0.75 * blue, 0.88 - 0.5 * blue, 0.92 - 0.2 * blue, 1.0),
                corners=triangles,
                number=pose.index,
            )
        )
        top = (x, y, pose.top + 0.5 * LETTER * result.radius)
        label = f"{pose.index}: {share}"
        markers.append(_label(result, pose.index + 1, label, top))
    return markers


def _label(
    result: PoseStatistics,
    number: int,
    text: str,
    position: tuple[float, float, float],
) -> cdr.Marker:
    return cdr.Marker(
        result.header.frame_id,
        f"{result.part_id}/labels",
        cdr.TEXT_VIEW_FACING,
        (*position, 0.0, 0.0, 0.0, 1.0),
        (0.0, 0.0, LETTER * result.radius),
        (0.1, 0.1, 0.1, 1.0),
        text=text,
        number=number,
    )

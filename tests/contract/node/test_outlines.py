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

"""True outlines of a part in its poses, and poses that look alike from above."""

import math

import numpy as np
import pytest
import trimesh

from lab.bodies import shapes

from .harness.goals import planned
from .harness.jobs import known_part
from .harness.parts import flat, new_id

OUTER = 0.02
INNER = 0.008
HIGH = 0.01
SIDES = 64
POLYGON = 0.5 * SIDES * math.sin(2.0 * math.pi / SIDES)
"""Area of a regular polygon over that of its circle's squared radius."""


@pytest.fixture
def washer(cell):
    """A ring, known to the node; its name."""
    ring = trimesh.creation.annulus(INNER, OUTER, HIGH, sections=SIDES)
    part_id = new_id()
    cell.good("estimate", part=flat((ring.vertices, ring.faces), part_id))
    return part_id


def areas(outline):
    """Of each closed loop; holes are negative."""
    points = np.array(outline.points).reshape(-1, 2)
    return [
        0.5 * float(x @ np.roll(y, -1) - y @ np.roll(x, -1))
        for x, y in (
            loop.T for loop in np.split(points, np.cumsum(outline.corners)[:-1])
        )
    ]


def test_a_hole_where_it_is_seen_and_a_gap_where_it_is_cut(cell, washer):
    answer = cell.good("get_statistics", part_id=washer, heights=[-1.0, OUTER])
    [result] = answer.statistics
    heights_of_poses = [
        (pose.pose_id, height) for pose in result.poses for height in (-1.0, OUTER)
    ]
    assert [
        (outline.pose_id, outline.height) for outline in answer.outlines
    ] == heights_of_poses
    flat_ones = on_edge = 0
    for pose, silhouette, cut in zip(
        result.poses, answer.outlines[::2], answer.outlines[1::2], strict=True
    ):
        if math.isclose(pose.top, HIGH, rel_tol=1e-6):
            flat_ones += 1
            boundary, hole = areas(silhouette)
            assert boundary == pytest.approx(POLYGON * OUTER**2, rel=1e-6)
            assert hole == pytest.approx(-POLYGON * INNER**2, rel=1e-6)
            assert len(cut.corners) == 0  # it is lower than that
        else:  # on its edge, cut through the axis, give or take a facet
            on_edge += 1
            [boundary] = areas(silhouette)
            assert boundary == pytest.approx(2.0 * OUTER * HIGH, rel=0.01)
            assert len(cut.corners) == 2  # on both sides of the bore
            assert sum(areas(cut)) == pytest.approx(
                2.0 * (OUTER - INNER) * HIGH, rel=0.01
            )
    assert flat_ones == 2 and on_edge == 1
    assert not cell.good("get_statistics", part_id=washer).outlines


def test_with_outlines_from_above_poses_have_their_lookalikes(cell):
    """A bar of 30 by 29.8 mm on its four long sides, of which two are the same."""
    part_id = new_id()
    vertices, triangles = shapes.box(0.04, 0.03, 0.0298)
    cell.good("estimate", part=flat((vertices, triangles), part_id))
    [result] = cell.good("get_statistics", part_id=part_id, heights=[-1.0]).statistics
    lookalikes = {pose.index: set(pose.alike_from_above) for pose in result.poses}
    sides = {0, 1, 2, 3}
    assert lookalikes == {
        **{index: sides - {index} for index in sides},
        4: {5},
        5: {4},
    }
    for heights in ([], [0.001]):
        [result] = cell.good(
            "get_statistics", part_id=part_id, heights=heights
        ).statistics
        assert not any(len(pose.alike_from_above) for pose in result.poses)
    answer = planned(cell, part_id=part_id, wanted=[0, 1], dropped_per_minute=40.0)
    assert list(answer.action) == [0, 0, 0, 0, 2, 2]
    [mistaken] = [
        warning for warning in answer.warnings if warning.code == "ALIKE_FROM_ABOVE"
    ]
    assert "poses 2, 3 look from above like poses 0, 1" in mistaken.text


def test_what_cannot_be_asked_is_refused(cell, washer):
    assert "one part's outlines" in cell.refused("get_statistics", heights=[0.001])
    assert "heights above the plate" in cell.refused(
        "get_statistics", part_id=washer, heights=[math.nan]
    )
    for part_id in (
        washer,
        known_part(cell),
    ):  # many triangles, or a box at many heights
        assert "ask for fewer heights" in cell.refused(
            "get_statistics", part_id=part_id, heights=[0.001] * 6000
        )

"""Outlines of parts as messages: what a gripper reads, and what is refused."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, shapes
from ros_pose_stats.errors import RequestError
from ros_pose_stats.ros.messages import outline_messages
from ros_pose_stats.ros.messages.outline_messages import outline_messages as messages_of
from ros_pose_stats.ros.messages.statistics_messages import Answer, statistics_message

SIZE = (0.03, 0.02, 0.012)


@pytest.fixture(scope="module")
def box():
    part = part_from_mesh(*shapes.box(*SIZE), part_id="box")
    return part, statistics_message(estimate(part), Answer(0, "plate", "", 1))


def loops(outline):
    """Loops (k, 2) of a message, as a planner takes them apart."""
    points = np.array(outline.points).reshape(-1, 2)
    return np.split(points, np.cumsum(outline.corners)[:-1]) if len(outline.corners) else []


def area(loop):
    x, y = loop.T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def test_a_box_in_each_pose_and_at_each_height(box):
    part, found = box
    outlines = messages_of(part, found, [-1.0, 0.011, 0.5])
    assert [(one.pose_id, one.height) for one in outlines] == [
        (pose.pose_id, height) for pose in found.poses for height in (-1.0, 0.011, 0.5)]
    for pose, seen, cut, above in zip(found.poses, outlines[::3], outlines[1::3], outlines[2::3],
                                      strict=True):
        base = math.prod(SIZE) / pose.top
        for one in (seen, cut):
            [loop] = loops(one)
            assert len(loop) == 4 and area(loop) == pytest.approx(base)
        assert len(above.corners) == len(above.points) == 0


def test_nothing_asked_for(box):
    assert messages_of(*box, []) == []


@pytest.mark.parametrize("height", [math.nan, math.inf, -math.inf])
def test_heights_that_are_none(box, height):
    with pytest.raises(RequestError, match="heights above the plate"):
        messages_of(*box, [0.001, height])


def test_too_many(box, monkeypatch):
    monkeypatch.setattr(outline_messages, "MOST_TRIANGLES", 12 * 6 * 2)
    assert len(messages_of(*box, [0.001, 0.002])) == 12
    with pytest.raises(RequestError, match=r"18 outlines \(6 poses, 3 heights\) of 12 triangles"):
        messages_of(*box, [0.001, 0.002, 0.003])

"""True outlines of a part in its poses, asked of a running node."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats.shapes.modelling import drill, extrude, surface_of

from .harness.parts import flat, new_id

WIDE, DEEP, HIGH, BORE = 40.0, 30.0, 10.0, 4.0


def drilled_block():
    """A block with a hole through it, millimetres."""
    x, y = 0.5 * WIDE, 0.5 * DEEP
    block = extrude(np.array([(-x, -y), (x, -y), (x, y), (-x, y)]), "z", 0.0, HIGH)
    return surface_of(block - drill(BORE, "z", (5.0, 3.0), -1.0, HIGH + 1.0))


def areas(outline):
    """Of each closed loop, square millimetres; holes are negative."""
    points = 1e3 * np.array(outline.points).reshape(-1, 2)
    found = []
    for x, y in (loop.T for loop in np.split(points, np.cumsum(outline.corners)[:-1])):
        found.append(0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum()))
    return found


def test_a_hole_where_it_can_be_seen_and_a_gap_where_it_is_cut(cell):
    name = new_id()
    cell.good("estimate", part=flat(drilled_block(), name, unit=1e-3))
    answer = cell.good("get_statistics", part_id=name, heights=[-1.0, 0.015])
    [result] = answer.statistics
    asked = [(pose.pose_id, height) for pose in result.poses for height in (-1.0, 0.015)]
    assert [(one.pose_id, one.height) for one in answer.outlines] == asked
    for pose, seen, cut in zip(result.poses, answer.outlines[::2], answer.outlines[1::2],
                               strict=True):
        if math.isclose(pose.top, HIGH * 1e-3, rel_tol=1e-3):  # on a face with the hole
            boundary, hole = areas(seen)
            assert boundary == pytest.approx(WIDE * DEEP)
            assert hole == pytest.approx(-math.pi * BORE**2, rel=0.02)
            assert len(cut.corners) == 0  # it is lower than that
        elif math.isclose(pose.top, DEEP * 1e-3, rel_tol=1e-3):  # the bore lies 18 or 12 high
            [boundary] = areas(seen)
            assert boundary == pytest.approx(WIDE * HIGH)
            assert len(cut.corners) == 2  # on both sides of it
            chord = 2.0 * math.sqrt(BORE**2 - 3.0**2)
            assert sum(areas(cut)) == pytest.approx((WIDE - chord) * HIGH, rel=0.02)
    assert not cell.good("get_statistics", part_id=name).outlines


def test_refusals(cell):
    name = new_id()
    cell.good("estimate", part=flat(drilled_block(), name, unit=1e-3))
    assert "one part's outlines" in cell.refused("get_statistics", heights=[0.001])
    assert "heights above the plate" in cell.refused("get_statistics", part_id=name,
                                                     heights=[math.nan])
    assert "triangles in all outlines" in cell.refused("get_statistics", part_id=name,
                                                       heights=[0.001] * 10_000)

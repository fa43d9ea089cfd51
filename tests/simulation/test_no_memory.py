"""A drop depends on its own start alone, also where ties are decided by the smallest things."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, record_drop, shapes, simulate
from ros_pose_stats.records import DropScene
from ros_pose_stats.shapes.demo_parts import DEMO_PARTS
from ros_pose_stats.simulation.drop_body import drop_body
from ros_pose_stats.simulation.drops import compute_drops, drop_rules
from ros_pose_stats.simulation.starts import random_starts


def parts():
    """Parts with faces of many corners, where a flat landing is one great tie."""
    found = {name: part_from_mesh(*make(), unit="mm") for name, make in DEMO_PARTS.items()}
    return {**found, "box": part_from_mesh(*shapes.box(1.0, 2.0, 3.0))}


@pytest.mark.parametrize("height", [1.01, 20.0])
@pytest.mark.parametrize("name", parts())
def test_the_same_start_gives_the_same_drop(name, height):
    """Face down, the most symmetric start of all, before and after other drops."""
    part = parts()[name]
    body = drop_body(part, 0.005, 0)
    scene = DropScene(0.5, height * body.radius)
    downs = np.array([pose.down for pose in body.resting.poses])
    mixed = np.concatenate([np.repeat(downs, 3, axis=0), random_starts(1, 0, 20), downs])
    rules = drop_rules(scene, body.radius)
    together = compute_drops(body, rules, mixed)
    for i, down in enumerate(mixed):
        alone = compute_drops(body, rules, down[None, :])
        assert together.pose[i] == alone.pose[0]
        assert together.impacts[i] == alone.impacts[0]
        assert together.energy_left[i] == alone.energy_left[0]


@pytest.mark.parametrize("workers", [1, 2])
def test_equal_starts_end_alike(workers):
    part = parts()["clamp"]
    found = simulate(part, starts=[[0.0, 0.0, -1.0]] * 300, workers=workers)
    told = record_drop(part, start=[0.0, 0.0, -1.0]).pose
    counts = {pose.index: pose.count for pose in found.poses}
    assert found.unsettled == (300 if told < 0 else 0)
    assert told < 0 or counts[told] == 300

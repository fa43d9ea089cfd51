"""Parts and their variants that several tests compare."""

from __future__ import annotations

import numpy as np

from ros_pose_stats import part_from_mesh, shapes
from ros_pose_stats.design.correspondence import find_correspondence
from ros_pose_stats.resting.poses import resting_poses
from tests.bodies import in_float32, moved, shuffled, subdivided

SIDE = 0.016
CUBE = shapes.box(SIDE, SIDE, SIDE)
NEAR_CUBE = shapes.box(SIDE, SIDE, 0.97 * SIDE)


def clamp():
    """The demo clamp in metres."""
    vertices, triangles = shapes.demo_parts.DEMO_PARTS["clamp"]()
    return 1e-3 * vertices, triangles


def stretched(surface, *factors):
    vertices, triangles = surface
    return vertices * np.array(factors), triangles


def exported(surface, seed):
    """The same part as another program writes it: other triangles, order, origin and digits."""
    offset = np.random.default_rng(seed).uniform(-0.1, 0.1, 3)
    return in_float32(shuffled(moved(subdivided(surface), None, offset), seed))


def correspondence(first, second):
    """Of two parts, or surfaces."""
    parts = [one if hasattr(one, "digest") else part_from_mesh(*one) for one in (first, second)]
    return find_correspondence(*(resting_poses(part) for part in parts))

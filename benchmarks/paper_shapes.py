"""The paper's random shapes, with their centre of mass shifted or not."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ros_pose_stats import Part, part_from_mesh, resting_poses
from ros_pose_stats.errors import PoseStatsError
from ros_pose_stats.geometry import shapes


def polyhedra(shift: float, seed: int) -> Iterator[Part]:
    """The paper's random shapes (section 3.A): hulls of 4 or more normal points, 13 on average.

    After four, another one with probability 0.9 each time. The centre of mass is moved along
    every principal axis by up to `shift` times the root of the principal moment over the mass,
    the inertia staying the central one; redrawn where that leaves the hull or one stable face.
    """
    random = np.random.default_rng(seed)
    while True:
        points = random.standard_normal((3 + random.geometric(0.1), 3))
        plain = part_from_mesh(*shapes.hull_mesh(points), unit="cm")
        moments, axes = np.linalg.eigh(plain.inertia / plain.mass)
        moved = axes @ (shift * random.uniform(-1.0, 1.0, 3) * np.sqrt(moments))
        try:
            part = part_from_mesh(plain.vertices, plain.triangles,
                                  center_of_mass=plain.center_of_mass + moved)
        except PoseStatsError:
            continue
        if len(resting_poses(part, 0.0).poses) > 1:
            yield part

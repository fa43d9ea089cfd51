"""Short ways to drop parts and to compare what came out."""

from __future__ import annotations

import numpy as np
from scipy.stats import chi2_contingency

from ros_pose_stats.records import DropScene
from ros_pose_stats.simulation.drop_body import drop_body
from ros_pose_stats.simulation.drops import compute_drops, drop_rules
from ros_pose_stats.simulation.starts import random_starts

from ..matching import matched

GRAVITY = 9.80665


def dropped(part, restitution, drops, seed=1, to_rest=False, tolerance=0.0, height=None):
    """Outcomes of single drops from random directions."""
    body = drop_body(part, tolerance, 0)
    rules = drop_rules(DropScene(restitution, height), body.radius, to_rest=to_rest)
    return compute_drops(body, rules, random_starts(seed, 0, drops))


def counts(statistics):
    """Drops in each pose, by index."""
    return [pose.count for pose in sorted(statistics.poses, key=lambda pose: pose.index)]


def chance(counts, others):
    """p value of two rows of counts coming from the same shares (chi-square).

    Poses with fewer than ten drops in both rows together are taken as one.
    """
    table = np.array((counts, others))
    rare = table.sum(axis=0) < 10
    table = np.column_stack((table[:, ~rare], table[:, rare].sum(axis=1)))
    table = table[:, table.sum(axis=0) > 0]
    return chi2_contingency(table).pvalue if table.shape[1] > 1 else 1.0


def alike(statistics, others, turn=None):
    """p value of two runs with poses matched by direction having the same shares."""
    partners = matched(statistics.poses, others.poses, turn, angle=1e-3)
    return chance([pose.count for pose in statistics.poses], [pose.count for pose in partners])


class Contacts:
    """Heights and vertical velocities of all corners at the events of a drop, scaled.

    Lengths by the radius, times by sqrt(radius / g).
    """

    def __init__(self, part, trajectory):
        self.radius = trajectory.radius
        self.unit = (self.radius / GRAVITY) ** 0.5
        self.points = drop_body(part, 0.005, 0).resting.body.points
        self.moment = part.inertia / part.mass / self.radius**2

    def heights(self, event):
        return event.height / self.radius + self.points @ event.up

    def velocities(self, event):
        arms = np.cross(self.points, event.up)
        return self.unit * (event.velocity / self.radius + arms @ event.angular_velocity)

    def energy(self, event):
        w, v = event.angular_velocity * self.unit, event.velocity * self.unit / self.radius
        return event.height / self.radius + v * v / 2.0 + w @ self.moment @ w / 2.0

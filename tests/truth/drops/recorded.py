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

"""Short ways to drop parts, to look at recorded drops, and to compare what was
counted.
"""

from itertools import pairwise
from types import SimpleNamespace

import numpy as np
from scipy.stats import chi2_contingency

from ros_pose_stats import DropScene, part_from_mesh, record_drop, simulate
from ros_pose_stats.core.simulation.drop_body import drop_body
from tests.matching import matched

GRAVITY = 9.80665
# least p value: of fifty comparisons with fixed seeds a right program fails none
SURE = 1e-4

EXACT = {
    "cluster_tolerance": 0.0,
    "round_sides": 0,
}  # each stable face a pose, corners as filed


AS_ROUNDED = 1e-9
"""Drops round corners to 6e-11 radii; what follows from one lies within this of what a
formula says of the exact body.
"""


def as_dropped(part):
    """Corners and inertia of the very body that is dropped, in part axes and radii.

    Points that are no corners stay as they are.
    """
    body = drop_body(part, DropScene(cluster_tolerance=0.0, round_sides=0))
    points = np.array(body.resting.body.points)
    arrays = body.arrays
    points[body.corner] = np.column_stack((arrays.x, arrays.y, arrays.z)) @ body.axes.T
    return points, body.axes @ np.diag(arrays.moment) @ body.axes.T


def light(surface, factor):
    """A part with its mass nearer to the centre: it swings off its contacts."""
    part = part_from_mesh(*surface)
    return part_from_mesh(*surface, mass=1.0, inertia=factor * part.inertia / part.mass)


def outcomes(part, *arguments, **options):
    """Outcome of each drop of a simulation, by name: pose, impacts, seconds,
    energy_left, ...
    """
    chunks = []
    simulate(part, *arguments, workers=1, on_drops=chunks.append, **options)
    return SimpleNamespace(
        **{
            name: np.concatenate([getattr(chunk.outcomes, name) for chunk in chunks])
            for name in ("pose", "impacts", "seconds", "energy_left")
        }
    )


def recordings(part, restitution, drops, seed=1, **options):
    """Recorded drops, their events alone, with the corners at these."""
    for drop in range(drops):
        yield with_corners(
            part, record_drop(part, drop, restitution, seed, interval=1e6, **options)
        )


def with_corners(part, trajectory):
    return trajectory, Corners(part, trajectory)


class Corners:
    """Heights, velocities and energies at the events of a drop of a polyhedron, scaled.

    Lengths by the radius, times by sqrt(radius / g), energies by m g radius.
    """

    def __init__(self, part, trajectory):
        self.radius = trajectory.radius
        self.unit = (self.radius / GRAVITY) ** 0.5
        self.points, self.moment = as_dropped(part)

    def time(self, event):
        return event.time / self.unit

    def heights(self, event):
        return event.height / self.radius + self.points @ event.up

    def velocities(self, event):
        return self.velocity(event) + np.cross(self.points, event.up) @ self.spin(event)

    def velocity(self, event):
        return event.velocity * self.unit / self.radius

    def spin(self, event):
        return event.angular_velocity * self.unit

    def energy(self, event):
        w = self.spin(event)
        v = self.velocity(event)
        return event.height / self.radius + v * v / 2.0 + w @ self.moment @ w / 2.0

    def lost_at_impact(self, event, restitution):
        """Energy that an impact at the event's corner took: (1 - ρ²)/2 m_eff u²."""
        arm = np.cross(self.points[event.vertex], event.up)
        mass = 1.0 / (1.0 + arm @ np.linalg.solve(self.moment, arm))
        leaving = self.velocities(event)[event.vertex]
        return 0.5 * (1.0 / restitution**2 - 1.0) * mass * leaving**2


def impacts_of(trajectory):
    """Each single impact with the event before it."""
    return [
        (previous_event, event)
        for previous_event, event in pairwise(trajectory.events)
        if event.kind == "impact"
    ]


def alike(statistics, others, turn=None):
    """p value of two runs, poses matched by direction, having the same shares
    (chi-square).

    Poses with fewer than ten drops in both runs together are taken as one.
    """
    partners = matched(statistics.poses, others.poses, turn, angle=1e-3)
    table = np.array(
        [[pose.count for pose in poses] for poses in (statistics.poses, partners)]
    )
    rare = table.sum(axis=0) < 10
    table = np.column_stack((table[:, ~rare], table[:, rare].sum(axis=1)))
    table = table[:, table.sum(axis=0) > 0]
    return chi2_contingency(table).pvalue if table.shape[1] > 1 else 1.0

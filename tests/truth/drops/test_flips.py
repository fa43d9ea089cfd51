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

"""Kicks out of the poses: their energy and points, another solver, symmetry, drops as a
limit.
"""

import numpy as np
import pytest
from scipy.stats import chi2_contingency

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from ros_pose_stats import DropScene, part_from_mesh, simulate, simulate_flips
from ros_pose_stats.base.errors import RequestError
from ros_pose_stats.core.simulation import flips
from ros_pose_stats.core.simulation.drop_body import drop_body
from ros_pose_stats.core.simulation.request import drop_request
from tests.truth.drops.recorded import AS_ROUNDED, EXACT, SURE, as_dropped
from tests.truth.reference.drop_solver import reference_flip


@pytest.fixture(scope="module")
def box():
    return part_from_mesh(*shapes.box(1.0, 2.0, 3.0))


class Kicks:
    """Kicks out of all poses in turn, in part axes; lengths in radii."""

    def __init__(self, part, height, seed, count):
        body = drop_body(part, DropScene(cluster_tolerance=0.0, round_sides=0))
        states = flips.Kicks(body, height).states(seed, 0, count)
        self.poses = flips.Kicks(body, height).poses(0, count)
        self.radius = body.resting.body.radius
        self.resting = body.resting
        self.points, self.inertia = as_dropped(part)
        self.height = states[:, 0]
        self.velocity = states[:, 1]
        self.up = states[:, 2:5] @ body.axes.T
        self.spin = states[:, 5:8] @ body.spin_axes.T

    def at(self):
        """Points (n, 3) where the plate hits: I w = v (r x up), and r lies on the
        plate.
        """
        arms = self.spin @ self.inertia / self.velocity[:, None]
        return np.cross(self.up, arms) - self.height[:, None] * self.up


def test_energy_and_no_spin_about_the_vertical():
    kicks = Kicks(part_from_mesh(*random_polyhedron(9, 6)), 0.4, 3, 2000)
    poses = kicks.resting.poses
    rested = np.array([pose.height for pose in poses])[kicks.poses] / kicks.radius
    np.testing.assert_allclose(kicks.height, rested, rtol=AS_ROUNDED)
    momentum = kicks.spin @ kicks.inertia
    energy = 0.5 * kicks.velocity**2 + 0.5 * (kicks.spin * momentum).sum(axis=1)
    np.testing.assert_allclose(energy, 0.4, rtol=AS_ROUNDED)
    np.testing.assert_allclose((kicks.up * momentum).sum(axis=1), 0.0, atol=1e-12)
    np.testing.assert_allclose(
        -kicks.up, np.array([pose.down for pose in poses])[kicks.poses], atol=AS_ROUNDED
    )


def triangle_moments(polygon):
    """Mean (3,) and covariance (3, 3) of uniform points of a flat polygon, by its
    triangles.
    """
    corners = np.stack(
        [np.broadcast_to(polygon[0], polygon[2:].shape), polygon[1:-1], polygon[2:]],
        axis=1,
    )
    areas = np.linalg.norm(
        np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1
    )
    share = areas / areas.sum()
    sums = corners.sum(axis=1)
    products = (
        np.einsum("tci,tcj->tij", corners, corners)
        + np.einsum("ti,tj->tij", sums, sums)
    ) / 12.0
    mean = share @ sums / 3.0
    return mean, np.einsum("t,tij->ij", share, products) - np.outer(mean, mean)


def test_points_are_uniform_on_the_contact_polygon():
    """Their mean and their scatter, for the pentagons and the sides of a prism."""
    kicks = Kicks(part_from_mesh(*shapes.prism(5, 1.0, 0.3)), 1.0, 8, 42_000)
    points = kicks.at()
    for pose in kicks.resting.poses:
        corners = kicks.points[
            kicks.points @ pose.down > pose.height / kicks.radius - 1e-9
        ]
        spokes = corners - corners.mean(axis=0)
        angle = np.arctan2(np.cross(spokes[0], spokes) @ pose.down, spokes @ spokes[0])
        mean, scatter = triangle_moments(corners[np.argsort(angle)])
        mine = points[kicks.poses == pose.index]
        sigma = np.sqrt(np.diag(scatter).clip(0.0) / len(mine)) + AS_ROUNDED
        assert (np.abs(mine.mean(axis=0) - mean) < 5.0 * sigma).all()
        # A variance of n uniform numbers is known to sqrt(0.8 / n) = 1.2 %.
        np.testing.assert_allclose(np.cov(mine.T), scatter, atol=0.05 * scatter.max())


@pytest.mark.long
@pytest.mark.parametrize(("restitution", "kick"), [(0.0, 0.3), (0.1, 0.4)])
def test_whole_flips_against_another_solver(restitution, kick):
    """One out of each pose, through some ten events: the pose of the matrix is
    theirs.
    """
    part = part_from_mesh(*random_polyhedron(6, 1))
    seed = 1
    rested = 0
    kicks = Kicks(part, kick, seed, len(simulate_flips(part, 0.0, 1, **EXACT).poses))
    flips = simulate_flips(part, kick * kicks.radius, 1, restitution, seed, **EXACT)
    downs = np.array([pose.down for pose in flips.poses])
    for pose, point in zip(kicks.poses, kicks.at(), strict=True):
        events = reference_flip(
            kicks.points, kicks.inertia, downs[pose], point, kick, restitution, 60
        )
        gap = np.linalg.norm(downs + events[-1].up, axis=1)
        if len(events) < 60 and gap.min() < 1e-6:
            assert flips.counts[pose, gap.argmin()] == 1
            rested += 1
    assert rested >= len(downs) // 2
    assert np.trace(flips.counts) < len(downs)  # some did flip


def like(*rows):
    """Chance of counts as different as these, out of one distribution."""
    counts = np.array(rows)
    return chi2_contingency(counts[:, counts.any(axis=0)]).pvalue


@pytest.mark.parametrize("share", [0.0, 0.999])
def test_less_than_the_way_out_is_no_flip(box, share):
    lowest = min(pose.barrier for pose in simulate_flips(box, 0.0, 1, seed=1).poses)
    flips = simulate_flips(box, share * lowest, 200, seed=2)
    np.testing.assert_array_equal(flips.transition, np.eye(6))
    assert flips.flips == 1200 and not flips.unsettled.any()


def test_high_kicks_are_drops(box):
    """Each row, and all together, against the counts of drops from as high."""
    flips = simulate_flips(box, 60.0, 500, seed=3)
    drops = simulate(box, 6000, seed=4, drop_height=60.0)
    fresh = [pose.count for pose in sorted(drops.poses, key=lambda pose: pose.index)]
    for row in (flips.counts.sum(axis=0), *flips.counts):
        assert like(row, fresh) > SURE


def test_workers_and_stops_change_nothing(box):
    first, two = (
        simulate_flips(box, 1.0, 300, seed=7, workers=workers) for workers in (1, 2)
    )
    np.testing.assert_array_equal(first.counts, two.counts)
    reports = []
    assert [pose.index for pose in first.poses] == list(
        range(6)
    ) and first.flips == 1800
    cut = simulate_flips(
        box,
        1.0,
        100_000,
        seed=7,
        workers=1,
        on_progress=lambda drops_done, total: reports.append((drops_done, total)),
        should_stop=lambda: bool(reports),
    )
    assert 0 < cut.flips == reports[-1][0] < reports[-1][1] == 600_000
    longer = simulate_flips(box, 1.0, -(-cut.flips // 6), seed=7)
    assert (longer.counts - cut.counts).sum() == longer.flips - cut.flips
    assert (longer.counts >= cut.counts).all()


def test_a_kick_too_high_is_refused_before_any_flip(box):
    begun = []
    with pytest.raises(RequestError, match="0 m or more and at most"):
        flips.flips_by_kick(
            box,
            DropScene(),
            [1.0, 1e99],
            drop_request(10, 1),
            on_kick=lambda number, count: begun.append(number),
        )
    assert begun == []

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

"""Estimates where a face is about to lose its stability, a saddle ties, or a scene
ends.
"""

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import oblique_prism, random_polyhedron
from ros_pose_stats import estimate, estimate_all, part_from_mesh
from tests.matching import downs, values

BASE = np.array((0.0, 0.0, -1.0))
NEEDLE = shapes.box(1.0, 0.001, 0.002)


def hull(points, **properties):
    return part_from_mesh(
        *shapes.hull_mesh(np.asarray(points, dtype=float)), **properties
    )


def leaning(overhang):
    """A box whose centre of mass is `overhang` beyond the base's edge."""
    return part_from_mesh(
        *oblique_prism(1.2, 2.0), center_of_mass=(1.0 + overhang, 0.1, 0.5)
    )


def share(part, method, direction, within=1e-9, tolerance=0.0):
    """Probability of the poses whose `down` is a direction; 0 if there is none."""
    statistics = estimate(part, method, cluster_tolerance=tolerance)
    return sum(
        pose.probability
        for pose in statistics.poses
        if pose.down @ direction > 1.0 - within
    )


@pytest.mark.parametrize("method", ["eae", "meae", "split"])
def test_energy_estimates_vanish_as_the_face_becomes_marginal(method):
    """To leading order a power of the way to the edge, at least the first; below 1e-14
    noise.
    """
    inside = np.array([share(leaning(-(10.0**-k)), method, BASE) for k in range(1, 9)])
    assert inside[0] > 1e-4
    if method == "split":  # a fitted function of such powers
        assert np.all(np.diff(inside) <= 1e-9) and inside[-1] < 1e-4
    else:
        assert np.all(inside[1:] < np.maximum(0.2 * inside[:-1], 1e-14))
        assert inside[-1] < 1e-9
    assert share(leaning(1e-8), method, BASE) == 0.0


@pytest.mark.parametrize("method", ["eae", "meae"])
def test_the_other_poses_pass_the_edge_without_a_step(method):
    inside, outside = (
        estimate(leaning(overhang), method, cluster_tolerance=0.0).poses
        for overhang in (-1e-7, 1e-7)
    )
    assert len(inside) == len(outside) + 1
    cosines = downs(outside) @ downs(inside).T
    assert cosines.max(axis=1).min() > 1.0 - 1e-9
    assert values(outside, "probability") == pytest.approx(
        values(inside, "probability")[cosines.argmax(axis=1)], abs=1e-6
    )


@pytest.mark.parametrize("method", ["area", "csae", "adre", "qse"])
def test_the_others_jump(method):
    assert share(leaning(-1e-7), method, BASE) > 0.1
    assert share(leaning(1e-7), method, BASE) == 0.0


@pytest.mark.parametrize("overhang", [-1e-9, -1e-12, 0.0, 1e-12, 1e-9])
def test_the_edge_itself_is_answered_soberly(overhang):
    for tolerance in (0.0, 0.005):
        for statistics in estimate_all(leaning(overhang), cluster_tolerance=tolerance):
            probability = values(statistics.poses, "probability")
            assert probability.min() >= 0.0
            assert probability.sum() == pytest.approx(1.0, abs=1e-12)
            assert all(
                pose.margin > 0.0 and pose.barrier > 0.0 for pose in statistics.poses
            )


@pytest.mark.parametrize("depth", [1e-1, 1e-8, 1e-11])
def test_a_centre_of_mass_close_to_a_face_inside(depth):
    part = part_from_mesh(
        *shapes.box(1.0, 1.0, 1.0), center_of_mass=(0.1, -0.2, -0.5 + depth)
    )
    for statistics in estimate_all(part):
        best = statistics.poses[0]
        assert best.down == pytest.approx(BASE)
        assert best.height == pytest.approx(depth, rel=1e-4)
        assert values(statistics.poses, "probability").sum() == pytest.approx(
            1.0, abs=1e-12
        )


@pytest.mark.parametrize(
    "surface",
    [
        NEEDLE,
        shapes.box(1.0, 1.0, 1e-5),
        shapes.box(1.0, 1e-4, 1e-4),
        shapes.cylinder(512, 0.01, 0.02),
        random_polyhedron(300, 1),
    ],
    ids=["needle", "plate", "bar", "cylinder", "many faces"],
)
def test_slivers_and_many_faces(surface):
    for statistics in estimate_all(part_from_mesh(*surface), cluster_tolerance=0.0):
        probability = values(statistics.poses, "probability")
        assert np.all(np.isfinite(probability)) and probability.min() >= 0.0
        assert probability.sum() == pytest.approx(1.0, abs=1e-12)
        if len(surface[0]) == 8:
            lowest = min(pose.height for pose in statistics.poses)
            assert len(probability) == 6
            assert statistics.poses[0].height == pytest.approx(lowest, rel=1e-9)


class TestTheEstimatorThatKnowsTheScene:
    part = part_from_mesh(*random_polyhedron(8, 3))

    def shares(self, **scene):
        statistics = estimate(self.part, "split", cluster_tolerance=0.0, **scene)
        return values(
            sorted(statistics.poses, key=lambda pose: pose.index), "probability"
        )

    def test_restitution_height_and_inertia_matter(self):
        radius = estimate(self.part).radius
        assert (
            np.abs(self.shares(restitution=0.9) - self.shares(restitution=0.0)).max()
            > 0.01
        )
        assert (
            np.abs(self.shares(drop_height=1.2 * radius) - self.shares()).max() > 0.001
        )
        box = shapes.box(1.0, 1.3, 1.7)
        moments = np.diag(part_from_mesh(*box, mass=1.0).inertia)
        uniform, hollow = (
            part_from_mesh(*box, mass=1.0, inertia=np.diag(moments * factors))
            for factors in ((1.0, 1.0, 1.0), (1.0, 1.0, 1.4))
        )
        shares = [share(part, "split", BASE) for part in (uniform, hollow)]
        assert abs(shares[0] - shares[1]) > 1e-3

    @pytest.mark.parametrize("step", [1e-3, 1e-5])
    def test_small_changes_of_the_scene_change_little(self, step):
        radius = estimate(self.part).radius
        for restitution in np.linspace(0.0, 0.94, 8):
            for height in radius * np.geomspace(1.0, 90.0, 6):
                first = self.shares(restitution=restitution, drop_height=height)
                second = self.shares(
                    restitution=restitution + step, drop_height=height * (1.0 + step)
                )
                assert np.abs(second - first).max() < 5.0 * step

    def test_a_face_that_breaks_in_two(self):
        """The roof of a house, its ridge off the middle, flattens until it is one
        face.
        """

        def walls(rise, tolerance):
            low = [
                (x, y, z) for x in (-0.6, 0.6) for y in (-0.5, 0.5) for z in (0.0, 0.7)
            ]
            house = hull([*low, *((x, 0.15, 0.7 + rise) for x in (-0.6, 0.6))])
            return share(house, "split", -BASE, 0.2, tolerance)

        assert walls(1e-5, 0.005) == pytest.approx(walls(0.0, 0.005), abs=2e-3)
        for rise in (1e-6, 1e-5, 1e-4, 1e-3):  # two poses
            assert walls(rise, 0.0) == pytest.approx(walls(0.0, 0.0), abs=3e-3)

    def test_whichever_of_two_saddles_is_the_higher_one_by_a_hair(self):
        first, second = (
            part_from_mesh(*shapes.box(1.0, 1.0 + step, 1.5)) for step in (-1e-7, 1e-7)
        )
        for direction in np.vstack((np.eye(3), -np.eye(3))):
            assert share(first, "split", direction) == pytest.approx(
                share(second, "split", direction), abs=1e-4
            )

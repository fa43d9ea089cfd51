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

"""Hulls as Qhull and files leave them: folded facets, twin corners, rough and narrow
planes.
"""

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from lab.bodies import shapes
from lab.bodies.samples import REGULAR_SOLIDS, convex_parts
from lab.bodies.variants import subdivided
from ros_pose_stats import estimate, part_from_mesh, resting_poses
from tests.matching import downs


def points_on_a_box(random, count, roughness=0.0):
    """Corners and random points of the faces of a 2 x 3 x 4 box, off by a normal
    `roughness`.
    """
    points = random.uniform(-1.0, 1.0, (count, 3))
    axis = random.integers(0, 3, count)
    points[np.arange(count), axis] = np.sign(points[np.arange(count), axis])
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    points = np.vstack([corners, points]) * [1.0, 1.5, 2.0]
    return points + roughness * random.normal(size=points.shape)


def test_a_box_of_scattered_points_has_six_faces():
    """Qhull cuts facets of many corners into triangles that may be slivers or fold
    back.
    """
    for seed in range(20):
        random = np.random.default_rng(seed)
        points = points_on_a_box(random, 200, 10.0 ** random.uniform(-15, -9))
        points = Rotation.random(random_state=seed).apply(points) + random.normal(
            size=3
        )
        poses = resting_poses(
            part_from_mesh(
                *shapes.hull_mesh(points), center_of_mass=points[:8].mean(axis=0)
            ),
            0.0,
        ).poses
        assert [pose.height for pose in poses] == pytest.approx(
            [1, 1, 1.5, 1.5, 2, 2], abs=1e-7
        )
        assert [len(pose.support_polygon) for pose in poses] == [4] * 6


@pytest.mark.parametrize(
    ("gap", "seed"), [(1e-9, 0), (1e-8, 1), (1e-7, 2), (1e-7, 3), (1e-6, 4), (1e-5, 5)]
)
def test_twin_corners_change_no_pose(seed, gap):
    """Of two corners 1e-7 apart the difference points anywhere."""
    random = np.random.default_rng(seed)
    points = random.normal(size=(12, 3))
    twins = points + gap * random.normal(size=points.shape)
    plain, doubled = (
        estimate(
            part_from_mesh(*shapes.hull_mesh(corners)), "meae", cluster_tolerance=1e-4
        )
        for corners in (points, np.vstack([points, twins]))
    )
    likely = [
        pose for pose in plain.poses if pose.margin > 1e-3 and pose.probability > 1e-3
    ]
    assert likely
    for pose in likely:
        matches = sum(
            twin_pose.probability
            for twin_pose in doubled.poses
            if twin_pose.down @ pose.down > 1.0 - 1e-6
        )
        assert matches == pytest.approx(pose.probability, abs=200.0 * gap)


@pytest.mark.parametrize("roughness", [1e-7, 1e-6, 1e-5, 1e-4])
def test_a_rough_box_keeps_its_poses(roughness):
    smooth = estimate(part_from_mesh(*shapes.box(2.0, 3.0, 4.0)), "meae").poses
    points = points_on_a_box(np.random.default_rng(5), 300, roughness)
    rough = estimate(
        part_from_mesh(*shapes.hull_mesh(points), center_of_mass=[0] * 3), "meae"
    ).poses
    assert len(rough) == 6
    for pose in smooth:
        nearest = max(rough, key=lambda candidate: candidate.down @ pose.down)
        assert nearest.height == pytest.approx(pose.height, abs=10.0 * roughness)
        assert nearest.probability == pytest.approx(
            pose.probability, abs=100.0 * roughness
        )


@pytest.mark.parametrize("tolerance", [0.0, 0.005])
@pytest.mark.parametrize(
    "roughness", [3e-7, 1e-6, 1e-5]
)  # about the tolerance of a plane
def test_rough_faces_give_no_pose_that_the_part_falls_out_of(roughness, tolerance):
    for surface in REGULAR_SOLIDS.values():
        vertices, _ = subdivided(subdivided(surface))
        noise = roughness * np.linalg.norm(vertices, axis=1).max()
        for seed in range(3):
            rough = vertices + noise * np.random.default_rng(seed).normal(
                size=vertices.shape
            )
            poses = resting_poses(
                part_from_mesh(*shapes.hull_mesh(rough)), tolerance
            ).poses
            assert min(min(pose.margin, pose.barrier) for pose in poses) > 0.0


@pytest.mark.parametrize("seed", range(2))
def test_no_pose_is_lost_to_a_coplanar_neighbour(seed):
    """Among thousands of facets some pairs are coplanar to 1e-7 and count as one face.

    A facet with the foot of the centre of mass 1e-4 inside is stable whatever is beside
    it; joined with another it leans by 1e-6 over its width, 1e-4.
    """
    points = shapes.ellipsoid_points(4000, seed, (1.0, 0.995, 0.99))
    part = part_from_mesh(*shapes.hull_mesh(points))
    faces = downs(resting_poses(part, 0.0, round_sides=0).poses)
    points -= part.center_of_mass
    hull = ConvexHull(points)
    normals = hull.equations[:, :3]
    heights = -hull.equations[:, 3]
    inside = np.full(len(normals), np.inf)
    for k in range(3):
        first, last, apex = (points[hull.simplices[:, (k + j) % 3]] for j in range(3))
        across = np.cross(normals, last - first)
        across /= np.linalg.norm(across, axis=1)[:, None]
        across *= np.sign(((apex - first) * across).sum(axis=1))[:, None]
        inside = np.minimum(
            inside, ((heights[:, None] * normals - first) * across).sum(axis=1)
        )
    stable = normals[inside > 1e-4]
    assert len(stable) > 100
    assert (stable @ faces.T).max(axis=1).min() > 1.0 - 2e-8


def test_a_bulge_of_a_thousandth_is_no_plane():
    raised = np.vstack((shapes.box(1.0, 1.0, 1.0)[0], (0.0, 0.0, 0.501)))
    poses = resting_poses(part_from_mesh(*shapes.hull_mesh(raised)), 0.0).poses
    assert max(pose.down[2] for pose in poses) < 1.0 - 1e-6


@pytest.mark.parametrize(("name", "part"), convex_parts().items())
def test_r_and_R_of_the_paper(name, part):
    """Distance to the surface and height above the plate: equal at equilibria, else r <
    R.
    """
    resting = resting_poses(part, 0.0, round_sides=0)
    body = resting.body
    u = shapes.sphere_points(2000, 0)
    on_surface = part.center_of_mass + (body.radius * body.r(u))[:, None] * u
    hull = ConvexHull(part.surface_vertices)
    beyond = hull.equations[:, :3] @ on_surface.T + hull.equations[:, 3:]
    assert np.abs(beyond.max(axis=0)).max() < 3e-6 * body.radius
    heights = (part.surface_vertices - part.center_of_mass) @ u.T
    assert body.R(u) * body.radius == pytest.approx(
        heights.max(axis=0), abs=3e-6 * body.radius
    )
    assert (body.r(u) < body.R(u)).all()
    for pose in resting.poses:
        for function in (body.r, body.R):
            assert function(pose.down) * body.radius == pytest.approx(
                pose.height, rel=1e-9
            )

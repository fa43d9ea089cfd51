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

"""What a pose says of itself, against plain geometry and other libraries."""

import gc
import weakref

import numpy as np
import pytest
from hypothesis import given, strategies
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from lab.bodies import shapes
from lab.bodies.samples import REGULAR_SOLIDS, oblique_prism, random_polyhedron
from lab.bodies.variants import moved, rotation
from ros_pose_stats import estimate_all, part_from_mesh, resting_poses
from ros_pose_stats.core.shapes import demo_parts
from tests.matching import values

PARTS = {
    "icosahedron": part_from_mesh(*REGULAR_SOLIDS["icosahedron"]),
    **{
        name: part_from_mesh(*demo_parts.DEMO_PARTS[name](), unit="mm")
        for name in ("cylinder", "hex_bolt", "clamp")
    },
    "leaning prism": part_from_mesh(*oblique_prism(3.0, 4.0)),
    "far off": part_from_mesh(
        *moved(shapes.box(1.0, 2.0, 3.0), rotation(1), (50.0, 20.0, -70.0))
    ),
    "shifted centre": part_from_mesh(
        *shapes.box(1.0, 2.0, 3.0), center_of_mass=(0.2, -0.3, 1.0)
    ),
    "random": part_from_mesh(*random_polyhedron(22, 5)),
}
CASES = [(name, 0.0) for name in PARTS] + [
    (name, 0.005) for name in ("cylinder", "hex_bolt", "clamp")
]
every_case = pytest.mark.parametrize(("name", "tolerance"), CASES)


def poses_and_radius(name, tolerance):
    part = PARTS[name]
    reach = part.surface_vertices - part.center_of_mass
    return (
        part,
        resting_poses(part, tolerance, round_sides=0).poses,
        np.linalg.norm(reach, axis=1).max(),
    )


def in_plate_frame(pose, points):
    """Points of the part's frame after it has come to rest."""
    return Rotation.from_quat(pose.orientation).apply(points) + pose.position


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def signed_area(polygon):
    return 0.5 * cross(polygon, np.roll(polygon, -1, axis=0)).sum()


@every_case
class TestEveryPose:
    """Planes are flat to 1e-6 of the radius, so that corners are off by 3e-6 at the
    most.
    """

    def test_it_stands_on_the_plate_with_its_centre_of_mass_above_the_origin(
        self, name, tolerance
    ):
        part, poses, radius = poses_and_radius(name, tolerance)
        rounding = 1e-13 * (radius + np.linalg.norm(part.center_of_mass))
        for pose in poses:
            points = in_plate_frame(pose, part.surface_vertices)
            assert in_plate_frame(pose, part.center_of_mass) == pytest.approx(
                (0.0, 0.0, pose.height), abs=rounding
            )
            assert points[:, 2].min() == pytest.approx(0.0, abs=3e-6 * radius)
            assert points[:, 2].max() == pytest.approx(pose.top, abs=rounding)

    def test_support_polygon_is_what_touches_the_plate(self, name, tolerance):
        part, poses, radius = poses_and_radius(name, tolerance)
        for pose in poses:
            points = in_plate_frame(pose, part.surface_vertices)
            touching = ConvexHull(points[points[:, 2] < 3e-6 * radius, :2])
            assert signed_area(pose.support_polygon) == pytest.approx(
                touching.volume, rel=1e-5
            )
            hull = ConvexHull(pose.support_polygon)
            assert hull.volume == pytest.approx(
                signed_area(pose.support_polygon), rel=1e-9
            )
            assert len(hull.vertices) == len(pose.support_polygon)
            assert (
                hull.equations[:, 2].max() < 0.0
            )  # the foot of the centre of mass is inside

    def test_outline_is_the_hull_of_the_shadow(self, name, tolerance):
        part, poses, radius = poses_and_radius(name, tolerance)
        for pose in poses:
            shadow = ConvexHull(in_plate_frame(pose, part.surface_vertices)[:, :2])
            assert signed_area(pose.outline) == pytest.approx(shadow.volume, rel=1e-6)
            planes = shadow.equations
            beyond = (pose.outline @ planes[:, :2].T + planes[:, 2]).max(axis=1)
            assert np.abs(beyond).max() < 1e-6 * radius
            along = np.roll(pose.outline, -1, axis=0) - pose.outline
            along /= np.linalg.norm(along, axis=1)[:, None]
            assert cross(along, np.roll(along, -1, axis=0)).min() > 0.0

    def test_margin_is_the_smallest_tilt_over_the_rim(self, name, tolerance):
        _, poses, _ = poses_and_radius(name, tolerance)
        for pose in poses:
            if len(pose.members) == 1:
                corners = pose.support_polygon
                along = np.roll(corners, -1, axis=0) - corners
                reach = cross(corners, along) / np.linalg.norm(along, axis=1)
                assert pose.margin == pytest.approx(
                    np.arctan2(reach.min(), pose.height), abs=3e-6
                )

    def test_numbers(self, name, tolerance):
        """Rising height; groups by their first pose; members are all stable faces, each
        once.
        """
        part, poses, radius = poses_and_radius(name, tolerance)
        assert [pose.index for pose in poses] == list(range(len(poses)))
        assert np.diff(values(poses, "height")).min(initial=0.0) > -1e-6 * radius
        group = values(poses, "group")
        assert np.all(group <= np.maximum.accumulate(np.append(-1, group[:-1])) + 1)
        members = sorted(i for pose in poses for i in pose.members)
        assert members == list(
            range(len(resting_poses(part, 0.0, round_sides=0).poses))
        )


@pytest.mark.parametrize("seed", [0, 1])
def test_rounding_does_not_renumber_ties(seed):
    """Heights and directions that differ by 1e-8 are the same: `down` decides, not
    noise.
    """
    vertices, triangles = shapes.prism(6, 1.0, 2.0 * np.cos(np.pi / 6.0))
    exact = resting_poses(part_from_mesh(vertices, triangles), 0.0, round_sides=0).poses
    noise = np.random.default_rng(seed).uniform(-1e-8, 1e-8, vertices.shape)
    rough = resting_poses(part_from_mesh(vertices + noise, triangles), 0.0, 0).poses
    for exact_pose, rough_pose in zip(exact, rough, strict=True):
        assert exact_pose.down == pytest.approx(rough_pose.down, abs=1e-6)
    ties = [tuple(np.rint(1e4 * pose.down).tolist()) for pose in exact]
    assert ties == sorted(
        ties
    )  # all eight are equally high, no component is near a half


def test_a_dense_run_of_heights_is_no_tie():
    part = part_from_mesh(*shapes.hull_mesh(shapes.sphere_points(4000, 2)))
    heights = values(resting_poses(part, 0.0, round_sides=0).poses, "height")
    assert (np.maximum.accumulate(heights) - heights).max() < 1.1e-6 * heights.max()


class TestOrientation:
    """The smallest rotation that brings `down` to -z; a half turn about x where that is
    any.
    """

    @staticmethod
    def poses(turn):
        return resting_poses(
            part_from_mesh(*moved(shapes.box(1.0, 2.0, 3.0), turn)), 0.0
        ).poses

    @given(strategies.integers(0, 10_000))
    def test_in_any_frame(self, seed):
        for pose in self.poses(rotation(seed)):
            turn = Rotation.from_quat(pose.orientation)
            assert turn.apply(pose.down) == pytest.approx((0.0, 0.0, -1.0), abs=1e-13)
            assert turn.magnitude() == pytest.approx(
                np.arccos(-pose.down[2]), abs=1e-10
            )
            assert np.linalg.norm(pose.orientation) == pytest.approx(1.0, abs=1e-15)

    @given(strategies.floats(-13.0, -1.0), strategies.floats(0.0, 6.3))
    def test_near_half_a_turn(self, exponent, azimuth):
        """Rounding of a `down` near +z turns no axis, and the result is right all the
        same.
        """
        tilt = 10.0**exponent
        axis = (np.cos(azimuth), np.sin(azimuth), 0.0)
        poses = self.poses(Rotation.from_rotvec(np.array(axis) * tilt).as_matrix())
        up = max(poses, key=lambda pose: pose.down[2])
        turn = Rotation.from_quat(up.orientation)
        assert turn.apply(up.down) == pytest.approx((0.0, 0.0, -1.0), abs=1e-9)
        if tilt < 1e-10:
            assert (
                turn.inv() * Rotation.from_rotvec((np.pi, 0.0, 0.0))
            ).magnitude() < 1e-9

    def test_lying_already_and_a_quarter_turn(self):
        expected = {
            (0, 0, -1): (0, 0, 0, 1),
            (0, 0, 1): (1, 0, 0, 0),
            (1, 0, 0): (0, np.sqrt(0.5), 0, np.sqrt(0.5)),
            (0, 1, 0): (-np.sqrt(0.5), 0, 0, np.sqrt(0.5)),
        }
        poses = self.poses(np.eye(3))
        for down, quaternion in expected.items():
            pose = max(poses, key=lambda pose: pose.down @ down)
            assert abs(pose.orientation @ quaternion) == pytest.approx(1.0, abs=1e-15)


def test_a_part_is_let_go():
    part = part_from_mesh(*shapes.box(1.0, 2.0, 3.0))
    estimate_all(part)
    resting_poses(part, 0.0)
    alive = weakref.ref(part)
    del part
    gc.collect()
    assert alive() is None

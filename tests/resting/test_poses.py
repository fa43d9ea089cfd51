"""The records of the stable poses, against plain geometry and other libraries."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from ros_pose_stats import estimate, part_from_mesh, resting_poses, shapes
from ros_pose_stats.shapes import demo_parts
from tests.bodies import REGULAR_SOLIDS, moved, oblique_prism, random_polyhedron, rotation
from tests.matching import values

PARTS = {
    "icosahedron": part_from_mesh(*REGULAR_SOLIDS["icosahedron"]),
    **{name: part_from_mesh(*demo_parts.DEMO_PARTS[name](), unit="mm")
       for name in ("cylinder", "hex_bolt", "clamp")},
    "leaning prism": part_from_mesh(*oblique_prism(3.0, 4.0)),
    "far off": part_from_mesh(*moved(shapes.box(1.0, 2.0, 3.0), rotation(1), (50.0, 20.0, -70.0))),
    "shifted centre": part_from_mesh(*shapes.box(1.0, 2.0, 3.0), center_of_mass=(0.2, -0.3, 1.0)),
    "random": part_from_mesh(*random_polyhedron(22, 5)),
}
CLUSTERED = [(name, 0.0) for name in PARTS] + [
    (name, 0.005) for name in ("cylinder", "hex_bolt", "clamp")]


def in_plate_frame(part, pose, points):
    """Points of the part's frame after it has come to rest."""
    return Rotation.from_quat(pose.orientation).apply(points) + pose.position


def cross(a, b):
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def signed_area(polygon):
    return 0.5 * cross(polygon, np.roll(polygon, -1, axis=0)).sum()


@pytest.mark.parametrize(("part", "tolerance"),
                         [(PARTS[name], tolerance) for name, tolerance in CLUSTERED],
                         ids=[f"{name}-{tolerance}" for name, tolerance in CLUSTERED])
class TestEveryPose:
    @staticmethod
    def poses(part, tolerance):
        return resting_poses(part, tolerance, round_sides=0).poses

    def test_stands_on_the_plate_with_its_centre_of_mass_above_the_origin(self, part, tolerance):
        radius = resting_poses(part, tolerance, round_sides=0).body.radius
        for pose in self.poses(part, tolerance):
            place = in_plate_frame(part, pose, part.surface_vertices)
            center = in_plate_frame(part, pose, part.center_of_mass)
            far = np.linalg.norm(part.center_of_mass)
            assert center == pytest.approx((0.0, 0.0, pose.height), abs=1e-14 * (radius + far))
            assert place[:, 2].min() == pytest.approx(0.0, abs=3e-6 * radius)
            assert place[:, 2].max() == pytest.approx(pose.top, abs=1e-12 * (radius + far))

    def test_support_polygon_is_what_touches_the_plate(self, part, tolerance):
        radius = resting_poses(part, tolerance, round_sides=0).body.radius
        for pose in self.poses(part, tolerance):
            place = in_plate_frame(part, pose, part.surface_vertices)
            touching = ConvexHull(place[place[:, 2] < 3e-6 * radius, :2])
            assert signed_area(pose.support_polygon) == pytest.approx(touching.volume, rel=1e-5)
            hull = ConvexHull(pose.support_polygon)
            assert hull.volume == pytest.approx(signed_area(pose.support_polygon), rel=1e-9)
            assert len(hull.vertices) == len(pose.support_polygon)
            # Stable: the foot of the centre of mass is inside.
            assert hull.equations[:, 2].max() < 0.0

    def test_outline_is_the_hull_of_the_shadow(self, part, tolerance):
        radius = resting_poses(part, tolerance, round_sides=0).body.radius
        for pose in self.poses(part, tolerance):
            shadow = ConvexHull(in_plate_frame(part, pose, part.surface_vertices)[:, :2])
            # Corners of faces that are flat to 1e-6 of the radius may be left out.
            assert signed_area(pose.outline) == pytest.approx(shadow.volume, rel=1e-6)
            planes = shadow.equations
            beyond = (pose.outline @ planes[:, :2].T + planes[:, 2]).max(axis=1)
            assert np.abs(beyond).max() < 1e-6 * radius
            along = np.roll(pose.outline, -1, axis=0) - pose.outline
            along /= np.linalg.norm(along, axis=1)[:, None]
            assert cross(along, np.roll(along, -1, axis=0)).min() > 0.0

    def test_margin_is_the_smallest_tilt_over_the_support_polygons_rim(self, part, tolerance):
        for pose in self.poses(part, tolerance):
            if len(pose.members) > 1:
                continue
            corners = pose.support_polygon
            along = np.roll(corners, -1, axis=0) - corners
            reach = cross(corners, along) / np.linalg.norm(along, axis=1)
            assert pose.margin == pytest.approx(
                np.arctan2(reach.min(), pose.height), rel=1e-6)

    def test_numbers_rise_with_height_and_groups_with_numbers(self, part, tolerance):
        poses = self.poses(part, tolerance)
        radius = resting_poses(part, tolerance, round_sides=0).body.radius
        assert [pose.index for pose in poses] == list(range(len(poses)))
        assert np.diff(values(poses, "height")).min(initial=0.0) > -1e-6 * radius
        group = values(poses, "group")
        assert group[0] == 0
        assert np.all(group <= np.maximum.accumulate(np.append(-1, group[:-1])) + 1)

    def test_members_partition_the_stable_faces(self, part, tolerance):
        members = sorted(i for pose in self.poses(part, tolerance) for i in pose.members)
        assert members == list(range(len(resting_poses(part, 0.0, round_sides=0).poses)))

    def test_geometry_arrays_cannot_be_written_to(self, part, tolerance):
        pose = self.poses(part, tolerance)[0]
        for array in (pose.down, pose.orientation, pose.position):
            with pytest.raises(ValueError, match="read-only"):
                array[0] = 1.0


@pytest.mark.parametrize("part", PARTS.values(), ids=PARTS)
def test_height_and_top_are_trimeshs(part):
    hull = trimesh.Trimesh(part.surface_vertices, part.surface_triangles,
                           process=False).convex_hull
    for pose in resting_poses(part, 0.0, round_sides=0).poses:
        along = (hull.vertices - part.center_of_mass) @ pose.down
        assert along.max() == pytest.approx(pose.height, rel=1e-6)
        assert np.ptp(along) == pytest.approx(pose.top, rel=1e-6)


def test_ties_in_height_are_numbered_by_down():
    downs = [tuple(np.round(pose.down, 9) + 0.0)
             for pose in resting_poses(part_from_mesh(*shapes.box(1.0, 1.0, 1.0)), 0.0).poses]
    assert downs == sorted(downs)


def test_rounding_does_not_renumber_ties():
    # Heights and directions that differ by 1e-8 are the same: `down` decides, not noise.
    vertices, triangles = shapes.prism(6, 1.0, 2.0 * np.cos(np.pi / 6.0))
    exact = resting_poses(part_from_mesh(vertices, triangles), 0.0, round_sides=0).poses
    for seed in range(5):
        noise = np.random.default_rng(seed).uniform(-1e-8, 1e-8, vertices.shape)
        rough = resting_poses(part_from_mesh(vertices + noise, triangles), 0.0, 0).poses
        for one, other in zip(exact, rough, strict=True):
            assert one.down == pytest.approx(other.down, abs=1e-6)


def test_a_dense_run_of_heights_is_no_tie():
    part = part_from_mesh(*shapes.hull_mesh(shapes.sphere_points(4000, 2)))
    heights = values(resting_poses(part, 0.0, round_sides=0).poses, "height")
    assert (np.maximum.accumulate(heights) - heights).max() < 1.1e-6 * heights.max()


def test_a_single_pose_has_an_infinite_barrier():
    # Loaded near a corner, with a single stable face.
    part = part_from_mesh(*random_polyhedron(6, 1329), center_of_mass=(-1.18, 0.55, 0.92))
    (pose,) = estimate(part, "meae", cluster_tolerance=0.0, round_sides=0).poses
    assert pose.barrier == np.inf
    assert pose.probability == 1.0
    assert 0.0 < pose.margin <= np.pi / 2.0
    assert pose.spread == 0.0


def test_answers_are_remembered_but_not_shared_between_tolerances():
    part = part_from_mesh(*shapes.cylinder(64, 1.0, 2.0))
    assert resting_poses(part, 0.005, round_sides=0) is resting_poses(part, 0.005, 0)
    assert len(resting_poses(part, 0.0, round_sides=0).poses) == 66
    assert len(resting_poses(part, 0.005, round_sides=0).poses) == 3

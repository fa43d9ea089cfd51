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

"""Parts as they most probably lie, beside the motions that trimesh makes."""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from lab.bodies.variants import moved, rotation
from ros_pose_stats import estimate, load_part, part_from_mesh, resting_poses, upright
from ros_pose_stats.core.shapes import demo_parts
from tests.running import answer, answer_json, refusal, refusal_of

BODIES = {
    "box, turned and far off": moved(
        shapes.box(1.0, 2.0, 3.0), rotation(1), (50.0, 20.0, -70.0)
    ),
    "tetrahedron": shapes.tetrahedron(),
    "random polyhedron": random_polyhedron(22, 5),
    "bracket": demo_parts.bracket(),
    "clamp": demo_parts.clamp(),
    "hex bolt": demo_parts.hex_bolt(),
    "cylinder of twelve sides": shapes.cylinder(12, 1.0, 4.0),
}


def meshes_and_parts(body):
    mesh = trimesh.Trimesh(*BODIES[body], process=False)
    return mesh, part_from_mesh(mesh)


def distance_to_support(points, radius):
    """How far the origin is from the polygon of the lowest points; negative inside."""
    low = points[points[:, 2] < points[:, 2].min() + 1e-6 * radius, :2]
    return ConvexHull(low, qhull_options="QJ").equations[:, 2].max()


@pytest.mark.parametrize("body", BODIES)
class TestUpright:
    def test_the_lowest_point_is_on_the_plate_and_the_centre_over_its_support(
        self, body
    ):
        mesh, part = meshes_and_parts(body)
        mesh.apply_transform(upright(part))
        radius = np.linalg.norm(part.surface_vertices - part.center_of_mass, axis=1)
        rounding = 1e-12 * (radius.max() + np.linalg.norm(part.center_of_mass))
        assert mesh.bounds[0, 2] == pytest.approx(0.0, abs=rounding)
        assert mesh.center_mass[:2] == pytest.approx((0.0, 0.0), abs=10.0 * rounding)
        assert distance_to_support(mesh.vertices, radius.max()) < 0.0

    def test_it_is_a_motion_that_mirrors_nothing(self, body):
        turn = upright(meshes_and_parts(body)[1])
        assert turn[3].tolist() == [0.0, 0.0, 0.0, 1.0]
        assert turn[:3, :3] @ turn[:3, :3].T == pytest.approx(np.eye(3), abs=1e-14)
        assert np.linalg.det(turn) == pytest.approx(1.0)


@pytest.mark.parametrize("body", ["tetrahedron", "random polyhedron", "bracket"])
def test_transforms_are_those_of_trimesh_but_for_yaw_and_place(body):
    """Of every face that both take for a pose; trimesh turns about the origin of the
    mesh and leaves it above that.
    """
    mesh, part = meshes_and_parts(body)
    transforms, probabilities = estimate(
        part, "area", cluster_tolerance=0.0, round_sides=0
    ).transforms()
    others, shares = trimesh.poses.compute_stable_poses(mesh)
    assert transforms.shape == (len(probabilities), 4, 4)
    assert (np.diff(probabilities) <= 0.0).all()
    assert probabilities.sum() == pytest.approx(shares.sum())
    assert len(others) == len(transforms)
    for other in others:
        nearest = np.argmax(transforms[:, 2, :3] @ other[2, :3])
        assert transforms[nearest, 2, :3] == pytest.approx(other[2, :3], abs=1e-6)
        lifted = mesh.copy().apply_transform(transforms[nearest])
        assert lifted.bounds[0, 2] == pytest.approx(0.0, abs=1e-6 * mesh.scale)
        assert lifted.bounds[1, 2] == pytest.approx(
            mesh.copy().apply_transform(other).bounds[1, 2], abs=1e-6 * mesh.scale
        )


def test_transforms_are_the_orientations_and_positions_of_the_poses():
    for pose in resting_poses(meshes_and_parts("clamp")[1]).poses:
        down = pose.transform[:3, :3] @ pose.down
        assert down == pytest.approx((0.0, 0.0, -1.0), abs=1e-14)
        turned = trimesh.transformations.quaternion_matrix(np.roll(pose.orientation, 1))
        assert pose.transform[:3, :3] == pytest.approx(turned[:3, :3], abs=1e-14)
        assert pose.transform[:3, 3].tolist() == pose.position.tolist()


def test_the_pose_is_that_of_the_answer_and_the_unit_that_of_the_mesh():
    vertices, triangles = shapes.box(20.0, 30.0, 40.0)
    part = part_from_mesh(vertices, triangles, (0.0, 0.0, 0.019), unit="mm")
    standing = upright(part, unit="mm")
    assert (standing[2, :3] @ (0.0, 0.0, 19.0)) + standing[2, 3] == pytest.approx(1.0)
    assert upright(part)[:, :3].tolist() == standing[:, :3].tolist()
    assert upright(part)[:3, 3] == pytest.approx(1e-3 * standing[:3, 3])
    with_poses = estimate(part, "area")
    assert upright(part, with_poses).tolist() == upright(part).tolist()


def test_what_it_cannot_turn_is_refused():
    part = part_from_mesh(*shapes.box(1.0, 2.0, 3.0))
    other = part_from_mesh(*shapes.box(1.0, 2.0, 4.0))
    assert "expected a Part" in refusal_of(upright, shapes.box(1.0, 2.0, 3.0))
    assert "statistics of the part" in refusal_of(upright, part, estimate(other))
    assert "got str" in refusal_of(upright, part, "mm")
    assert "a mesh unit" in refusal_of(upright, part, unit=0.0)


@pytest.mark.parametrize("options", [(), ("--method", "area")], ids=["auto", "area"])
def test_the_command_writes_the_mesh_as_it_lies(tmp_path, options):
    file = tmp_path / "clamp.stl"
    mesh = trimesh.Trimesh(*demo_parts.clamp(), process=False)
    mesh.export(file)
    lying = tmp_path / "lying.stl"
    request = "estimate", file, "--unit", "mm", *options, "--upright", lying
    assert f"wrote {lying}" in answer(*request)
    written = trimesh.load_mesh(lying)
    expected = mesh.copy().apply_transform(upright(load_part(file, "mm"), unit="mm"))
    assert written.bounds == pytest.approx(expected.bounds, abs=1e-4)
    assert written.volume == pytest.approx(mesh.volume, rel=1e-5)
    lying.unlink()
    answer_json(*request)
    assert lying.exists()


def test_the_command_refuses_what_it_cannot_write(tmp_path):
    file = tmp_path / "clamp.stl"
    trimesh.Trimesh(*demo_parts.clamp(), process=False).export(file)
    request = "estimate", file, "--upright"
    assert ".stl" in refusal(*request, tmp_path / "lying.obj")
    assert "one method" in refusal(*request, tmp_path / "a.stl", "--method", "all")

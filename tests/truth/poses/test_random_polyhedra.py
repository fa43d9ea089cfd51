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

"""The paper's random polyhedra against a second reading of the recipe, and against
trimesh.
"""

import numpy as np
import pytest
import trimesh
from scipy.spatial import ConvexHull

from lab.bodies.random_polyhedra import random_polyhedron
from ros_pose_stats import resting_poses

SAMPLE = 100
every_recipe = pytest.mark.parametrize(
    ("shift", "moment"), [(0.0, "inertia"), (1.0, "inertia"), (0.65, "second")]
)


def drawn(random, shift, moment):
    """A body by the recipe: vertices, stable faces and the shift's length; None to
    redraw.
    """
    points = random.standard_normal((3 + random.geometric(0.1), 3))
    hull = ConvexHull(points)
    corners = points[hull.simplices]
    across = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    inward = np.einsum("ij,ij->i", across, hull.equations[:, :3]) < 0.0
    corners[inward] = corners[inward][:, ::-1]
    volumes = np.linalg.det(corners) / 6.0
    corners -= volumes @ corners.sum(axis=1) / 4.0 / volumes.sum()
    corners /= np.linalg.norm(corners, axis=2).max()
    volumes = np.linalg.det(corners) / 6.0
    sums = corners.sum(axis=1)
    outer = np.einsum("tki,tkj->tij", corners, corners) + np.einsum(
        "ti,tj->tij", sums, sums
    )
    second, axes = np.linalg.eigh(
        np.tensordot(volumes, outer, 1) / 20.0 / volumes.sum()
    )
    square = second if moment == "second" else second.sum() - second
    moved = axes @ (shift * random.uniform(-1.0, 1.0, 3) * np.sqrt(square))
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    heights = np.einsum("ij,ij->i", normals, corners[:, 0] - moved)
    feet = moved + heights[:, None] * normals
    stable = np.all(
        [
            np.einsum(
                "ij,ij->i",
                np.cross(corners[:, (k + 1) % 3] - corners[:, k], feet - corners[:, k]),
                normals,
            )
            > 0.0
            for k in range(3)
        ],
        axis=0,
    ).sum()
    if heights.min() <= 0.0 or stable < 2:
        return None
    return len(hull.vertices), stable, np.linalg.norm(moved)


def assert_same_mean(first, second):
    """Within four standard errors."""
    error = np.sqrt(np.var(first) / len(first) + np.var(second) / len(second))
    assert abs(np.mean(first) - np.mean(second)) <= 4.0 * error + 1e-12


@every_recipe
def test_vertices_stable_faces_shift_and_redraws_are_distributed_alike(shift, moment):
    random = np.random.default_rng(20)
    tries = [drawn(random, shift, moment) for _ in range(3 * SAMPLE)]
    figures = np.array([figure for figure in tries if figure is not None])
    bodies = [random_polyhedron(11, number, shift, moment) for number in range(SAMPLE)]
    ours = np.array(
        [
            (
                len(body.vertices),
                len(resting_poses(body.part(), 0.0).poses),
                np.linalg.norm(body.center_of_mass),
            )
            for body in bodies
        ]
    )
    for column in range(3):
        assert_same_mean(ours[:, column], figures[:, column])
        assert_same_mean(ours[:, column] ** 2, figures[:, column] ** 2)
    # One body out of a try or not, in both samples.
    assert_same_mean(
        np.concatenate([[0] * body.redraws + [1] for body in bodies]),
        np.array([figure is not None for figure in tries], dtype=float),
    )


@every_recipe
def test_a_body_has_radius_1_its_central_inertia_and_a_shift_within_its_box(
    shift, moment
):
    """The box is shift q_i along the principal axes, here as trimesh has them."""
    shares = []
    for number in range(60):
        body = random_polyhedron(5, number, shift, moment)
        part = body.part()
        mesh = trimesh.Trimesh(body.vertices, body.triangles, process=False)
        assert mesh.is_volume
        assert mesh.volume == pytest.approx(ConvexHull(body.vertices).volume)
        assert mesh.center_mass == pytest.approx(np.zeros(3), abs=1e-12)
        assert np.linalg.norm(body.vertices, axis=1).max() == pytest.approx(
            1.0, rel=1e-14
        )
        assert part.inertia / part.mass == pytest.approx(
            mesh.moment_inertia / mesh.volume, rel=1e-9, abs=1e-12
        )
        assert part.center_of_mass.tolist() == body.center_of_mass.tolist()
        moments, axes = np.linalg.eigh(mesh.moment_inertia / mesh.volume)
        square = moments.sum() / 2.0 - moments if moment == "second" else moments
        shares.append(np.abs(body.center_of_mass @ axes) / np.sqrt(square))
    assert np.max(shares) <= shift * (1.0 + 1e-9)
    assert np.max(shares, axis=0) == pytest.approx(np.full(3, shift), rel=0.35)


def test_a_body_depends_on_its_seed_and_number_alone():
    whole = [random_polyhedron(3, number, 1.0) for number in range(4)]
    repeated = random_polyhedron(3, 2, 1.0)
    assert np.array_equal(repeated.vertices, whole[2].vertices)
    assert np.array_equal(repeated.center_of_mass, whole[2].center_of_mass)
    first = {
        tuple(random_polyhedron(seed, number).vertices[0].tolist())
        for seed in (0, 1, 2**64 - 1)
        for number in (0, 1, 2**32)
    }
    assert len(first) == 9

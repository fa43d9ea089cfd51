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

"""Changed parts against parts that were modelled anew, and shares with a closed form.

The space of changes is the one that `sensitivity` hands out with its effects.
"""

import math

import numpy as np
import pytest

from lab.bodies import shapes
from ros_pose_stats import PoseStatsError, estimate, part_from_mesh, sensitivity
from ros_pose_stats.core.shapes.demo_parts import DEMO_PARTS

SIZES = (20e-3, 30e-3, 50e-3)


def space_of(part):
    return sensitivity(part, [0], checks=0).space


def face(space, direction):
    """Number of the face that is nearest to a direction."""
    anchors = [
        feature.anchor @ np.array(direction) if feature.kind == "face" else -np.inf
        for feature in space.features
    ]
    return int(np.argmax(anchors))


def assert_same_body(part, twin):
    assert part.mass == pytest.approx(twin.mass, rel=1e-9)
    np.testing.assert_allclose(part.center_of_mass, twin.center_of_mass, atol=1e-11)
    np.testing.assert_allclose(
        part.inertia, twin.inertia, rtol=1e-8, atol=1e-9 * twin.inertia.max()
    )
    assert len(part.surface_vertices) == len(twin.surface_vertices)
    gap = np.linalg.norm(
        part.surface_vertices[:, None] - twin.surface_vertices[None], axis=2
    )
    assert gap.min(axis=1).max() < 1e-9


@pytest.fixture(scope="module")
def space():
    """Of the box, of mass 1 kg; a sliver has its density."""
    return space_of(part_from_mesh(*shapes.box(*SIZES)))


def test_nothing_changed_is_the_part(space):
    assert_same_body(space.change_feature(0, 0.0).part, space.part)


def test_a_box_has_three_axes_twice_and_six_faces(space):
    assert [feature.kind for feature in space.features] == 3 * ["centre"] + 3 * [
        "stretch"
    ] + 6 * ["face"]


def test_stretched(space):
    steps = np.zeros(len(space.features))
    steps[3:6] = 0.1, -0.2, 0.05
    expected = part_from_mesh(*shapes.box(*np.array(SIZES) * (1.1, 0.8, 1.05)))
    assert_same_body(space.change(steps).part, expected)


@pytest.mark.parametrize("step", [3e-3, -3e-3])
def test_a_face_moved(space, step):
    vertices, triangles = shapes.box(SIZES[0], SIZES[1] + step, SIZES[2])
    expected = part_from_mesh(
        vertices + np.array([0.0, 0.5 * step, 0.0]),
        triangles,
        mass=1.0 + step / SIZES[1],
    )
    assert_same_body(
        space.change_feature(face(space, (0.0, 1.0, 0.0)), step).part, expected
    )


def test_the_centre_of_mass_moved_keeps_the_inertia(space):
    part = space.change_feature(1, 2e-3).part
    np.testing.assert_allclose(part.center_of_mass, (0.0, 2e-3, 0.0), atol=1e-15)
    np.testing.assert_allclose(part.inertia, space.part.inertia, rtol=1e-12)


def test_too_far_is_refused(space):
    with pytest.raises(PoseStatsError, match="change the part less"):
        space.change_feature(face(space, (0.0, 0.0, 1.0)), -60e-3)
    with pytest.raises(PoseStatsError):
        space.change_feature(0, 15e-3)


def test_estimates_of_a_stretched_box_have_closed_forms(space):
    """`area`: its area's share; `csae`: a rectangle's solid angle, 4 atan(ab / c |(a,
    b, c)|).
    """
    part = space.change_feature(5, 0.1).part
    a = 0.5 * SIZES[0]
    b = 0.5 * SIZES[1]
    c = 0.55 * SIZES[2]
    for method, share in (
        ("area", 0.5 * a * b / (a * b + b * c + c * a)),
        ("csae", math.atan(a * b / (c * math.hypot(a, b, c))) / math.pi),
    ):
        top = next(pose for pose in estimate(part, method).poses if pose.down[2] > 0.9)
        assert top.probability == pytest.approx(share, rel=1e-9)


def test_a_part_with_rounded_edges_and_holes_keeps_its_own_mass_properties():
    part = part_from_mesh(*DEMO_PARTS["clamp"](), unit="mm")
    unchanged = space_of(part).change_feature(0, 0.0).part
    np.testing.assert_allclose(
        unchanged.center_of_mass, part.center_of_mass, atol=1e-12
    )
    np.testing.assert_allclose(unchanged.inertia, part.inertia, rtol=1e-9, atol=1e-16)
    original_answer = estimate(part, "split")
    answer = estimate(unchanged, "split")
    assert [pose.index for pose in original_answer.poses] == [
        pose.index for pose in answer.poses
    ]
    np.testing.assert_allclose(
        [pose.probability for pose in answer.poses],
        [pose.probability for pose in original_answer.poses],
        atol=1e-9,
    )


def test_the_mantle_of_a_cylinder_moves_as_one_face():
    space = space_of(part_from_mesh(*shapes.cylinder(64, 9e-3, 22e-3)))
    assert [feature.kind for feature in space.features].count("face") == 3
    mantle = next(
        k
        for k, feature in enumerate(space.features)
        if feature.kind == "face" and len(feature.planes) > 1
    )
    wider = space.change_feature(mantle, 0.5e-3).part
    assert len(estimate(wider).poses) == 3
    # The mantle lies as far out as its circle, within the sagitta of 192 sides.
    assert np.linalg.norm(wider.surface_vertices[:, :2], axis=1).max() == pytest.approx(
        9.5e-3, rel=1e-3
    )

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

"""Orientations with a camera's errors, made by scipy's rotations, are found to be their
poses.
"""

import math
from functools import cache

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from ros_pose_stats import (
    PoseStatsError,
    classify_orientations,
    part_from_mesh,
    resting_poses,
)
from ros_pose_stats.core.shapes import demo_parts

NOISE = math.radians(5.0)
MANY = 10_000
WITHIN = 1.0 - math.exp(-4.5)
"""Share of normal errors about two axes that are below three standard deviations."""


SURFACES = {
    "clamp": demo_parts.DEMO_PARTS["clamp"],
    "gear": demo_parts.DEMO_PARTS["gear"],
    "bolt": demo_parts.DEMO_PARTS["hex_bolt"],
    "cylinder": demo_parts.DEMO_PARTS["cylinder"],
    "nut": lambda: shapes.prism(6, 10.0, 12.0),
    "cube": lambda: shapes.box(2.0, 2.0, 2.0),
    "brick": lambda: shapes.box(1.0, 2.0, 3.0),
    "crowded": lambda: random_polyhedron(160, 7),
}
SYMMETRIES = {
    "cube": Rotation.create_group("O"),
    "brick": Rotation.create_group("D2"),
    "nut": Rotation.create_group("D6"),
}
"""Rotations that carry the part into itself, from a table of point groups."""


@cache
def part_of(name):
    vertices, triangles = SURFACES[name]()
    return part_from_mesh(np.asarray(vertices) * 1e-3, triangles)


def observed(name, rng, noise=NOISE, symmetric=True):
    """Poses (n,) drawn at random, and orientations (n, 4) as a camera with errors tells
    them.
    """
    poses = resting_poses(part_of(name)).poses
    pose = rng.integers(len(poses), size=MANY)
    true = Rotation.from_quat(
        np.array([resting_pose.orientation for resting_pose in poses])[pose]
    )
    if symmetric and name in SYMMETRIES:
        chosen = rng.integers(len(SYMMETRIES[name]), size=MANY)
        true = true * SYMMETRIES[name][chosen]
    yaw = Rotation.from_rotvec(
        np.outer(rng.uniform(0.0, 2.0 * np.pi, MANY), (0.0, 0.0, 1.0))
    )
    error = Rotation.from_rotvec(rng.normal(0.0, noise, (MANY, 3)))
    return pose, (error * yaw * true).as_quat()


@pytest.mark.parametrize("name", SURFACES)
def test_none_is_counted_wrong_at_five_degrees_of_noise(name):
    pose, measured = observed(name, np.random.default_rng(22))
    classification = classify_orientations(part_of(name), measured)
    group = np.array([pose_.group for pose_ in resting_poses(part_of(name)).poses])
    counted = classification >= 0
    assert (group[classification[counted]] == group[pose[counted]]).all()
    expected = WITHIN * (
        name != "crowded"
    )  # some of its poses are too close at this noise
    assert counted.mean() > expected - 4.0 * math.sqrt(WITHIN * (1.0 - WITHIN) / MANY)


@pytest.mark.parametrize("name", ["clamp", "cube", "brick", "gear"])
def test_the_very_pose_is_named_where_the_camera_chooses_no_equal_orientation(name):
    pose, measured = observed(name, np.random.default_rng(23), symmetric=False)
    classification = classify_orientations(part_of(name), measured)
    assert (classification[classification >= 0] == pose[classification >= 0]).all()


@pytest.mark.parametrize("name", ["cube", "nut"])
def test_an_equal_orientation_counts_for_the_pose_that_it_names(name):
    part = part_of(name)
    group = SYMMETRIES[name]
    for pose in resting_poses(part).poses:
        classification = classify_orientations(
            part, (Rotation.from_quat(pose.orientation) * group).as_quat()
        )
        alike = {
            member.index
            for member in resting_poses(part).poses
            if member.group == pose.group
        }
        assert set(classification.tolist()) == alike
        assert (
            np.bincount(classification)[sorted(alike)] == len(group) / len(alike)
        ).all()


@pytest.mark.parametrize("name", ["gear", "cylinder"])
def test_a_part_that_rolls_is_known_at_any_angle_of_its_roll(name):
    part = part_of(name)
    roll = Rotation.from_rotvec(
        np.outer(np.linspace(0.0, 2.0 * np.pi, 777), (0.0, 0.0, 1.0))
    )
    assert any(pose.rolls for pose in resting_poses(part).poses)
    for pose in resting_poses(part).poses:
        measured = (Rotation.from_quat(pose.orientation) * roll).as_quat()
        assert set(classify_orientations(part, measured).tolist()) == {pose.index}


def test_what_leans_too_far_is_no_pose():
    part = part_of("clamp")
    pose = resting_poses(part).poses[0]
    tilts = np.radians([0.0, 14.9, 15.1, 40.0])
    leaning = Rotation.from_rotvec(np.outer(tilts, (1.0, 0.0, 0.0)))
    measured = (leaning * Rotation.from_quat(pose.orientation)).as_quat()
    assert classify_orientations(part, measured).tolist() == [
        pose.index,
        pose.index,
        -1,
        -1,
    ]
    wider = classify_orientations(part, measured, math.radians(16.0))
    assert wider.tolist() == [pose.index, pose.index, pose.index, -1]


def test_poses_that_are_close_are_told_apart_by_a_good_camera_alone():
    """The densest part: at five degrees half is left out, at half a degree nothing."""
    name = "crowded"
    rng = np.random.default_rng(5)
    pose, measured = observed(name, rng, math.radians(0.5))
    classification = classify_orientations(part_of(name), measured, math.radians(1.5))
    counted = classification >= 0
    assert (classification[counted] == pose[counted]).all()
    assert counted.mean() > WITHIN - 4.0 * math.sqrt(WITHIN * (1.0 - WITHIN) / MANY)
    assert (classify_orientations(part_of(name), measured) < 0).mean() > 0.3


def test_a_die_on_its_edge_counts_for_the_nearer_face_if_that_is_asked_for():
    """All its poses are alike, so that none is in doubt."""
    part = part_of("cube")
    lowest = resting_poses(part).poses[0]
    edge = Rotation.from_rotvec((math.radians(44.0), 0.0, 0.0))
    (measured,) = (edge * Rotation.from_quat(lowest.orientation)).as_quat()[None]
    assert classify_orientations(part, [measured]).tolist() == [-1]
    assert classify_orientations(part, [measured], math.radians(90.0)).tolist() == [0]


def test_unknown_orientations_are_in_no_pose():
    part = part_of("brick")
    flat = resting_poses(part).poses[0].orientation
    rows = np.array(
        [
            flat,
            np.full(4, np.nan),
            np.zeros(4),
            (np.inf, 0.0, 0.0, 0.0),
            -flat,
            np.round(flat, 2),
        ]
    )
    assert classify_orientations(part, rows).tolist() == [0, -1, -1, -1, 0, 0]
    assert classify_orientations(part, []).tolist() == []
    assert classify_orientations(part, np.empty((0, 4))).dtype == np.int64


@pytest.mark.parametrize(
    ("orientations", "words"),
    [
        ([(0.0, 0.0, 0.0, 1.0), (0.0, 0.0, 0.0, 2.0)], "length 2 in row 1"),
        ([(1e300, 0.0, 0.0, 1e300)], "row 0"),
        ((0.0, 0.0, 0.0, 1.0), r"shape \(4,\)"),
        (np.zeros((2, 3)), r"shape \(2, 3\)"),
        ([("a", "b", "c", "d")], "x y z w"),
        ([(1.0, 2.0), (3.0,)], "x y z w"),
    ],
)
def test_what_is_no_unit_quaternion_or_angle_is_refused(orientations, words):
    with pytest.raises(PoseStatsError, match=words):
        classify_orientations(part_of("brick"), orientations)
    for angle in (0.0, -0.1, 15.0, math.nan, "wide", (0.1, 0.2)):
        with pytest.raises(PoseStatsError, match="radians"):
            classify_orientations(part_of("brick"), np.empty((0, 4)), angle)

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

"""Warnings and notes about poses that are close to changing, and about curves."""

import numpy as np
import pytest

from lab.bodies import exports, shapes
from lab.bodies.curved import cut_ball
from lab.bodies.samples import random_polyhedron
from ros_pose_stats import estimate, part_from_mesh, resting_poses, simulate


def warnings_of(part, tolerance=0.0, round_sides=0):
    answer = estimate(
        part, "csae", cluster_tolerance=tolerance, round_sides=round_sides
    )
    return {warning.code: warning.text for warning in answer.warnings}


def leaning(lean):
    """A prism whose bases stop being stable at a lean of 1; all edges differ."""
    base = np.array([(x, y, 0.0) for x in (-0.5, 0.5) for y in (-0.4, 0.4)])
    top = base + np.array((lean, 0.0, 1.5))
    return part_from_mesh(*shapes.hull_mesh(0.01 * np.vstack((base, top))))


def cylinder(sides):
    return part_from_mesh(*shapes.cylinder(sides, 0.01, 0.02))


@pytest.mark.parametrize(
    ("lean", "warned"), [(0.9, False), (0.99, True), (1.001, False)]
)
def test_a_face_about_to_be_lost_is_marginal(lean, warned):
    """The foot of the centre of mass is 0.5 (1 - lean) widths inside, 0.75 high."""
    warnings = warnings_of(leaning(lean))
    assert ("MARGINAL_POSE" in warnings) == warned
    if warned:
        tilt = np.degrees(np.arctan(0.5 * (1.0 - lean) / 0.75))
        poses = [
            pose.index
            for pose in resting_poses(leaning(lean), 0.0).poses
            if pose.margin < 0.0175
        ]
        assert f"poses {', '.join(map(str, poses))} topple" in warnings["MARGINAL_POSE"]
        assert f"{tilt:.2g} degrees" in warnings["MARGINAL_POSE"]


def test_the_roof_of_a_flat_ridge_is_shallow():
    points = [[x, y, z] for x in (-0.6, 0.6) for y in (-0.5, 0.5) for z in (0.0, 0.7)]
    points += [[x, 0.0, 0.71] for x in (-0.6, 0.6)]
    part = part_from_mesh(*shapes.hull_mesh(0.01 * np.array(points)))
    least = min(pose.barrier for pose in resting_poses(part, 0.0).poses)
    assert f"{1e3 * least:.2g} mm" in warnings_of(part)["SHALLOW_POSE"]
    assert warnings_of(part_from_mesh(*shapes.box(0.01, 0.01, 0.01))) == {}


@pytest.mark.parametrize(
    ("side", "warned"), [(1.0, False), (1.0005, True), (1.2, False)]
)
def test_saddles_nearly_as_high_as_each_other_are_a_near_tie(side, warned):
    part = part_from_mesh(*shapes.box(0.01, 0.02, 0.02 * side))
    assert ("NEAR_TIE" in warnings_of(part)) == warned


@pytest.mark.parametrize("tolerance", [0.0, 0.0025])
@pytest.mark.parametrize("sides", [48, 60, 400])
def test_facets_as_the_file_has_them(sides, tolerance):
    warnings = warnings_of(cylinder(sides), tolerance)
    assert (
        f"facets that turn by {360.0 / sides:.2g} degrees" in warnings["COARSE_CURVE"]
    )


@pytest.mark.parametrize(
    ("body", "turn"),
    [
        (exports.ellipse(48), "6.6"),
        (exports.ellipse(192), "1.7"),
        (cut_ball(2), "10"),
        (cut_ball(4), "2.7"),
        (exports.cylinder(48, 1.0), ""),
        (exports.gear(24), ""),
        (exports.screw(48), ""),
        (exports.filleted_box(64), ""),
        (random_polyhedron(220, 5), ""),
    ],
)
def test_curves_that_are_no_circles_depend_on_the_file(body, turn):
    warning = warnings_of(part_from_mesh(*body), 0.0025, 192).get("COARSE_CURVE", "")
    assert (
        not warning
        if not turn
        else (
            f"facets that turn by {turn} degrees" in warning
            and "by up to 10 points" in warning
        )
    )


@pytest.mark.parametrize(
    ("sides", "codes"),
    [
        (24, ["ROUNDED", "CLUSTERED"]),
        (600, ["ROUNDED", "CLUSTERED"]),
        (192, ["CLUSTERED"]),
    ],
)
def test_circles_are_given_the_sides_of_the_contract(sides, codes):
    warnings = warnings_of(cylinder(sides), 0.0025, 192)
    assert list(warnings) == codes
    if "ROUNDED" in warnings:
        assert (
            "2 round edges" in warnings["ROUNDED"]
            and "192 sides" in warnings["ROUNDED"]
        )


def test_drops_carry_them_too():
    statistics = simulate(leaning(0.999), 10, seed=1, cluster_tolerance=0.0)
    assert [(warning.code, warning.acts) for warning in statistics.warnings] == [
        ("MARGINAL_POSE", True),
        ("SHALLOW_POSE", False),
    ]

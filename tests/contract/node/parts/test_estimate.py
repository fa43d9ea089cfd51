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

"""`~/estimate` and `~/get_statistics`: which part, in which scene, with which
values.
"""

import math

import numpy as np
import pytest
from geometry_msgs.msg import Inertia, Vector3

from ros_pose_stats import estimate
from tests.answers import METHODS, notes

from ..harness.jobs import finished, known_part, start
from ..harness.parts import (
    WEDGE,
    flat,
    library_part,
    nested,
    new_id,
    probabilities,
    whole,
)

ROUNDING = 1e-12
"""Between two processes of this machine that compute the same."""


def assert_like_library(statistics, expected):
    """Every field that the library's answer has too."""
    for name in (
        "part_id",
        "part_digest",
        "method",
        "seed",
        "drops",
        "unsettled",
        "round_sides",
        "version",
        "scene",
    ):
        assert getattr(statistics, name) == getattr(expected, name), name
    assert notes(statistics) == notes(expected)
    for name in (
        "radius",
        "restitution",
        "drop_height",
        "cluster_tolerance",
        "expected_error",
        "largest_error",
        "plate_error",
    ):
        np.testing.assert_allclose(
            getattr(statistics, name), getattr(expected, name), ROUNDING, 0.0
        )
    for pose, twin in zip(statistics.poses, expected.poses, strict=True):
        assert pose.pose_id == f"{statistics.part_id}/{twin.index}"
        for name in ("index", "group", "count", "group_size", "yaw_symmetry", "rolls"):
            assert getattr(pose, name) == getattr(twin, name), name
        down = pose.down
        axis = pose.roll_axis
        turn = pose.pose.orientation
        np.testing.assert_allclose(
            (down.x, down.y, down.z), twin.down, ROUNDING, ROUNDING
        )
        np.testing.assert_allclose(
            (axis.x, axis.y, axis.z), twin.roll_axis, ROUNDING, ROUNDING
        )
        np.testing.assert_allclose(
            (turn.x, turn.y, turn.z, turn.w), twin.orientation, ROUNDING, ROUNDING
        )
        for name in (
            "height",
            "top",
            "margin",
            "barrier",
            "spread",
            "probability",
            "probability_low",
            "probability_high",
            "standard_error",
            "group_probability",
        ):
            np.testing.assert_allclose(
                getattr(pose, name), getattr(twin, name), ROUNDING, ROUNDING
            )
        np.testing.assert_allclose(
            np.reshape(pose.outline, (-1, 2)), twin.outline, ROUNDING, ROUNDING
        )
        np.testing.assert_allclose(
            np.reshape(pose.support_polygon, (-1, 2)),
            twin.support_polygon,
            ROUNDING,
            ROUNDING,
        )


class TestWhichPart:
    @pytest.mark.parametrize("make", [flat, nested])
    def test_a_carried_one_is_estimated_and_remembered(self, cell, make):
        part_id = new_id()
        answer = cell.good("estimate", part=make(WEDGE, part_id)).statistics
        assert (answer.part_id, answer.part_digest) == (
            part_id,
            library_part(WEDGE).digest,
        )
        (remembered,) = cell.good("get_statistics", part_id=part_id).statistics
        for repeated in (
            remembered,
            cell.good("estimate", part_id=part_id).statistics,
            cell.good("estimate", part=make(WEDGE, part_id)).statistics,
        ):
            assert whole(repeated) == whole(answer)
        assert part_id in {
            statistics_.part_id
            for statistics_ in cell.good("get_statistics").statistics
        }

    def test_a_name_beside_it(self, cell):
        part_id = new_id()
        for part in (flat(WEDGE), flat(WEDGE, part_id)):
            assert (
                cell.good("estimate", part_id=part_id, part=part).statistics.part_id
                == part_id
            )
        message = cell.refused("estimate", part_id="this", part=flat(WEDGE, "other"))
        assert "'this'" in message and "'other'" in message

    def test_nameless_ones_are_named_by_their_digest(self, cell):
        answer = cell.good("estimate", part=flat(WEDGE)).statistics
        assert answer.part_id == f"mesh_{answer.part_digest[:12]}"
        assert cell.good("estimate", part_id=answer.part_id).statistics

    def test_names_in_any_script(self, cell):
        answer = cell.good("estimate", part=flat(WEDGE, "Winkel 4×5 – 支架")).statistics
        assert answer.poses[0].pose_id.startswith("Winkel 4×5 – 支架/")

    @pytest.mark.parametrize(
        "service",
        ["estimate", "get_statistics", "forget_part", "start_drop_simulation"],
    )
    def test_unknown_ones_are_refused_with_some_that_are_known(self, cell, service):
        known_part(cell)
        message = cell.refused(service, part_id="nobody")
        assert (
            "'nobody'" in message and "known part (" in message and len(message) < 500
        )
        assert message.endswith(
            "; publish its mesh on /pose_stats/part_mesh, or send it to "
            "/pose_stats/estimate"
        )

    @pytest.mark.parametrize(
        "service", ["estimate", "forget_part", "start_drop_simulation"]
    )
    def test_none_at_all(self, cell, service):
        message = cell.refused(service)
        assert "part_id" in message or "''" in message


class TestValues:
    @pytest.mark.parametrize("method", METHODS)
    def test_are_those_of_the_library(self, cell, method):
        part_id = known_part(cell)
        statistics = cell.good("estimate", part_id=part_id, method=method).statistics
        assert_like_library(statistics, estimate(library_part(WEDGE, part_id), method))

    def test_and_the_node_says_when_and_where(self, cell):
        answer = cell.good("estimate", part=flat(WEDGE, new_id()))
        statistics = answer.statistics
        assert "split" in answer.message and "most accurate" in answer.message
        assert_like_library(
            statistics, estimate(library_part(WEDGE, statistics.part_id))
        )
        assert (statistics.header.frame_id, statistics.plate, statistics.job_id) == (
            "plate",
            "",
            "",
        )
        assert (
            statistics.final
            and statistics.revision > 0
            and statistics.header.stamp.sec > 0
        )
        assert statistics.compute_time.sec + statistics.compute_time.nanosec > 0

    @pytest.mark.parametrize(
        ("method", "words"),
        [
            ("guess", "combined"),
            ("simulation", "start a drop simulation"),
            ("hybrid", "auto with a target_error"),
        ],
    )
    def test_what_is_no_estimator_is_refused(self, cell, method, words):
        message = cell.refused("estimate", part_id=known_part(cell), method=method)
        assert f"'{method}'" in message and words in message


class TestScene:
    def test_request_before_part_before_node(self, cell):
        part_id = known_part(cell, restitution=0.3, drop_height=2.0)
        for fields, scene in (
            ({}, (0.3, 2.0)),
            ({"restitution": 0.1}, (0.1, 2.0)),
            ({"drop_height": 5.0}, (0.3, 5.0)),
            ({"restitution": 0.0, "drop_height": 4.0}, (0.0, 4.0)),
        ):
            statistics = cell.good("estimate", part_id=part_id, **fields).statistics
            dropped = finished(cell, start(cell, part_id, 50, **fields)).statistics
            assert (
                statistics.restitution,
                dropped.restitution,
                dropped.drop_height,
            ) == (
                scene[0],
                *scene,
            )

    def test_a_carried_part_brings_its_wishes(self, cell):
        part = flat(WEDGE, new_id(), restitution=0.3)
        assert cell.good("estimate", part=part).statistics.restitution == 0.3
        assert (
            cell.good("estimate", part=part, restitution=0.4).statistics.restitution
            == 0.4
        )

    @pytest.mark.parametrize("restitution", [-1.0, -0.001, -math.inf])
    def test_negative_is_the_nodes(self, cell, restitution):
        statistics = cell.good(
            "estimate", part_id=known_part(cell), restitution=restitution
        ).statistics
        assert statistics.restitution == 0.5

    @pytest.mark.parametrize(
        ("fields", "words"),
        [
            *[
                ({"restitution": value}, "below 1")
                for value in (1.0, math.nan, math.inf)
            ],
            *[
                ({"drop_height": value}, "above 0 m")
                for value in (0.0, math.nan, math.inf)
            ],
            *[({"target_error": value}, "below 1") for value in (-0.1, 1.0, math.nan)],
        ],
    )
    def test_out_of_range(self, cell, fields, words):
        ((_, value),) = fields.items()
        message = cell.refused("estimate", part_id=known_part(cell), **fields)
        assert str(value) in message and words in message


class TestMassProperties:
    def test_mass_centre_and_inertia_are_used(self, cell):
        tensor = [[3e-5, 1e-6, -2e-6], [1e-6, 4e-5, 5e-7], [-2e-6, 5e-7, 5e-5]]
        inertia = Inertia(
            m=0.4,
            com=Vector3(x=0.02, y=0.012, z=0.006),
            ixx=3e-5,
            iyy=4e-5,
            izz=5e-5,
            ixy=1e-6,
            ixz=-2e-6,
            iyz=5e-7,
        )
        part_id = new_id()
        statistics = cell.good(
            "estimate", part=flat(WEDGE, part_id, inertia=inertia)
        ).statistics
        expected = library_part(
            WEDGE,
            part_id,
            mass=0.4,
            center_of_mass=(0.02, 0.012, 0.006),
            inertia=tensor,
        )
        assert_like_library(statistics, estimate(expected))

    def test_the_centre_is_in_metres_whatever_the_unit(self, cell):
        inertia = Inertia(m=1.0, com=Vector3(x=0.02, y=0.012, z=0.006))
        part = flat(
            (1000.0 * WEDGE[0], WEDGE[1]), new_id(), unit=0.001, inertia=inertia
        )
        statistics = cell.good("estimate", part=part, method="split").statistics
        expected = estimate(
            library_part(WEDGE, mass=1.0, center_of_mass=(0.02, 0.012, 0.006)), "split"
        )
        assert statistics.radius == pytest.approx(expected.radius)
        assert probabilities(statistics.poses) == pytest.approx(
            probabilities(expected.poses)
        )

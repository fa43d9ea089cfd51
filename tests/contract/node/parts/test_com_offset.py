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

"""`~/estimate` for a part whose filling or insert moves its centre of mass."""

import math

import numpy as np
import pytest
from geometry_msgs.msg import Vector3

from ros_pose_stats import estimate, part_from_mesh, shift_center
from tests.running import refusal_of

from ..harness.cell import latched
from ..harness.jobs import known_part
from ..harness.listed import jobs_of, recorded_of
from ..harness.parts import (
    WEDGE,
    fine_box,
    flat,
    library_part,
    new_id,
    probabilities,
    whole,
)

OFFSET = (0.004, -0.002, 0.001)
STEP = Vector3(x=OFFSET[0], y=OFFSET[1], z=OFFSET[2])


def shifted(client, **fields):
    return client.good("estimate", com_offset=STEP, **fields).statistics


@pytest.mark.parametrize("method", ["", "meae"])
def test_the_answer_is_that_of_the_library(cell, method):
    part_id = known_part(cell)
    statistics = shifted(cell, part_id=part_id, method=method)
    expected = estimate(
        shift_center(library_part(WEDGE, part_id), OFFSET), method or "auto"
    )
    assert (statistics.part_id, statistics.part_digest, statistics.method) == (
        part_id,
        expected.part_digest,
        expected.method,
    )
    assert probabilities(statistics.poses) == pytest.approx(
        probabilities(expected.poses)
    )
    (warning,) = (
        warning for warning in statistics.warnings if warning.code == "COM_SHIFTED"
    )
    assert "4, -2 and 1 mm" in warning.text and not warning.acts


def test_given_mass_properties_stay(cell):
    plain = library_part(WEDGE, mass=0.3)
    part = flat(WEDGE, new_id())
    part.inertia.m = 0.3
    part.inertia.com = Vector3(
        **dict(zip("xyz", plain.center_of_mass.tolist(), strict=True))
    )
    expected = part_from_mesh(*WEDGE, plain.center_of_mass + np.array(OFFSET), 0.3)
    assert shifted(cell, part=part).part_digest == expected.digest


def test_a_large_part(cell):
    surface = fine_box(8000)
    part_id = new_id()
    plain = cell.good("estimate", part=flat(surface, part_id)).statistics
    statistics, repeated = (shifted(cell, part_id=part_id) for _ in range(2))
    expected = estimate(shift_center(library_part(surface, part_id), OFFSET))
    assert whole(statistics) == whole(repeated)
    assert statistics.part_digest == expected.part_digest != plain.part_digest
    assert probabilities(statistics.poses) == pytest.approx(
        probabilities(expected.poses)
    )


def test_the_part_stays_as_it_was_sent_and_nothing_is_latched(cell, shared_node):
    """The answer is in the bag, and is remembered; no drops follow."""
    part_id = new_id()
    statistics = shifted(cell, part=flat(WEDGE, part_id))
    cell.good("estimate", part_id=part_id)
    latched_before = latched(cell, part_id)
    assert (
        latched_before.part_digest
        == library_part(WEDGE).digest
        != statistics.part_digest
    )
    assert not any(warning.code == "COM_SHIFTED" for warning in latched_before.warnings)
    assert whole(shifted(cell, part_id=part_id)) == whole(statistics)
    missed = shifted(cell, part_id=part_id, target_error=0.0001).warnings
    assert any(
        warning.code == "TARGET_MISSED"
        and "send the part with this centre of mass" in warning.text
        for warning in missed
    )
    by_another_method = cell.good(
        "estimate", part_id=part_id, com_offset=Vector3(z=0.002)
    ).statistics
    assert by_another_method.part_digest != statistics.part_digest
    plain = cell.good("estimate", part_id=part_id, com_offset=Vector3()).statistics
    assert whole(plain) == whole(latched(cell, part_id)) == whole(latched_before)
    assert jobs_of(cell, part_id) == []
    assert whole(statistics) in map(whole, recorded_of(shared_node, "answers", part_id))
    results = recorded_of(shared_node, "pose_statistics", part_id)
    assert {result.part_digest for result in results} == {latched_before.part_digest}


@pytest.mark.parametrize("value", [math.nan, -math.inf])
def test_numbers_that_are_none_are_refused(cell, value):
    part_id = new_id()
    message = cell.refused(
        "estimate", part=flat(WEDGE, part_id), com_offset=Vector3(y=value)
    )
    assert "a shift of the centre of mass of three finite numbers in metres" in message
    assert part_id in cell.refused(
        "estimate", part_id=part_id
    )  # it was not taken either


def test_out_of_the_hull_it_is_refused_as_a_given_centre_is(cell):
    message = cell.refused(
        "estimate", part_id=known_part(cell), com_offset=Vector3(z=0.05)
    )
    beyond = library_part(WEDGE).center_of_mass + np.array((0.0, 0.0, 0.05))
    assert message == refusal_of(part_from_mesh, *WEDGE, beyond)

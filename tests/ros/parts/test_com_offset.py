"""`~/estimate` for a part whose filling or insert moves its centre of mass."""

from __future__ import annotations

import math

import numpy as np
import pytest
from geometry_msgs.msg import Vector3
from ros_pose_stats_msgs.msg import PartMesh

from ros_pose_stats import analyse_bags, estimate, part_from_mesh, shift_center
from ros_pose_stats.errors import MassPropertiesError

from ..harness.bags import recorded
from ..harness.cell import cell_of, latched
from ..harness.jobs import known_part
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


def shifted(part_id, **fields):
    return {"part_id": part_id, "com_offset": STEP, **fields}


@pytest.mark.parametrize("method", ["", "auto", "split", "meae"])
def test_the_answer_is_that_of_the_library(cell, method):
    part_id = known_part(cell)
    answer = cell.good("estimate", **shifted(part_id, method=method))
    expected = estimate(shift_center(library_part(WEDGE, part_id), OFFSET), method or "auto")
    found = answer.statistics
    assert (found.part_id, found.part_digest) == (part_id, expected.part_digest)
    assert found.method == expected.method
    assert probabilities(found.poses) == probabilities(expected.poses)
    (said,) = (one for one in found.warnings if one.startswith("COM_SHIFTED:"))
    assert "4, -2 and 1 mm" in said


def test_a_carried_part_is_remembered_as_it_was_sent(cell):
    part_id = new_id()
    found = cell.good("estimate", **shifted("", part=flat(WEDGE, part_id))).statistics
    plain = cell.good("estimate", part_id=part_id).statistics
    assert plain.part_digest == library_part(WEDGE).digest != found.part_digest
    assert not any(one.startswith("COM_SHIFTED:") for one in plain.warnings)


def test_nothing_is_latched(cell):
    part_id = known_part(cell)
    before = latched(cell, part_id)
    cell.good("estimate", **shifted(part_id))
    cell.good("estimate", **shifted(part_id, target_error=0.001))
    (now,) = cell.good("get_statistics", part_id=part_id).statistics
    assert whole(now) == whole(before)
    assert whole(latched(cell, part_id)) == whole(before)
    jobs = cell.call("list_drop_simulations")
    assert part_id not in jobs.part_id  # no drops of the part as it is known either


def test_it_is_remembered_like_other_answers(cell):
    part_id = known_part(cell)
    first, again = (cell.good("estimate", **shifted(part_id)).statistics for _ in range(2))
    assert whole(again) == whole(first)
    other = cell.good("estimate", part_id=part_id, com_offset=Vector3(z=0.002)).statistics
    assert other.part_digest != first.part_digest


def test_a_large_part(cell):
    """Its poses are found in a process of their own, for the shifted centre again."""
    surface, part_id = fine_box(8000), new_id()
    plain = cell.good("estimate", part=flat(surface, part_id)).statistics
    found = [cell.good("estimate", **shifted(part_id)).statistics for _ in range(2)]
    expected = estimate(shift_center(library_part(surface, part_id), OFFSET))
    assert whole(found[0]) == whole(found[1])
    assert found[0].part_digest == expected.part_digest != plain.part_digest
    assert probabilities(found[0].poses) == pytest.approx(probabilities(expected.poses))


def test_no_shift_is_the_part_itself(cell):
    part_id = known_part(cell)
    plain = cell.good("estimate", part_id=part_id).statistics
    assert whole(cell.good("estimate", part_id=part_id, com_offset=Vector3()).statistics) == whole(
        plain)


def test_a_missed_target_says_what_to_do(cell):
    found = cell.good("estimate", **shifted(known_part(cell), target_error=0.0001)).statistics
    (missed,) = (one for one in found.warnings if one.startswith("TARGET_MISSED:"))
    assert "send the part with this centre of mass" in missed


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_numbers_that_are_none_are_refused(cell, value):
    part_id = new_id()
    message = cell.refused("estimate", part=flat(WEDGE, part_id), com_offset=Vector3(y=value))
    assert "a shift of the centre of mass of three finite numbers in metres" in message
    assert part_id in cell.refused("estimate", part_id=part_id)  # it was not taken either


def test_out_of_the_hull_it_is_refused_as_a_given_centre_is(cell):
    part_id = known_part(cell)
    message = cell.refused("estimate", part_id=part_id, com_offset=Vector3(z=0.05))
    part = library_part(WEDGE)
    with pytest.raises(MassPropertiesError) as refused:
        part_from_mesh(*WEDGE, part.center_of_mass + np.array((0.0, 0.0, 0.05)))
    assert message == str(refused.value)


def test_given_mass_properties_stay(cell):
    part = flat(WEDGE, new_id())
    plain = library_part(WEDGE, mass=0.3)
    part.inertia.m = 0.3
    part.inertia.com = Vector3(**dict(zip("xyz", plain.center_of_mass.tolist(), strict=True)))
    assert isinstance(part, PartMesh)
    found = cell.good("estimate", **shifted("", part=part)).statistics
    expected = part_from_mesh(*WEDGE, plain.center_of_mass + np.array(OFFSET), 0.3)
    assert found.part_digest == expected.digest


def test_the_answer_is_in_the_bag_and_no_result(domain, tmp_path):
    with cell_of(domain, tmp_path, "shifting") as (node, client):
        client.good("estimate", part=flat(WEDGE, "wedge"))
        found = client.good("estimate", **shifted("wedge")).statistics
        node.assert_sound()
    answers = recorded(tmp_path, "answers")
    assert [one.part_digest for one in answers].count(found.part_digest) == 1
    assert any(whole(one) == whole(found) for one in answers)
    assert {one.part_digest for one in recorded(tmp_path, "pose_statistics")} == {
        library_part(WEDGE).digest}
    parts = analyse_bags([tmp_path]).parts
    assert {one.record.part_digest for one in parts} == {
        library_part(WEDGE).digest, found.part_digest}

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

"""`~/fit_plate`: counts in, a profile in the file of plates, results of that scene
out.
"""

import numpy as np
import yaml

from lab.bodies import shapes
from ros_pose_stats import simulate

from ..harness.camera import counted, counting, learnt
from ..harness.cell import latched
from ..harness.client import until
from ..harness.parts import flat, library_part, new_id

BOXES = {
    "flat": shapes.box(0.020, 0.016, 0.012),
    "bar": shapes.box(0.030, 0.010, 0.020),
}
TRUTH = 0.25, 0.12
"""Restitution and drop height of the plate that is counted on."""

FITTED = [
    name + end
    for name in ("restitution", "drop_height")
    for end in ("", "_low", "_high")
]


def model_of(client, surface, part_id):
    return client.good("estimate", part=flat(surface, part_id)).statistics


def count_boxes(client, parts):
    """What a camera counts of both on the true plate; the node has learnt from it."""
    for seed, (name, surface) in enumerate(BOXES.items(), start=1):
        dropped = simulate(
            library_part(surface), parts, TRUTH[0], seed, TRUTH[1], workers=1
        )
        numbers = {pose.index: pose.count for pose in dropped.poses}
        model = model_of(client, surface, name)
        counting(client).publish(
            counted(model, [numbers[pose.index] for pose in model.poses])
        )
        learnt(client, name, parts)


class TestRefusals:
    def test_without_counts(self, tuned):
        assert "none" in tuned.refused("fit_plate")
        assert "on plate 'oak', got none" in tuned.refused("fit_plate", plate="oak")

    def test_with_too_few_or_those_of_another_plate(self, tuned):
        tuned.set(plate="glass")
        model = model_of(tuned, BOXES["flat"], new_id())
        counting(tuned).publish(counted(model, [1, 2, 3, 4, 5, 6]))
        learnt(tuned, model.part_id, 21)
        assert "got 21; count 29 more" in tuned.refused("fit_plate", plate="glass")
        message = tuned.refused("fit_plate", plate="oak")
        assert "on plate 'oak', got only those on 'glass'" in message

    def test_with_nowhere_to_write_or_no_name(self, tuned, tmp_path):
        model = model_of(tuned, BOXES["flat"], new_id())
        counting(tuned).publish(counted(model, [100] * 6))
        learnt(tuned, model.part_id, 600)
        assert "parameter plates" in tuned.refused(
            "fit_plate", plate="glass", apply=True
        )
        tuned.set(plates=str(tmp_path / "plates.yaml"))
        assert "a plate's name" in tuned.refused("fit_plate", apply=True)


def test_a_plate_is_learnt_written_and_used(tuned, tmp_path):
    file = tmp_path / "plates.yaml"
    tuned.set(plates=str(file))
    count_boxes(tuned, 400)
    latched_before = latched(tuned, "bar")
    answer = tuned.good("fit_plate", plate="glass", apply=True)
    assert (answer.counted, sorted(answer.parts)) == (800, sorted(BOXES))
    profile = yaml.safe_load(file.read_text())["plates"]["glass"]
    for name in (*FITTED, "plate_error", "p_value"):
        np.testing.assert_allclose(profile[name], getattr(answer, name))
    assert (profile["counted"], profile["parts"]) == (800, list(answer.parts))
    for name in BOXES:
        statistics = until(
            lambda name=name: (
                (candidate := latched(tuned, name)).plate == "glass" and candidate
            )
        )
        assert (statistics.restitution, statistics.drop_height) == (
            answer.restitution,
            answer.drop_height,
        )
        assert (statistics.method, statistics.counted_parts) == ("observed", 400)
        assert (
            statistics.plate_error < answer.plate_error
        )  # surer than its plate alone makes it
    assert latched(tuned, "bar").revision > latched_before.revision
    assert (
        tuned.good("estimate", part_id="bar").statistics.plate_error
        == answer.plate_error
    )


def test_a_fit_that_cannot_be_written_is_refused_and_known_all_the_same(
    tuned, tmp_path
):
    (tmp_path / "a file").touch()
    tuned.set(plates=str(tmp_path / "a file" / "plates.yaml"))
    model = model_of(tuned, BOXES["flat"], new_id())
    counting(tuned).publish(counted(model, [40, 40, 20, 20, 5, 5]))
    learnt(tuned, model.part_id, 130)
    answer = tuned.call("fit_plate", plate="glass", apply=True)
    assert not answer.success and "can be written (parameter plates)" in answer.message
    assert (
        answer.counted == 130
        and 0.0 <= answer.restitution_low <= answer.restitution < 1.0
    )
    assert latched(tuned, model.part_id).plate == ""

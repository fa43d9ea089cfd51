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

"""Fitted plates, judged by parts that were not counted."""

import pytest

from ros_pose_stats import simulate
from ros_pose_stats.core.plates import count_part
from study.plates.friction import study_parts
from study.plates.runs import METHODS, judge_plate

DROPS = 4000


@pytest.mark.long
def test_on_a_plate_that_is_the_model_the_default_answer_is_within_two_points():
    """Its drops are those of the model in the default scene; the estimate errs more."""
    counted = []
    for part in study_parts():
        statistics = simulate(part, DROPS, seed=9)
        counts = {pose.index: pose.count for pose in statistics.poses}
        counted.append(count_part(part, counts))
    judged = judge_plate("the model", counted, 200, 2, (1,), lambda _: None)
    assert set(judged.errors) == set(METHODS)
    assert judged.errors["default + drops"] < 0.02
    assert judged.errors["default + drops"] < judged.errors["default"]
    assert judged.errors["best scene"] <= judged.errors["default"]

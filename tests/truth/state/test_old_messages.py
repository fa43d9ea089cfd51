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

"""What version 0.2.0 wrote into a state or a catalogue is read as today."""

import pytest
from rclpy.serialization import deserialize_message
from ros_pose_stats_msgs.msg import Code, JobEvent, JobStatus, PoseStatistics

from ros_pose_stats.node.recorder import convert_to_installed
from ros_pose_stats.node.recording.reader import read_messages
from ros_pose_stats.tools.catalogue import store
from tests.answers import notes
from tests.contract.bags.test_versions import (
    NOTES_OF_0_2,
    events_of_0_2,
    result_of_0_2,
)


def of_today(file, kind):
    """The messages of a bag as a state of today has them."""
    return [
        deserialize_message(
            convert_to_installed(kind.__name__, message.definition, message.data), kind
        )
        for message in read_messages(file, pytest.fail, lambda share: None)
    ]


def test_events_have_the_status_of_their_simulation(tmp_path):
    queued, _, failed, forgotten = of_today(events_of_0_2(tmp_path), JobEvent)
    assert queued.status == JobStatus(
        job_id="job_1", part_id="clamp", state=JobStatus.QUEUED, drops_total=9
    )
    assert (failed.status.state, failed.status.code) == (
        JobStatus.FAILED,
        Code.INTERNAL,
    )
    assert (failed.message, failed.seed, failed.part_digest) == ("no", 7, "d")
    assert forgotten.part_forgotten and not failed.part_forgotten


def test_sentences_become_notes(tmp_path):
    (message,) = of_today(result_of_0_2(tmp_path), PoseStatistics)
    assert notes(message) == NOTES_OF_0_2
    assert [pose.index for pose in message.poses] == [1, 0]


def test_sentences_in_rows_of_a_catalogue_are_notes():
    row = {"warnings": ["LOW_DROP: released low.", "UNIT_GUESSED: in mm."]}
    assert store.notes_of(row) == [
        ("LOW_DROP", "released low.", True),
        ("UNIT_GUESSED", "in mm.", True),
    ]
    assert [str(doubt) for doubt in store.doubts_of(row)] == ["LOW_DROP: released low."]

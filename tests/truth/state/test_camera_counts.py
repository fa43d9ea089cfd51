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

"""Messages of cameras are taken many at a time, and each once."""

from unittest.mock import MagicMock, Mock

from ros_pose_stats_msgs.msg import PoseCounts

from ros_pose_stats.node import camera_counts


def waiting(messages):
    """A subscription for which messages wait in the middleware."""
    queue = iter([*messages, None, None])
    return MagicMock(handle=MagicMock(take_message=lambda *_: next(queue)))


def message(number):
    """A message, and what the middleware says of it."""
    return b"%d" % number, {
        "publication_sequence_number": number,
        "source_timestamp": number,
        "reception_sequence_number": number,
    }


def test_what_waits_for_both_subscriptions_is_taken_together_and_once(monkeypatch):
    """A reliable camera's messages come by both, a best-effort camera's by one."""
    monkeypatch.setattr(camera_counts.time, "sleep", lambda seconds: None)
    subscriptions = [
        waiting([message(2), message(3)]),
        waiting([message(1), message(2), message(3), message(7)]),
    ]
    node = Mock(create_subscription=Mock(side_effect=subscriptions))
    refusals = Mock(count_lost=Mock(return_value=0))
    batches = []
    subscription = camera_counts.BatchSubscription(
        Mock(node=node, refusals=refusals),
        PoseCounts,
        "pose_counts",
        "counts",
        batches.append,
    )
    take = node.create_subscription.call_args_list[0].args[2]
    take(*message(1))
    subscription.take_waiting()
    assert batches == [[b"1", b"2", b"3", b"7"]]

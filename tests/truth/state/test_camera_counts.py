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

import itertools
import threading
from concurrent.futures import Future
from unittest.mock import MagicMock, Mock

import pytest
from rclpy.serialization import serialize_message
from ros_pose_stats_msgs.msg import PoseCounts

from ros_pose_stats.node import camera_counts


def message(number):
    """A message, and what the middleware says of it."""
    return b"%d" % number, {
        "publication_sequence_number": number,
        "source_timestamp": number,
        "reception_sequence_number": number,
    }


class Camera:
    """Subscriptions for which messages wait in the middleware."""

    def __init__(self, reliable, unreliable, hand_over):
        self.callbacks = []
        self.subscriptions = []
        self._waiting = [iter(reliable), iter(unreliable)]
        self.batches = camera_counts.BatchSubscription(
            Mock(
                node=Mock(create_subscription=self._subscribe),
                refusals=Mock(count_lost=Mock(return_value=0)),
            ),
            PoseCounts,
            "pose_counts",
            "counts",
            hand_over,
        )

    def _subscribe(self, kind, name, callback, profile, *, callback_group, **_):
        waiting = self._waiting[len(self.callbacks)]
        subscription = MagicMock()
        subscription.handle.take_message = lambda *_: next(waiting, None)
        callback_group.add_entity(subscription)
        self.callbacks.append(callback)
        self.subscriptions.append(subscription)
        self.group = callback_group
        return subscription


def test_what_waits_for_both_subscriptions_is_taken_together_and_once():
    """A reliable camera's messages come by both, a best-effort camera's by one."""
    batches = []
    camera = Camera(
        [message(2), message(3)], map(message, (1, 2, 3, 7)), batches.append
    )
    camera.callbacks[0](*message(1))
    assert batches == [[b"1", b"2", b"3", b"7"]]


def test_what_a_callback_has_taken_comes_before_what_is_taken_at_the_end(monkeypatch):
    batches = []
    camera = Camera([message(2)], [], batches.append)
    subscription = camera.subscriptions[0]
    # As the executor does it, before it takes the message.
    begin = camera.group.beginning_execution
    assert begin(subscription)
    is_refused = threading.Event()

    def begin_at_the_end(subscription):
        has_begun = begin(subscription)
        if not has_begun:
            is_refused.set()
        return has_begun

    monkeypatch.setattr(camera.group, "beginning_execution", begin_at_the_end)
    end = threading.Thread(target=camera.batches.take_last)
    end.start()
    assert is_refused.wait(60.0)
    camera.callbacks[0](*message(1))
    camera.group.ending_execution(subscription)
    end.join(60.0)
    assert batches == [[b"1", b"2"]]
    # And no callback comes any more.
    assert not camera.group.can_execute(subscription)


def test_the_end_does_not_wait_for_a_camera_that_goes_on():
    batches = []
    camera = Camera(map(message, itertools.count()), [], batches.append)
    camera.batches.take_last()
    assert sum(map(len, batches)) > camera_counts.DEPTH


@pytest.mark.filterwarnings(
    "ignore::DeprecationWarning"
)  # of a library that reads messages
def test_a_count_has_its_mesh_before_it_in_the_bag_also_at_the_end():
    """The lane that reads meshes is closed by then."""
    events = []
    cancelled = Future()
    cancelled.cancel()
    part = Mock(
        introduce=lambda: events.append("mesh"),
        once_introduced=lambda act: cancelled,
        lock=threading.Lock(),
        latched=None,
    )
    node = Mock()
    node.create_subscription.return_value.handle = MagicMock()
    node.create_subscription.return_value.handle.take_message.return_value = None
    recorder = Mock(record=lambda topic, data: events.append("count"))
    camera_counts.Cameras(
        Mock(node=node, recorder=recorder), Mock(current=lambda _: part), Mock()
    )
    callback = node.create_subscription.call_args_list[2].args[2]
    callback(serialize_message(PoseCounts(part_id="clamp")), message(1)[1])
    assert events == ["mesh", "count"]

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

"""The collector of garbage keeps all threads waiting while it looks at objects."""

import gc
import weakref
from unittest.mock import Mock

import pytest
from rclpy import executors

from ros_pose_stats.node import node


class Loaded(list):
    """Stands for the modules and kernels that a start loads."""


@pytest.fixture
def executor(monkeypatch):
    executor = Mock()
    monkeypatch.setattr(executors, "MultiThreadedExecutor", lambda **_: executor)
    yield executor
    gc.unfreeze()


def test_once_a_node_answers_the_collector_looks_at_nothing_of_its_start(executor):
    """And what the start no longer needs was collected before."""
    lasting = []
    references = []

    def start():
        lasting.append(Loaded())
        garbage = Loaded()
        garbage.append(garbage)
        references.append(weakref.ref(garbage))

    def answer(_):
        seen.append([thing for thing in gc.get_objects() if type(thing) is Loaded])
        kept.append(references[0]() is not None)

    seen = []
    kept = []
    executor.add_node.side_effect = answer
    starting_node = Mock(start=start)
    starting_node.intake.restored = []
    node.Life(starting_node, Mock(is_requested=False))._live()
    assert seen == [[]] and kept == [False]

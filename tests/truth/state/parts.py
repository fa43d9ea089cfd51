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

"""Parts of a node that is not there, and what they work with."""

from types import SimpleNamespace
from unittest.mock import Mock

from ros_pose_stats.node.equipment import Equipment
from ros_pose_stats.node.memory import Memory
from ros_pose_stats.node.parts.channel import Channel
from ros_pose_stats.node.parts.known_part import Commons, KnownPart
from ros_pose_stats.node.parts.part_source import PartSource

NODE_SCENE = (-1.0, -1.0)  # of a part that has no scene of its own


def equipment_of(lanes=None, state=None, node=None, **settings):
    return Equipment(
        node or Mock(), lambda: SimpleNamespace(**settings), state, None, Mock(), lanes
    )


def source_of(build):
    """A source whose part stays in memory once it is built, of a state without it."""
    state = Mock(mesh=lambda part_id: None)
    return PartSource(Memory(1), ("clamp", b""), lambda _: build(), state)


def known_part(source, equipment=None, part_id="clamp"):
    equipment = equipment or equipment_of()
    commons = Commons(equipment, list)
    channel = Channel(equipment, list)
    return KnownPart(commons, channel, part_id, "", b"", NODE_SCENE, source)

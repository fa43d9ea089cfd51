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

"""What most owners in the node work with, made before any of them."""

from collections.abc import Callable
from typing import Any, NamedTuple

from ros_pose_stats_msgs.msg import Code, PoseStatistics

from ..core.records.notes import Note, note
from .answering_node import AnsweringNode
from .lanes import Lanes
from .messages.statistics_messages import is_recorded, with_warning
from .recorder import Recorder
from .refusals import Refusals
from .settings import Settings
from .state import State


def unrecorded_note(reason: str) -> Note:
    """The warning of what could not be written down."""
    return note("NOT_RECORDED", f"this could not be written down: {reason}.")


class Equipment(NamedTuple):
    """It is handed to each of them as it is; `settings` gives the present ones."""

    node: AnsweringNode
    settings: Callable[[], Settings]
    state: State
    recorder: Recorder
    refusals: Refusals
    lanes: Lanes

    def not_recorded(self) -> Note:
        """The warning of an answer that is not in the bag, or not in the state."""
        return unrecorded_note(self.state.problem or self.recorder.last_problem)

    def warn_unrecorded(self, message: PoseStatistics) -> PoseStatistics:
        """The same with the warning that it is not on record, which it has once."""
        if not is_recorded(message):
            return message
        return with_warning(message, self.not_recorded())

    def say_unrecorded(self, response: Any) -> None:
        """Say in a response that what was asked for is done, but not on record."""
        response.code = Code.NOT_RECORDED
        response.message = f"{response.message} {self.not_recorded()}".lstrip()

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

"""Results of a part as messages: numbered, labelled with the plate, remembered."""

import copy
from collections.abc import Callable
from dataclasses import replace

from ros_pose_stats_msgs.msg import PoseStatistics
from std_msgs.msg import Header

from ...base import methods
from ...core import records
from ...core.records import DropScene
from ..memory import Memory
from ..messages import statistics_messages
from ..settings import Settings

REMEMBERED_POSES = 20_000  # of results, for parts and scenes that come again; 2 kB each

BEST = "best"  # of all that came for a scene; latched at once where it is the part's
CHECKED = "checked"  # the default estimate with some drops beside it, the usual answer
TRIED = "tried"  # the end of the last job

ResultKey = tuple[str, str, str, DropScene, str, float, str]
ResultMemory = Memory[ResultKey, PoseStatistics]


def memory_of_results() -> ResultMemory:
    """What came of all parts."""
    return Memory(REMEMBERED_POSES, lambda message: len(message.poses))


class PartResults:
    """Results of one mesh under a name, by their scene and role.

    A role is `BEST`, `CHECKED`, `TRIED` or the method of an estimate.
    """

    def __init__(
        self,
        memory: ResultMemory,
        settings: Callable[[], Settings],
        next_revision: Callable[[], int],
        part_id: str,
        digest: str,
    ) -> None:
        self._memory = memory
        self._settings = settings
        self._next_revision = next_revision
        self._part_id = part_id
        self._digest = digest

    def get(self, role: str, scene: DropScene) -> PoseStatistics | None:
        """The result of a role in a scene; None if there is none."""
        return self._memory.get(self._key(role, scene))

    def put(self, role: str, scene: DropScene, message: PoseStatistics) -> None:
        """Remember a result in place of the one before."""
        self._memory.put(self._key(role, scene), message)

    def put_final(self, scene: DropScene, message: PoseStatistics) -> None:
        """Remember a result that nothing refines, as the best if it is that."""
        if message.job_id:
            self.put(TRIED, scene, message)
        best = self.get(BEST, scene)
        if best is None or statistics_messages.replaces(message, best):
            self.put(BEST, scene, message)

    def put_restored(self, scene: DropScene, model: PoseStatistics) -> None:
        """Remember the model behind what an earlier run has latched."""
        self.put(BEST, scene, model)
        if not model.job_id:
            self.put(CHECKED if model.drops else model.method, scene, model)

    def _key(self, role: str, scene: DropScene) -> ResultKey:
        settings = self._settings()
        return (
            role,
            self._part_id,
            self._digest,
            scene,
            settings.plate,
            settings.plate_error,
            settings.plate_frame,
        )

    def number(
        self,
        statistics: records.PoseStatistics,
        settings: Settings,
        job_id: str = "",
        final: bool = True,
    ) -> PoseStatistics:
        """Make the message of a new result, with the error of the settings' plate."""
        if statistics.method != methods.OBSERVED:
            statistics = replace(statistics, plate_error=settings.plate_error)
        return statistics_messages.statistics_message(
            statistics,
            settings.plate_frame,
            plate=settings.plate,
            revision=self._next_revision(),
            job_id=job_id,
            final=final,
        )

    def relabel(self, settings: Settings, message: PoseStatistics) -> PoseStatistics:
        """The same with the present frame and plate, which an observed one has."""
        labels = (message.plate, message.header.frame_id, message.plate_error)
        if message.method == methods.OBSERVED or labels == (
            settings.plate,
            settings.plate_frame,
            settings.plate_error,
        ):
            return message
        twin = copy.copy(message)
        twin.header = Header(stamp=message.header.stamp, frame_id=settings.plate_frame)
        twin.plate = settings.plate
        twin.plate_error = settings.plate_error
        twin.revision = self._next_revision()
        return twin

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

"""A state as a killed node has left it, and what a node on a copy of it shows."""

import atexit
import shutil
import tempfile
import time
from functools import cache
from pathlib import Path

from ros_pose_stats import estimate
from tests.contract.node.harness import parts
from tests.contract.node.harness.camera import counted, counting, learnt
from tests.contract.node.harness.cell import cell_of
from tests.contract.node.harness.client import CANCELLED
from tests.contract.node.harness.jobs import finished, start
from tests.contract.node.harness.parts import fine_box, flat, library_part

from ..cell import domain
from .kills import sound
from .ledger import BOXES

NAME = "pose_stats.sqlite3"
SURFACES = {
    **{f"box_{number}": surface for number, surface in enumerate(BOXES)},
    "fine": fine_box(6000),
}

SECONDS_TO_CHECK = 20.0
"""In which a node has checked the estimates whose results got lost."""


class Original:
    """A state with parts, counts and a job, as a killed node has left it, and what it
    showed.
    """

    def __init__(self, folder):
        self.folder = folder / "original"
        with self.cell(folder / "bags", self.folder / NAME) as (node, client):
            self.shown = {}
            self.before = []
            for act in (self._send, self._drop, self._count):
                act(client)
                self.before.append(self.shown)
                time.sleep(1.5)  # all is committed by then
                self.shown = numbers_of(client)
            node.kill()
        self.csae = {
            name: parts.probabilities(estimate(library_part(surface), "csae").poses)
            for name, surface in SURFACES.items()
        }

    @staticmethod
    def _send(client):
        for name, surface in SURFACES.items():
            client.good("estimate", part=flat(surface, name), method="csae")

    def _drop(self, client):
        self.job = start(client, "box_1", 500, seed=3)
        self.done = str(finished(client, self.job).statistics)

    @staticmethod
    def _count(client):
        model = learnt(client, "box_0", 0)
        counting(client).publish(counted(model, [3, 4, 5, 6, 7, 8]))
        learnt(client, "box_0", 33)

    @staticmethod
    def cell(bags, file, **values):
        """A node on a state file."""
        return cell_of(domain(), bags, "damaged", state_file=file, workers=1, **values)

    def copy(self, folder):
        """The file, its log and its meshes once more; the file."""
        shutil.rmtree(folder, ignore_errors=True)
        shutil.copytree(self.folder, folder)
        return folder / NAME

    def start(self, folder, file, whole=False):
        """Start a node on a file: what is wrong with it, and how many parts it knows.

        `whole`: everything is to be there; else also what was shown earlier, since a
        log that is damaged in the middle ends there.
        """
        with self.cell(folder / "bags", file) as (node, client):
            wrong = self._wrong(client, whole)
            part_count = len(client.call("get_statistics").statistics)
            node.stop()
            wrong += sound(node)
        return wrong, part_count

    def _unlike(self, present):
        """What is shown of parts as it never was."""
        return [
            f"{name} shows {numbers}, and showed {self.shown.get(name)}"
            for name, numbers in present.items()
            if numbers
            not in [earlier.get(name) for earlier in (self.shown, *self.before)]
        ]

    def _wrong(self, client, whole):
        end = time.monotonic() + SECONDS_TO_CHECK
        while self._unlike(present := numbers_of(client)) and time.monotonic() < end:
            time.sleep(0.1)
        wrong = self._unlike(present)
        for name in present:
            answer = client.call("estimate", part_id=name, method="csae")
            if answer.success:
                if parts.probabilities(answer.statistics.poses) != self.csae[name]:
                    wrong.append(
                        f"{name} is another part: {answer.statistics.part_digest}"
                    )
            elif whole or (
                "send the part again" not in answer.message
                and name in numbers_of(client)
            ):  # else it has gone meanwhile
                wrong.append(f"{name}: {answer.message}")
        job = client.call("get_drop_simulation", job_id=self.job)
        if (
            job.success
            and str(job.statistics) != self.done
            and (whole or job.status.state != CANCELLED or job.statistics.drops)
        ):
            wrong.append(f"the job has another result: {job.statistics}")
        if whole and not (present == self.shown and job.success):
            wrong.append(
                f"{len(present)} of {len(self.shown)} parts, job: {job.message}"
            )
        return wrong


@cache
def killed_state():
    """The same for all trials of this program, which change copies of it alone."""
    folder = tempfile.TemporaryDirectory(prefix="trial_original_")
    atexit.register(folder.cleanup)
    return Original(Path(folder.name))


def numbers_of(client):
    """What is shown of each part, but for its time and revision."""
    return {
        statistics.part_id: (
            statistics.part_digest,
            statistics.method,
            statistics.counted_parts,
            statistics.drops,
            sorted(
                (pose.index, pose.count, pose.probability) for pose in statistics.poses
            ),
        )
        for statistics in client.call("get_statistics").statistics
    }

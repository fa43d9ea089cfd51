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

"""A start with as many parts as a node may know."""

import time

from ros_pose_stats import estimate
from tests.contract.node.harness import parts
from tests.contract.node.harness.bags import size_of
from tests.contract.node.harness.parts import fine_box, flat, library_part
from tests.contract.node.harness.transports import LOOPBACK

from ..cell import MEGABYTE, Client, domain, forget_peak, status
from ..frame import Outcome, Setting, judged
from ..soak.life import NodeProcess

PARTS = 256
TOGETHER = 2**30
READY_SECONDS = 3.0
ASKED = 8
PART_BYTES = 24
"""Of a triangle in a message: half a vertex of 24 bytes and three indices of 4."""


def a_start_with_all_parts(setting: Setting) -> Outcome:
    """256 known parts of 1 GiB together: ready in 3 s, and requests about them
    answered.
    """
    number = setting.of(PARTS, 6)
    surface = fine_box(TOGETHER / PARTS / PART_BYTES)
    surfaces = [((1.0 + 0.001 * k) * surface[0], surface[1]) for k in range(number)]
    state = setting.folder / "state"

    def begin():
        return NodeProcess(
            setting.folder / "bags",
            "-r",
            "__ns:=/many",
            max_parts=PARTS,
            state_file=state / "many.sqlite3",
            max_part_bytes=2**33,
            environment={**LOOPBACK, "ROS_DOMAIN_ID": str(domain())},
        )

    with Client(domain(), "/many/pose_stats") as client:
        with begin() as node:
            node.ready()
            for k, surface in enumerate(surfaces):
                client.good("estimate", part=flat(surface, f"part_{k}"), method="csae")
        size = size_of(state)
        seconds = []
        peaks = []
        wrong = []
        for _ in range(2):
            time.sleep(1.0)
            began = time.monotonic()
            with begin() as node:
                node.ready()
                seconds.append(time.monotonic() - began)
                forget_peak(node)
                wrong += _answers(client, surfaces)
                peaks.append(status(node, "VmHWM"))
        added = size_of(state) - size
    return judged(
        number,
        f"{size / MEGABYTE:.0f} MiB of state; ready in "
        f"{' and '.join(f'{time_taken:.1f}' for time_taken in seconds)} s"
        f"{'' if setting.judges_times else ' (not judged)'}; at most "
        f"{' and '.join(f'{peak / MEGABYTE:.0f}' for peak in peaks)} MiB of memory; "
        f"{added} bytes more after two starts; wrong: {wrong}",
        ready_in_time=min(seconds) < READY_SECONDS or not setting.judges_times,
        all_are_answered=not wrong,
        a_start_adds_nothing=added < 0.01 * size,
    )


def _answers(client, surfaces):
    """Which of some parts are not as the library has them, or not known."""
    latched = {
        statistics.part_id for statistics in client.good("get_statistics").statistics
    }
    wrong = [
        f"part_{k} is not shown"
        for k in range(len(surfaces))
        if f"part_{k}" not in latched
    ]
    for k in range(0, len(surfaces), max(1, len(surfaces) // ASKED)):
        answer = client.call("estimate", part_id=f"part_{k}", method="csae")
        expected = estimate(library_part(surfaces[k]), "csae").poses
        if parts.probabilities(answer.statistics.poses) != parts.probabilities(
            expected
        ):
            wrong.append(f"part_{k}: {answer.message or 'another result'}")
    return wrong

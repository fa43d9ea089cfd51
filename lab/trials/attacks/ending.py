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

"""Signals, clocks, floods of counts, and disks that fill."""

import time
from pathlib import Path

from ros_pose_stats_msgs.msg import PoseCounts

from lab.bodies.slow import smooth_body
from tests.contract.node.harness.bags import recorded, size_of
from tests.contract.node.harness.client import until
from tests.contract.node.harness.parts import fine_box

from ..cell import (
    ENDINGS,
    WEDGE,
    Health,
    MeshPublisher,
    end,
    flat,
    latched,
    quiet,
    tried_node,
)
from ..frame import Outcome, Setting, judged

ENDING = 2.0
"""Seconds within which a node ends, also in the middle of a long estimate."""


def _paced(messages, rate):
    """Messages at a rate."""
    begin = time.monotonic()
    for number, message in enumerate(messages, 1):
        yield message
        time.sleep(max(0.0, begin + number / rate - time.monotonic()))


def size_of_bags(folder: Path) -> int:
    """Bytes of all runs; the state beside them has bounds of its own."""
    return sum(size_of(run) for run in folder.glob("pose_stats_*"))


def a_disk_that_fills(setting: Setting) -> Outcome:
    """Fifty new meshes of 30 kB a second, of one part, with a bound of 1 MB on all
    bags, whose closed files are compressed.
    """
    bound = 1_000_000
    number = setting.of(750, 300)
    largest = 0
    vertices, triangles = fine_box(1200)
    with tried_node(setting.folder, max_log_bytes=bound) as (_, client):
        publisher = MeshPublisher(client).matched()
        health = Health(client)
        for message in _paced(
            (
                flat((vertices * (1.0 + 1e-3 * k), triangles), "grows")
                for k in range(number)
            ),
            50.0,
        ):
            publisher.publish(message)
            largest = max(largest, size_of_bags(setting.folder))
        latched(client, "grows")
        quiet(health)
        deleted = int(health.line("recording")[1]["deleted for max_log_bytes"])
        size_at_end = size_of_bags(setting.folder)
    return judged(
        number,
        f"{largest / 1e6:.1f} MB at most for a bound of {bound / 1e6:.1f}, "
        f"{size_at_end / 1e6:.1f} in the end, {deleted} files deleted",
        the_bound_is_reached=deleted > 0,
        the_bound_holds_in_the_end=size_at_end <= bound,
        more_is_soon_gone=largest <= 1.25 * bound,
    )


def a_flood_of_counts(setting: Setting) -> Outcome:
    """Four thousand camera counts, two thousand a second."""
    number = setting.of(4000, 2000)
    with tried_node(setting.folder) as (_, client):
        statistics = client.good("estimate", part=flat(WEDGE, "counted")).statistics
        camera = MeshPublisher(
            client, f"{client.prefix}/pose_counts", PoseCounts
        ).matched()
        health = Health(client)
        for message in _paced(
            (
                PoseCounts(
                    part_id="counted",
                    numbering=statistics.numbering,
                    index=[0],
                    count=[k],
                )
                for k in range(number)
            ),
            2000.0,
        ):
            camera.publish(message)

        def lost():
            return int(health.line("recording")[1].get("counts lost", 0))

        def kept():
            return len(recorded(setting.folder, "pose_counts"))

        until(lambda: kept() + lost() >= number, "the counts")
        lost_counts = lost()
        recorded_total = kept()
    return judged(
        number,
        f"{recorded_total} recorded, {lost_counts} told as lost",
        each_is_recorded_or_told=recorded_total + lost_counts == number,
    )


def a_signal_during_an_estimate(setting: Setting) -> Outcome:
    """SIGTERM while a mesh is estimated that takes long."""
    with tried_node(setting.folder) as (node, client):
        waiting = client.send("estimate", part=flat(smooth_body(3e5), "long"))
        time.sleep(1.5)
        assert not waiting.done(), "the estimate was too quick for this attack"
        seconds = end(node)
        time.sleep(0.5)
        answered = waiting.done()
    return judged(
        1,
        f"ended after {seconds:.1f} s, {'answered' if answered else 'no answer'}",
        it_ends_soon=not setting.judges_times or seconds < ENDING,
        the_client_is_answered=answered,
    )


def ends_by_sigterm(setting: Setting) -> Outcome:
    """The ends of all nodes of the attacks above: each by SIGTERM, with status 0."""
    longest = max(ENDINGS, default=0.0)
    return judged(
        len(ENDINGS),
        f"the slowest of {len(ENDINGS)} after {longest:.1f} s",
        each_ends_soon=not setting.judges_times or longest < ENDING,
    )


def simulated_time_stands_still(setting: Setting) -> Outcome:
    """A node with `use_sim_time` and nobody who publishes /clock."""
    with tried_node(setting.folder, use_sim_time=True) as (_, client):
        Health(client).line("jobs")
        stamp = client.good(
            "estimate", part=flat(WEDGE, "timeless")
        ).statistics.header.stamp
    return judged(
        1, f"answered with the stamp {stamp.sec} s", time_stands_still=stamp.sec == 0
    )

"""A node that is started again and again, killed, or started on bags that somebody has copied."""

from __future__ import annotations

import random
import shutil
import time

from tests.contract.node.harness.bags import bags_of, size_of
from tests.contract.node.harness.client import until
from tests.contract.node.harness.parts import fine_box

from ..cell import MEGABYTE, forget_peak, part_ids, publish_in_turn, status, tried_node
from ..frame import Outcome, Setting, judged
from ..soak.lanes import estimates, goals, jobs
from ..soak.life import Life, node_of
from ..soak.told import Told

TRIANGLE_BYTES = 24
"""Of a closed mesh in flat arrays: half a vertex of 24 bytes and three indices of 4."""

LARGE = fine_box(2_000_000 / TRIANGLE_BYTES)
"""A mesh of 2 MB."""

LARGE_BYTES = LARGE[0].nbytes + LARGE[1].nbytes
SHARE_IN_START, START_SECONDS, LOAD_CALLS = 0.2, 2.0, 60


def _restarted(folder, known, **values):
    """Start and end a node: bytes on the disk then, the most memory, the parts."""
    with tried_node(folder, **values) as (node, client):
        forget_peak(node)
        until(lambda: len(part_ids(client)) >= known, "the parts")
        peak, parts = status(node, "VmHWM"), part_ids(client)
    return size_of(folder), peak, parts


def restart_with_nothing_new(setting: Setting) -> Outcome:
    """Four large parts known, and the node started again and again."""
    with tried_node(setting.folder, max_parts=3) as (_, client):
        publish_in_turn(client, LARGE, [f"part_{number}" for number in range(4)])
        known = len(part_ids(client))
    before = size_of(setting.folder)
    starts = [_restarted(setting.folder, known, max_parts=3) for _ in range(setting.of(4, 2))]
    added = (starts[-1][0] - before) / len(starts) / (4 * LARGE_BYTES)
    first, last = starts[0][1], starts[-1][1]
    return judged(len(starts), f"{added:.2%} of the meshes' size added a start, at most "
                  f"{first / MEGABYTE:.0f} and {last / MEGABYTE:.0f} MiB of memory",
                  disk_is_flat=added < 0.01, memory_is_flat=last < 1.1 * first,
                  the_same_parts_are_there=all(one[2] == starts[0][2] for one in starts))


def restart_on_a_copied_run(setting: Setting) -> Outcome:
    """A part forgotten since, and a copy of the run that knew it."""
    with tried_node(setting.folder) as (_, client):
        publish_in_turn(client, LARGE, ["part_0", "part_1"])
    with tried_node(setting.folder) as (_, client):
        until(lambda: len(part_ids(client)) == 2, "the parts")
        client.good("forget_part", part_id="part_0")
    oldest, *_, newest = bags_of(setting.folder)
    shutil.copytree(oldest, newest.with_name(
        newest.name[:-1] + ("0" if newest.name[-1] != "0" else "1")))  # the newest but one
    starts = [_restarted(setting.folder, 1)[2] for _ in range(2)]
    return judged(len(starts), f"{starts[-1]} known",
                  what_was_forgotten_stays_away=all(one == ["part_1"] for one in starts))


def kills(setting: Setting) -> Outcome:
    """Killed at any moment, and what clients had been told looked for in the bags."""
    told, chance, number = Told(), random.Random(setting.seed), setting.of(10, 4)
    for _ in range(number):
        node = node_of(setting.folder, log_drops=chance.choice(("true", "false")))
        try:
            if chance.random() < SHARE_IN_START:
                time.sleep(START_SECONDS * chance.random())
                continue
            life = Life(node, told, chance.random())
            life.start((estimates, jobs, goals))
            life.go_on(round(LOAD_CALLS * chance.random()))
            life.end(kill=True)
        finally:
            node.kill()
        told.wrong += told.not_in([setting.folder])
    Life(node_of(setting.folder), told, 0).end(kill=False)
    lost = dict.fromkeys([*told.wrong, *told.not_in([setting.folder]),
                          *told.unlike_the_library()])
    looked_for = len(told.answers) + len(told.accepted) + len(told.ended)
    return Outcome(number, list(lost), f"{looked_for} answers, acceptances and ends looked for, "
                   f"{told.events['jobs cancelled by the next start']} jobs cancelled by the next "
                   "start")

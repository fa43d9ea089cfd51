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

"""Memory by large parts, refused goals, requests that wait, and floods of meshes."""

from lab.bodies.slow import ROUND
from tests.contract.node.harness.bags import on_topic, raw_of
from tests.contract.node.harness.client import wait_for
from tests.contract.node.harness.goals import Goals
from tests.contract.node.harness.parts import fine_box, library_part

from .. import cell
from ..cell import MEGABYTE, flat, status, tried_node
from ..frame import Outcome, Setting, judged

LARGE = fine_box(83_000)
"""A mesh of 2 MB."""

LARGE_BYTES = LARGE[0].nbytes + LARGE[1].nbytes

BUILT = 2.5
"""Times its mesh that such a part takes in memory."""

WORKING_BYTES = 24 * MEGABYTE
"""Beside built parts: the one that is being built, its messages, and results."""


def many_large_parts(setting: Setting) -> Outcome:
    """As many parts as `max_part_bytes` holds in memory, and as many again, which stay
    known.
    """
    half = setting.of(16, 8)
    bound = round(BUILT * half * LARGE_BYTES)
    with tried_node(setting.folder, max_part_bytes=bound) as (node, client):
        cell.publish_in_turn(client, LARGE, ["first"])
        sizes = [status(node, "VmRSS")]
        for first in (1, 1 + half):
            names = [f"part_{number}" for number in range(first, first + half)]
            cell.publish_in_turn(client, LARGE, names, first=first)
            sizes.append(status(node, "VmRSS"))
        part_count = len(cell.part_ids(client))
    grown = sizes[1] - sizes[0]
    later = sizes[2] - sizes[1]
    return judged(
        2 * half,
        f"{grown / MEGABYTE:.0f} MiB more for a bound of "
        f"{bound / MEGABYTE:.0f}, then {later / MEGABYTE:.0f}, {part_count} parts "
        "known",
        bounded=grown < bound + WORKING_BYTES,
        no_more_comes=later < 0.5 * bound,
        all_are_known=part_count == 1 + 2 * half,
    )


def refused_goals(setting: Setting) -> Outcome:
    """Goals of the action that are refused, each with a large mesh."""
    number = setting.of(30, 20)
    with tried_node(setting.folder, max_drops=1000) as (node, client):
        goals = Goals(client)
        part = flat(LARGE, "refused")
        sizes = []
        for _ in range(number + 1):
            _, result = goals.send(part=part, drops=2000).result()
            assert not result.success
            assert "max_drops" in result.message
            sizes.append(status(node, "VmRSS"))
        goals.close()
    grown = sizes[-1] - sizes[0]
    sent_bytes = number * LARGE_BYTES
    return judged(
        number,
        f"{grown / MEGABYTE:.0f} MiB more after "
        f"{sent_bytes / MEGABYTE:.0f} MiB of meshes",
        meshes_are_let_go=grown < 0.3 * sent_bytes,
    )


def waiting_requests(setting: Setting) -> Outcome:
    """Forty estimates of large new meshes, asked for all at once."""
    with tried_node(setting.folder, max_mesh_bytes=LARGE_BYTES) as (node, client):
        client.good("estimate", part=flat(LARGE, "first"))
        cell.forget_peak(node)
        memory_before = status(node, "VmRSS")
        larger = (1.1 * LARGE[0], LARGE[1])
        waiting = [
            client.send("estimate", part=flat(larger, f"part_{number}"))
            for number in range(40)
        ]
        answers = [wait_for(future) for future in waiting]
        grown = status(node, "VmHWM") - memory_before
    refused = [future.message for future in answers if not future.success]
    return judged(
        40,
        f"{grown / MEGABYTE:.0f} MiB more at most, {len(refused)} refused",
        bounded=grown < 2 * 40 * LARGE_BYTES,
        refusals_say_why=all("expected" in message for message in refused),
    )


def a_flood_of_meshes(setting: Setting) -> Outcome:
    """A thousand meshes of eight parts as fast as can be, while somebody asks and is
    answered.
    """
    number = setting.of(1000, 300)
    vertices, triangles = ROUND
    surfaces = [((1.0 + 1e-3 * k) * vertices, triangles) for k in range(number)]
    with tried_node(setting.folder) as (node, client):
        publisher = cell.MeshPublisher(client).matched()
        health = cell.Health(client)
        publisher.publish(flat(ROUND, "before"))
        cell.latched(client, "before")
        memory_before = status(node, "VmRSS")
        last = library_part(surfaces[-1]).digest
        publisher.publish(
            *(flat(surface, f"part {k % 8}") for k, surface in enumerate(surfaces))
        )
        requests = 0
        while cell.latched(client, f"part {(number - 1) % 8}").part_digest != last:
            requests += client.call("list_drop_simulations") is not None
        grown = status(node, "VmHWM") - memory_before
        values = cell.quiet(health)
        recorded_meshes = len(raw_of(setting.folder, on_topic("part_mesh"))) - 1
    return judged(
        number,
        f"{recorded_meshes} taken, {values['overrun']} told as overrun, {requests} "
        f"calls answered meanwhile, {grown / MEGABYTE:.0f} MiB more at most",
        bounded=grown < 400 * MEGABYTE,
        none_refused=values["refused"] == 0,
        each_is_taken_or_told=recorded_meshes + values["overrun"] == number,
    )

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

"""Round trips of the services while the node is idle, and while it drops on every
core.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from ros_pose_stats_msgs.msg import PartMesh

from lab.bodies.curved import Body
from lab.frame.results import Row, Section, Target
from lab.frame.timing import Contender, Pace, Timings, race
from ros_pose_stats import part_from_mesh
from tests.contract.node.harness.jobs import finished, start
from tests.contract.node.harness.parts import flat

from . import jobs
from .bare import SERVICE
from .listener import Listener
from .mesh_to_estimate import larger
from .spread import p99, spread
from .starting import cores

BARE = "bare rclpy service"
NEW = "new_mesh"

TIMED = (
    "Round trip of a call from this process, nothing else asked meanwhile; the calls "
    "take turns. `full load`: a drop simulation of the clamp runs on {workers} "
    "workers, as many as there are cores; what is started meanwhile waits in the queue "
    "and is cancelled. `get`, `list` and `start` stand for `get_drop_simulation`, "
    "`list_drop_simulations` and `start_drop_simulation`. The carried part has flat "
    "arrays of {triangles} triangles, in `new mesh` others each time. `"
    + BARE
    + "`: an empty service in a process of its own, by which "
    "the others are divided, round by round. The bounds are {start:g} ms for a start "
    "and {others:g} ms for the others, held against the 99th percentile; they are "
    "meant for disks on which a sync takes at most 2 ms, see above."
)
START = 10.0
OTHERS = 50.0  # milliseconds


class Known(NamedTuple):
    """Parts that the node knows.

    Attributes
    ----------
    part_id : str
        Id of the part that is asked for, and dropped meanwhile.
    carried_id : str
    carried : Body
        Part that requests carry.
    """

    part_id: str
    carried_id: str
    carried: Body


def services(
    client, bare_client, listener: Listener, parts: Known, pace: Pace
) -> Section:
    """A row for each service, idle and under full load."""

    def measure(job_id: str, drops: int) -> Timings:
        calls = Calls(client, listener)
        return race(_contenders(calls, bare_client, parts, job_id, drops), pace)

    ended = start(client, parts.part_id, 100)
    finished(client, ended)
    idle = measure(ended, 1)
    with jobs.under_way(client, parts.part_id) as running:
        loaded = measure(running, 100)
    rows = [
        _row(timings, key, load)
        for load, timings in (("idle", idle), ("full load", loaded))
        for key in timings.seconds
    ]
    return Section(
        "services",
        "Services",
        TIMED.format(
            workers=cores(),
            triangles=len(parts.carried.triangles),
            start=START,
            others=OTHERS,
        ),
        tuple(rows),
    )


def _contenders(
    calls: Calls, bare_client, parts: Known, job_id: str, drops: int
) -> list[Contender]:
    """All calls in the order of the table; `drops` are those of a job that is
    started.
    """
    part_id = parts.part_id
    _, vertices, triangles = parts.carried

    def carried(part_id: str, corners: Any) -> dict[str, Any]:
        return {"part": flat((corners, triangles), part_id), "drops": drops}

    return [
        calls.ask(BARE, SERVICE, client=bare_client),
        calls.ask("get", "get_drop_simulation", job_id=job_id),
        calls.ask("get_statistics", "get_statistics", part_id=part_id),
        calls.ask("list", "list_drop_simulations"),
        calls.ask("estimate, known part", "estimate", part_id=part_id),
        calls.start("start, known part", lambda: {"part_id": part_id, "drops": drops}),
        calls.start("start, carried part", lambda: carried(parts.carried_id, vertices)),
        calls.start(
            "start, carried part, new mesh",
            lambda: carried(NEW, larger(vertices)),
            is_new=True,
        ),
    ]


class Calls:
    """Maker of contenders; before each call what the last one began is ended,
    untimed.
    """

    def __init__(self, client, listener: Listener) -> None:
        self._client = client
        self._listener = listener
        self._job_id = ""
        self._new_mesh: Any = None

    def ask(self, name: str, service: str, client=None, **fields: Any) -> Contender:
        """A call that leaves nothing behind, of the node or another client's node."""
        call = (client or self._client).call
        return Contender(name, lambda _: call(service, **fields), self._settle)

    def start(
        self, name: str, fields: Callable[[], dict[str, Any]], is_new: bool = False
    ) -> Contender:
        """Start a job; the estimate of a mesh that is new is waited for afterwards."""

        def prepare() -> dict[str, Any]:
            self._settle()
            self._listener.forget()
            return {**fields(), "seed": next(jobs.SEEDS)}

        def call(values: dict[str, Any]) -> None:
            answer = self._client.good("start_drop_simulation", **values)
            self._job_id = answer.job_id
            self._new_mesh = values["part"] if is_new else None

        return Contender(name, call, prepare)

    def _settle(self) -> None:
        if self._job_id:
            jobs.end(self._client, self._job_id)
        if self._new_mesh is not None:
            self._listener.wait(_digest(self._new_mesh))
        self._job_id = ""
        self._new_mesh = None


def _digest(mesh: PartMesh) -> str:
    """What every result of such a mesh tells of it."""
    corners = np.reshape(mesh.vertices, (-1, 3))
    triangles = np.reshape(mesh.triangles, (-1, 3))
    return part_from_mesh(corners, triangles).digest


def _row(timings: Timings, key: str, load: str) -> Row:
    """A row of the table, judged by the bound of such a call."""
    seconds = timings.seconds[key]
    bound = START if key.startswith("start") else OTHERS
    return Row(
        f"{key}, {load}",
        {**spread(seconds), "times bare": timings.ratio(key, BARE)},
        () if key == BARE else (Target("p99, ms", p99(seconds), bound),),
    )

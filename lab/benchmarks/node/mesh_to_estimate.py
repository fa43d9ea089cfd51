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

"""Time from the publishing of a mesh to the latched estimate, beside that of
subscriptions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import count
from statistics import median
from typing import NamedTuple

from rclpy.serialization import serialize_message
from scipy.spatial import ConvexHull

from lab.bodies.curved import Body
from lab.frame.results import Row, Section
from lab.frame.timing import Contender, Pace, Timings, race
from ros_pose_stats import estimate, part_from_mesh
from ros_pose_stats.core.records import Array
from tests.contract.node.harness.cell import MeshPublisher
from tests.contract.node.harness.parts import flat, mesh

from .listener import Listener
from .spread import beyond, spread

CAD_TOPIC = "/benchmark/cad"
FLAT = "PartMesh"
STANDARD = "shape_msgs/Mesh"
NEW = "PartMesh, new name"
HULL = "hull"
LIBRARY = "library"
STEP = 1e-6

TIMED = (
    "From the publishing of an already serialised mesh to the arrival of its latched "
    "`PoseStatistics`, another mesh each time (larger by a millionth), so nothing is "
    "answered from memory. `PartMesh` has flat arrays; `shape_msgs/Mesh` comes on a "
    "topic of `mesh_topics`; with a new name the part's publisher is new as well and "
    "has to be found by the subscriber. `hull`: `scipy.spatial.ConvexHull` of the same "
    "vertices in the client's process, in turns with the messages; `beyond the hull` "
    "is the median difference. `library`: `part_from_mesh` and `estimate` there, "
    "without messages, bag and process. All vertices of a rounded box are on the hull, "
    "half of those of a ring. The 99th percentile of fewer than 100 runs is the "
    "largest."
)


class Topics(NamedTuple):
    """Where meshes go, and who hears what becomes of them."""

    listener: Listener
    parts: MeshPublisher
    standard_meshes: MeshPublisher


def mesh_to_estimate(topics: Topics, bodies: Sequence[Body], pace: Pace) -> Section:
    """Two rows for each body, and one of the first body with ever new names."""
    rows = []
    for body in bodies:
        names = (FLAT, STANDARD, NEW) if body is bodies[0] else (FLAT, STANDARD)
        timings = race([*_scale(body), *_senders(topics, body, names)], pace)
        rows += [_row(timings, body, name) for name in names]
    return Section(
        "mesh_to_estimate", "From the mesh to the latched estimate", TIMED, tuple(rows)
    )


def _scale(body: Body) -> list[Contender]:
    """Contenders that do the same in this process, for scale."""

    def fresh() -> Array:
        return larger(body.vertices)

    def library(vertices: Array) -> object:
        return estimate(part_from_mesh(vertices, body.triangles), "split")

    library(fresh())  # loads the kernels
    return [Contender(HULL, ConvexHull, fresh), Contender(LIBRARY, library, fresh)]


def _senders(topics: Topics, body: Body, names: Sequence[str]) -> Iterator[Contender]:
    """Contenders through the node; their topics and, but for new names, parts are known
    to it.
    """
    numbers = count()
    for name in names:
        publisher = topics.standard_meshes if name == STANDARD else topics.parts
        prepare = _maker(name, body, numbers)

        def send(
            message: tuple[bytes, str], publisher: MeshPublisher = publisher
        ) -> None:
            data, digest = message
            topics.listener.forget()
            publisher.publish(data)
            topics.listener.wait(digest)

        send(prepare())
        yield Contender(name, send, prepare)


def _maker(
    name: str, body: Body, numbers: count[int]
) -> Callable[[], tuple[bytes, str]]:
    """Return a function that makes message and digest of another mesh at each call."""

    def make() -> tuple[bytes, str]:
        surface = (larger(body.vertices), body.triangles)
        part_id = f"ring_{next(numbers)}" if name == NEW else "ring"
        message = mesh(surface) if name == STANDARD else flat(surface, part_id)
        return bytes(serialize_message(message)), part_from_mesh(*surface).digest

    return make


def _row(timings: Timings, body: Body, name: str) -> Row:
    seconds = timings.seconds
    return Row(
        f"{body.name}, {name}",
        {
            **spread(seconds[name]),
            "hull, ms": 1e3 * median(seconds[HULL]),
            "beyond the hull, ms": beyond(seconds[name], seconds[HULL]),
            "library, ms": 1e3 * median(seconds[LIBRARY]),
            "beyond the library, ms": beyond(seconds[name], seconds[LIBRARY]),
        },
    )


_numbers = count(1)


def larger(vertices: Array) -> Array:
    """A slightly larger copy, which is new to the node."""
    return vertices * (1.0 + STEP * next(_numbers))

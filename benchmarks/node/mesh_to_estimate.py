"""From the publishing of a mesh to the latched estimate."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import count
from statistics import median

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import ConvexHull

from ros_pose_stats import estimate, part_from_mesh

from ..bodies import Body
from ..results import Row, Section
from ..timing import Contender, Pace, Timings, race
from .client import Client
from .meshes import Fresh, mesh_bytes, part_mesh_bytes
from .spread import beyond, spread

PART_TOPIC, CAD_TOPIC = "/pose_stats/part_mesh", "/benchmark/cad"
FLAT, STANDARD, NEW = "PartMesh", "shape_msgs/Mesh", "PartMesh, new name"
HULL, LIBRARY = "hull", "library"

TIMED = (
    "From the publishing of an already serialised mesh to the arrival of its latched "
    "`PoseStatistics`, another mesh each time (larger by a millionth), so nothing is answered "
    "from memory. `PartMesh` has flat arrays; `shape_msgs/Mesh` comes on a topic of "
    "`mesh_topics`; with a new name the part's publisher is new as well and has to be found by "
    "the subscriber. `hull`: `scipy.spatial.ConvexHull` of the same vertices in the client's "
    "process, in turns with the messages; `beyond the hull` is the median difference. "
    "`library`: `part_from_mesh` and `estimate` there, without messages, bag and process. All "
    "vertices of a rounded box are on the hull, half of those of a ring. The 99th percentile "
    "of fewer than 100 runs is the largest.")


def mesh_to_estimate(client: Client, bodies: Sequence[Body], pace: Pace) -> Section:
    """Two rows for each body, and one of the first body with ever new names."""
    rows = []
    for body in bodies:
        names = (FLAT, STANDARD, NEW) if body is bodies[0] else (FLAT, STANDARD)
        timings = race([*_scale(body), *senders(client, body, names)], pace)
        rows += [_row(timings, body, name) for name in names]
    return Section("mesh_to_estimate", "From the mesh to the latched estimate", TIMED,
                   tuple(rows))


def _scale(body: Body) -> list[Contender]:
    """What the same takes in this process."""
    fresh = Fresh(body)

    def library(vertices: NDArray[np.float64]) -> object:
        return estimate(part_from_mesh(vertices, body.triangles))

    library(fresh())  # loads the kernels
    return [Contender(HULL, ConvexHull, fresh), Contender(LIBRARY, library, fresh)]


def senders(client: Client, body: Body, names: Sequence[str]) -> Iterator[Contender]:
    """Through the node; each has met its topic and, but for new names, its part before."""
    numbers = count()
    for name in names:
        topic = CAD_TOPIC if name == STANDARD else PART_TOPIC
        prepare = _maker(name, Fresh(body), numbers)

        def send(made: tuple[bytes, str], topic: str = topic) -> object:
            return client.publish_until_latched(topic, *made)

        send(prepare())
        yield Contender(name, send, prepare)


def _maker(name: str, fresh: Fresh, numbers: count[int]) -> Callable[[], tuple[bytes, str]]:
    """Makes message and digest of ever other meshes."""
    triangles = fresh.body.triangles

    def make() -> tuple[bytes, str]:
        vertices = fresh()
        digest = part_from_mesh(vertices, triangles).digest
        if name == STANDARD:
            return mesh_bytes(vertices, triangles), digest
        part_id = f"ring_{next(numbers)}" if name == NEW else "ring"
        return part_mesh_bytes(part_id, vertices, triangles), digest

    return make


def _row(timings: Timings, body: Body, name: str) -> Row:
    seconds = timings.seconds
    return Row(f"{body.name}, {name}", {
        **spread(seconds[name]), "hull, ms": 1e3 * median(seconds[HULL]),
        "beyond the hull, ms": beyond(seconds[name], seconds[HULL]),
        "library, ms": 1e3 * median(seconds[LIBRARY]),
        "beyond the library, ms": beyond(seconds[name], seconds[LIBRARY])})

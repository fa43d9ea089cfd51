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

"""Large inputs that are bad on purpose, each in a process that may end."""

import time
from collections.abc import Callable

import numpy as np

from lab.bodies import shapes
from lab.bodies.degenerate import joined, split
from lab.bodies.shapes import Surface
from ros_pose_stats import PoseStatsError, estimate_all, part_from_mesh

from ..frame import Outcome, Setting
from .watched import Tried, Watched

TRIANGLES = 100_000
BOUND = 60.0
"""Seconds of the processor that any of them may take to be made, taken as a part and
estimated nine times.
"""

NO_PARTS = {"coincident", "flat"}


def _random() -> np.random.Generator:
    return np.random.default_rng(1)


def _loose(count: int) -> Surface:
    return split(
        (_random().standard_normal((3 * count, 3)), np.arange(3 * count).reshape(-1, 3))
    )


def _closed_tangle(count: int) -> Surface:
    corners = _random().integers(200, size=(count // 4, 4))
    faces = corners[:, [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]]]
    return _random().standard_normal((200, 3)), faces.reshape(-1, 3)


def _cone(count: int) -> Surface:
    sides = count // 2
    base, triangles = shapes.prism(sides, 1.0, 1.0)
    corners = np.arange(sides)
    fan = np.column_stack((corners, np.roll(corners, -1), np.full(sides, sides)))
    return np.vstack((base[:sides], (0.0, 0.0, 1.0))), np.vstack(
        (triangles[: sides - 2], fan)
    )


def _sphere_of_rings(count: int) -> Surface:
    angles = 2.0 * np.pi * np.arange(500) / 500
    circle = np.column_stack((np.cos(angles), np.sin(angles)))
    return shapes.hull_mesh(
        np.vstack(
            [
                np.column_stack((np.sqrt(1.0 - z * z) * circle, np.full(500, z)))
                for z in np.linspace(-1.0, 1.0, count // 1000 + 2)[1:-1]
            ]
        )
    )


def _boxes(count: int, size: float) -> Surface:
    side = np.arange(float(round((count / 12.0) ** (1.0 / 3.0))))
    places = np.stack(np.meshgrid(side, side, side), axis=-1).reshape(-1, 3)
    vertices, triangles = shapes.box(size, size, size)
    return joined(*((vertices + center, triangles) for center in places))


def _nested_boxes(count: int) -> Surface:
    vertices, triangles = shapes.box(1.0, 1.0, 1.0)
    return joined(
        *(
            (factor * vertices, triangles)
            for factor in np.linspace(0.1, 1.0, count // 12)
        )
    )


def _dust(count: int) -> Surface:
    vertices, triangles = split(shapes.hull_mesh(shapes.sphere_points(count // 6, 1)))
    return vertices + 1e-8 * _random().standard_normal(vertices.shape), triangles


CASES: dict[str, Callable[[int], Surface]] = {
    "loose triangles": _loose,
    "tangle": lambda count: (  # every edge is crowded
        _random().standard_normal((1000, 3)),
        _random().integers(1000, size=(count, 3)),
    ),
    "closed tangle": _closed_tangle,  # every edge is shared by hundreds of tetrahedra
    "lattice tangle": lambda count: (  # many coplanar or without area
        _random().integers(0, 12, (5000, 3)).astype(float),
        _random().integers(5000, size=(count, 3)),
    ),
    "ring": lambda count: shapes.prism(count // 5, 1.0, 0.5),
    "cone": _cone,
    "sphere": lambda count: shapes.hull_mesh(shapes.sphere_points(count // 2, 1)),
    "sphere of rings": _sphere_of_rings,  # cocircular points on parallels
    "boxes": lambda count: _boxes(count, 1.0),  # each touches its neighbours
    "crossing boxes": lambda count: _boxes(count, 1.5),
    "nested boxes": _nested_boxes,
    "dust": _dust,  # all vertices within a few welds of another
    "coincident": lambda count: (
        np.ones((count, 3)),
        np.arange(3 * count).reshape(-1, 3) % count,
    ),
    "flat": lambda count: (_loose(count)[0] * (1.0, 1.0, 0.0), _loose(count)[1]),
    "needle": lambda count: shapes.prism(count // 4, 1e-3, 1.0),
}


def attempt_large(name: str, triangles: int, _: bool) -> Tried:
    """Make a large input, hand it over and ask for all estimates."""
    surface = CASES[name](triangles)
    begin = time.perf_counter()
    refusal = ""
    try:
        estimate_all(part_from_mesh(*surface))
    except PoseStatsError as error:
        refusal = str(error)
    return Tried(triangles, refusal, seconds=time.perf_counter() - begin)


def large_inputs(setting: Setting) -> Outcome:
    """Fifteen large bad meshes, each made, taken or refused, and estimated within a
    minute.
    """
    outcome = Outcome()
    slowest = (0.0, "")
    size = setting.of(TRIANGLES, 10_000)
    with Watched(attempt_large, BOUND) as watched:
        for name in CASES:
            tried = watched.tried(name, size)
            outcome.tried += 1
            outcome.broken += [f"{name}: {fault}" for fault in tried.faults]
            if not tried.faults and bool(tried.refusal) != (name in NO_PARTS):
                outcome.broken.append(f"{name}: {tried.refusal or 'taken'}")
            slowest = max(slowest, (tried.seconds, name))
    outcome.seen = (
        f"{size} triangles; the slowest, {slowest[1]}, took {slowest[0]:.1f} s"
    )
    return outcome

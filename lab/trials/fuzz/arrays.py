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

"""Arrays that are no mesh, or hardly one: values, indices, shapes and types that do not
fit.

Each maker takes a random generator and gives what is handed over as vertices and
triangles.
"""

from typing import Any

import numpy as np

from lab.bodies import shapes
from lab.bodies.degenerate import Random, polyhedron, power
from lab.bodies.shapes import Surface

Arrays = tuple[Any, Any]


def bad_values(random: Random) -> Arrays:
    """NaN, infinity and numbers at the edge of their range among the coordinates."""
    vertices, triangles = polyhedron(random)
    bad = (np.nan, np.inf, -np.inf, 1.7e308, -1.7e308, 1e200, 1e60)
    for _ in range(int(random.integers(1, 4))):
        vertices[random.integers(len(vertices)), random.integers(3)] = random.choice(
            bad
        )
    return vertices, triangles


def tiny_values(random: Random) -> Arrays:
    """Coordinates that are zero, subnormal, equal or of very unlike sizes."""
    vertices, triangles = polyhedron(random)
    for _ in range(int(random.integers(1, 5))):
        column = random.integers(3)
        vertices[:, column] = random.choice((0.0, 5e-324, 1e-310, 1.0)) * (
            1.0 if random.random() < 0.5 else vertices[:, column]
        )
        vertices[random.integers(len(vertices))] *= power(random, -300, 0)
    return vertices, triangles


def bad_indices(random: Random) -> Arrays:
    """Vertex numbers out of range, negative, broken, huge, or that count from 1."""
    vertices, triangles = polyhedron(random)
    kinds: list[Any] = [
        triangles + 1,
        triangles - 1,
        triangles + 0.5,
        triangles.astype(float) * np.nan,
        triangles + len(vertices),
        triangles.astype(np.int64) + 2**40,
        -triangles,
        triangles.astype(np.uint64) + np.uint64(2**63),
        triangles * 1e300,
        triangles.astype(object) + 2**70,
        np.full_like(triangles, -(2**62)),
        [[0, 1, None]] * 4,
        triangles.astype(complex),
        triangles * 1j,
        triangles > 0,
        np.where(triangles == 0, 2**32, triangles),
        triangles.astype(str),
        triangles.astype("M8[s]"),
        triangles.astype("m8[s]"),
        triangles.astype(bytes),
    ]
    return vertices, kinds[int(random.integers(len(kinds)))]


def _shapes_of(surface: Surface) -> list[Arrays]:
    vertices, triangles = surface
    return [
        ([], []),
        (np.zeros((0, 3)), np.zeros((0, 3), int)),
        (vertices, []),
        ([], triangles),
        (np.zeros((0, 3)), triangles),
        (vertices, np.zeros((0, 3), int)),
        (vertices[:, :2], triangles),
        (vertices, triangles[:, :2]),
        (vertices.T, triangles),
        (vertices, triangles.T),
        (vertices.ravel(), triangles),
        (vertices, triangles.ravel()),
        (vertices[None], triangles),
        (vertices, triangles[None]),
        (0.0, 0),
        (None, None),
        ([*vertices.tolist()[:-1], [1.0]], triangles),
        (vertices, [[0, 1, 2], [1, 2]]),
        ({}, {}),
        ({0, 1}, {0, 1}),
        (np.hstack((vertices, vertices)), triangles),
        (vertices[:1], triangles[:1]),
        (vertices[:3], [[0, 1, 2]]),
        (np.zeros((3, 0)), np.zeros((3, 0), int)),
        (vertices * 1j, triangles),
        (vertices.astype("M8[s]"), triangles),
        (np.array([{}] * 3), triangles),
        (vertices, [*triangles.tolist(), [0]]),
        (iter(vertices), triangles),
        (vertices, iter(triangles)),
        (b"mesh", b"mesh"),
    ]


def bad_shapes(random: Random) -> Arrays:
    """Empty, flat, ragged, transposed or no arrays at all."""
    choices = _shapes_of(polyhedron(random))
    return choices[int(random.integers(len(choices)))]


def good_types(random: Random) -> Arrays:
    """A polyhedron as lists, tuples, other number types, other memory layouts."""
    vertices, triangles = polyhedron(random)
    ways: list[Any] = [
        lambda a: a.tolist(),
        lambda a: tuple(map(tuple, a.tolist())),
        np.asfortranarray,
        lambda a: np.repeat(a, 2, axis=0)[::2],
        lambda a: a.astype(object),
        lambda a: a.astype(a.dtype.newbyteorder()),
        np.ma.masked_invalid,
        lambda a: a.astype(str),
        lambda a: a[::-1][::-1],
        _read_only,
    ]
    kinds = [
        np.uint8,
        np.int16,
        np.uint64,
        np.float16,
        np.float32,
        np.longdouble,
        np.int64,
    ]
    convert_vertices = ways[int(random.integers(len(ways)))]
    convert_triangles = ways[int(random.integers(len(ways)))]
    return convert_vertices(vertices), convert_triangles(
        triangles.astype(kinds[int(random.integers(len(kinds)))])
    )


def _read_only(array: Any) -> Any:
    copy = array.copy()
    copy.flags.writeable = False
    return copy


def small_numbers(random: Random) -> Arrays:
    """Vertices of few bits: whole numbers, half and single precision."""
    vertices, triangles = polyhedron(random)
    kinds = (np.int8, np.int32, np.uint8, np.float16, np.float32, np.bool_)
    kind = kinds[int(random.integers(len(kinds)))]
    with np.errstate(all="ignore"):
        return (np.abs(vertices) * power(random, 0, 1.5)).astype(kind), triangles


NUMBERS = (
    np.nan,
    np.inf,
    -np.inf,
    0.0,
    -0.0,
    5e-324,
    1e-310,
    1e-9,
    0.5,
    1.0,
    -1.0,
    2.0,
    3.0,
    1e9,
    1e160,
    -1.7e308,
)
PIECES = (
    None,
    True,
    0,
    -1,
    7,
    2**70,
    1j,
    "",
    "a",
    "\0",
    b"b",
    np.float32(2.0),
    object(),
    {},
    *NUMBERS,
)
TYPES = (
    "b",
    "H",
    "i",
    "q",
    "Q",
    "e",
    "f",
    "d",
    "g",
    "F",
    "D",
    "M8[s]",
    "m8[s]",
    "S3",
    "O",
)


def any_numbers(random: Random) -> Arrays:
    """Coordinates from nasty to harmless, and any indices, or the corners of a box."""
    box_vertices, box_triangles = shapes.box(1.0, 2.0, 3.0)
    numbers = NUMBERS if random.random() < 0.5 else (-2.0, -1.0, 0.0, 1.0, 2.0)
    points = random.choice(numbers, (int(random.integers(0, 10)), 3))
    indices = random.integers(-1, 9, (int(random.integers(0, 13)), 3))
    random_triangles = random.integers(0, 8, (int(random.integers(1, 31)), 3))
    choices = (
        (points, indices),
        (random.choice(numbers, (8, 3)), box_triangles),
        (random.uniform(-1.0, 1.0, (8, 3)), box_triangles),
        (box_vertices, random_triangles),
    )
    return choices[int(random.integers(len(choices)))]


def any_object(random: Random, depth: int = 0) -> Any:
    """An array of any shape, type and content, or anything else, nested or not."""
    choice = random.random()
    if choice < 0.5:
        shape = tuple(random.integers(0, 7, int(random.integers(0, 4))).tolist())
        kind = np.dtype(TYPES[random.integers(len(TYPES))])
        if kind.hasobject:
            return np.full(shape, PIECES[random.integers(len(PIECES))], dtype=object)
        return np.ndarray(shape, kind, random.bytes(kind.itemsize * 7**3))
    if choice < 0.7 and depth < 3:
        return [
            any_object(random, depth + 1) for _ in range(int(random.integers(0, 5)))
        ]
    return PIECES[random.integers(len(PIECES))]


def any_objects(random: Random) -> Arrays:
    """Any object in place of vertices, of triangles, of both or of neither."""
    vertices, triangles = polyhedron(random)
    bits = random.integers(4)
    return (
        any_object(random) if bits & 1 else vertices,
        any_object(random) if bits & 2 else triangles,
    )

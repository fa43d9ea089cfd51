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

"""Symmetry is that of surfaces, whatever divides and rounds them.

A thread counts as the surface that it winds on; flats, keyways and marks of 0.3 mm
stay.
"""

import numpy as np
import pytest
from manifold3d import Manifold, Mesh64

from lab.bodies import exports, fine_parts, threaded
from lab.bodies.fine_parts import surface
from lab.bodies.variants import in_float32, moved, rotation
from ros_pose_stats import part_from_mesh, resting_poses

BOLT = [1, 1, 6]
NUT = [2, 6]


def sizes(body):
    return sorted(np.bincount(resting_poses(part_from_mesh(*body)).group).tolist())


def radius(body):
    return np.linalg.norm(body[0] - np.mean(body[0], axis=0), axis=1).max()


def rounded(body, seed):
    """Coordinates to 1e-6 radii, of a turned copy."""
    vertices, triangles = moved(body, rotation(seed))
    step = 1e-6 * radius(body)
    return np.rint(vertices / step) * step, triangles


def far(body, seed):
    """In float32, 100 radii from the origin."""
    offset = 100.0 * radius(body) * rotation(seed + 20)[0]
    return in_float32(moved(body, rotation(seed), offset))


BODIES = {
    "bolt": (lambda: threaded.bolt(24, start=17.0, turn=5.0), BOLT),
    "nut": (lambda: threaded.nut(36, start=17.0, turn=5.0), NUT),
    "bolt without a thread, 33 sides": (lambda: exports.screw(33, 0.1), BOLT),
    "twelve teeth": (lambda: exports.gear(12, 0.15), [2, 12]),
    "sixty teeth": (lambda: exports.gear(60), [1, 2]),
}


@pytest.mark.parametrize(("make", "expected"), BODIES.values(), ids=BODIES)
def test_rounded_and_far_from_the_origin(make, expected):
    body = make()
    assert sizes(body) == expected
    for seed in range(2):
        assert sizes(rounded(body, seed)) == expected
        assert sizes(far(body, seed)) == expected


@pytest.mark.parametrize(("sides", "hand"), [(20, 1), (36, -1)])
def test_threads_however_they_are_divided(sides, hand):
    """The modeller cuts a left-handed thread against its winding.

    A mirror makes that a right-handed one, cut so.
    """
    for body, expected in (
        (threaded.bolt(sides, turns=8.0, start=40.0, hand=hand), BOLT),
        (threaded.nut(sides, start=40.0, hand=hand), NUT),
    ):
        vertices, triangles = body
        assert sizes(body) == expected
        mirrored = vertices * (-1.0, 1.0, 1.0), triangles[:, ::-1]
        assert sizes(mirrored) == expected


@pytest.mark.parametrize("sides", [20, 64])
def test_threads_as_a_grid_of_heights(sides):
    """Only along crests and roots lead edges on helices there."""
    vertices, triangles = fine_parts.screw(sides)
    assert sizes((1e3 * vertices, triangles)) == BOLT


@pytest.mark.parametrize("sides", [16, 20, 31, 32, 50, 100])
def test_bolts_without_a_thread_however_they_are_divided(sides):
    assert sizes(exports.screw(sides, 0.2)) == BOLT


def cut(body, edges, middle):
    vertices, triangles = body
    solid = Manifold(Mesh64(vertices, triangles.astype(np.uint64)))
    return surface(solid - Manifold.cube(edges, True).translate(middle))


MARKS = {
    "a flat on the thread": ("bolt", 1, (4.0, 10.0, 14.0), (5.7, 0.0, 12.0)),
    "a keyway in the thread": ("bolt", -1, (1.0, 1.0, 14.0), (4.2, 0.0, 12.0)),
    "a mark on the head": ("bolt", 1, (1.0, 1.0, 1.0), (3.0, 0.0, -5.5)),
    "a flat of the nut": ("nut", -1, (20.0, 4.0, 20.0), (0.0, 8.2, 0.0)),
    "a mark on the nut": ("nut", 1, (0.6, 0.6, 1.0), (5.4, 0.0, 6.7)),
    "a keyway in the nut": ("nut", -1, (1.0, 1.0, 20.0), (3.9, 0.0, 0.0)),
}


@pytest.mark.parametrize(("body", "hand", "edges", "middle"), MARKS.values(), ids=MARKS)
def test_marks_of_three_tenths_part_poses(body, hand, edges, middle):
    plain = getattr(threaded, body)(22 - 2 * hand, start=17.0, hand=hand)
    assert sizes(cut(plain, edges, middle)) == [1] * 8


def plain_bolt(sides):
    """Head and shank of 6 mm, 14 poses: six each on the head's sides and corners."""
    head = threaded.hexagon(5.0, False).mirror((0.0, 0.0, 1.0))
    return surface(head + Manifold.cylinder(6.0, 4.0, 4.0, sides))


@pytest.mark.parametrize("sides", [32, 33, 64, 192])
def test_marks_on_round_shanks_part_poses(sides):
    plain = plain_bolt(sides)
    assert sizes(plain) == [1, 1, 6, 6]
    for edges, middle in (
        ((4.0, 20.0, 3.0), (5.7, 0.0, 6.0)),  # a flat
        ((1.0, 1.0, 3.0), (4.2, 0.0, 6.0)),  # a keyway
        ((0.6, 0.6, 0.6), (1.5, 0.0, 6.0)),  # a mark on the tip
    ):
        assert set(sizes(cut(plain, edges, middle))) == {1}


def test_mirror_images_on_a_threaded_part_stay_apart():
    """Two pins that a mirror exchanges and no turn: the thread tells no hand."""
    bolt = Manifold(Mesh64(*[np.asarray(a) for a in _mesh64(threaded.bolt(24))]))
    pin = Manifold.cube((1.0, 2.0, 1.0), True)
    pins = pin.translate((6.0, 3.0, -2.0)) + pin.translate((6.0, -3.0, -2.0))
    groups = resting_poses(part_from_mesh(*surface(bolt + pins))).group
    assert set(np.bincount(groups).tolist()) == {1}


def _mesh64(body):
    return body[0], body[1].astype(np.uint64)

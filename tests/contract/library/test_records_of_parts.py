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

"""A part's digest, name and arrays, and the sentence about the scene that every result
has.
"""

import hashlib
import struct
from dataclasses import replace

import numpy as np
import pytest

from lab.bodies import shapes
from ros_pose_stats import (
    Part,
    estimate,
    part_from_mesh,
    resting_poses,
    shift_center,
    simulate,
)

VERTICES, TRIANGLES = shapes.box(20.0, 30.0, 40.0)


def digest_by_hand(part):
    """Number by number, as the contract has it."""
    numbers = [x for vertex in part.vertices for x in vertex]
    data = struct.pack(f"<{len(numbers)}d", *numbers)
    indices = [int(i) for triangle in part.triangles for i in triangle]
    data += struct.pack(f"<{len(indices)}I", *indices)
    data += struct.pack("<13d", part.mass, *part.center_of_mass, *part.inertia.ravel())
    return hashlib.sha256(data).hexdigest()


def numbering_of(digest, tolerance, sides):
    """As PoseStatistics.msg has it."""
    data = digest.encode() + struct.pack("<dII", tolerance, sides, 1)
    return int.from_bytes(hashlib.sha256(data).digest()[:8], "little")


def test_the_digest_is_that_of_the_contract_and_changes_with_what_it_covers():
    mass_properties = (
        {},
        {"mass": 2.0},
        {"center_of_mass": (0.0, 0.0, 1e-9)},
        {"unit": "mm"},
        {"mass": 1.0, "inertia": np.diag((1e2, 1.1e2, 1.2e2))},
    )
    parts = [
        part_from_mesh(VERTICES, TRIANGLES, **properties)
        for properties in mass_properties
    ]
    assert [part.digest for part in parts] == [digest_by_hand(part) for part in parts]
    assert len({part.digest for part in parts}) == len(parts)
    assert parts[3].vertices == pytest.approx(VERTICES * 1e-3, rel=1e-15)


def test_the_digest_is_of_the_mesh_as_received():
    doubled = np.vstack((VERTICES, VERTICES))
    separate = np.vstack((TRIANGLES[:6], TRIANGLES[6:] + len(VERTICES)))
    part = part_from_mesh(doubled, separate)
    assert (len(part.vertices), len(part.surface_vertices)) == (16, 8)
    assert np.array_equal(part.triangles, separate)
    assert (
        part.digest
        == digest_by_hand(part)
        != part_from_mesh(VERTICES, TRIANGLES).digest
    )


def test_a_part_without_a_name_is_called_by_its_digest():
    assert part_from_mesh(VERTICES, TRIANGLES, part_id="crate").part_id == "crate"
    part = part_from_mesh(VERTICES, TRIANGLES)
    assert isinstance(part, Part)
    for nameless in (
        part,
        shift_center(part, (0.0, 0.0, 1e-3)),
        replace(part, mass=3.0, part_id=""),
    ):
        assert (
            nameless.digest == digest_by_hand(nameless)
            and nameless.part_id == f"mesh_{nameless.digest[:12]}"
        )


def test_arrays_are_its_own_and_cannot_be_written_to():
    vertices = VERTICES.copy()
    triangles = TRIANGLES.copy()
    part = part_from_mesh(vertices, triangles)
    vertices[:] = 0.0
    triangles[:] = 0
    assert np.array_equal(part.vertices, VERTICES)
    assert np.array_equal(part.triangles, TRIANGLES)
    for name in (
        "vertices",
        "triangles",
        "surface_vertices",
        "surface_triangles",
        "center_of_mass",
        "inertia",
    ):
        with pytest.raises(ValueError, match="read-only"):
            getattr(part, name)[0] = 0
    pose = resting_poses(part).poses[0]
    for array in (
        pose.down,
        pose.orientation,
        pose.position,
        pose.roll_axis,
        pose.outline[0],
        pose.support_polygon[0],
    ):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


def test_results_say_how_high_and_how_bouncy_in_one_sentence():
    part = part_from_mesh(VERTICES, TRIANGLES, unit="mm")
    dropped = simulate(part, 10, seed=1, workers=1, restitution=0.3)
    high = f"{2e4 * dropped.radius:.3g}"
    assert dropped.scene == (
        f"released {high} mm above a frictionless plate, restitution 0.3"
    )
    assert dropped.as_dict()["scene"] == dropped.scene
    assert estimate(part, "split", drop_height=0.25).scene == (
        "released 250 mm above a frictionless plate, restitution 0.5"
    )
    assert estimate(part, "csae").scene == (
        "released at any height above a frictionless plate, at any restitution"
    )


def test_poses_of_equal_probability_come_by_their_index():
    """Of a cube the six probabilities differ by rounding alone."""
    for method in ("area", "csae", "meae", "split"):
        poses = estimate(part_from_mesh(*shapes.box(1.0, 1.0, 1.0)), method).poses
        assert [pose.index for pose in poses] == list(range(6))


def test_equal_numberings_are_equal_poses():
    """One for mesh, tolerance and sides, whatever the scene and the method."""
    block = part_from_mesh(*shapes.box(0.03, 0.02, 0.01))
    plain = estimate(block)
    assert plain.numbering == numbering_of(plain.part_digest, 0.0025, 192)
    assert plain.as_dict()["numbering"] == plain.numbering > 0
    bouncy = estimate(block, "area", restitution=0.8, drop_height=0.1)
    assert bouncy.numbering == plain.numbering
    for fields, numbered in (
        ({"cluster_tolerance": 0.0}, (0.0, 192)),
        ({"round_sides": 0}, (0.0025, 0)),
    ):
        statistics = estimate(block, **fields)
        assert statistics.numbering == numbering_of(block.digest, *numbered)
    heavier = part_from_mesh(*shapes.box(0.03, 0.02, 0.01), mass=2.0)
    assert estimate(heavier).numbering != plain.numbering

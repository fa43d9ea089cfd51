"""A part's digest and its arrays."""

from __future__ import annotations

import hashlib
import struct

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, shapes

VERTICES, TRIANGLES = shapes.box(20.0, 30.0, 40.0)


def digest_by_hand(part):
    """Number by number, as the contract has it."""
    numbers = [x for vertex in part.vertices for x in vertex]
    data = struct.pack(f"<{len(numbers)}d", *numbers)
    indices = [int(i) for triangle in part.triangles for i in triangle]
    data += struct.pack(f"<{len(indices)}I", *indices)
    data += struct.pack("<13d", part.mass, *part.center_of_mass, *part.inertia.ravel())
    return hashlib.sha256(data).hexdigest()


@pytest.mark.parametrize("properties", [
    {}, {"mass": 0.3}, {"center_of_mass": (0.001, 0.002, -0.003)},
    {"mass": 2.0, "inertia": np.diag((1e-3, 1.1e-3, 1.2e-3))},
])
def test_digest_is_that_of_the_contract(properties):
    part = part_from_mesh(VERTICES, TRIANGLES, unit="mm", **properties)
    assert part.digest == digest_by_hand(part)
    assert part.vertices == pytest.approx(VERTICES * 1e-3, rel=1e-15)
    assert np.array_equal(part.triangles, TRIANGLES)


def test_digest_is_of_the_mesh_as_received():
    doubled = np.vstack((VERTICES, VERTICES))
    apart = np.vstack((TRIANGLES[:6], TRIANGLES[6:] + len(VERTICES)))
    part = part_from_mesh(doubled, apart)
    assert len(part.vertices) == 16
    assert len(part.surface_vertices) == 8
    assert part.digest == digest_by_hand(part)
    assert part.digest != part_from_mesh(VERTICES, TRIANGLES).digest


def test_digest_changes_with_what_it_covers():
    digests = {part_from_mesh(VERTICES, TRIANGLES, **properties).digest for properties in (
        {}, {"mass": 2.0}, {"center_of_mass": (0.0, 0.0, 1e-9)}, {"unit": "mm"},
        {"mass": 1.0, "inertia": np.eye(3)})}
    assert len(digests) == 5


def test_name():
    assert part_from_mesh(VERTICES, TRIANGLES, part_id="crate").part_id == "crate"
    part = part_from_mesh(VERTICES, TRIANGLES)
    assert part.part_id == f"mesh_{part.digest[:12]}"


def test_arrays_are_its_own_and_cannot_be_written_to():
    vertices, triangles = VERTICES.copy(), TRIANGLES.copy()
    part = part_from_mesh(vertices, triangles)
    vertices[:] = 0.0
    triangles[:] = 0
    assert np.array_equal(part.vertices, VERTICES)
    assert np.array_equal(part.triangles, TRIANGLES)
    for name in ("vertices", "triangles", "surface_vertices", "surface_triangles",
                 "center_of_mass", "inertia"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(part, name)[0] = 0

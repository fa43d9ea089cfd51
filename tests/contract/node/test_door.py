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

"""The few messages that random searches once tripped over, each as small as it can
be.
"""

import struct

import pytest
from geometry_msgs.msg import Inertia, Vector3
from ros_pose_stats_msgs.msg import PartMesh
from shape_msgs.msg import Mesh

from .harness.cell import MeshPublisher
from .harness.goals import Goals, refused_plan
from .harness.jobs import known_part
from .harness.parts import WEDGE, flat, mesh, new_id

MOST = 2**64 - 1
NAMES = ["y" * 5000, "\x1b[31mred", "a\nFATAL", "\u202egnp", "\ufeff"]
SIGNALLING = struct.unpack("<d", struct.pack("<Q", 0x7FF4 << 48))[0]


def assert_line(message):
    assert message.isprintable() and 0 < len(message) < 700, ascii(message)


@pytest.mark.parametrize(
    "name", NAMES, ids=["long", "colour", "lines", "turned", "mark"]
)
def test_a_refusal_shows_what_came_in_a_line_of_bounded_length(cell, name):
    part_id = known_part(cell)
    for service, fields in (
        ("estimate", {"part_id": name}),
        ("estimate", {"part": flat(WEDGE, name)}),
        ("estimate", {"part_id": part_id, "method": name}),
        ("estimate", {"part_id": name, "part": PartMesh(part_id=part_id)}),
        ("estimate", {"part_id": name, "part": flat(WEDGE, part_id)}),
        ("start_drop_simulation", {"part_id": name}),
        ("forget_part", {"part_id": name}),
        ("get_statistics", {"part_id": name}),
        ("get_drop_simulation", {"job_id": name}),
        ("cancel_drop_simulation", {"job_id": name}),
        ("fit_plate", {"plate": name}),
    ):
        assert_line(cell.refused(service, **fields))
    assert_line(refused_plan(cell, part_id=name))


@pytest.mark.parametrize("field", ["vertices", "com", "ixx"])
def test_a_signalling_nan_is_refused_without_a_warning_in_the_log(cell, field):
    """Of its kind only broken messages have; numpy complains of it where it is computed
    with.
    """
    part = flat(WEDGE, new_id())
    if field == "vertices":
        part.vertices[3] = SIGNALLING
    elif field == "com":
        part.inertia = Inertia(com=Vector3(x=SIGNALLING))
    else:
        part.inertia = Inertia(
            m=1.0, com=Vector3(x=0.02, y=0.014, z=0.007), ixx=SIGNALLING
        )
    MeshPublisher(cell).matched().publish(part)
    assert_line(cell.refused("estimate", part=part))


def test_the_largest_numbers_of_a_request(cell):
    part_id = known_part(cell)
    assert "max_drops" in cell.refused(
        "start_drop_simulation", part_id=part_id, drops=MOST
    )
    assert cell.good(
        "start_drop_simulation", part_id=part_id, drops=3, seed=MOST
    ).job_id
    goals = Goals(cell)
    assert "max_drops" in goals.send(part_id=part_id, drops=MOST).result()[1].message
    goals.close()


def test_a_nested_mesh_in_a_request_has_a_bound_on_its_vertices_too(cell):
    corner = mesh(WEDGE).vertices[0]
    mesh_ = Mesh(vertices=[corner] * 30_001, triangles=mesh(WEDGE).triangles)
    assert "at most 30000 vertices" in cell.refused(
        "estimate", part=PartMesh(mesh=mesh_)
    )

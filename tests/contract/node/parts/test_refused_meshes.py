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

"""Meshes that are none: refused with a reason to all who may ask, and the next one
served.
"""

from array import array

import pytest
from geometry_msgs.msg import Inertia, Vector3
from ros_pose_stats_msgs.msg import Code, PartMesh

from lab.bodies import shapes
from lab.bodies.variants import subdivided

from ..harness.cell import Health, MeshPublisher, latched
from ..harness.client import FAILED, until
from ..harness.goals import Goals
from ..harness.jobs import finished, get, known_part, reached, start
from ..harness.parts import WEDGE, flat, library_part, mesh, nested, new_id

VERTICES, TRIANGLES = WEDGE
NAN = float("nan")
INFINITY = float("inf")


def moved_corner(corner, value):
    vertices = VERTICES.copy()
    vertices[corner] = value
    return vertices, TRIANGLES


def other_corner(value):
    triangles = TRIANGLES.copy()
    triangles[1, 1] = value
    return VERTICES, triangles


def weighing(mass=1.0, com=(0.02, 0.014, 0.007), **tensor):
    return flat(
        WEDGE,
        inertia=Inertia(
            m=mass, com=Vector3(**dict(zip("xyz", com, strict=True))), **tensor
        ),
    )


def uneven(name):
    message = flat(WEDGE)
    values = getattr(message, name)
    setattr(message, name, array(values.typecode, list(values)[:-1]))
    return message


BAD = {
    "nan": (flat(moved_corner((2, 1), NAN)), "nan"),
    "infinite": (flat(moved_corner((0, 0), INFINITY)), "inf"),
    "index out of range": (flat(other_corner(77)), "77"),
    "no volume": (flat(moved_corner((slice(None), 2), 0.0)), "thick"),
    "points only": (flat((VERTICES, TRIANGLES[:0])), "triangle"),
    "triangles only": (flat((VERTICES[:0], TRIANGLES)), "expected"),
    "both forms": (
        flat(WEDGE, "2", mesh=mesh(WEDGE)),
        "part '2', got mesh and the flat arrays",
    ),
    "uneven vertices": (
        uneven("vertices"),
        "multiple of three numbers in vertices, part 'part_",
    ),
    "uneven triangles": (
        uneven("triangles"),
        "multiple of three numbers in triangles, part 'pa",
    ),
    "centre outside": (weighing(com=(1.0, 1.0, 1.0)), "centre of mass"),
    "centre nan": (weighing(com=(NAN, 0.0, 0.0)), "nan"),
    "centre without mass": (weighing(0.0, (0.01, 0.0, 0.0)), "inertia.m = 0"),
    "impossible inertia": (weighing(ixx=1.0, iyy=0.1, izz=0.1), "inertia"),
    "negative inertia": (weighing(ixx=-1.0, iyy=1.0, izz=1.0), "inertia"),
    "inertia without mass": (weighing(0.0, 3 * (0.0,), ixx=1.0), "inertia.m = 0"),
    "negative mass": (weighing(-2.0), "-2"),
    "unit 0": (flat(WEDGE, unit=0.0), "unit above 0"),
    "unit negative": (flat(WEDGE, unit=-0.001), "-0.001"),
    "unit nan": (flat(WEDGE, unit=NAN), "nan"),
    "restitution 1": (flat(WEDGE, restitution=1.0), "restitution"),
    "restitution nan": (flat(WEDGE, restitution=NAN), "restitution"),
    "drop height nan": (flat(WEDGE, drop_height=NAN), "drop height"),
    "long name": (
        flat(WEDGE, "x" * 201),
        "part_id of at most 200 printable characters",
    ),
    "escape": (
        flat(WEDGE, "part\x1b[31m"),
        "part_id of at most 200 printable characters",
    ),
    "newline": (
        flat(WEDGE, "part\nFATAL"),
        "part_id of at most 200 printable characters",
    ),
}


def bad(kind):
    """A message of a name of its own, where the name is not what is bad; and what is
    said.
    """
    message, words = BAD[kind]
    if message.part_id == "" or message.part_id.startswith("part_"):
        message.part_id = new_id()
    return message, words


@pytest.fixture
def publisher(cell):
    return MeshPublisher(cell).matched()


@pytest.fixture(scope="module")
def ball():
    """Some eighty thousand triangles."""
    surface = shapes.icosahedron()
    for _ in range(6):
        surface = subdivided(surface)
    return surface


class TestRequests:
    @pytest.mark.parametrize("kind", BAD)
    def test_all_say_why_and_nothing_is_remembered(self, cell, shared_node, kind):
        message, words = bad(kind)
        refusal = cell.refused("estimate", part=message)
        assert words in refusal and refusal in shared_node.says(refusal).log
        assert cell.refused("estimate", part=message) == refusal
        answer = cell.call("start_drop_simulation", part=message, drops=10)
        if answer.success:  # a look at the mesh that takes long is taken later
            answer = reached(cell, answer.job_id, FAILED)
        assert answer.message == refusal
        assert not cell.call("get_statistics", part_id=message.part_id).success
        assert "\x1b[31m" not in shared_node.log and "\nFATAL" not in shared_node.log
        assert cell.good("estimate", part=flat(WEDGE, new_id())).statistics.poses

    def test_large_nested_meshes_are_for_the_topic(self, cell):
        ball = shapes.hull_mesh(shapes.sphere_points(5100, 1))
        message = cell.refused("estimate", part=nested(ball, new_id()))
        assert str(len(ball[1])) in message and "10000" in message
        assert "publish it on /pose_stats/part_mesh or use the flat arrays" in message


class TestTopic:
    def test_all_say_why_in_log_and_diagnostics(self, cell, shared_node, publisher):
        health = Health(cell)
        refused_before = int(health.line("parts")[1]["refused"])
        messages = list(map(bad, BAD))
        publisher.publish(*[message for message, _ in messages], PartMesh())
        expected = refused_before + len(BAD) + 1
        line, values = health.line(
            "parts", lambda _, values: int(values["refused"]) >= expected
        )
        assert line.level == line.WARN and int(values["refused"]) == expected
        reasons = ["got none", *[words for _, words in messages]]
        listed = [value for key, value in values.items() if key.startswith("refused ")]
        assert len(listed) == 20 and all(
            "/pose_stats/part_mesh" in line and any(words in line for words in reasons)
            for line in listed
        )  # the latest ones
        for words in reasons:
            until(
                lambda words=words: any(
                    "/pose_stats/part_mesh" in line
                    and "mesh refused: " in line
                    and words in line
                    for line in shared_node.lines
                ),
                words,
            )
        part_id = new_id()
        publisher.publish(flat(WEDGE, part_id))
        assert latched(cell, part_id).part_digest == library_part(WEDGE).digest

    def test_a_flood_of_the_same_bad_mesh_is_not_logged_each_time(
        self, cell, shared_node, publisher
    ):
        publisher.publish(*[flat(WEDGE, new_id(), unit=-7.5)] * 50)
        shared_node.says("-7.5")
        part_id = new_id()
        publisher.publish(flat(WEDGE, part_id))
        latched(cell, part_id)
        assert shared_node.log.count("got -7.5") < 20  # once in two seconds


class TestLargeOnes:
    """A look at them takes a while, which the acceptance of a job does not wait for."""

    def test_jobs_and_goals_fail_with_the_reason_while_others_are_served(
        self, cell, ball
    ):
        sheet = ball[0] * (1.0, 1.0, 0.0), ball[1]
        part_id = new_id()
        quick_part = known_part(cell)
        goals = Goals(cell)
        job_id = cell.good(
            "start_drop_simulation", part=flat(sheet, part_id), drops=100
        ).job_id
        goal = goals.send(part=flat((2.0 * sheet[0], sheet[1]), new_id()), drops=100)
        assert finished(cell, start(cell, quick_part, 100)).status.drops_done == 100
        failed = reached(cell, job_id, FAILED)
        assert failed.message.startswith("expected ") and failed.status.drops_done == 0
        assert part_id in cell.refused("estimate", part_id=part_id)
        _, result = goal.result()
        goals.close()
        assert not result.success and result.message.startswith("expected ")
        assert failed.status.code == result.code == Code.BAD_MESH

    def test_a_nameless_one_twice_is_one_job(self, cell, ball):
        fields = {"part": flat(ball), "drops": 5_000_000, "seed": 3}
        first, second = (
            cell.good("start_drop_simulation", **fields).job_id for _ in range(2)
        )
        until(lambda: get(cell, first).status.drops_done > 0)
        assert first == second == cell.good("start_drop_simulation", **fields).job_id

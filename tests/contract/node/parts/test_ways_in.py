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

"""Every way in for a mesh: topics, publishers that were there before the node, the
command.
"""

import json
import os
import sys

import numpy as np
import pytest
import trimesh
from geometry_msgs.msg import Inertia, Vector3
from ros_pose_stats_msgs.msg import PartMesh, PoseStatistics
from shape_msgs.msg import Mesh

from lab.bodies import shapes
from ros_pose_stats import load_part
from tests.answers import write_stl
from tests.running import answer, answer_json, call, refusal, strict_json

from ..harness.cell import MeshPublisher, cell_of, latched
from ..harness.client import Client, until
from ..harness.jobs import known_part
from ..harness.node import Running
from ..harness.parts import WEDGE, flat, library_part, mesh, new_id
from ..harness.transports import SHARED_MEMORY

BOX = shapes.box(20.0, 30.0, 40.0)
TOPICS = "[/cad/bracket, gear=/cad/wheel, early=/cad/early]"
PART_MESH = "/workshop/pose_stats/part_mesh"
COMMAND = sys.executable, "-m", "ros_pose_stats"


@pytest.fixture(scope="module")
def clamp(tmp_path_factory):
    return write_stl(
        tmp_path_factory.mktemp("cad") / "clamp 7.stl", (1000.0 * WEDGE[0], WEDGE[1])
    )


@pytest.fixture(scope="module")
def package(tmp_path_factory, clamp):
    """The share folder of an installed package with the clamp."""
    prefix = tmp_path_factory.mktemp("prefix")
    index = prefix / "share" / "ament_index" / "resource_index" / "packages"
    index.mkdir(parents=True)
    (index / "cell_parts").touch()
    share = prefix / "share" / "cell_parts"
    share.mkdir()
    (share / "clamp.stl").write_bytes(clamp.read_bytes())
    return share


@pytest.fixture(scope="module")
def workshop(domain, tmp_path_factory, clamp, package):
    """A node whose latched publishers were there before it; two in this process, one
    command, with which it shares memory as at a user's.
    """
    with (
        Client(domain, "/workshop/pose_stats") as early,
        Running(
            *COMMAND,
            "publish",
            clamp,
            "--unit",
            "mm",
            "--mass",
            "0.06",
            "--restitution",
            "0.2",
            "--drop-height",
            "0.3",
            "--ros-args",
            "-r",
            "__ns:=/workshop",
            environment=SHARED_MEMORY,
        ) as command,
    ):
        MeshPublisher(early, latched=True).publish(flat(WEDGE, "early part"))
        MeshPublisher(early, "/cad/early", Mesh, latched=True).publish(mesh(BOX))
        output = command.says("clamp 7: ")
        with cell_of(
            domain,
            tmp_path_factory.mktemp("bags"),
            "workshop",
            mesh_topics=TOPICS,
            mesh_folders=f"[{clamp.parent}]",
            environment={**SHARED_MEMORY, "AMENT_PREFIX_PATH": str(package.parents[1])},
            mesh_unit=0.001,
        ) as (node, client):
            yield client, output
            status, complained = command.end()
            assert status == 0
            # Whether it waited for longer than five seconds, and for what, is up to the
            # machine.
            assert len(complained) <= 1
            assert all(
                line.endswith("Publishing on until one answers, or Ctrl-C")
                for line in complained
            )
            node.assert_sound()


@pytest.mark.parametrize(
    ("part_id", "expected"),
    [("early part", library_part(WEDGE)), ("early", library_part(BOX, unit="mm"))],
)
def test_latched_publishers_that_were_there_before(workshop, part_id, expected):
    client, _ = workshop
    assert latched(client, part_id).part_digest == expected.digest


def test_the_command_publishes_a_file_for_nodes_that_start_later(workshop, clamp):
    """With a unit, a mass and a scene, under the file's name; ROS arguments go to
    ROS.
    """
    client, output = workshop
    latched_statistics = latched(client, "clamp 7")
    assert output.startswith("clamp 7: ") and f"{len(WEDGE[1])} triangles" in output
    assert latched_statistics.part_digest == load_part(clamp, "mm", mass=0.06).digest
    assert (latched_statistics.restitution, latched_statistics.drop_height) == (
        0.2,
        0.3,
    )


@pytest.mark.parametrize(
    ("topic", "part_id", "is_latched"),
    [("/cad/bracket", "bracket", False), ("/cad/wheel", "gear", True)],
)
def test_standard_meshes_on_mesh_topics(workshop, topic, part_id, is_latched):
    client, _ = workshop
    MeshPublisher(client, topic, Mesh, latched=is_latched).matched().publish(mesh(BOX))
    assert latched(client, part_id).part_digest == library_part(BOX, unit="mm").digest


def test_a_mesh_by_the_file_that_holds_it(workshop, clamp):
    """With its unit, in a topic and in a request, for an estimate and for drops."""
    client, _ = workshop
    part_id = new_id()
    resource = clamp.as_uri()
    message = PartMesh(part_id=part_id, mesh_resource=resource, mesh_resource_unit="mm")
    MeshPublisher(client).matched().publish(message)
    digest = load_part(clamp, "mm").digest
    result = latched(client, part_id)
    assert result.part_digest == digest
    assert (result.unit, result.unit_guessed) == (0.001, False)
    assert client.good("estimate", part=message).statistics.part_digest == digest
    message.part_id = new_id()
    request = {"part": message, "drops": 50}
    job_id = client.good("start_drop_simulation", **request).job_id
    assert latched(client, message.part_id).part_digest == digest
    client.good("get_drop_simulation", job_id=job_id)


def test_a_body_of_a_mesh_of_several(workshop):
    client, _ = workshop
    box_in_metres = shapes.box(0.02, 0.03, 0.04)
    beside = WEDGE[0] + (1.0, 0.0, 0.0), WEDGE[1] + len(box_in_metres[0])
    pair = tuple(map(np.vstack, zip(box_in_metres, beside, strict=True)))
    refusal = client.refused("estimate", part=flat(pair))
    assert "2 that stand apart and differ: 0: " in refusal
    for body, choice, count in ((0, 0, 2), (1, 1, 2), (-2, "all", 1)):
        result = client.good("estimate", part=flat(pair, body=body)).statistics
        assert result.part_digest == library_part(pair, body=choice).digest
        assert result.bodies == count
    refusal = client.refused("estimate", part=flat(pair, body=-3))
    assert "the number of a body" in refusal


def test_files_elsewhere_are_not_read(workshop, cell, clamp, package, tmp_path):
    """Nor by links, by dots, or in a node that was given no folder."""
    client, _ = workshop
    link = clamp.parent / f"{new_id()}.stl"
    outside = write_stl(tmp_path / "outside.stl", WEDGE)
    link.symlink_to(outside)
    (package / "link.stl").unlink(missing_ok=True)
    (package / "link.stl").symlink_to(outside)
    up = "/".join([".."] * len(package.parts))
    packed = PartMesh(
        mesh_resource="package://cell_parts/clamp.stl", mesh_resource_unit="mm"
    )
    client.good("estimate", part=packed)
    for uri, words in (
        (f"{clamp.parent.as_uri()}/none.stl", "No such file"),
        ("part.stl", "file:///FILE"),
        ("package://no_such_package/part.stl", "a package that is installed"),
        (f"package://cell_parts/{up}{outside}", "mesh_folders"),
        ("package://cell_parts/link.stl", "mesh_folders"),
        (outside.as_uri(), "mesh_folders"),
        (link.as_uri(), "mesh_folders"),
        (f"{clamp.parent.as_uri()}/%2e%2e/none.stl", "mesh_folders"),
        ("file:///nowhere/%00.stl", "mesh_folders"),
    ):
        assert words in client.refused("estimate", part=PartMesh(mesh_resource=uri))
    resource = PartMesh(mesh_resource=clamp.as_uri())
    assert "mesh_folders" in cell.refused("estimate", part=resource)


def test_what_is_no_mesh_file_or_too_large_is_not_read(workshop, clamp):
    client, _ = workshop
    folder = clamp.parent / new_id()
    (folder / "folder.stl").mkdir(parents=True)
    os.mkfifo(folder / "pipe.step")
    for name, size in (("sparse.stl", 3 * 2**30), ("sparse.obj", 2**30)):
        (folder / name).touch()
        os.truncate(folder / name, size)
    for name, words in (
        ("folder.stl", "Is a directory"),
        ("pipe.step", "a pipe"),
        ("sparse.stl", "at most 67.11 MB"),
        ("sparse.obj", "at most 67.11 MB"),
    ):
        resource = PartMesh(mesh_resource=(folder / name).as_uri())
        assert words in client.refused("estimate", part=resource)


def test_a_file_whose_unit_nobody_names_is_refused_with_the_lengths(workshop, clamp):
    """The unit of arrays is none for a file, and `auto` would be a guess."""
    client, _ = workshop
    for unit in ("", "auto"):
        message = PartMesh(
            unit=0.001, mesh_resource=clamp.as_uri(), mesh_resource_unit=unit
        )
        refusal = client.refused("estimate", part=message)
        assert "its length is 40 mm in mm, 1.02 m in inch, 40 m in m, got" in refusal
        assert refusal.endswith("fill in mesh_resource_unit: mm, inch or m")
    refusal = client.refused("estimate", part=flat(WEDGE, mesh_resource_unit="mm"))
    assert "mesh_resource_unit beside a mesh_resource only" in refusal


def test_a_nameless_part_is_named_by_its_digest(cell):
    surface = 1.23 * WEDGE[0], WEDGE[1]
    digest = library_part(surface).digest
    MeshPublisher(cell).matched().publish(flat(surface))
    assert latched(cell, f"mesh_{digest[:12]}").part_digest == digest


def test_unit_and_mass_properties(cell):
    """The mesh is in its unit; centre and inertia are in metres."""
    part_id = new_id()
    large = (1000.0 * WEDGE[0], WEDGE[1])
    inertia = Inertia(
        m=0.2,
        com=Vector3(x=0.02, y=0.014, z=0.007),
        ixx=2e-5,
        ixy=1e-6,
        ixz=-2e-6,
        iyy=3e-5,
        iyz=5e-7,
        izz=4e-5,
    )
    MeshPublisher(cell).matched().publish(
        flat(large, part_id, unit=0.001, inertia=inertia)
    )
    tensor = np.array([[2e-5, 1e-6, -2e-6], [1e-6, 3e-5, 5e-7], [-2e-6, 5e-7, 4e-5]])
    expected = library_part(
        large, unit=0.001, mass=0.2, inertia=tensor, center_of_mass=(0.02, 0.014, 0.007)
    )
    assert latched(cell, part_id).part_digest == expected.digest


def test_the_unit_of_standard_meshes_follows_the_parameter(tuned):
    publisher = MeshPublisher(tuned, "/tuned/cad", Mesh).matched()
    for unit in (0.001, 0.01):
        assert tuned.set(mesh_unit=unit) == {}
        publisher.publish(mesh(BOX))
        digest = library_part((unit * BOX[0], BOX[1])).digest
        until(
            lambda digest=digest: latched(tuned, "cad").part_digest == digest,
            "the new unit",
        )


@pytest.fixture
def wedge(tmp_path):
    return write_stl(tmp_path / "wedge.stl", WEDGE)


@pytest.mark.usefixtures("domain")
class TestTheCommand:
    """How it ends, and what it refuses as the node would."""

    def test_it_gives_up_after_the_time_given(self, wedge):
        outcome = call(
            "publish",
            wedge,
            "--unit",
            "m",
            "--part-id",
            "Winkel 4×5",
            "--com",
            0.02,
            0.014,
            0.007,
            "--seconds",
            0,
            "--node",
            "/nobody",
        )
        assert outcome.stdout.startswith("Winkel 4×5: ")
        assert (
            outcome.returncode == 2
            and "no node answers on /nobody/pose_stat" in outcome.stderr
        )

    def test_it_sends_no_file_whose_unit_nobody_names(self, wedge):
        outcome = call("publish", wedge)
        assert (outcome.returncode, outcome.stdout) == (2, "")
        assert " 40 mm in m, got none; give --unit mm, " in outcome.stderr

    def test_what_came_just_before_the_time_is_over_is_printed(self, cell, wedge):
        """An estimate after which a better one might come at any moment."""
        part = load_part(wedge, unit="m")
        shown = cell.good(
            "estimate",
            part=flat((part.vertices, part.triangles), "late"),
            method="csae",
        ).statistics
        results = MeshPublisher(
            cell, "/late/pose_statistics", PoseStatistics, latched=True
        )
        with Running(
            *COMMAND,
            "publish",
            wedge,
            "--part-id",
            "late",
            "--unit",
            "m",
            "--node",
            "late",
            "--seconds",
            6,
            "--json",
        ) as command:
            command.says("Publishing on until one answers", "stderr")
            until(
                lambda: results.publish(shown) and command.process.poll() is not None,
                "its end",
            )
            output, complaint = command.process.communicate()
        assert command.process.returncode == 0, complaint
        assert json.loads(output)["method"] == "csae"

    def test_it_prints_what_the_node_answers_and_show_what_is_latched(
        self, cell, wedge
    ):
        part_id = new_id()
        part = load_part(wedge, unit="m")
        surface = part.vertices, part.triangles
        cell.good("estimate", part=flat(surface, part_id, restitution=0.25))
        arguments = (
            "publish",
            wedge,
            "--part-id",
            part_id,
            "--unit",
            "m",
            "--restitution",
            0.25,
            "--json",
        )
        published = strict_json(call(*arguments).stdout)
        assert (published["method"], published["restitution"]) == ("hybrid", 0.25)
        assert answer_json("show", part_id) == published
        statistics = latched(cell, part_id)
        table = answer("show", part_id)
        assert f"{statistics.scene}\n{len(statistics.poses)} stable poses" in table
        assert all(
            f" {100.0 * pose.probability:.2f}% " in table for pose in statistics.poses
        )
        [row] = [line for line in answer("show").splitlines() if f" {part_id} " in line]
        pose = statistics.poses[0]
        assert f"{pose.index}: {100.0 * pose.probability:.1f}, " in row

    def test_an_answer_about_another_scene_is_not_taken_for_its_own(
        self, cell, tmp_path
    ):
        """Of a mesh so fine that the node builds it while the answer before is still
        latched.
        """
        fine = trimesh.creation.box((0.02, 0.03, 0.04)).subdivide_loop(5)
        part_id = new_id()
        path = write_stl(tmp_path / "fine.stl", (fine.vertices, fine.faces))
        for height in (0.3, 0.4):
            outcome = call(
                "publish",
                path,
                "--unit",
                "m",
                "--part-id",
                part_id,
                "--drop-height",
                height,
                "--json",
            )
            assert strict_json(outcome.stdout)["drop_height"] == height

    def test_a_method_that_knows_no_heights_answers_whatever_the_height(
        self, tuned, wedge
    ):
        assert tuned.set(default_method="csae") == {}
        outcome = call(
            "publish",
            wedge,
            "--unit",
            "m",
            "--node",
            tuned.prefix,
            "--drop-height",
            0.3,
            "--seconds",
            60,
            "--json",
        )
        assert strict_json(outcome.stdout)["method"] == "csae"

    def test_show_names_the_parts_that_there_are_and_says_where_nobody_answers(
        self, cell
    ):
        assert known_part(cell) in refusal("show", "nothing of that name")
        assert "on /nobody/get_statistics, got none" in refusal(
            "show", "--node", "/nobody"
        )

    def test_show_asks_the_node_that_remappings_lead_to(self, tuned):
        part_id = known_part(tuned)
        cell = tuned.prefix.rpartition("/")[0]
        renamed = [f"desk/get_statistics:={tuned.prefix}/get_statistics"]
        for words in (
            ["--ros-args", "-r", f"__ns:={cell}"],
            ["--node", "desk", "--ros-args", "-r", *renamed],
        ):
            outcome = call("show", part_id, "--json", *words)
            assert strict_json(outcome.stdout)["part_id"] == part_id

    def test_show_goes_on_with_new_results(self, cell, tmp_path, monkeypatch):
        """And prints nothing else, whatever the middleware complains of."""
        part_id = known_part(cell)
        monkeypatch.setenv("FASTRTPS_DEFAULT_PROFILES_FILE", str(tmp_path / "none.xml"))
        monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
        with Running(*COMMAND, "show", part_id, "--watch", "--json") as command:
            first = json.loads(command.says(""))
            cell.good("forget_part", part_id=part_id)
            last = json.loads(command.says(""))
            assert command.end()[0] == 0
        assert first["poses"] and not last["poses"]
        assert last["warnings"][0]["code"] == "FORGOTTEN"

    @pytest.mark.parametrize(
        "content", [b"", b"solid nothing\nendsolid nothing\n", b"\0" * 84, b"\0" * 100]
    )
    def test_files_that_hold_no_mesh(self, tmp_path, content):
        path = tmp_path / "bad.stl"
        path.write_bytes(content)
        line = refusal("publish", path)
        assert "bad.stl" in line or "triangles" in line

    def test_a_flat_part(self, tmp_path):
        vertices, triangles = WEDGE
        path = write_stl(
            tmp_path / "plane.stl", (vertices * (1.0, 1.0, 0.0), triangles)
        )
        assert "thick" in refusal("publish", path, "--unit", "m")

    @pytest.mark.parametrize(
        ("arguments", "words"),
        [
            (["--com", 1000.0, 0.0, 0.0], "centre of mass"),
            (["--mass", 0], "finite mass above 0 kg"),
            (["--seconds", -1], "seconds"),
            (["--part-id", "x" * 300], "at most 200"),
            (["--part-id", "a\nb"], "printable"),
            (["--node", "two words"], "ROS topic"),
            (["--ros-args", "-r", "x"], "ROS arguments that rcl can read"),
            *[
                (["--restitution", value], "restitution from 0")
                for value in (1.0, -0.5, "nan")
            ],
            *[(["--drop-height", value], "drop height above 0") for value in (0, -1.0)],
        ],
    )
    def test_what_the_node_would_refuse(self, wedge, arguments, words):
        assert words in refusal("publish", wedge, "--unit", "m", *arguments)

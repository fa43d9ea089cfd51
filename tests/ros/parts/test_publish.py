"""The command `publish PART`."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from ros_pose_stats import load_part
from ros_pose_stats.errors import PoseStatsError
from ros_pose_stats.ros.part_publisher import publish_part
from tests.bodies import write_stl
from tests.running import complaints

from ..harness.cell import cell_of, latched
from ..harness.client import until
from ..harness.node import PATIENCE
from ..harness.parts import WEDGE
from ..test_signals import catches

MILLIMETRES = 1000.0 * WEDGE[0], WEDGE[1]


class Publishing:
    """The command in a process of its own."""

    def __init__(self, *arguments):
        self.process = subprocess.Popen(
            [sys.executable, "-m", "ros_pose_stats", "publish", *map(str, arguments)],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=dict(os.environ))

    def said(self):
        """The line that it prints once the part is published."""
        return self.process.stdout.readline()

    def end(self, number=signal.SIGINT):
        """Its exit status and its complaints."""
        if number:
            self.process.send_signal(number)
        _, error = self.process.communicate(timeout=PATIENCE)
        return self.process.returncode, complaints(error)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        if self.process.poll() is None:
            self.process.kill()
            self.process.communicate()


@pytest.fixture(scope="module")
def started(domain, tmp_path_factory):
    with cell_of(domain, tmp_path_factory.mktemp("bags"), "published",
                 mesh_topics="[]") as (node, client):
        yield node, client


@pytest.fixture
def client(started):
    yield started[1]
    started[0].assert_sound()


@pytest.fixture(scope="module")
def clamp(tmp_path_factory):
    return write_stl(tmp_path_factory.mktemp("cad") / "clamp 7.stl", MILLIMETRES)


TOPIC = ("--topic", "/published/pose_stats/part_mesh")


class TestPublishing:
    @pytest.mark.long
    def test_until_ctrl_c(self, client, clamp):
        with Publishing(clamp, "--unit", "mm", *TOPIC) as publishing:
            said = publishing.said()
            assert said.startswith("clamp 7: ") and f"{len(WEDGE[1])} triangles" in said
            assert said.endswith(f" published on {TOPIC[1]}\n")
            shown = latched(client, "clamp 7")
            assert shown.part_digest == load_part(clamp, "mm").digest
            assert publishing.end() == (0, [])

    @pytest.mark.parametrize(("number", "delay"), [(signal.SIGINT, 0.0), (signal.SIGTERM, 0.1)])
    def test_ends_well_before_it_is_published(self, domain, clamp, number, delay):
        with Publishing(clamp, *TOPIC) as publishing:
            until(lambda: catches(publishing.process, signal.SIGTERM), "the handlers")
            time.sleep(delay)
            assert publishing.end(number) == (0, [])

    @pytest.mark.long
    def test_for_a_while_under_another_name(self, client, clamp):
        with Publishing(clamp, "--unit", "cm", "--part-id", "other", "--com", 2, 1.4, 0.7,
                        "--seconds", "3", *TOPIC) as publishing:
            shown = latched(client, "other")
            assert publishing.end(None) == (0, [])
        expected = load_part(clamp, "cm", center_of_mass=np.array([2.0, 1.4, 0.7]) / 100.0)
        assert shown.part_digest == expected.digest

    def test_with_a_mass_and_a_scene_of_its_own(self, client, clamp):
        with Publishing(clamp, "--unit", "mm", "--part-id", "dropped low", "--restitution", "0.2",
                        "--drop-height", "0.3", "--mass", "0.06", *TOPIC) as publishing:
            publishing.said()
            shown = latched(client, "dropped low")
            assert publishing.end() == (0, [])
        assert (shown.restitution, shown.drop_height) == (0.2, 0.3)
        assert shown.part_digest == load_part(clamp, "mm", mass=0.06).digest

    def test_a_node_that_starts_later_has_it_too(self, domain, tmp_path, clamp):
        topic = "/later/pose_stats/part_mesh"
        with Publishing(clamp, "--part-id", "early bird", "--topic", topic) as publishing:
            publishing.said()
            with cell_of(domain, tmp_path, "later") as (_, client):
                assert latched(client, "early bird").warnings  # clamp of 40 m
            assert publishing.end() == (0, [])

    @pytest.mark.long
    def test_a_remapped_name(self, client, clamp):
        """ROS arguments go to ROS."""
        with Publishing(clamp, "--part-id", "remapped", "--topic", "meshes", "--ros-args",
                        "-r", f"meshes:={TOPIC[1]}") as publishing:
            publishing.said()
            latched(client, "remapped")
            assert publishing.end() == (0, [])


class TestRefusals:
    @pytest.mark.parametrize(("arguments", "said"), [
        (["no such file.stl"], "no such file"), (["{clamp}", "--topic", "two words"], "topic")])
    def test_status_and_one_line(self, domain, clamp, arguments, said):
        with Publishing(*[one.format(clamp=clamp) for one in arguments]) as publishing:
            status, lines = publishing.end(None)
        assert status == 2, (status, lines)
        assert len(lines) == 1 and said in lines[0].lower(), lines

    @pytest.mark.parametrize("content", [
        b"", b"solid nothing\nendsolid nothing\n", b"\0" * 84, b"\0" * 100])
    def test_files_that_hold_no_mesh(self, tmp_path, content):
        path = tmp_path / "bad.stl"
        path.write_bytes(content)
        assert_refused("bad.stl|triangles", path)

    def test_a_flat_part(self, tmp_path):
        vertices, triangles = WEDGE
        assert_refused("thick", write_stl(tmp_path / "plane.stl",
                                          (vertices * (1.0, 1.0, 0.0), triangles)))

    def test_what_the_node_would_refuse(self, clamp):
        assert_refused("centre of mass", clamp, center_of_mass=(1000.0, 0.0, 0.0))
        assert_refused("finite mass above 0 kg", clamp, mass=0.0)
        assert_refused("seconds", clamp, seconds=-1.0)
        assert_refused("restitution from 0", clamp, restitution=1.0)
        assert_refused("restitution from 0", clamp, restitution=-0.5)
        assert_refused("restitution from 0", clamp, restitution=float("nan"))
        assert_refused("drop height above 0", clamp, drop_height=0.0)
        assert_refused("drop height above 0", clamp, drop_height=-1.0)
        assert_refused("part_id of at most", clamp, part_id="x" * 300)
        assert_refused("part_id of at most", clamp, part_id="a\nb")


def assert_refused(said, file, unit=None, center_of_mass=None, part_id="", seconds=None,
                   **given):
    with pytest.raises(PoseStatsError, match=said):
        publish_part(str(file), unit, center_of_mass, part_id, "topic", seconds, [], **given)

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

"""The bag of a run: what was published, answered, counted and dropped, read whole by
others.
"""

from collections import defaultdict
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
import yaml
from geometry_msgs.msg import Inertia, Vector3
from mcap.reader import make_reader
from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs.msg import JobStatus, PoseCounts, PoseStatistics
from shape_msgs.msg import Mesh

from ros_pose_stats import analyse_bags, part_from_mesh
from tests.contract.node.harness.bags import (
    KINDS,
    assert_readable_by_others,
    bags_of,
    files_of,
    message_of,
    on_topic,
    raw,
)
from tests.contract.node.harness.cell import MeshPublisher, cell_of, latched
from tests.contract.node.harness.client import until
from tests.contract.node.harness.goals import Goals
from tests.contract.node.harness.jobs import (
    LONG,
    cancelled,
    finished,
    running_with_results,
    start,
)
from tests.contract.node.harness.parts import WEDGE, counts, flat, mesh, nested, whole
from tests.running import answer, answer_json

from .rosbag2 import assert_played_by_time

INERTIA = Inertia(
    m=0.2, com=Vector3(x=0.02, y=0.014, z=0.007), ixx=2e-5, iyy=3e-5, izz=4e-5
)
VERTICES, TRIANGLES = WEDGE
NAMELESS = f"mesh_{part_from_mesh(3.0 * VERTICES, TRIANGLES).digest[:12]}"
FACTORS = {"flat": 1.0, "millimetres": 1000.0, "nested": 2.0, "cad": 1.0, NAMELESS: 3.0}


class Run(NamedTuple):
    """A bag, what clients saw of its run, and what the library said of it meanwhile."""

    bag: Path
    published: list
    answers: list
    counts: list
    ends: dict
    live: object


def camera_message(numbers):
    """With every field filled in."""
    message = PoseCounts(
        part_id="flat",
        numbering=2**64 - 1,
        plate="steel",
        drop_height=0.3,
        index=list(range(len(numbers))),
        count=numbers,
        unclassified=2**40,
    )
    message.header.stamp.sec = 12
    message.header.stamp.nanosec = 34
    message.header.frame_id = "camera"
    return serialize_message(message)


def send_parts(client):
    """Every way, and the full one twice."""
    meshes = [
        flat(WEDGE, "flat", restitution=0.25, drop_height=0.7),
        flat(
            (1000.0 * VERTICES, TRIANGLES), "millimetres", unit=0.001, inertia=INERTIA
        ),
        nested((2.0 * VERTICES, TRIANGLES), "nested"),
        flat((3.0 * VERTICES, TRIANGLES)),
    ]
    MeshPublisher(client).matched().publish(*meshes, *meshes)
    MeshPublisher(client, "/recorded/cad", Mesh).matched().publish(mesh(WEDGE))
    for part_id in FACTORS:
        until(lambda part_id=part_id: latched(client, part_id).drops, "its check")


def ask(client):
    """Estimates, simulations and a goal: what was answered, and how each job ended."""
    answers = [
        client.good("estimate", part_id="flat", **fields).statistics
        for fields in ({}, {"method": "csae"}, {"restitution": 0.1})
    ]
    jobs = {}
    for part_id, drops in (("flat", 1000), ("nested", 200)):
        job_id = start(client, part_id, drops, seed=9)
        jobs[job_id] = JobStatus.DONE
        answers.append(finished(client, job_id).statistics)
    job_id = start(client, "cad", LONG)
    running_with_results(client, job_id)
    jobs[job_id] = JobStatus.CANCELLED
    answers.append(cancelled(client, job_id).statistics)
    goals = Goals(client)
    _, result = goals.send(part_id="millimetres", drops=300).result()
    goals.close()
    jobs[result.job_id] = JobStatus.DONE
    client.good("forget_part", part_id="cad")
    return [*answers, result.statistics], jobs


@pytest.fixture(scope="module")
def run(domain, tmp_path_factory):
    """A run that ended well."""
    folder = tmp_path_factory.mktemp("bags")
    published = []
    messages = [camera_message(numbers) for numbers in ([], [5], [1, 2, 3], [2**63, 0])]
    with cell_of(
        domain[0],
        folder,
        "recorded",
        environment=domain[1],
        log_drops="true",
        plate="steel",
        mesh_topics="[/recorded/cad]",
    ) as (node, client):
        client.subscribe(
            PoseStatistics,
            f"{client.prefix}/pose_statistics",
            published.append,
            latched=True,
            raw=True,
        )
        send_parts(client)
        MeshPublisher(
            client, f"{client.prefix}/pose_counts", PoseCounts
        ).matched().publish(*messages)
        answers, jobs = ask(client)
        (bag,) = bags_of(folder)
        until(
            lambda: len(of(bag, "pose_counts")) == len(messages),
            "the counts in the bag",
        )
        until(
            lambda: newest(of(bag, "pose_statistics")) == newest(published),
            "results in the bag",
        )
        live = analyse_bags(folder)
        node.stop()
    return Run(bag, published, answers, messages, jobs, live)


def of(bag, topic):
    """Bytes of the messages of one topic."""
    return [data for name, data in raw(bag) if name == on_topic(topic)]


def newest(results):
    """The last revision of each part."""
    recorded = [deserialize_message(data, PoseStatistics) for data in results]
    return {
        statistics.part_id: statistics.revision
        for statistics in sorted(recorded, key=lambda statistics: statistics.revision)
    }


def messages(bag, topic):
    return [message_of(on_topic(topic), data) for data in of(bag, topic)]


class TestTopics:
    def test_pose_statistics_is_what_was_published(self, run):
        """Of a part's first ones a subscriber misses those replaced before it has found
        them.
        """
        recorded = list(map(whole, messages(run.bag, "pose_statistics")))
        assert all(
            whole(deserialize_message(data, PoseStatistics)) in recorded
            for data in run.published
        )
        assert (
            len(recorded) >= 6
        )  # five estimates, and the drops of "flat", which are surer

    def test_answers_are_what_was_answered(self, run):
        assert sorted(map(whole, messages(run.bag, "answers"))) == sorted(
            map(whole, run.answers)
        )

    def test_counts_are_unchanged(self, run):
        recorded = [deserialize_message(data, PoseCounts) for data in run.counts]
        assert (
            messages(run.bag, "pose_counts") == recorded
        )  # padding in CDR may hold anything

    def test_a_part_is_there_once_as_it_was_received(self, run):
        meshes = {
            message.part_id: message for message in messages(run.bag, "part_mesh")
        }
        assert len(of(run.bag, "part_mesh")) == len(meshes) == len(FACTORS)
        for part_id, factor in FACTORS.items():
            message = meshes[part_id]
            assert list(message.vertices) == (factor * VERTICES).ravel().tolist()
            assert list(message.triangles) == TRIANGLES.ravel().tolist()
            assert not message.mesh.vertices  # standard meshes are converted
        assert (meshes["flat"].restitution, meshes["flat"].drop_height) == (0.25, 0.7)
        assert (meshes["millimetres"].unit, meshes["millimetres"].inertia) == (
            0.001,
            INERTIA,
        )

    def test_a_mesh_stands_before_the_first_result_of_it(self, run):
        parts = [
            (topic, message_of(topic, data).part_id)
            for topic, data in raw(run.bag)
            if topic in map(on_topic, ("part_mesh", "pose_statistics", "answers"))
        ]
        for part_id in FACTORS:
            first = next(topic for topic, of_part in parts if of_part == part_id)
            assert first == on_topic("part_mesh"), part_id

    def test_job_events_are_each_job_s_life(self, run):
        lives = defaultdict(list)
        for event in messages(run.bag, "job_events"):
            lives[event.status.job_id].append(event)
        assert [
            (event.part_forgotten, event.status.part_id) for event in lives.pop("")
        ] == [(True, "cad")]
        assert {
            job_id: [event.status.state for event in life]
            for job_id, life in lives.items()
        } == {
            job_id: [JobStatus.QUEUED, JobStatus.RUNNING, end]
            for job_id, end in run.ends.items()
        }
        answers = {message.job_id: message for message in run.answers}
        for job_id, life in lives.items():
            assert life[-1].status.drops_done == answers[job_id].drops
            assert life[-1].part_digest == answers[job_id].part_digest
            assert {event.seed for event in life} == {answers[job_id].seed}

    def test_drop_records_add_up_to_the_counts(self, run):
        for job_id in run.ends:
            reported = next(
                message for message in run.answers if message.job_id == job_id
            )
            records = [
                message
                for message in messages(run.bag, "drop_records")
                if message.job_id == job_id
            ]
            ends = np.cumsum([len(record.pose_index) for record in records])
            assert [record.first_drop for record in records] == [0, *ends[:-1]]
            assert (
                ends[-1] >= reported.drops
            )  # a cancelled run has a few that nobody counted
            poses = np.concatenate([record.pose_index for record in records])[
                : reported.drops
            ]
            assert np.count_nonzero(poses < 0) == reported.unsettled
            assert counts(reported.poses) == {
                pose.index: np.count_nonzero(poses == pose.index)
                for pose in reported.poses
            }
            downs = np.concatenate([record.start_down for record in records]).reshape(
                -1, 3
            )
            assert len(downs) == ends[-1] and np.linalg.norm(
                downs, axis=1
            ) == pytest.approx(1.0)


class TestReaders:
    def test_rosbags_and_mcap_read_every_message(self, run):
        assert_readable_by_others(run.bag)
        assert {topic for topic, _ in raw(run.bag)} == set(map(on_topic, KINDS))

    def test_rosbag2_plays_it_by_time(self, run):
        (file,) = files_of(run.bag)
        assert_played_by_time(file)

    def test_its_description_is_complete(self, run):
        text = (run.bag / "metadata.yaml").read_text()
        information = yaml.safe_load(text)["rosbag2_bagfile_information"]
        assert set(information) == {
            "version",
            "storage_identifier",
            "duration",
            "starting_time",
            "message_count",
            "topics_with_message_count",
            "compression_format",
            "compression_mode",
            "relative_file_paths",
            "files",
            "custom_data",
            "ros_distro",
        }
        assert information["message_count"] == len(raw(run.bag))
        assert information["relative_file_paths"] == [
            file.name for file in files_of(run.bag)
        ]
        for topic in information["topics_with_message_count"]:
            name = topic["topic_metadata"]["name"]
            assert topic["message_count"] == sum(
                recorded_topic == name for recorded_topic, _ in raw(run.bag)
            )
            (quality,) = topic["topic_metadata"]["offered_qos_profiles"]
            is_latched = name in map(on_topic, ("part_mesh", "pose_statistics"))
            assert quality["durability"] == (
                "transient_local" if is_latched else "volatile"
            )
        (file,) = files_of(run.bag)
        with file.open("rb") as stream:
            reader = make_reader(stream, validate_crcs=True)
            header = reader.get_header()
            summary = reader.get_summary()
        assert (header.profile, header.library.split()[0]) == ("ros2", "ros_pose_stats")
        assert summary.statistics.message_count == information["message_count"]

    def test_the_command_bag_says_it_all_also_while_it_is_written(self, run):
        text = answer("bag", run.bag)
        values = answer_json("bag", run.bag)
        assert all(f"== {part_id} (" in text for part_id in FACTORS)
        jobs = {
            job["job_id"]: job["state"]
            for part in values["parts"]
            for job in part["jobs"]
        }
        states = {JobStatus.DONE: "done", JobStatus.CANCELLED: "cancelled"}
        assert jobs == {job_id: states[end] for job_id, end in run.ends.items()}
        assert values["files"][0]["state"] == "whole"
        (file,) = run.live.contents.files
        assert file.state == "open"
        for kind, number in run.live.contents.messages.items():
            assert 0 < number <= values["messages"][kind]

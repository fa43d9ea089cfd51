"""The bag of a run holds what was published, answered, counted and dropped, and nothing else."""

from __future__ import annotations

import numpy as np
import pytest
import yaml
from geometry_msgs.msg import Inertia, Vector3
from rclpy.serialization import deserialize_message, serialize_message
from ros_pose_stats_msgs.msg import JobEvent, PoseCounts, PoseStatistics
from shape_msgs.msg import Mesh

from ros_pose_stats import simulate
from ros_pose_stats.recording.run_names import bag_files, runs
from tests.running import command

from ..harness.cell import MeshPublisher, cell_of, latched
from ..harness.client import until
from ..harness.goals import Goals
from ..harness.jobs import LONG, cancelled, finished, running_with_results, start
from ..harness.parts import WEDGE, counts, flat, library_part, mesh, nested, whole
from ..harness.readers import TYPES, by_mcap_ros2, by_rosbags, message_of, on_topic, raw, same

DROPS = 3000
INERTIA = Inertia(m=0.2, com=Vector3(x=0.02, y=0.014, z=0.007), ixx=2e-5, iyy=3e-5, izz=4e-5)
VERTICES, TRIANGLES = WEDGE


class Told:
    """What clients saw of the run."""

    def __init__(self):
        self.published = []
        self.answers = []
        self.counts = []
        self.meshes = []
        self.jobs = {}


def counted(part_id, numbers):
    """A camera's message, with every field filled in."""
    message = PoseCounts(part_id=part_id, part_digest="ab" * 32, cluster_tolerance=0.005,
                         round_sides=192, plate="steel", drop_height=0.3,
                         index=list(range(len(numbers))), count=numbers, unclassified=2**40)
    message.header.stamp.sec, message.header.stamp.nanosec = 12, 34
    message.header.frame_id = "camera"
    return message


def send_meshes(client, told):
    """Parts by every way; what arrived of them."""
    told.meshes = [
        flat(WEDGE, "flat", restitution=0.25, drop_height=0.7),
        flat((1000.0 * VERTICES, TRIANGLES), "millimetres", unit=0.001, inertia=INERTIA),
        nested((2.0 * VERTICES, TRIANGLES), "nested"), flat((3.0 * VERTICES, TRIANGLES))]
    publisher = MeshPublisher(client).matched()
    publisher.publish(*told.meshes, *told.meshes)
    MeshPublisher(client, "/recorded/cad", Mesh).matched().publish(mesh(WEDGE))
    for part_id in ("flat", "millimetres", "nested", "cad"):
        latched(client, part_id)
    client.good("estimate", part=told.meshes[0])


def ask(client, told):
    """Estimates, simulations and a goal; what was answered."""
    for fields in ({}, {"method": "csae"}, {"restitution": 0.1}):
        told.answers.append(client.good("estimate", part_id="flat", **fields).statistics)
    for part_id, drops in (("flat", DROPS), ("nested", 200)):
        job_id = start(client, part_id, drops, seed=9)
        told.jobs[job_id] = JobEvent.DONE
        told.answers.append(finished(client, job_id).statistics)
    job_id = start(client, "cad", LONG)
    running_with_results(client, job_id)
    told.jobs[job_id] = JobEvent.CANCELLED
    told.answers.append(cancelled(client, job_id).statistics)
    _, result = Goals(client).send(part_id="millimetres", drops=300).result()
    told.jobs[result.job_id] = JobEvent.DONE
    told.answers.append(result.statistics)
    client.good("forget_part", part_id="cad")


@pytest.fixture(scope="module")
def run(domain, tmp_path_factory):
    """The bag of a run that ended well, and what was told in it."""
    folder, told = tmp_path_factory.mktemp("bags"), Told()
    with cell_of(domain, folder, "recorded", log_drops="true", plate="steel",
                 mesh_topics="[/recorded/cad]") as (node, client):
        client.subscribe(PoseStatistics, f"{client.prefix}/pose_statistics",
                         told.published.append, latched=True, raw=True)
        send_meshes(client, told)
        camera = MeshPublisher(client, f"{client.prefix}/pose_counts", PoseCounts).matched()
        for numbers in ([], [5], [1, 2, 3], [2**63, 0]):
            told.counts.append(serialize_message(counted("flat", numbers)))
        camera.publish(*told.counts)
        ask(client, told)
        until(lambda: len(of(runs(folder)[0], "pose_counts")) == len(told.counts))
        until(lambda: len(of(runs(folder)[0], "pose_statistics")) == len(told.published))
        node.stop()
    (bag,) = runs(folder)
    return bag, told


def of(bag, topic):
    """Bytes of the messages of one topic."""
    return [data for name, data in raw(bag) if name == on_topic(topic)]


def messages(bag, topic):
    return [message_of(on_topic(topic), data) for data in of(bag, topic)]


class TestTopics:
    def test_pose_statistics_is_what_was_published(self, run):
        bag, told = run
        published = [whole(deserialize_message(data, PoseStatistics)) for data in told.published]
        assert sorted(map(whole, messages(bag, "pose_statistics"))) == sorted(published)
        assert len(published) >= 6  # five estimates, and the drops of "flat", which are surer

    def test_answers_are_what_was_answered(self, run):
        bag, told = run
        recorded = list(map(whole, messages(bag, "answers")))
        answered = list(map(whole, told.answers))
        assert set(answered) <= set(recorded)
        carried = len(recorded) - len(answered)
        assert carried == 1  # the one of `send_meshes`

    def test_counts_are_unchanged(self, run):
        bag, told = run
        assert of(bag, "pose_counts") == told.counts

    def test_part_mesh_once_a_digest_as_received(self, run):
        bag, _ = run
        found = {message.part_id: message for message in messages(bag, "part_mesh")}
        nameless = f"mesh_{library_part((3.0 * VERTICES, TRIANGLES)).digest[:12]}"
        assert len(of(bag, "part_mesh")) == len(found) == 5
        assert set(found) == {"flat", "millimetres", "nested", "cad", nameless}
        for message in found.values():
            assert not message.mesh.vertices and not message.mesh.triangles
            assert list(message.triangles) == TRIANGLES.ravel().tolist()
            assert message.header.stamp.sec > 10**9
        for part_id, factor in (("flat", 1.0), ("millimetres", 1000.0), ("nested", 2.0),
                                ("cad", 1.0), (nameless, 3.0)):
            assert list(found[part_id].vertices) == (factor * VERTICES).ravel().tolist()
        assert (found["flat"].restitution, found["flat"].drop_height) == (0.25, 0.7)
        assert found["millimetres"].unit == 0.001 and found["millimetres"].inertia == INERTIA
        assert found["nested"].unit == 1.0 and found["nested"].inertia == Inertia()

    def test_job_events_tell_each_jobs_life(self, run):
        bag, told = run
        lives = {}
        for event in messages(bag, "job_events"):
            lives.setdefault(event.job_id, []).append(event)
        forgotten = lives.pop("")
        assert [(event.event, event.part_id) for event in forgotten] == [
            (JobEvent.PART_FORGOTTEN, "cad")]
        assert {job_id: [event.event for event in life] for job_id, life in lives.items()} == {
            job_id: [JobEvent.QUEUED, JobEvent.RUNNING, end] for job_id, end in told.jobs.items()}
        answers = {message.job_id: message for message in told.answers}
        for job_id, life in lives.items():
            assert life[-1].drops_done == answers[job_id].drops
            assert life[-1].part_digest == answers[job_id].part_digest
            assert {event.seed for event in life} == {answers[job_id].seed}

    def test_drop_records_add_up_and_are_the_simulations_own(self, run):
        bag, told = run
        for job_id in told.jobs:
            answer = next(one for one in told.answers if one.job_id == job_id)
            found = [one for one in messages(bag, "drop_records") if one.job_id == job_id]
            first = 0
            for one in found:
                assert one.first_drop == first and one.part_digest == answer.part_digest
                first += len(one.pose_index)
            assert first >= answer.drops  # a cancelled run has a few that nobody counted
            poses = np.concatenate([one.pose_index for one in found])[:answer.drops]
            assert np.count_nonzero(poses < 0) == answer.unsettled
            assert counts(answer.poses) == {
                pose.index: np.count_nonzero(poses == pose.index) for pose in answer.poses}

    def test_drop_records_are_those_of_the_library(self, run):
        bag, told = run
        answer = next(one for one in told.answers if one.drops == DROPS)
        found = [one for one in messages(bag, "drop_records") if one.job_id == answer.job_id]
        chunks = []
        simulate(library_part(WEDGE), DROPS, 0.25, 9, 0.7, on_drops=chunks.append)
        for name, expected in (
                ("start_down", [chunk.downs.astype(np.float32).ravel() for chunk in chunks]),
                ("pose_index", [chunk.outcomes.pose for chunk in chunks]),
                ("impacts", [chunk.outcomes.impacts for chunk in chunks]),
                ("seconds", [chunk.outcomes.seconds.astype(np.float32) for chunk in chunks]),
                ("energy_left", [chunk.outcomes.energy_left.astype(np.float32)
                                 for chunk in chunks])):
            recorded = np.concatenate([getattr(one, name) for one in found])
            assert np.array_equal(recorded, np.concatenate(expected)), name


class TestReaders:
    @pytest.mark.parametrize("read", [by_rosbags, by_mcap_ros2])
    def test_other_peoples(self, run, read):
        bag, _ = run
        found = read(bag)
        assert [(topic, data) for topic, data, _ in found] == raw(bag)
        assert all(same(decoded, message_of(topic, data)) for topic, data, decoded in found)

    def test_metadata_is_complete(self, run):
        bag, _ = run
        about = yaml.safe_load((bag / "metadata.yaml").read_text())["rosbag2_bagfile_information"]
        assert set(about) == {
            "version", "storage_identifier", "duration", "starting_time", "message_count",
            "topics_with_message_count", "compression_format", "compression_mode",
            "relative_file_paths", "files", "custom_data", "ros_distro"}
        topics = {topic["topic_metadata"]["name"]: topic
                  for topic in about["topics_with_message_count"]}
        assert set(topics) == set(TYPES)
        for name, topic in topics.items():
            assert topic["message_count"] == sum(one == name for one, _ in raw(bag)) > 0
            assert topic["topic_metadata"]["type"] == TYPES[name].name
            assert topic["topic_metadata"]["type_description_hash"] == TYPES[name].type_hash
            assert TYPES[name].type_hash.startswith("RIHS01_")
        assert about["message_count"] == len(raw(bag))
        assert about["relative_file_paths"] == [file.name for file in bag_files(bag)]

    def test_nothing_lies_beside_it(self, run):
        bag, _ = run
        assert {path.name for path in bag.iterdir()} == {
            "metadata.yaml", ".lock", *[file.name for file in bag_files(bag)]}

    def test_the_command_bag(self, run):
        bag, told = run
        done = command("bag", bag)
        assert done.returncode == 0, done.stderr
        for part_id in ("flat", "millimetres", "nested", "cad"):
            assert part_id in done.stdout
        answer = command("bag", bag, "--json").stdout
        assert all(job_id in answer for job_id in told.jobs)

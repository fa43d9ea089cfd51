"""What a node begins with that finds the bags of an earlier one."""

from __future__ import annotations

import signal

import pytest
from ros_pose_stats_msgs.msg import JobEvent
from shape_msgs.msg import Mesh

from ros_pose_stats.recording.run_names import runs
from ros_pose_stats.ros.restart.earlier_runs import RUNS_TAKEN_IN
from ros_pose_stats.ros.restart.last_run import PART_RESTORED

from ..harness.bags import recorded
from ..harness.cell import Health, MeshPublisher, cell_of, latched
from ..harness.client import CANCELLED, until
from ..harness.jobs import LONG, finished, get, running_with_results, start
from ..harness.parts import WEDGE, counts, flat, library_part, mesh, probabilities, whole
from ..harness.readers import assert_readable_by_others
from .test_last_run import Writing

VERTICES, TRIANGLES = WEDGE


def scaled(factor):
    return factor * VERTICES, TRIANGLES


@pytest.fixture
def again(domain, tmp_path):
    """Starts one node after the other on the same folder."""
    def start_again(**values):
        return cell_of(domain, tmp_path, "again", mesh_topics="[/again/cad]", **values)

    return start_again


def shown(client):
    """What is latched, by part."""
    return {message.part_id: message for message in client.call("get_statistics").statistics}


def first_life(client):
    """Parts of all kinds; what is latched for them in the end."""
    client.good("estimate", part=flat(WEDGE, "estimated"))
    client.good("estimate", part=flat(scaled(1.1), "simulated"))
    finished(client, start(client, "simulated", 5000, seed=3))
    client.good("estimate", part=flat(WEDGE, "wishes", restitution=0.2, drop_height=1.5))
    finished(client, start(client, "wishes", 2000, seed=4))
    for factor in (1.2, 1.3, 1.2):
        client.good("estimate", part=flat(scaled(factor), "back again"))
    client.good("estimate", part=flat(WEDGE, "forgotten"))
    client.good("forget_part", part_id="forgotten")
    client.good("estimate", part=flat(WEDGE, "remembered"))
    client.good("forget_part", part_id="remembered")
    client.good("estimate", part=flat(WEDGE, "remembered"))
    MeshPublisher(client, "/again/cad", Mesh).matched().publish(mesh(scaled(1.4)))
    latched(client, "cad")
    return shown(client)


def assert_restored(client, before):
    """All parts with their results, as soon as the node is ready."""
    with client.late_joiner() as joiner:
        now = {part_id: joiner.wait(part_id) for part_id in before}
        assert joiner.parts() == set(before)
    assert {part_id: whole(message) for part_id, message in now.items()} == {
        part_id: whole(message) for part_id, message in shown(client).items()}
    for part_id, message in now.items():
        old = before[part_id]
        assert (message.part_digest, message.drops, message.method) == (
            old.part_digest, old.drops, old.method)
        assert probabilities(message.poses) == probabilities(old.poses)
        assert counts(message.poses) == counts(old.poses)
        assert message.revision >= old.revision and message.final
    return now


@pytest.mark.long
def test_through_many_lives(again, tmp_path):
    with again() as (node, client):
        first = first_life(client)
    assert set(first) == {"estimated", "simulated", "wishes", "back again", "remembered", "cad"}
    assert first["back again"].part_digest == library_part(scaled(1.2)).digest
    with again() as (node, client):
        now = assert_restored(client, first)
        assert whole(now["simulated"]) == whole(first["simulated"])
        better = finished(client, start(client, "simulated", 20_000, seed=5)).statistics
        assert better.revision > now["simulated"].revision
        job_id = start(client, "wishes", LONG)
        running_with_results(client, job_id)
        second = shown(client)
        node.kill()
    with again() as (node, client):
        assert_restored(client, {**second, "wishes": second["wishes"]})
        assert get(client, job_id).state == CANCELLED
        _, values = Health(client).line("recording")
        assert runs(tmp_path)[-2].name in values["last repair"]
        assert f"{runs(tmp_path)[-2].name} mended" in node.log
    with again() as (node, client):
        assert_restored(client, second)
        assert get_unknown(client, job_id)
        assert Health(client).line("recording")[1]["last repair"] == "none"
    with again(restore="false") as (node, client):
        assert shown(client) == {}
    for bag in runs(tmp_path):
        assert_readable_by_others(bag)
    ends = [event for event in recorded(tmp_path, "job_events")
            if event.job_id == job_id and event.event >= JobEvent.DONE]
    assert [event.event for event in ends] == [JobEvent.CANCELLED]


def get_unknown(client, job_id):
    """The message about a job of a run before the last."""
    return client.refused("get_drop_simulation", job_id=job_id)


def test_a_refined_estimate_comes_back_and_still_answers(again):
    asked = {"part_id": "part", "target_error": 0.01}
    with again() as (_, client):
        client.good("estimate", part=flat(WEDGE, "part"))
        client.good("estimate", **asked)
        until(lambda: shown(client)["part"].method == "hybrid" and shown(client)["part"].final)
        before = shown(client)
    with again() as (_, client):
        now = assert_restored(client, before)
        found = client.good("estimate", **asked).statistics
        assert whole(found) == whole(now["part"])
        assert not client.call("list_drop_simulations").job_id


@pytest.mark.long
def test_other_parameters(again):
    with again() as (_, client):
        client.good("estimate", part=flat(WEDGE, "part"))
        client.good("estimate", part=flat(WEDGE, "wishes", restitution=0.5))
        for part_id in ("part", "wishes"):
            finished(client, start(client, part_id, 5000))
        before = shown(client)
    with again(restitution=0.3) as (_, client):
        now = shown(client)
        assert (now["part"].method, now["part"].restitution) == ("split", 0.3)
        assert now["part"].revision > before["part"].revision
        assert whole(now["wishes"]) == whole(before["wishes"])
    with again(plate_frame="feeder", plate="steel", cluster_tolerance=0.0) as (_, client):
        for message in shown(client).values():
            assert (message.header.frame_id, message.plate) == ("feeder", "steel")
            assert (message.drops, message.cluster_tolerance) == (0, 0.0)
    with again(cluster_tolerance=0.0, round_sides=0) as (_, client):
        for message in shown(client).values():
            assert (message.drops, message.round_sides) == (0, 0)


@pytest.mark.long
def test_meshes_are_not_recorded_twice_and_copies_are_known(again, tmp_path):
    with again() as (_, client):
        client.good("estimate", part=flat(WEDGE, "part"))
        publisher = MeshPublisher(client, "/again/cad", Mesh, latched=True)
        publisher.publish(mesh(WEDGE))  # is there when the next node starts
        latched(client, "cad")
        with again() as (_, other):
            other.good("estimate", part=flat(WEDGE, "part"))
            publisher.publish(mesh(WEDGE))
            MeshPublisher(other).matched().publish(flat(WEDGE, "last"))
            latched(other, "last")
            names = [message.part_id for message in recorded_in(runs(tmp_path)[-1], "part_mesh")]
            assert len(names) == len(set(names))


def recorded_in(bag, topic):
    from ..harness.readers import message_of, on_topic, raw

    return [message_of(name, data) for name, data in raw(bag) if name == on_topic(topic)]


@pytest.mark.long
def test_killed_while_it_starts(again, tmp_path, node_of):
    """By the time that bags are mended, all that they leave is in the new one."""
    with again() as (node, client):
        client.good("estimate", part=flat(WEDGE, "estimated"))
        client.good("estimate", part=flat(scaled(1.1), "simulated"))
        finished(client, start(client, "simulated", 1000))
        jobs = {start(client, "simulated", LONG, seed=seed) for seed in (1, 2, 3)}
        before = shown(client)
        node.kill()
    node = node_of("-r", "__ns:=/again", log_directory=tmp_path)
    node.says(" mended: ")
    node.kill()
    last = runs(tmp_path)[-1]
    events = recorded_in(last, "job_events")
    assert {event.part_id for event in events if event.event == PART_RESTORED} == set(before)
    assert (events[0].event, events[-1].event) == (RUNS_TAKEN_IN, RUNS_TAKEN_IN)
    results = {message.part_id: message for message in recorded_in(last, "pose_statistics")}
    assert {part_id: whole(message) for part_id, message in results.items()} == {
        part_id: whole(message) for part_id, message in before.items()}
    cancelled = [event.job_id for event in recorded_in(last, "job_events")
                 if event.event == JobEvent.CANCELLED]
    assert sorted(cancelled) == sorted(jobs)
    with again() as (node, client):
        assert_restored(client, before)
    told = [event.job_id for event in recorded(tmp_path, "job_events")
            if event.event == JobEvent.CANCELLED]
    assert sorted(told) == sorted(jobs)


@pytest.mark.long
def test_two_nodes_leave_each_other_alone(again, domain, tmp_path):
    with again() as (node, client):
        client.good("estimate", part=flat(WEDGE, "mine"))
        job_id = start(client, "mine", LONG)
        (mine,) = runs(tmp_path)
        for _ in range(2):
            with cell_of(domain, tmp_path, "other", max_log_bytes=1) as (other, guest):
                assert "mended" not in other.log
                assert "mine" not in shown(guest)
                assert job_id not in guest.call("list_drop_simulations").job_id
                line, values = Health(guest).line("recording")
                assert "max_log_bytes" in line.message or not int(values["bytes written"])
                guest.good("estimate", part=flat(WEDGE, "theirs"))
                finished(guest, start(guest, "theirs", 200))
        running_with_results(client, job_id)
        node.stop(signal.SIGTERM)
    ends = [event.event for event in recorded(tmp_path, "job_events")
            if event.job_id == job_id and event.event >= JobEvent.DONE]
    assert mine.is_dir() and ends == [JobEvent.CANCELLED]


@pytest.mark.long
def test_the_oldest_bags_make_room(again, tmp_path):
    for number in range(16):
        writing = Writing(tmp_path, number, "again/pose_stats")
        for k in range(50):
            writing.part(f"part {k}", 1.0)
        writing.end()
    old = runs(tmp_path)
    size = sum(file.stat().st_size for file in old[-1].iterdir())
    bound = 14 * size
    with again(max_log_bytes=bound) as (_, client):
        assert len(shown(client)) == 50
        _, values = Health(client).line("recording")
        left = runs(tmp_path)[:-1]
        assert left == old[-len(left):] and 1 <= len(left) <= 13
        assert int(values["runs deleted for max_log_bytes"]) == 16 - len(left)
        assert values["last run deleted"] == old[15 - len(left)].name
        assert values["files deleted for max_log_bytes"] == "0"
        assert 0 <= int(values["bytes left"]) < bound - len(left) * size


@pytest.mark.long
def test_a_damaged_bag_does_not_keep_the_node_from_starting(again, tmp_path):
    with again() as (node, client):
        client.good("estimate", part=flat(WEDGE, "part"))
        node.kill()
    (bag,) = runs(tmp_path)
    (file,) = bag.glob("*.mcap")
    data = file.read_bytes()
    file.write_bytes(data[:-40] + b"\xff" * 20)
    (tmp_path / "pose_stats_20200101T000000_000000_1").mkdir()
    (tmp_path / "pose_stats_20200101T000000_000001_1").mkdir()
    (tmp_path / "pose_stats_20200101T000000_000001_1"
     / "pose_stats_20200101T000000_000001_1_0.mcap").write_bytes(b"no bag")
    with again() as (node, client):
        assert f"{bag.name} mended" in node.log
        until(lambda: "part" in shown(client))

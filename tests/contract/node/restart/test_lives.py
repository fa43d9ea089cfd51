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

"""What a node that is started again has: parts, results, counts and jobs of its state
file.
"""

import shutil
from types import SimpleNamespace

import pytest
from ros_pose_stats_msgs.msg import JobStatus
from shape_msgs.msg import Mesh

from tests.running import refusal

from ..harness.bags import assert_readable_by_others, bags_of, ends, recorded
from ..harness.camera import counted, counting, learnt
from ..harness.cell import Health, MeshPublisher, cell_of, latched
from ..harness.client import CANCELLED, Client, until, wait_for
from ..harness.goals import planned
from ..harness.jobs import LONG, finished, get, running_with_results, start
from ..harness.listed import rows
from ..harness.node import NodeProcess
from ..harness.parts import (
    WEDGE,
    counts,
    fine_box,
    flat,
    library_part,
    mesh,
    probabilities,
    scaled,
    whole,
)
from ..harness.slow import builder_at_work, standing

BETTER = 8000
"""Drops that take the place of the 5000 before."""


def shown(client):
    """What is latched, by part."""
    return {
        statistics.part_id: statistics
        for statistics in client.good("get_statistics").statistics
    }


def first_life(client):
    """Parts of all kinds."""
    client.good("estimate", part=flat(WEDGE, "estimated", restitution=-0.0))
    client.good("estimate", part=flat(scaled(1.1), "simulated"))
    finished(client, start(client, "simulated", 5000, seed=3))
    client.good(
        "estimate", part=flat(WEDGE, "own scene", restitution=0.2, drop_height=1.5)
    )
    finished(client, start(client, "own scene", 2000, seed=4))
    client.good("estimate", part=flat(WEDGE, "refined"))
    finished(client, start(client, "refined", 100_000, target_error=0.02))
    for factor in (1.2, 1.3, 1.2):
        client.good("estimate", part=flat(scaled(factor), "back again"))
    for part_id in ("forgotten", "remembered"):
        client.good("estimate", part=flat(WEDGE, part_id))
        client.good("forget_part", part_id=part_id)
    client.good("estimate", part=flat(WEDGE, "remembered"))
    MeshPublisher(client, "/lives/cad", Mesh).matched().publish(mesh(scaled(1.4)))
    until(lambda: latched(client, "cad").drops, "its check")
    answer = client.good("estimate", part=flat(scaled(1.5), "seen")).statistics
    counting(client).publish(
        counted(answer, [9, 1], from_pose=answer.poses[1].index, feeder_setting="slow"),
        counted(answer, [30, 70]),
    ).acknowledged()
    learnt(client, "seen", 100)


def fed(client):
    """What a feeder gets at a setting whose flips were counted."""
    return planned(
        client,
        part_id="seen",
        wanted=[0],
        dropped_per_minute=60.0,
        cycle_seconds=1.0,
        kick_height=0.012,
        feeder_setting="slow",
    )


def assert_restored(client, expected):
    """All parts with their results, as soon as the node is ready, latched and asked
    for.
    """
    with client.late_joiner() as joiner:
        restored = {part_id: joiner.wait(part_id) for part_id in expected}
        assert joiner.parts() == set(expected)
    current = shown(client)
    assert current.keys() == expected.keys()
    for part_id, message in restored.items():
        old = expected[part_id]
        assert whole(message) == whole(current[part_id])
        for field in (
            "part_digest",
            "method",
            "drops",
            "counted_parts",
            "seed",
            "restitution",
        ):
            assert getattr(message, field) == getattr(old, field), (part_id, field)
        assert counts(message.poses) == counts(old.poses)
        assert probabilities(message.poses) == pytest.approx(probabilities(old.poses))
        assert message.revision >= old.revision and message.final


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("bags")


@pytest.fixture(scope="module")
def begin(domain, folder):
    """Starts one node after the other on the same folder."""
    return lambda **values: cell_of(
        domain, folder, "lives", mesh_topics="[/lives/cad]", plate="glass", **values
    )


@pytest.fixture(scope="module")
def lives(begin, domain, folder):
    """One that ends well, one that is killed, and what they left."""
    remembered = SimpleNamespace()
    with begin() as (_, client):
        first_life(client)
        remembered.first = shown(client)
        remembered.fed = fed(client)
        remembered.done = [row.job_id for row in rows(client)]
        remembered.answers = {job_id: get(client, job_id) for job_id in remembered.done}
    with begin() as (node, client):
        assert_restored(
            client, remembered.first
        )  # here, since it is over when the next one begins
        remembered.fed_again = fed(client)
        remembered.again = {job_id: get(client, job_id) for job_id in remembered.done}
        remembered.process = node.process.pid
        remembered.second = refusal(
            "node", "--ros-args", "-p", f"log_directory:={folder}", "-r", "__ns:=/lives"
        )
        remembered.better = finished(
            client, start(client, "simulated", BETTER, seed=5)
        ).statistics
        camera = counting(client)
        camera.publish(counted(remembered.first["seen"], [1, 0]))
        learnt(client, "seen", 101)
        with cell_of(domain, folder, "other") as (other_node, guest):
            remembered.others = shown(guest), rows(guest), other_node.log
            for part_id in ("unwanted", "asked for", "first"):
                guest.good("estimate", part=flat(fine_box(6000), part_id))
        camera.publish(counted(remembered.first["seen"], [0, 1]))
        until(
            lambda: len(recorded(folder, "pose_counts")) == 4,
            "the last count on record",
        )
        # After all that waits: it takes whatever processors have left.
        remembered.job_id = start(client, "own scene", LONG)
        running_with_results(client, remembered.job_id)
        remembered.bag = bags_of(folder)[1]
        client.good("forget_part", part_id="estimated")
        node.kill()
    return remembered


def test_finished_jobs_answer_as_before(lives):
    assert len(lives.done) == 3
    for job_id, answer in lives.answers.items():
        assert (
            whole(lives.again[job_id]) == whole(answer) and answer.statistics.drops > 0
        )


def test_counted_flips_are_known_again_and_are_no_landings(lives):
    assert all(
        answer.message.endswith("and 10 seen.")
        for answer in (lives.fed, lives.fed_again)
    )
    assert lives.first["seen"].counted_parts == 100


def test_a_second_node_of_the_name_is_refused_with_the_first_one_s_process(lives):
    assert (
        f"process {lives.process} has in use" in lives.second
        and "state_file" in lives.second
    )


def test_all_parts_of_a_node_that_ended_well_come_back(lives):
    assert set(lives.first) == {
        "estimated",
        "simulated",
        "own scene",
        "refined",
        "back again",
        "remembered",
        "cad",
        "seen",
    }
    assert lives.first["back again"].part_digest == library_part(scaled(1.2)).digest
    assert lives.first["seen"].method == "observed"
    assert lives.better.drops == BETTER
    assert lives.better.revision > lives.first["simulated"].revision


def test_another_node_of_the_same_folder_is_left_alone(lives):
    """It has no parts or jobs of this one, and mends nothing under its hands."""
    parts, jobs, log = lives.others
    assert parts == {} and jobs == []
    assert "mended" not in log


@pytest.fixture(scope="module")
def third(lives, begin, folder):
    """The life after a kill, beside garbage; what its clients saw."""
    for name, text in (
        ("pose_stats_20200101T000000_000000_1", ""),
        ("pose_stats_20200101T000000_000001_1", "no bag"),
    ):
        (folder / name).mkdir()
        if text:
            (folder / name / f"{name}_0.mcap").write_text(text)
    with begin() as (node, client):
        # A start waits for that, but not for ever.
        node.says(f"{lives.bag.name} mended")
        Health(client).eventually(
            "recording", lambda _, values: lives.bag.name in values["last repair"]
        )
        record = SimpleNamespace(
            shown=shown(client),
            job=get(client, lives.job_id),
        )
        expected = {
            **lives.first,
            "simulated": lives.better,
            "seen": record.shown["seen"],
        }
        del expected["estimated"]
        assert_restored(client, {**expected, "own scene": record.shown["own scene"]})
        for part_id in ("own scene", "simulated"):  # used last
            client.good("estimate", part_id=part_id)
    return record


def test_a_kill_loses_nothing_that_was_acknowledged(lives, third, folder):
    assert "estimated" not in third.shown
    assert (
        third.shown["simulated"].drops == BETTER
        and third.shown["seen"].counted_parts == 102
    )
    assert third.shown["own scene"].part_digest == lives.first["own scene"].part_digest
    assert third.job.status.state == CANCELLED and "the node ended" in third.job.message
    assert third.job.statistics.final is bool(third.job.statistics.drops)
    assert_readable_by_others(lives.bag)
    assert [event.status.state for event in ends(folder)[lives.job_id]] == [
        JobStatus.CANCELLED
    ]


def test_bags_may_go_and_a_new_scene_is_estimated(lives, third, begin, folder):
    """Nor is the end of a job told again. Of all parts the last used are kept."""
    for bag in bags_of(folder):
        shutil.rmtree(bag)
    with begin(restitution=0.3, plate_frame="feeder", max_parts=5) as (_, client):
        client.good("estimate", part_id="seen")
        current = until(
            lambda: len(results := shown(client)) == 5 and results, "five results"
        )
        assert {"seen", "simulated", "own scene"} <= current.keys()
        assert all(
            statistics.header.frame_id == "feeder" for statistics in current.values()
        )
        assert (current["simulated"].job_id, current["simulated"].restitution) == (
            "",
            0.3,
        )
        assert current["simulated"].revision > third.shown["simulated"].revision
        assert current["own scene"].restitution == 0.2
        assert current["seen"].counted_parts == 102
        assert get(client, lives.job_id).status.state == CANCELLED
    assert lives.job_id not in ends(folder)
    (file,) = folder.glob("lives.*.sqlite3")
    file.write_bytes(file.read_bytes()[:-5000])
    with begin(restore="false") as (node, client):
        assert shown(client) == {} and "the node starts without it" in node.log
        line, values = Health(client).line("recording")
        assert values["state file set aside"].startswith(f"{file.name}.unreadable-")
        assert values["state file set aside"] in line.message


@pytest.mark.usefixtures("lives")
def test_large_parts_that_are_still_to_be_built_hold_up_nobody(domain, folder):
    """Nor is one refused that is not wanted any more."""
    with (
        Client(domain, "/other/pose_stats") as client,
        NodeProcess(folder, "-r", "__ns:=/other") as node,
    ):
        with standing(builder_at_work(node.process.pid)):
            node.ready()
            outlines = [
                client.send("get_statistics", part_id="asked for", heights=[-1.0])
                for _ in range(2)
            ]
            client.good("forget_part", part_id="unwanted")
            assert not any(answer.done() for answer in outlines)
        assert all(wait_for(answer).outlines for answer in outlines)
        _, values = Health(client).line(
            "parts", lambda _, values: values["meshes waiting"] == "0"
        )
        assert values["refused"] == "0"

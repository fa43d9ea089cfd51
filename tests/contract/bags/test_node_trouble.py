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

"""Kill, full disk and missing folder: what was acknowledged stays, and the node serves
on.
"""

import re
import resource
import shutil
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from ros_pose_stats_msgs.msg import Code

from lab.bodies.slow import smooth_body
from ros_pose_stats import analyse_bags
from tests.contract.node.harness.bags import (
    assert_readable_by_others,
    bags_of,
    files_of,
    message_of,
    on_topic,
    raw,
    recorded,
    size_of,
)
from tests.contract.node.harness.cell import Health, cell_of, latched
from tests.contract.node.harness.client import until
from tests.contract.node.harness.goals import Goals
from tests.contract.node.harness.jobs import finished, start
from tests.contract.node.harness.parts import WEDGE, flat, new_id, whole
from tests.contract.node.harness.slow import builder_at_work, standing
from tests.running import is_gone

from .rosbag2 import assert_played_by_time

FILE = 65_536
"""Bytes after which a file of the bag is followed by another; no fewer can be asked
for.
"""


class Killed(NamedTuple):
    bag: Path
    answers: list
    """What was answered before the kill."""
    running: object
    """What the library said while the node ran."""
    builder: int
    """Its process that builds parts."""


def ask(client, number):
    """Answers to estimates of parts that are new; requests carry them."""
    return [
        client.good("estimate", part=flat(WEDGE, new_id())).statistics
        for _ in range(number)
    ]


@pytest.fixture(scope="module")
def killed(domain, tmp_path_factory):
    """A node with small files that was killed while it built a part."""
    folder = tmp_path_factory.mktemp("killed")
    with cell_of(
        domain[0], folder, "killed", environment=domain[1], max_bag_bytes=FILE
    ) as (node, client):
        answers = ask(client, 30)
        job_id = start(client, answers[0].part_id, 300)
        answers.append(finished(client, job_id).statistics)
        running = analyse_bags(folder).contents
        request = client.send("estimate", part=flat(smooth_body(12_000)))
        builder = builder_at_work(node.process.pid)
        assert not request.done()
        node.kill()
    (bag,) = bags_of(folder)
    return Killed(bag, answers, running, builder)


class TestKilled:
    def test_no_process_outlives_it(self, killed):
        assert until(lambda: is_gone(killed.builder))

    def test_everything_acknowledged_is_there(self, killed):
        answers = set(map(whole, recorded(killed.bag.parent, "answers")))
        assert set(map(whole, killed.answers)) <= answers
        parts = {
            message.part_id for message in recorded(killed.bag.parent, "part_mesh")
        }
        assert {message.part_id for message in killed.answers} <= parts

    def test_files_follow_each_other_and_each_finished_one_stands_by_itself(
        self, killed
    ):
        files = files_of(killed.bag)
        assert len(files) > 3
        assert max(file.stat().st_size for file in files) <= FILE
        assert [file.state for file in killed.running.files] == (
            ["whole"] * (len(files) - 1) + ["open"]
        )
        contents = analyse_bags(killed.bag).contents
        assert contents.files[-1].state in ("open", "cut")
        assert contents.messages["PoseStatistics"] >= 2 * len(killed.answers) - 2
        for file in files[:-1]:
            assert analyse_bags(file).contents.files[0].state == "whole"
        assert (killed.bag / "metadata.yaml").is_file()  # from the first record on


def earlier_copy(bag, folder, number):
    """A copy under the name of a run of another year."""
    copy = folder / re.sub(r"stats_\d{4}", f"stats_200{number}", bag.name)
    shutil.copytree(bag, copy)
    for file in copy.glob("*.mcap"):
        file.rename(copy / file.name.replace(bag.name, copy.name))
    return copy


FOOTER = "a footer that leads nowhere"
"""Of which nothing is said: a file with it has an end, and nothing was lost."""

DAMAGE = {
    FOOTER: lambda content: (
        content + b"\x02" + (20).to_bytes(8, "little") + b"\xff" * 20 + b"\x89MCAP0\r\n"
    ),
    "as it was": lambda content: content,
    "cut": lambda content: content[:-777],
    "zeros at its end": lambda content: content[:-500] + bytes(500),
    "noise behind it": lambda content: content + np.random.default_rng(3).bytes(900),
    "flipped": lambda content: (
        content[:-3000] + bytes((content[-3000] ^ 4,)) + content[-2999:]
    ),
    "nothing of the last file": lambda content: b"",
}
"""An unfinished file as a power cut or a bad disk may leave it."""


@pytest.fixture(scope="module")
def mended(killed, domain, tmp_path_factory):
    """The next start beside unfinished bags of every kind; what whole messages each had
    before.
    """
    folder = tmp_path_factory.mktemp("mended")
    files_before = {}
    for number, (kind, damaged) in enumerate(DAMAGE.items()):
        bag = earlier_copy(killed.bag, folder, number)
        last = files_of(bag)[-1]
        last.write_bytes(damaged(last.read_bytes()))
        files_before[kind] = bag, analyse_bags(bag).contents.messages["PoseStatistics"]
    (folder / "notes").mkdir()
    (folder / "notes" / "mine.mcap").write_text("mine")
    with cell_of(domain[0], folder, "mended", environment=domain[1]) as (node, client):
        ask(client, 1)
        for kind, (bag, _) in files_before.items():
            if kind != FOOTER:
                node.says(f"{bag.name} mended")
        node.stop()
    return files_before


class TestNextStart:
    @pytest.mark.parametrize("kind", DAMAGE)
    def test_finishes_what_was_left(self, mended, killed, kind):
        bag, messages = mended[kind]
        contents = analyse_bags(bag).contents
        assert {file.state for file in contents.files} == {"whole"}
        assert contents.messages["PoseStatistics"] == messages
        assert_readable_by_others(bag)
        for file in files_of(bag):
            assert_played_by_time(file)
        answers = {whole(message) for message in recorded_in(bag)}
        lost = sum(whole(message) not in answers for message in killed.answers)
        is_complete = kind in (FOOTER, "as it was", "noise behind it")
        assert lost == 0 if is_complete else lost < 15
        assert not list(bag.glob("*.half"))
        foreign = bag.parent / "notes"
        assert [file.read_text() for file in foreign.iterdir()] == ["mine"]


def recorded_in(bag):
    """Answers in one bag."""
    return [
        message_of(topic, data)
        for topic, data in raw(bag)
        if topic == on_topic("answers")
    ]


def test_the_oldest_files_go_once_all_bags_are_too_large(killed, domain, tmp_path):
    """Old runs first, but none that a link leads to, then old files of this run."""
    archive = earlier_copy(killed.bag, tmp_path.with_name("archive"), 0)
    (tmp_path / archive.name).symlink_to(archive)
    old = [
        file
        for number in range(1, 4)
        for file in files_of(earlier_copy(killed.bag, tmp_path, number))
    ]
    bound = int(1.5 * size_of(killed.bag, "*.mcap"))
    with cell_of(
        domain[0],
        tmp_path,
        "bounded",
        environment=domain[1],
        max_bag_bytes=FILE,
        max_log_bytes=bound,
    ) as (node, client):
        (first,) = ask(client, 1)
        until(lambda: size_of(tmp_path, "*.mcap") <= bound, "the bound")
        remaining = [file for file in old if file.exists()]
        assert (
            0 < len(remaining) < len(old)
            and remaining == old[len(old) - len(remaining) :]
        )
        answers = []
        while any(file.exists() for file in old) or len(answers) < 50:
            answers.append(
                client.good(
                    "estimate",
                    part_id=first.part_id,
                    method="csae",
                    restitution=1e-4 * len(answers),
                ).statistics
            )
            assert len(answers) < 5000
        until(lambda: size_of(tmp_path, "*.mcap") <= bound, "the bound")
        node.stop()
    assert size_of(archive, "*.mcap") == size_of(killed.bag, "*.mcap")
    *_, bag = bags_of(tmp_path)
    assert_readable_by_others(bag)
    assert set(map(whole, answers[-10:])) <= {
        whole(message) for message in recorded_in(bag)
    }


NOT_RECORDED = "NOT_RECORDED: "


def unrecorded(statistics):
    return [
        warning for warning in statistics.warnings if warning.code == "NOT_RECORDED"
    ]


def assert_says_that_nothing_is_recorded(node, client, health):
    """In answers, on acceptance, with results and on diagnostics; it serves all the
    same.
    """
    (statistics,) = ask(client, 1)
    assert len(unrecorded(statistics)) == 1
    assert len(unrecorded(latched(client, statistics.part_id))) == 1
    accepted = client.good(
        "start_drop_simulation", part_id=statistics.part_id, drops=200
    )
    assert accepted.message.startswith(NOT_RECORDED)
    job_statistics = finished(client, accepted.job_id).statistics
    assert job_statistics.drops == 200 and len(unrecorded(job_statistics)) == 1
    goals = Goals(client)
    _, result = goals.send(part_id=statistics.part_id, drops=100).result()
    goals.close()
    assert result.success and unrecorded(result.statistics)
    answered = client.good("estimate", part_id=statistics.part_id)
    assert {answered.code, accepted.code, result.code} == {Code.NOT_RECORDED}
    line, values = health.line(
        "recording", lambda line, _: line.level == DiagnosticStatus.WARN
    )
    assert (
        line.message.startswith(NOT_RECORDED)
        and int(values["messages not recorded"]) > 0
    )
    node.says(NOT_RECORDED)


def assert_records(client, folder, health):
    """Everything is recorded again, each bag by itself; the answer that is there."""
    health.line("recording", lambda line, _: line.level == DiagnosticStatus.OK)
    (statistics,) = ask(client, 1)
    assert not unrecorded(statistics)
    assert whole(statistics) in set(map(whole, recorded(folder, "answers")))
    return statistics


def test_a_full_disk_and_a_missing_folder_come_and_go(domain, tmp_path):
    folder = tmp_path / "bags"
    with cell_of(domain[0], folder, "trouble", environment=domain[1]) as (node, client):
        health = Health(client)
        first = assert_records(client, folder, health)
        (bag,) = bags_of(folder)
        (file,) = files_of(bag)
        # A file that may not grow is a disk that is full; half a message still fits.
        room = file.stat().st_size + 100
        resource.prlimit(
            node.process.pid, resource.RLIMIT_FSIZE, (room, resource.RLIM_INFINITY)
        )
        assert_says_that_nothing_is_recorded(node, client, health)
        resource.prlimit(
            node.process.pid,
            resource.RLIMIT_FSIZE,
            (resource.RLIM_INFINITY, resource.RLIM_INFINITY),
        )
        until(lambda: not unrecorded(ask(client, 1)[0]), "room")
        second_part = assert_records(client, folder, health)
        node.says("recording works again")
        assert {whole(first), whole(second_part)} <= set(
            map(whole, recorded(folder, "answers"))
        )
        with standing(node.process.pid):  # nothing is made in it while it goes
            shutil.rmtree(folder)
        until(
            lambda: not unrecorded(ask(client, 1)[0]) and bags_of(folder), "another bag"
        )
        last = assert_records(client, folder, health)
        (bag,) = bags_of(folder)
        shutil.copytree(bag, folder / "copy")
        monday = bag.rename(folder / "monday")
        newest = client.good("estimate", part_id=last.part_id).statistics
        bag = bags_of(folder)[0].rename(folder / "tuesday")
        node.stop()
    assert_readable_by_others(monday)
    assert whole(last) in {whole(message) for message in recorded_in(monday)}
    assert_readable_by_others(bag)
    topics = [
        topic
        for topic, data in raw(bag)
        if message_of(topic, data).part_id == last.part_id
    ]
    assert topics[:2] == [on_topic("part_mesh"), on_topic("answers")]
    assert whole(newest) in {whole(message) for message in recorded_in(bag)}

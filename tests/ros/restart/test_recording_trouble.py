"""Disks that are full, folders that are none or go away: the node serves on and says so."""

from __future__ import annotations

import resource
import shutil
import signal

import pytest
from diagnostic_msgs.msg import DiagnosticStatus

from ros_pose_stats.recording.run_names import runs
from tests.volume import few_quick

from ..harness.bags import ends, recorded
from ..harness.cell import Health, cell_of, latched
from ..harness.client import until
from ..harness.goals import Goals
from ..harness.jobs import LONG, cancelled, finished, get, start
from ..harness.parts import WEDGE, flat, new_id
from ..harness.readers import assert_readable_by_others, raw

NOT_RECORDED = "NOT_RECORDED: "


def unrecorded(warnings):
    return [one for one in warnings if one.startswith(NOT_RECORDED)]


def carried(client, part_id=""):
    """The answer to an estimate of a part that is new."""
    return client.good("estimate", part=flat(WEDGE, part_id or new_id())).statistics


def assert_says_that_nothing_is_recorded(client, node, health):
    """In answers, on acceptance, with results and on diagnostics."""
    part_id = new_id()
    assert len(unrecorded(carried(client, part_id).warnings)) == 1
    assert len(unrecorded(latched(client, part_id).warnings)) == 1
    answer = client.good("start_drop_simulation", part_id=part_id, drops=200)
    assert answer.message.startswith(NOT_RECORDED)
    found = finished(client, answer.job_id)
    assert found.statistics.drops == 200 and len(unrecorded(found.statistics.warnings)) == 1
    goals = Goals(client)
    _, result = goals.send(part_id=part_id, drops=100).result()
    assert result.success and unrecorded(result.statistics.warnings)
    line, values = health.line("recording", lambda line, _: line.level == DiagnosticStatus.WARN)
    assert line.message.startswith(NOT_RECORDED)
    assert int(values["messages not recorded"]) > 0
    node.says(NOT_RECORDED)


def assert_records(client, node, health):
    """Everything is recorded again."""
    statistics = carried(client)
    assert not unrecorded(statistics.warnings)
    job_id = start(client, statistics.part_id, 200)
    assert not unrecorded(finished(client, job_id).statistics.warnings)
    line, _ = health.line("recording", lambda line, _: line.level == DiagnosticStatus.OK)
    assert line.message == "recording"
    answers = [message.revision for message in recorded(node.log_directory, "answers")
               if message.part_id == statistics.part_id]
    assert statistics.revision in answers
    assert job_id in ends(node.log_directory)


def allow(process, size):
    """Let a process make files of at most this size: beyond it the disk is full."""
    resource.prlimit(process.pid, resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))


class TestFullDisk:
    def test_comes_and_goes(self, domain, tmp_path):
        with cell_of(domain, tmp_path, "full", log_drops="true") as (node, client):
            health = Health(client)
            known = carried(client)
            finished(client, start(client, known.part_id, 300))
            for room in (0, 100):
                (bag,) = runs(tmp_path)
                (file,) = bag.glob("*.mcap")
                allow(node.process, file.stat().st_size + room)
                assert_says_that_nothing_is_recorded(client, node, health)
                damage = []
                assert raw(bag)
                list_damage(bag, damage)
                assert all(one.start == one.end for one in damage)  # just no footer
                allow(node.process, resource.RLIM_INFINITY)
                assert_records(client, node, health)
                node.says("recording works again")
            parts = {message.part_id for message in client.good("get_statistics").statistics}
            until(lambda: parts == {one.part_id for one in recorded(tmp_path, "part_mesh")})
            node.stop()
        (bag,) = runs(tmp_path)
        assert_readable_by_others(bag)

    def test_the_end_of_a_job_that_has_nothing_to_show(self, domain, tmp_path):
        with cell_of(domain, tmp_path, "full") as (node, client):
            part_id = carried(client).part_id
            first, second = (start(client, part_id, LONG, seed=seed) for seed in (1, 2))
            (bag,) = runs(tmp_path)
            (file,) = bag.glob("*.mcap")
            allow(node.process, file.stat().st_size)
            found = cancelled(client, second)
            assert not found.statistics.drops and NOT_RECORDED in found.message
            allow(node.process, resource.RLIM_INFINITY)
            assert NOT_RECORDED not in cancelled(client, first).message

    @pytest.mark.long
    def test_until_the_end(self, domain, tmp_path):
        """What was recorded before is kept, and mended by the next node."""
        with cell_of(domain, tmp_path, "full") as (node, client):
            known = carried(client)
            (bag,) = runs(tmp_path)
            before = raw(bag)
            (file,) = bag.glob("*.mcap")
            allow(node.process, file.stat().st_size + 100)
            assert unrecorded(carried(client).warnings)
            node.stop(signal.SIGTERM)
        assert raw(bag)[:len(before)] == before
        with cell_of(domain, tmp_path, "full") as (node, client):
            assert latched(client, known.part_id).part_digest == known.part_digest
        assert_readable_by_others(bag)


def list_damage(bag, damage):
    from ros_pose_stats.recording.reader.raw_reader import raw_messages

    for _ in raw_messages(bag, damage.append):
        pass


class TestFolder:
    @pytest.mark.long
    def test_a_file_in_its_place_until_it_is_gone(self, domain, tmp_path):
        folder = tmp_path / "bags"
        folder.write_text("no folder")
        with cell_of(domain, folder, "file") as (node, client):
            health = Health(client)
            assert_says_that_nothing_is_recorded(client, node, health)
            early = carried(client)
            folder.unlink()
            assert_records(client, node, health)
            until(lambda: early.part_id in {
                one.part_id for one in recorded(folder, "part_mesh")}, "the early part")
            node.stop()
        (bag,) = runs(folder)
        assert_readable_by_others(bag)

    @pytest.mark.long
    @pytest.mark.parametrize("whole", few_quick([True, False], 1))
    def test_deleted_while_the_node_runs(self, domain, tmp_path, whole):
        folder = tmp_path / "bags"
        with cell_of(domain, folder, "deleted") as (node, client):
            health = Health(client)
            early = carried(client)
            (bag,) = runs(folder)
            shutil.rmtree(folder if whole else bag)
            assert_records(client, node, health)
            until(lambda: early.part_id in {
                one.part_id for one in recorded(folder, "part_mesh")}, "the early part")
            shown = latched(client, early.part_id)
            job_id = start(client, early.part_id, 100)
            assert get(client, job_id).state
            node.stop()
        (bag,) = runs(folder)
        assert_readable_by_others(bag)
        with cell_of(domain, folder, "deleted") as (_, client):
            assert latched(client, early.part_id).part_digest == shown.part_digest

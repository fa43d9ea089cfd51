"""Who listens is told of a part that the node does not know any more; who comes later is not."""

from __future__ import annotations

import math
import signal
import subprocess
import sys
import time

import pytest
from ros_pose_stats_msgs.msg import JobEvent

from ros_pose_stats import analyse_bags

from ..harness.bags import recorded
from ..harness.cell import cell_of
from ..harness.client import until
from ..harness.jobs import known_part
from ..harness.parts import WEDGE, flat

LISTENER = """
import os, sys, rclpy
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_pose_stats_msgs.msg import PoseStatistics
rclpy.init(domain_id=int(sys.argv[1]))
node = rclpy.create_node("listener")
node.create_subscription(PoseStatistics, sys.argv[2], lambda message: print(
    message.part_id, len(message.poses), flush=True), QoSProfile(
        depth=100, durability=DurabilityPolicy.TRANSIENT_LOCAL))
rclpy.spin(node)
"""


def says_forgotten(message):
    return any(line.startswith("FORGOTTEN: ") for line in message.warnings)


def publishers(client):
    return len(client.node.get_publishers_info_by_topic(f"{client.prefix}/pose_statistics"))


def test_a_subscriber_is_told_once_and_last(cell):
    part_id = known_part(cell)
    with cell.late_joiner() as listener:
        before = listener.wait(part_id)
        cell.good("forget_part", part_id=part_id)
        told = listener.wait(part_id, says_forgotten)
        assert (told.part_digest, told.header.frame_id, told.radius, told.final) == (
            before.part_digest, before.header.frame_id, before.radius, True)
        assert not told.poses and math.isnan(told.expected_error)
        assert told.revision > before.revision
        assert told.warnings == ["FORGOTTEN: a client had the part forgotten; send the mesh again "
                                 "to get results."]
        listener.wait(known_part(cell))
        assert [says_forgotten(one) for one in listener.of(part_id)] == [False, True]


def test_who_comes_later_is_not(cell):
    before = until(lambda: publishers(cell) and publishers(cell))
    part_id = known_part(cell)
    until(lambda: publishers(cell) == before + 1, "the part's publisher")
    cell.good("forget_part", part_id=part_id)
    until(lambda: publishers(cell) == before, "its end")
    kept = known_part(cell)
    with cell.late_joiner() as joiner:
        joiner.wait(kept)
        assert part_id not in joiner.parts()


def test_a_part_that_comes_again_has_higher_numbers(cell):
    part_id = known_part(cell)
    with cell.late_joiner() as listener:
        for _ in range(5):  # at once: its publisher may not have gone yet
            cell.good("forget_part", part_id=part_id)
            cell.good("estimate", part=flat(WEDGE, part_id))
        last = listener.wait(part_id, lambda message: message.revision >= 11)
        assert last.poses
        numbers = [message.revision for message in listener.of(part_id)]
        assert numbers == sorted(set(numbers))
    with cell.late_joiner() as joiner:
        joiner.wait(known_part(cell))
        assert [one.revision for one in joiner.of(part_id)] == [last.revision]


def test_a_part_that_made_room_is_told_with_the_reason(domain, tmp_path):
    with cell_of(domain, tmp_path, "narrow", max_parts=2) as (_, client):
        first = known_part(client)
        with client.late_joiner() as listener:
            listener.wait(first)
            second, third = known_part(client), known_part(client)
            told = listener.wait(first, says_forgotten)
            assert not told.poses and "max_parts" in told.warnings[0]
            listener.wait(third)
            assert client.set(max_parts=1) == {}
            assert not listener.wait(second, says_forgotten).poses
            assert not says_forgotten(listener.of(third)[-1])


def test_a_subscriber_that_hangs_holds_up_nobody(domain, tmp_path):
    with cell_of(domain, tmp_path, "patient") as (node, client):
        parts = [known_part(client) for _ in range(20)]
        hangs = subprocess.Popen([sys.executable, "-W", "ignore", "-c", LISTENER, str(domain),
                                  f"{client.prefix}/pose_statistics"],
                                 stdout=subprocess.PIPE, text=True)
        try:
            heard = {hangs.stdout.readline().split()[0] for _ in parts}
            assert heard == set(parts)
            hangs.send_signal(signal.SIGSTOP)
            with client.late_joiner() as listener:
                for part_id in parts:
                    assert listener.wait(part_id).poses
                began = time.monotonic()
                for part_id in parts:
                    client.good("forget_part", part_id=part_id)
                for part_id in parts:
                    assert not listener.wait(part_id, says_forgotten).poses
                assert time.monotonic() - began < 10.0
            until(lambda: publishers(client) == 0, "the publishers to go")
        finally:
            hangs.kill()
            hangs.wait()
            hangs.stdout.close()
        node.assert_sound()


@pytest.mark.parametrize("end", [signal.SIGTERM, signal.SIGKILL])
def test_the_next_run_does_not_begin_with_it(domain, tmp_path, end):
    with cell_of(domain, tmp_path, "again") as (node, client):
        gone, kept = known_part(client), known_part(client)
        client.good("forget_part", part_id=gone)
        node.stop(end) if end == signal.SIGTERM else node.kill()
    *_, last = (one for one in recorded(tmp_path, "pose_statistics") if one.part_id == gone)
    assert says_forgotten(last) and not last.poses
    events = [one for one in recorded(tmp_path, "job_events")
              if one.event == JobEvent.PART_FORGOTTEN]
    assert [(one.part_id, one.header.stamp) for one in events] == [(gone, last.header.stamp)]
    with (cell_of(domain, tmp_path, "again") as (_, client), client.late_joiner() as joiner):
        joiner.wait(kept)
        assert {one.part_id for one in client.good("get_statistics").statistics} == {kept}
        assert joiner.parts() == {kept}
    found = analyse_bags(tmp_path)
    (part,) = (one.record for one in found.parts if one.record.part_id == gone)
    assert len(part.forgotten) == 1 and part.histories[0].leading.method == "split"
    assert found.contents.notes == ()

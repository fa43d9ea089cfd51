"""Counts of cameras: recorded together, and those that come too quickly counted as lost."""

from __future__ import annotations

import signal
import time

import pytest
from ros_pose_stats_msgs.msg import PoseCounts

from .harness.bags import recorded
from .harness.cell import Health, MeshPublisher, cell_of
from .harness.client import until
from .harness.parts import WEDGE, flat


@pytest.fixture
def cell(domain, tmp_path):
    """A node, its client, a camera's publisher, and a maker of counts."""
    with cell_of(domain, tmp_path, "counting") as (node, client):
        found = client.good("estimate", part=flat(WEDGE, "counted")).statistics

        def count(number):
            return PoseCounts(part_id="counted", part_digest=found.part_digest,
                              cluster_tolerance=found.cluster_tolerance,
                              round_sides=found.round_sides, index=[0],
                              count=[number])

        camera = MeshPublisher(client, f"{client.prefix}/pose_counts", PoseCounts).matched()
        yield node, client, camera, count


def numbers(folder):
    return [one.count[0] for one in recorded(folder, "pose_counts")]


def test_a_quick_camera_loses_nothing_unsaid(cell, tmp_path):
    node, client, camera, count = cell
    for number in range(2000):
        camera.publish(count(number))
        time.sleep(0.0004)
    health = Health(client)
    until(lambda: len(numbers(tmp_path)) + int(
        health.line("recording")[1]["counts lost"]) == 2000, "the counts")
    line, values = health.line("parts")
    assert "2000 of counts on ~/pose_counts" in values["floods"] and "flood" in line.message
    assert node.log.count("a flood: more than 600 of counts on ~/pose_counts") == 1


def test_what_is_received_when_the_node_ends_is_recorded(cell, tmp_path):
    node, _, camera, count = cell
    camera.publish(*map(count, range(300)))
    time.sleep(0.2)
    node.stop(signal.SIGTERM)
    assert numbers(tmp_path) == list(range(300))


def test_all_are_recorded_or_counted_as_lost(cell, tmp_path):
    node, client, camera, count = cell
    camera.publish(count(0))
    until(lambda: numbers(tmp_path) == [0], "the first")
    node.send(signal.SIGSTOP)
    camera.publish(*map(count, range(1, 4000)))
    time.sleep(0.2)
    node.send(signal.SIGCONT)
    until(lambda: 3999 in numbers(tmp_path), "the last")
    _, values = Health(client).line("recording")
    lost = int(values["counts lost"])
    assert lost > 0 and lost + len(numbers(tmp_path)) == 4000
    node.says("counts lost so far")

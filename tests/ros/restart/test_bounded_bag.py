"""A flood of meshes against max_log_bytes: the disk holds it, the next start finds all parts."""

from __future__ import annotations

import pytest
from diagnostic_msgs.msg import DiagnosticStatus
from ros_pose_stats_msgs.msg import JobEvent

from ros_pose_stats import analyse_bags
from ros_pose_stats.recording.run_names import runs

from ..harness.bags import ends, recorded, size_of
from ..harness.cell import Health, MeshPublisher, cell_of, latched
from ..harness.client import until
from ..harness.jobs import LONG, start
from ..harness.parts import WEDGE, flat, library_part
from ..harness.readers import assert_readable_by_others

BOUND = 1_000_000
MESHES = 400
VERTICES, TRIANGLES = WEDGE


def scaled(number, part_id):
    """A wedge of another size for each number."""
    return flat(((1.0 + 1e-3 * number) * VERTICES, TRIANGLES), part_id)


@pytest.fixture
def flooded(domain, tmp_path):
    """A node that was flooded with meshes of one part after it was given another; its client."""
    with cell_of(domain, tmp_path, "bounded", max_log_bytes=BOUND) as (node, client):
        publisher = MeshPublisher(client).matched()
        publisher.publish(scaled(0, "kept"))
        latched(client, "kept")
        node.job_id = start(client, "kept", LONG)
        last = library_part(((1.0 + 1e-3 * (MESHES - 1)) * VERTICES, TRIANGLES)).digest
        for number in range(MESHES):
            publisher.publish(scaled(number, "stream"))
            if number % 20 == 0:
                until(lambda n=number: latched(client, "stream").part_digest == library_part(
                    ((1.0 + 1e-3 * n) * VERTICES, TRIANGLES)).digest)
                assert size_of(tmp_path) < 1.25 * BOUND
        until(lambda: latched(client, "stream").part_digest == last)
        yield node, client


def test_the_running_bag_is_bounded_and_keeps_what_counts(flooded, domain, tmp_path):
    node, client = flooded
    until(lambda: size_of(tmp_path) <= BOUND, "the bound")
    _, values = Health(client).line("recording")
    deleted = int(values["files deleted for max_log_bytes"])
    assert deleted > 3 and values["last file deleted"].endswith(f"_{deleted - 1}.mcap")
    shown = {part_id: latched(client, part_id) for part_id in ("kept", "stream")}
    kept = [mesh for mesh in recorded(tmp_path, "part_mesh") if mesh.part_id == "kept"]
    assert 1 <= len(kept) <= 3
    (bag,) = runs(tmp_path)
    node.kill()
    assert ends(tmp_path) == {}
    with cell_of(domain, tmp_path, "bounded", max_log_bytes=BOUND) as (_, again):
        for part_id, before in shown.items():
            after = latched(again, part_id)
            assert after.part_digest == before.part_digest
            # Drops of one of them went on after it was looked at.
            assert after.revision == before.revision or (
                part_id == "kept" and after.revision > before.revision)
            assert after.poses == before.poses or after.revision > before.revision
    assert [event.event for event in ends(tmp_path)[node.job_id]] == [JobEvent.CANCELLED]
    assert_readable_by_others(bag)
    assert {"kept", "stream"} == {part.record.part_id for part in analyse_bags(bag).parts}


def test_parts_too_large_for_the_bound_are_said(domain, tmp_path):
    """They do not go round and round in the bag."""
    with cell_of(domain, tmp_path, "bounded", max_log_bytes=BOUND) as (_, client):
        for number in range(150):
            client.good("estimate", part=scaled(number, f"part {number}"))
        line, values = Health(client).line(
            "recording", lambda line, _: line.level == DiagnosticStatus.WARN)
        assert "too large for max_log_bytes" in line.message
        before = int(values["files deleted for max_log_bytes"])
        _, values = Health(client).line("recording")
        assert int(values["files deleted for max_log_bytes"]) == before
        until(lambda: size_of(tmp_path) <= BOUND, "the bound")

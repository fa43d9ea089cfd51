"""Two cells side by side, with the same folder for their bags."""

from __future__ import annotations

import pytest
from ros_pose_stats_msgs.msg import JobEvent

from .harness.bags import ends, recorded
from .harness.jobs import finished, start
from .harness.parts import WEDGE, flat


@pytest.mark.long
def test_two_namespaces(node_of, client_of, tmp_path):
    names = ("/cell1", "/cell2")
    nodes = [node_of("-r", f"__ns:={name}", log_directory=tmp_path) for name in names]
    for node in nodes:
        node.ready()
    clients = [client_of(f"{name}/pose_stats") for name in names]
    vertices, triangles = WEDGE
    for scale, client in enumerate(clients, 1):
        client.good("estimate", part=flat((scale * vertices, triangles), "part"))
    first, second = (client.good("get_statistics", part_id="part").statistics[0]
                     for client in clients)
    assert first.part_digest != second.part_digest
    jobs = [start(client, "part", 1000, seed=1) for client in clients]
    assert len(set(jobs)) == 2
    for client, job_id in zip(clients, jobs, strict=True):
        assert finished(client, job_id).drops_done == 1000
        assert client.call("list_drop_simulations").job_id == [job_id]
    for client, digest in zip(clients, (first.part_digest, second.part_digest), strict=True):
        with client.late_joiner() as joiner:
            assert joiner.wait("part").part_digest == digest
            assert joiner.parts() == {"part"}
    for node in nodes:
        node.stop()
    assert len(list(tmp_path.glob("pose_stats_*"))) == 2
    assert {job_id: [one.event for one in events]
            for job_id, events in ends(tmp_path).items()} == {
                job_id: [JobEvent.DONE] for job_id in jobs}
    assert {one.part_id for one in recorded(tmp_path, "part_mesh")} == {"part"}

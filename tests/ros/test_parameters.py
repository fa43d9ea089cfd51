"""Parameters while the node runs."""

from __future__ import annotations

import math

import pytest
from rclpy.parameter import Parameter

from .contract import DEFAULTS
from .harness.client import RUNNING, until
from .harness.jobs import LONG, cancel_all, cancelled, finished, get, known_part, reached, start
from .harness.parts import WEDGE, flat, new_id

FIXED = {"mesh_topics", "log_directory", "max_bag_bytes", "max_log_bytes", "restore"}


@pytest.fixture(scope="module")
def node(domain, tmp_path_factory):
    """A node whose parameters these tests change."""
    from .harness.node import NodeProcess

    with NodeProcess(tmp_path_factory.mktemp("bags"), "-r", "__ns:=/tuned") as found:
        yield found.ready()


@pytest.fixture(scope="module")
def module_client(domain, node):
    from .harness.client import Client

    with Client(domain, "/tuned/pose_stats") as found:
        yield found


@pytest.fixture
def client(module_client):
    yield module_client
    cancel_all(module_client)
    back = {name: value for name, value in DEFAULTS.items() if name not in FIXED}
    assert module_client.set(**back) == {}


class TestRefusals:
    @pytest.mark.parametrize(("name", "value", "said"), [
        ("restitution", 1.0, "below 1"), ("restitution", -0.1, "0"),
        ("restitution", math.nan, "nan"), ("restitution", "high", "double"),
        ("drop_height", 0.0, "0.0"), ("drop_height", math.nan, "nan"),
        ("cluster_tolerance", 1.0, "below 1"), ("target_error", -1.0, "-1"),
        ("mesh_unit", 0.0, "0"), ("mesh_unit", -1.0, "-1"),
        ("default_method", "guess", "auto"), ("default_method", 5, "string"),
        ("default_method", "hybrid", "auto"),
        ("refine_drops", -1, "-1"), ("drops", 0, "0"), ("drops", 1.5, "integer"),
        ("workers", -2, "-2"), ("max_queued_jobs", -1, "-1"), ("max_drops", 0, "0"),
        ("max_job_seconds", 0.0, "0"), ("max_parts", 0, "0"), ("max_mesh_bytes", 0, "0"),
        ("log_drops", "yes", "bool"), ("plate", 7, "string"),
    ])
    def test_come_with_a_reason_and_change_nothing(self, client, name, value, said):
        reason = client.set(**{name: value}).get(name)
        assert reason is not None, "accepted"
        assert name.replace("_", " ") in reason.replace("_", " ")
        assert said in reason and "\n" not in reason
        (kept,) = client.call("get_parameters", names=[name]).values
        assert Parameter(name, value=DEFAULTS[name]).get_parameter_value() == kept

    @pytest.mark.parametrize("name", sorted(FIXED))
    def test_what_holds_for_the_run_cannot_be_changed(self, client, name):
        value = {"mesh_topics": ["/other"], "log_directory": "/tmp", "restore": False}.get(
            name, 10**6)
        assert "at the start" in client.set(**{name: value})[name]

    def test_deleting_one(self, client):
        message = Parameter("restitution", Parameter.Type.NOT_SET).to_parameter_msg()
        (result,) = client.call("set_parameters", parameters=[message]).results
        assert not result.successful

    def test_one_that_is_none(self, client):
        assert client.set(no_such_parameter=1)


class TestChanges:
    def test_whole_numbers_are_taken_for_fractions(self, client):
        assert client.set(restitution=0, max_job_seconds=5, drop_height=2) == {}
        found = client.good("estimate", part_id=known_part(client)).statistics
        assert found.restitution == 0.0

    def test_known_parts_are_estimated_again_and_latched(self, client):
        parts = [known_part(client) for _ in range(3)]
        with client.late_joiner() as joiner:
            for part_id in parts:
                assert joiner.wait(part_id).restitution == 0.5
            client.set(restitution=0.25)
            for part_id in parts:
                new = joiner.wait(part_id, lambda message: message.restitution == 0.25)
                assert new.revision > joiner.of(part_id)[0].revision
        assert client.good("estimate", part_id=parts[0]).statistics.restitution == 0.25

    def test_a_simulation_of_the_old_scene_makes_room(self, client):
        part_id = known_part(client)
        finished(client, start(client, part_id, 5000))
        with client.late_joiner() as joiner:
            assert joiner.wait(part_id).drops == 5000
            client.set(restitution=0.25)
            found = joiner.wait(part_id, lambda message: message.restitution == 0.25)
            assert (found.method, found.drops) == ("split", 0)
            client.set(restitution=0.5)
            found = joiner.wait(part_id, lambda message: message.revision > found.revision)
            assert (found.restitution, found.drops) == (0.5, 5000)  # known from before

    def test_method_plate_and_frame(self, client):
        part_id = known_part(client)
        with client.late_joiner() as joiner:
            joiner.wait(part_id)
            client.set(default_method="csae")
            joiner.wait(part_id, lambda message: message.method == "csae")
            client.set(plate="brass")
            joiner.wait(part_id, lambda message: message.plate == "brass")
            client.set(plate_frame="tray")
            joiner.wait(part_id, lambda message: message.header.frame_id == "tray")

    def test_cluster_tolerance(self, client):
        part_id = known_part(client)
        apart = client.good("estimate", part_id=part_id).statistics
        client.set(cluster_tolerance=0.1)
        with client.late_joiner() as joiner:
            found = joiner.wait(part_id, lambda message: message.cluster_tolerance == 0.1)
        assert len(found.poses) < len(apart.poses)

    def test_running_jobs_keep_their_snapshot(self, client):
        client.set(plate="brass")
        part_id = known_part(client)
        job_id = start(client, part_id, LONG, seed=1)
        reached(client, job_id, RUNNING)
        client.set(restitution=0.25, plate="oak", max_job_seconds=1.0, cluster_tolerance=0.0)
        until(lambda: get(client, job_id).drops_done > 500)
        found = cancelled(client, job_id).statistics
        assert (found.restitution, found.cluster_tolerance) == (0.5, 0.0025)
        assert found.plate == "brass"

    def test_numbers_of_jobs(self, client):
        part_id = known_part(client)
        client.set(drops=123, max_drops=1000, max_job_seconds=0.5, max_queued_jobs=0)
        assert finished(client, start(client, part_id, 0)).drops_total == 123
        assert "1000" in client.refused("start_drop_simulation", part_id=part_id, drops=1001)
        client.set(max_drops=LONG)
        job_id = start(client, part_id, LONG)
        assert "max_queued_jobs" in client.refused("start_drop_simulation", part_id=part_id,
                                                   drops=10)
        assert any("0.5 s" in one for one in finished(client, job_id).statistics.warnings)

    def test_max_parts(self, client):
        oldest, used, *_ = [known_part(client) for _ in range(4)]
        client.good("estimate", part_id=used)
        client.set(max_parts=3)
        known = {one.part_id for one in client.good("get_statistics").statistics}
        assert used in known and oldest not in known and len(known) == 3
        known_part(client)
        assert len(client.good("get_statistics").statistics) == 3

    def test_max_mesh_bytes(self, client):
        client.set(max_mesh_bytes=100)
        message = client.refused("estimate", part=flat(WEDGE, new_id()))
        assert "max_mesh_bytes" in message and "100" in message

    def test_several_at_once_are_all_taken_or_none(self, client):
        messages = [Parameter("restitution", value=0.1).to_parameter_msg(),
                    Parameter("drops", value=-1).to_parameter_msg()]
        results = client.call("set_parameters", parameters=messages).results
        assert [result.successful for result in results] == [True, False]

"""The services `~/get_statistics` and `~/forget_part`."""

from __future__ import annotations

import pytest
from ros_pose_stats_msgs.msg import JobEvent

from ..harness.bags import recorded
from ..harness.client import RUNNING
from ..harness.jobs import LONG, cancelled, finished, get, known_part, reached, start
from ..harness.parts import WEDGE, flat, new_id, whole


class TestGetStatistics:
    def test_of_one_part(self, cell):
        part_id = known_part(cell)
        (found,) = cell.good("get_statistics", part_id=part_id).statistics
        assert whole(found) == whole(cell.good("estimate", part_id=part_id).statistics)

    def test_of_all_parts(self, cell):
        parts = {known_part(cell) for _ in range(3)}
        found = {one.part_id for one in cell.good("get_statistics").statistics}
        assert parts <= found

    def test_of_an_unknown_part(self, cell):
        message = cell.refused("get_statistics", part_id="nobody")
        assert "'nobody'" in message and "known part" in message


class TestForgetPart:
    def test_is_unknown_afterwards(self, cell):
        part_id = known_part(cell)
        cell.good("forget_part", part_id=part_id)
        for service in ("get_statistics", "estimate", "forget_part"):
            assert f"'{part_id}'" in cell.refused(service, part_id=part_id)
        assert part_id not in {
            one.part_id for one in cell.good("get_statistics").statistics}

    def test_an_unknown_part(self, cell):
        assert "'nobody'" in cell.refused("forget_part", part_id="nobody")

    def test_no_name(self, cell):
        assert "''" in cell.refused("forget_part")

    def test_goes_to_the_bag(self, cell, shared_node):
        part_id = known_part(cell)
        cell.good("forget_part", part_id=part_id)
        assert [event.part_id for event in recorded(shared_node.log_directory, "job_events")
                if event.event == JobEvent.PART_FORGOTTEN][-1] == part_id

    def test_its_simulations_go_on(self, cell):
        part_id = known_part(cell)
        job_id = start(cell, part_id, LONG)
        reached(cell, job_id, RUNNING)
        cell.good("forget_part", part_id=part_id)
        assert get(cell, job_id).state == RUNNING
        cancelled(cell, job_id)
        with cell.late_joiner() as joiner:
            joiner.wait(known_part(cell))
            assert part_id not in joiner.parts()


class TestLeastRecentlyUsed:
    @pytest.mark.long
    def test_a_part_that_made_room_can_come_again(self, node_of, client_of):
        with node_of(max_parts=2).ready():
            client = client_of()
            first, second, third = (known_part(client) for _ in range(3))
            known = {one.part_id for one in client.good("get_statistics").statistics}
            assert known == {second, third}
            client.good("estimate", part=flat(WEDGE, first))
            with client.late_joiner() as joiner:
                joiner.wait(first)
                joiner.wait(third)
                assert joiner.parts() == {first, third}

    def test_names_in_the_refusal_are_those_known(self, cell):
        part_id = new_id()
        known_part(cell)
        message = cell.refused("estimate", part_id=part_id)
        assert "known part (" in message and len(message) < 500

    def test_a_simulation_keeps_its_part(self, cell):
        """Until it is done, whoever makes room."""
        part_id = known_part(cell)
        job_id = start(cell, part_id, 2000)
        cell.good("forget_part", part_id=part_id)
        assert finished(cell, job_id).statistics.drops == 2000

"""A long queue, clients that die, and meshes that turn out bad."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from ros_pose_stats_msgs.msg import JobEvent

from ros_pose_stats import shapes, simulate
from tests.bodies import subdivided

from ..harness.bags import ends
from ..harness.client import CANCELLED, DONE, FAILED, QUEUED, RUNNING, until
from ..harness.goals import Goals
from ..harness.jobs import LONG, finished, get, known_part, reached, start
from ..harness.parts import WEDGE, counts, flat, library_part, new_id

CLIENT = """
import sys
import rclpy
from rclpy.action import ActionClient
from ros_pose_stats_msgs.action import SimulateDrops

rclpy.init()
node = rclpy.create_node("doomed")
actions = ActionClient(node, SimulateDrops, "/pose_stats/simulate_drops")
actions.wait_for_server()
goal = SimulateDrops.Goal(part_id=sys.argv[1], drops=int(sys.argv[2]), seed=7)
sent = actions.send_goal_async(goal, feedback_callback=lambda message: None)
sent.add_done_callback(lambda done: done.result().get_result_async())
rclpy.spin(node)
"""


def killed_client(cell, part_id, drops):
    """Have a client send a goal, and kill it while the job runs; the job's id."""
    with subprocess.Popen([sys.executable, "-c", CLIENT, part_id, str(drops)]) as client:
        def running():
            listed = cell.call("list_drop_simulations")
            return [job_id for job_id, part, state in zip(
                listed.job_id, listed.part_id, listed.state, strict=True)
                if part == part_id and state == RUNNING]

        (job_id,) = until(running)
        client.kill()
    return job_id


class TestLongQueue:
    @pytest.mark.long
    def test_half_of_fifty_are_cancelled(self, node_of, client_of):
        node = node_of(max_queued_jobs=64).ready()
        client = client_of()
        part_id = known_part(client)
        blocker = start(client, part_id, LONG)
        jobs = [start(client, part_id, 100 + seed, seed=seed) for seed in range(1, 51)]
        assert [get(client, job_id).state for job_id in jobs] == [QUEUED] * 50
        dice = np.random.default_rng(1)
        unwanted = set(dice.choice(jobs, 25, replace=False).tolist())
        for job_id in unwanted:
            client.good("cancel_drop_simulation", job_id=job_id)
        client.good("cancel_drop_simulation", job_id=blocker)
        for seed, job_id in enumerate(jobs, 1):
            wanted = CANCELLED if job_id in unwanted else DONE
            assert reached(client, job_id, wanted).drops_done == (
                0 if job_id in unwanted else 100 + seed)
        node.stop()
        ended = ends(node.log_directory)
        assert {job_id for job_id, events in ended.items()
                if [one.event for one in events] == [JobEvent.DONE]} == set(jobs) - unwanted
        assert len(ended) == 51 and all(len(events) == 1 for events in ended.values())


@pytest.mark.long
class TestClientsThatDie:
    def test_a_goal_whose_client_was_killed_is_done_all_the_same(self, cell):
        part_id = known_part(cell)
        job_id = killed_client(cell, part_id, 30_000)
        assert get(cell, job_id).state == RUNNING
        answer = finished(cell, job_id)
        expected = simulate(library_part(WEDGE), 30_000, seed=7)
        assert counts(answer.statistics.poses) == counts(expected.poses)

    def test_the_next_client_is_served(self, cell):
        part_id = known_part(cell)
        job_id = killed_client(cell, part_id, LONG)
        cell.good("cancel_drop_simulation", job_id=job_id)
        goals = Goals(cell)
        assert goals.send(part_id=part_id, drops=100).result()[1].success
        goals.close()


def fine_ball():
    """Some 80 000 triangles."""
    surface = shapes.icosahedron()
    for _ in range(6):
        surface = subdivided(surface)
    return surface


@pytest.fixture(scope="module")
def big_bad_mesh():
    """Takes a while to be found bad: all in one plane."""
    vertices, triangles = fine_ball()
    return vertices * (1.0, 1.0, 0.0), triangles


class TestMeshesThatTurnOutBad:
    def test_the_job_fails_with_the_reason(self, cell, big_bad_mesh):
        """The acceptance did not wait for the mesh."""
        part_id = new_id()
        job_id = cell.good("start_drop_simulation", part=flat(big_bad_mesh, part_id),
                           drops=100).job_id
        failed = reached(cell, job_id, FAILED)
        assert failed.message.startswith("expected ") and "\n" not in failed.message
        assert failed.drops_done == 0
        assert part_id in cell.refused("estimate", part_id=part_id)

    def test_so_does_a_goal(self, cell, big_bad_mesh):
        goals = Goals(cell)
        vertices, triangles = big_bad_mesh
        goal = goals.send(part=flat((2.0 * vertices, triangles), new_id()), drops=100)
        _, result = goal.result()
        assert not result.success and result.message.startswith("expected ")
        goals.close()

    def test_others_are_served_meanwhile(self, cell, big_bad_mesh):
        vertices, triangles = big_bad_mesh
        part_id = known_part(cell)
        coming = cell.send("start_drop_simulation", drops=100,
                           part=flat((3.0 * vertices, triangles), new_id()))
        assert finished(cell, start(cell, part_id, 100)).drops_done == 100
        until(coming.done)
        answer = coming.result()
        if answer.success:
            reached(cell, answer.job_id, FAILED)

    def test_a_nameless_big_part_twice_is_one_job(self, cell):
        reached(cell, start(cell, known_part(cell), LONG), RUNNING)
        ball = fine_ball()
        def ask():
            return cell.good("start_drop_simulation", part=flat(ball), drops=10, seed=3).job_id
        first, second = ask(), ask()
        until(lambda: library_part(ball).part_id in {
            one.part_id for one in cell.good("get_statistics").statistics})
        assert first == second == ask()

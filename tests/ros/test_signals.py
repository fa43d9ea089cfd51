"""SIGINT and SIGTERM end the node well at any moment."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from ros_pose_stats_msgs.msg import JobEvent

from .harness.bags import ends, recorded
from .harness.client import RUNNING, until, wait_for
from .harness.goals import Goals
from .harness.jobs import LONG, known_part, reached, running_with_results, start
from .harness.parts import flat
from .harness.slow import builder_at_work, ellipsoid, is_gone

QUICK_END = 10.0
"""Seconds; half a second where nobody else computes, and once it was the whole estimate."""

BOTH = pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])


def catches(process, number):
    """Whether a process handles a signal itself."""
    status = Path(f"/proc/{process.pid}/status").read_text()
    caught = int(status.partition("SigCgt:")[2].split()[0], 16)
    return bool(caught >> (number - 1) & 1)


SIGNALS_WHILE_WAITING = """
import os, signal, threading
from ros_pose_stats.ros.stop_signals import StopSignals
stop = StopSignals()
def interrupt():
    for _ in range(20_000):
        os.kill(os.getpid(), signal.SIGINT)
sender = threading.Thread(target=interrupt)
sender.start()
while sender.is_alive():
    stop.asked = False
    stop.wait(0.0)
os.kill(os.getpid(), signal.SIGINT)  # the last one may have been forgotten above
assert stop.wait()
"""


def test_a_signal_in_the_middle_of_a_wait():
    """Its handler must not wait for a lock that the interrupted wait holds."""
    subprocess.run([sys.executable, "-c", SIGNALS_WHILE_WAITING], check=True, timeout=60.0)


class TestStartUp:
    @pytest.mark.parametrize(("number", "delay"), [
        (signal.SIGINT, 0.0), (signal.SIGTERM, 0.5), (signal.SIGINT, 1.0)])
    def test_before_or_about_ready(self, node_of, number, delay):
        node = node_of()
        until(lambda: catches(node.process, signal.SIGTERM), "the handlers")
        time.sleep(delay)
        node.stop(number)

    def test_as_soon_as_it_says_ready(self, node_of):
        node_of().ready().stop()

    def test_more_than_once(self, node_of):
        node = node_of().ready()
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGINT):
            node.send(number)
        assert node.ended() == 0
        node.assert_sound()


class TestAtWork:
    @BOTH
    def test_a_running_job_is_cancelled_and_its_result_is_in_the_bag(
            self, node_of, client_of, number):
        node = node_of().ready()
        client = client_of()
        job_id = start(client, known_part(client), LONG, seed=5)
        running_with_results(client, job_id)
        node.stop(number)
        (event,) = ends(node.log_directory)[job_id]
        assert event.event == JobEvent.CANCELLED
        assert event.message == "the node ended"
        answers = [one for one in recorded(node.log_directory, "answers")
                   if one.job_id == job_id and one.final]
        assert answers[-1].drops == event.drops_done > 0

    @pytest.mark.long
    def test_goals_in_the_queue(self, node_of, client_of):
        node = node_of().ready()
        client = client_of()
        goals = Goals(client)
        part_id = known_part(client)
        sent = [goals.send(part_id=part_id, drops=LONG, seed=seed) for seed in range(1, 7)]
        job_id = sent[0].first_feedback().job_id
        node.stop()
        ended = ends(node.log_directory)
        assert len(ended) == 6 and job_id in ended
        assert all([one.event for one in events] == [JobEvent.CANCELLED]
                   for events in ended.values())
        goals.close()

    def test_an_estimate_that_takes_long_is_refused(self, node_of, client_of):
        node = node_of().ready()
        client = client_of()
        known_part(client)
        asked = client.send("estimate", part=flat(ellipsoid(120_000), "long"))
        process = builder_at_work(node.process.pid)
        assert not asked.done()
        begin = time.monotonic()
        node.stop(signal.SIGTERM)
        assert time.monotonic() - begin < QUICK_END
        answer = wait_for(asked)
        assert not answer.success
        assert answer.message == "expected a running node, got one that is ending; start it again"
        assert is_gone(process)
        assert len(recorded(node.log_directory, "part_mesh")) == 1

    @pytest.mark.long
    def test_while_the_node_itself_computes(self, node_of, client_of):
        node = node_of().ready()
        client = client_of()
        client.good("estimate", part=flat(ellipsoid(300_000), "long"))
        assert client.set(cluster_tolerance=0.011) == {}
        asked = client.send("estimate", part_id="long")
        time.sleep(0.5)
        assert not asked.done(), "too quick for this test"
        begin = time.monotonic()
        node.stop(signal.SIGTERM)
        assert time.monotonic() - begin < QUICK_END
        assert "a running node" in wait_for(asked).message
        assert len(recorded(node.log_directory, "part_mesh")) == 1

    def test_a_refinement_and_a_client_in_the_queue(self, node_of, client_of):
        node = node_of(refine_drops=LONG).ready()
        client = client_of()
        part_id = known_part(client)
        until(lambda: RUNNING in client.call("list_drop_simulations").state)
        job_id = start(client, part_id, LONG)
        reached(client, job_id, RUNNING)
        node.stop()
        assert len(ends(node.log_directory)) == 2

    @pytest.mark.long
    def test_while_meshes_and_requests_come(self, node_of, client_of):
        node = node_of().ready()
        client = client_of()
        goals = Goals(client)
        part_id = known_part(client)
        for seed in range(1, 9):
            client.send("estimate", part_id=part_id, restitution=0.1 + 0.01 * seed)
            client.send("start_drop_simulation", part_id=part_id, drops=1000, seed=seed)
        node.stop(signal.SIGTERM)
        queued = [one.job_id for one in recorded(node.log_directory, "job_events")
                  if one.event == JobEvent.QUEUED]
        assert set(queued) == set(ends(node.log_directory))
        goals.close()

"""Answers to clients that the node does not know entirely yet, or never will."""

from __future__ import annotations

import threading
import time
import warnings

import pytest
from rclpy.action import ActionClient
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.action import SimulateDrops

from ros_pose_stats.ros import late_answers
from ros_pose_stats.ros.late_answers import MOST_WAITING, LateAnswers, losses

from .harness_cell import cell_of
from .harness_client import until, wait_for
from .harness_parts import WEDGE, flat

LOST = "failed to send response (timeout): client will not receive response"
"""What rclpy says; `test_clients_that_cannot_hear` has it from rclpy itself."""


class Send:
    """An answer that the first attempts throw away."""

    def __init__(self, missed):
        self.missed = missed
        self.attempts = []
        self.delivered = threading.Event()

    def __call__(self):
        self.attempts.append(threading.current_thread().name)
        if len(self.attempts) <= self.missed:
            warnings.warn(LOST, RuntimeWarning, stacklevel=1)
        else:
            self.delivered.set()


@pytest.fixture
def said():
    return []


@pytest.fixture
def answers(said):
    found = LateAnswers(said.append)
    yield found
    found.close()


@pytest.fixture
def hurried(monkeypatch):
    monkeypatch.setattr(late_answers, "PAUSES", (0.01, 0.01, 0.01))
    monkeypatch.setattr(late_answers, "REST", 0.01)


def test_an_answer_that_arrives_is_sent_once_by_the_caller(answers, said):
    send = Send(0)
    answers.send("~/estimate", send)
    assert send.attempts == [threading.current_thread().name] and not said


def test_a_lost_answer_is_sent_until_it_arrives(answers, said):
    send, start = Send(3), time.monotonic()
    answers.send("~/estimate", send)
    assert time.monotonic() - start < sum(late_answers.PAUSES[:3])  # the caller is free again
    assert send.delivered.wait(60.0)
    assert send.attempts == [threading.current_thread().name] + 3 * ["late answers"]
    assert not said


def test_what_never_arrives_is_given_up_in_one_line(hurried, answers, said):
    send = Send(1000)
    answers.send("~/estimate", send)
    line, = until(lambda: list(said), "the end of it")
    assert line.startswith("~/estimate: ") and "\n" not in line
    assert all(word in line for word in ("expected", "got", "quality of service"))
    assert len(send.attempts) == 1 + 3


def test_a_deaf_client_does_not_hold_up_the_others(answers):
    deaf, late = Send(1000), Send(1)
    answers.send("~/estimate", deaf)
    answers.send("~/estimate", late)
    assert late.delivered.wait(60.0)


def test_an_error_ends_one_answer_only(hurried, answers, said):
    def broken():
        if threading.current_thread().name == "late answers":
            raise RuntimeError("no such thing")
        warnings.warn(LOST, RuntimeWarning, stacklevel=1)

    late = Send(1)
    answers.send("~/forget_part", broken)
    answers.send("~/estimate", late)
    assert late.delivered.wait(60.0)
    assert until(lambda: list(said), "the error") == [
        "~/forget_part: the answer could not be sent: no such thing"]


def test_deaf_clients_cannot_fill_the_memory(answers, said, monkeypatch):
    monkeypatch.setattr(late_answers, "PAUSES", (3600.0,))
    for _ in range(MOST_WAITING):
        answers.send("~/estimate", Send(1000))
    assert not said
    answers.send("~/estimate", Send(1000))
    assert len(said) == 1


def test_close_gives_up_what_waits(said):
    answers, send = LateAnswers(said.append), Send(1000)
    answers.send("~/estimate", send)
    answers.close()
    attempts = len(send.attempts)
    answers.send("~/estimate", send)  # of a request that was under way
    time.sleep(2 * late_answers.PAUSES[0])
    assert len(send.attempts) == attempts + 1 and not said


def test_other_warnings_are_shown_as_ever(answers):
    with warnings.catch_warnings(record=True) as shown, losses() as lost:
        warnings.simplefilter("always")
        late_answers.catch_losses()
        warnings.warn("of something else", RuntimeWarning, stacklevel=1)
        other = threading.Thread(target=Send(1))
        other.start()
        other.join()
        Send(1)()
    assert lost == [LOST]
    assert [str(one.message) for one in shown] == ["of something else", LOST]


def test_clients_that_cannot_hear(domain, tmp_path):
    """Their quality of service shuts out all answers: the node says so, and serves the others."""
    latched = QoSProfile(depth=10, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    with cell_of(domain, tmp_path, "late") as (node, client):
        client.good("estimate", part=flat(WEDGE, "wedge"))
        asks = client.node.create_client(
            srv.GetStatistics, f"{client.prefix}/get_statistics", qos_profile=latched)
        drops = ActionClient(client.node, SimulateDrops, f"{client.prefix}/simulate_drops",
                             goal_service_qos_profile=latched)
        asked = asks.call_async(srv.GetStatistics.Request())
        goal = drops.send_goal_async(SimulateDrops.Goal(part_id="wedge", drops=10))
        jobs = until(lambda: client.call("list_drop_simulations").job_id, "the goal's job")
        for about in ("~/get_statistics", "simulate_drops"):
            node.says(f"{about}: an answer could not be delivered")
            assert wait_for(client.send("get_statistics")).success
        assert client.call("list_drop_simulations").job_id == jobs
        assert not asked.done() and not goal.done()
        assert node.log.count("could not be delivered") == 2
        asks.call_async(srv.GetStatistics.Request())  # not given up when the node ends
        assert client.good("get_statistics")
        drops.destroy()

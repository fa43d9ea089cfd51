"""Answers to clients that the node does not know entirely yet, or never will."""

from __future__ import annotations

import threading
import time
import warnings

import pytest
from rclpy.action import ActionClient
from rclpy.exceptions import InvalidHandle
from rclpy.qos import DurabilityPolicy, QoSProfile
from ros_pose_stats_msgs import srv
from ros_pose_stats_msgs.action import SimulateDrops

from ros_pose_stats.ros.transport import late_answers
from ros_pose_stats.ros.transport.late_answers import MOST_WAITING, PAUSES, LateAnswers, losses

from ..harness.cell import cell_of
from ..harness.client import until, wait_for
from ..harness.parts import WEDGE, flat

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


def failing_later(error):
    """An answer that is lost at first and cannot be sent any more then."""
    def send():
        if threading.current_thread().name == "late answers":
            raise error
        warnings.warn(LOST, RuntimeWarning, stacklevel=1)

    return send


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
    assert len(deaf.attempts) < len(PAUSES)


def test_a_deaf_client_leaves_the_interpreter_to_others(answers, monkeypatch):
    monkeypatch.setattr(late_answers, "PAUSES", len(PAUSES) * (0.0,))
    deaf = Send(1000)
    answers.send("~/estimate", deaf)
    start = time.monotonic()
    until(lambda: len(deaf.attempts) == 1 + 3, "three attempts")
    assert time.monotonic() - start >= 2 * late_answers.REST


def test_a_service_that_has_ended_needs_no_word(answers, said):
    late = Send(1)
    answers.send("~/forget_part", failing_later(InvalidHandle("destroyed")))
    answers.send("~/estimate", late)
    assert late.delivered.wait(60.0) and not said


def test_an_error_ends_one_answer_only(hurried, answers, said):
    late = Send(1)
    answers.send("~/forget_part", failing_later(RuntimeError("no such thing")))
    answers.send("~/estimate", late)
    assert late.delivered.wait(60.0)
    assert until(lambda: list(said), "the error") == [
        "~/forget_part: the answer could not be sent: no such thing"]


def test_deaf_clients_cannot_fill_the_memory(answers, said, monkeypatch):
    """The one that was tried most often goes, so that a client that is late has its turn."""
    monkeypatch.setattr(late_answers, "PAUSES", (0.0, 3600.0, 3600.0))
    deaf = [Send(1000) for _ in range(MOST_WAITING)]
    answers.send("~/estimate", deaf[0])
    until(lambda: len(deaf[0].attempts) == 2, "the first one's attempt")
    monkeypatch.setattr(late_answers, "PAUSES", (3600.0, 3600.0, 3600.0))
    for send in deaf[1:]:
        answers.send("~/estimate", send)
    assert not said
    monkeypatch.setattr(late_answers, "PAUSES", (0.0, 3600.0, 3600.0))
    late = Send(1)
    answers.send("~/get_statistics", late)
    line, = said
    assert line.startswith("~/estimate: ")
    assert late.delivered.wait(60.0)


def test_a_deaf_client_that_polls_does_not_fill_the_log(hurried, answers, said):
    polls = [Send(1000) for _ in range(5)]
    for send in polls:
        answers.send("~/estimate", send)
    until(lambda: all(len(send.attempts) == 1 + 3 for send in polls), "the end of all")
    answers.close()
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
        warnings.warn("of something else", RuntimeWarning, stacklevel=1)
        other = threading.Thread(target=Send(1))
        other.start()
        other.join()
        Send(1)()
    assert lost == [LOST]
    assert [str(one.message) for one in shown] == ["of something else", LOST]


def test_a_loss_is_noticed_while_another_thread_catches_warnings(answers):
    """As numba does while it compiles; that holds for the whole process."""
    catching, end = threading.Event(), threading.Event()

    def catch():
        with warnings.catch_warnings(record=True):
            catching.set()
            end.wait(60.0)

    other = threading.Thread(target=catch)
    other.start()
    catching.wait(60.0)
    send = Send(1)
    answers.send("~/estimate", send)
    end.set()
    other.join()
    assert send.delivered.wait(60.0)


@pytest.mark.long
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
        for about in ("~/get_statistics", "~/simulate_drops"):
            node.says(f"]: {about}: an answer could not be delivered")
            assert wait_for(client.send("get_statistics")).success
        assert client.call("list_drop_simulations").job_id == jobs
        assert not asked.done() and not goal.done()
        assert node.log.count("could not be delivered") == 2
        asks.call_async(srv.GetStatistics.Request())  # not given up when the node ends
        assert client.good("get_statistics")
        drops.destroy()

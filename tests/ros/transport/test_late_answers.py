"""Answers to clients that the node does not know entirely yet, or never will."""

from __future__ import annotations

import itertools
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
from ros_pose_stats.ros.transport.late_answers import (
    MOST_CLIENTS,
    MOST_WAITING,
    LateAnswers,
    losses,
)

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
    monkeypatch.setattr(late_answers, "PAUSES", (0.01, 0.01, 0.05))
    monkeypatch.setattr(late_answers, "GIVE_UP", 0.3)


def test_an_answer_that_arrives_is_sent_once_by_the_caller(answers, said):
    send = Send(0)
    answers.send("~/estimate", 1, send)
    assert send.attempts == [threading.current_thread().name] and not said


def test_a_lost_answer_is_sent_until_it_arrives(answers, said):
    send, start = Send(3), time.monotonic()
    answers.send("~/estimate", 1, send)
    assert time.monotonic() - start < sum(late_answers.PAUSES[:3])  # the caller is free again
    assert send.delivered.wait(60.0)
    assert send.attempts == [threading.current_thread().name] + 3 * ["late answers"]
    assert not said


def test_what_never_arrives_is_given_up_in_one_line(hurried, answers, said):
    send = Send(1000)
    answers.send("~/estimate", 1, send)
    line, = until(lambda: list(said), "the end of it")
    assert line.startswith("~/estimate: ") and "\n" not in line
    assert all(word in line for word in ("expected", "got", "quality of service"))
    assert len(send.attempts) >= 1 + 3


def test_a_deaf_client_does_not_hold_up_the_others(answers):
    deaf, late = Send(1000), Send(1)
    answers.send("~/estimate", 1, deaf)
    answers.send("~/estimate", 7, late)
    assert late.delivered.wait(60.0)
    assert len(deaf.attempts) <= len(late_answers.PAUSES)


def test_a_deaf_client_that_asks_on_costs_no_further_attempts(answers):
    """Each of them holds the interpreter for a tenth of a second."""
    asked, start = [Send(1000) for _ in range(100)], time.monotonic()
    for number, send in enumerate(asked):
        answers.send("~/estimate", number, send)
        time.sleep(0.005)
    began = sum(pause <= time.monotonic() - start
                for pause in itertools.accumulate(late_answers.PAUSES))
    assert sum(len(send.attempts) for send in asked) <= 1 + began
    other = Send(0)
    answers.send("~/get_statistics", 100, other)
    assert other.delivered.is_set()  # at once, though its number is the deaf client's next one


def test_who_is_taken_for_the_deaf_client_waits_for_one_attempt(answers):
    deaf, other = Send(1000), Send(0)
    answers.send("~/estimate", 1, deaf)
    answers.send("~/estimate", 2, other)
    assert not other.attempts
    assert other.delivered.wait(60.0)
    assert len(deaf.attempts) <= 2


def test_what_waits_for_a_client_arrives_once_it_hears(answers):
    asked = [Send(1), Send(0), Send(0)]
    for number, send in enumerate(asked, 5):
        answers.send("~/estimate", number, send)
    assert all(send.delivered.wait(60.0) for send in asked)
    until(lambda: not answers._clients, "the client to be taken for one that hears")
    later = Send(0)
    answers.send("~/estimate", 8, later)
    assert later.attempts == [threading.current_thread().name]


def test_a_service_that_has_ended_needs_no_word(answers, said):
    late = Send(1)
    answers.send("~/forget_part", 1, failing_later(InvalidHandle("destroyed")))
    answers.send("~/estimate", 7, late)
    assert late.delivered.wait(60.0) and not said


def test_an_error_ends_one_answer_only(hurried, answers, said):
    late = Send(1)
    answers.send("~/forget_part", 1, failing_later(RuntimeError("no such thing")))
    answers.send("~/estimate", 7, late)
    assert late.delivered.wait(60.0)
    assert until(lambda: list(said), "the error") == [
        "~/forget_part: the answer could not be sent: no such thing"]


def test_deaf_clients_cannot_fill_the_memory(answers, monkeypatch):
    monkeypatch.setattr(late_answers, "PAUSES", (3600.0, 3600.0))
    for client in range(2 * MOST_CLIENTS):
        for number in range(2 * MOST_WAITING):
            answers.send("~/estimate", 1000 * client + number, Send(1000))
    assert len(answers._clients) == MOST_CLIENTS
    assert all(len(client.answers) == MOST_WAITING for client in answers._clients)


def test_close_gives_up_what_waits(said):
    answers, send = LateAnswers(said.append), Send(1000)
    answers.send("~/estimate", 1, send)
    answers.close()
    attempts = len(send.attempts)
    answers.send("~/estimate", 1, send)  # of a request that was under way
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
    answers.send("~/estimate", 1, send)
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
        for about in ("~/get_statistics", "~/simulate_drops/_action/send_goal"):
            node.says(f"]: {about}: an answer could not be delivered")
            assert wait_for(client.send("get_statistics")).success
        assert client.call("list_drop_simulations").job_id == jobs
        assert not asked.done() and not goal.done()
        assert node.log.count("could not be delivered") == 2
        asks.call_async(srv.GetStatistics.Request())  # not given up when the node ends
        assert client.good("get_statistics")
        client.run(drops.destroy)

"""An answer that takes long has arrived; only the middleware's word tells that it has not."""

from __future__ import annotations

import time
import warnings

import pytest

from ros_pose_stats.ros.transport.answers import Answers


@pytest.fixture
def answers():
    return Answers(pytest.fail)


def test_a_slow_machine_makes_no_client_deaf(answers):
    asked, arrived = answers.asked("~/estimate", 1), []

    def send_slowly(number):
        time.sleep(0.11)  # as long as the middleware waits for a client that it cannot reach
        arrived.append(number)

    for number in range(4):
        answers.send(asked, lambda number=number: send_slowly(number))
    assert arrived == [0, 1, 2, 3]
    assert not asked.client.unsent


def test_what_was_thrown_away_is_sent_again(answers):
    """The binding returns with the warning set as an error, which Python calls a SystemError."""
    asked, tries = answers.asked("~/estimate", 1), []

    def send():
        tries.append(len(tries))
        if len(tries) == 1:
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("error", RuntimeWarning)
                    warnings.warn("failed to send response (timeout)", RuntimeWarning,
                                  stacklevel=1)
            except RuntimeWarning as warning:
                raise SystemError("returned a result with an exception set") from warning

    answers.send(asked, send)
    assert len(asked.client.unsent) == 1
    asked.client.due = 0.0
    answers.retry()
    assert len(tries) == 2 and not asked.client.unsent


def test_many_requests_at_once_do_not_take_the_place_of_another_client(answers):
    patient = [answers.asked("~/estimate", number).client for number in (1, 2, 3)]
    many = [answers.asked("~/estimate", number).client for number in range(1, 10)]
    assert answers.asked("~/estimate", 4).client is patient[-1]
    assert set(map(id, many)) == {id(many[0])} != {id(patient[0])}

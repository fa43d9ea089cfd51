"""Who is answered: clients that can be reached always are, others cost little."""

from collections import Counter

import pytest

from ros_pose_stats.node.answering_node import Answers


class Service:
    """Clients that number their calls; those that begin with D are out of reach."""

    def __init__(self):
        self.now, self.answers = 1000.0, Answers(lambda line: None, lambda: self.now)
        self.tried = Counter()
        self.heard = Counter()

    def call(self, client, number, *, is_reached=None):
        asked = self.answers.asked("s", number)

        def send():
            self.tried[client] += 1
            if not (client[0] != "D" if is_reached is None else is_reached):
                raise RuntimeWarning("failed to send response")
            self.heard[client] += 1

        return lambda: self.answers.send("s", asked, send)


@pytest.mark.parametrize(
    ("clients", "most"),
    [("D", 220), ("DD", 220), ("HD", 220), ("HDD", 220), ("DH", 2000)],
)
def test_who_can_be_reached_is_and_others_are_tried_seldom(clients, most):
    service = (
        Service()
    )  # a call a second of each; one that asks before its like is taken for it
    for number in range(1, 2001):
        service.now += 1.0
        for which, kind in enumerate(clients):
            service.call(f"{kind}{which}", number)()
    assert service.heard == {name: 2000 for name in service.tried if name[0] == "H"}
    assert service.tried.total() - service.heard.total() <= most


def test_calls_made_at_once_are_answered_beside_one_that_has_passed_their_numbers():
    service = Service()
    for number in range(1, 9):
        for client in ("H", "D") if number < 4 else ("D",):
            service.call(client, number)()
    for send in [service.call("H", number) for number in range(4, 8)][::-1]:
        send()
    assert service.heard["H"] == 7


def test_who_is_reached_again_is_answered_soon():
    service = Service()
    for number in range(1, 3640):
        service.now += 1.0
        service.call("D", number, is_reached=number >= 3600)()
    assert service.heard["D"] >= 29


def test_who_is_passed_is_answered_though_later_answers_to_the_other_fail_first():
    service = Service()
    for client in ("H", "D"):
        for number in range(1, 5):
            service.call(client, number)()
    asked = service.answers.asked("s", 5)
    later = [service.call("D", number) for number in (6, 7)]

    def send():
        for fail in later:
            fail()
        raise RuntimeWarning("failed to send response")

    service.answers.send("s", asked, send)
    service.call("H", 5)()
    assert service.heard["H"] == 5

"""The service `~/feeding`: from latched results and flips, late and once, and its refusals."""

from __future__ import annotations

import math
import signal
import time

import numpy as np
import pytest

from ros_pose_stats import estimate, simulate, simulate_flips
from ros_pose_stats.statistics.feeding import drop_afresh, flip_wrong_ones
from ros_pose_stats.statistics.pose_shares import pose_shares

from .harness.client import RUNNING, wait_for
from .harness.goals import Goals
from .harness.jobs import LONG, finished, known_part, reached, start
from .harness.parts import WEDGE, flat, library_part, new_id

KICK = 0.012
POSES = len(estimate(library_part(WEDGE)).poses)
ASKED = {"wanted": [0, 2], "rate": 40.0, "cycle_time": 0.5}
NAMES = {"accepted": "accepted", "passes": "passes", "flips": "flips",
         "accepted_per_minute": "per_minute"}


def numbers(answer):
    """What an answer tells, in the words of the library."""
    return {ours: tuple(getattr(answer, name + end) for end in ("", "_low", "_high"))
            for name, ours in NAMES.items()}


def check_numbers(answer, expected):
    for name, told in numbers(answer).items():
        assert told == pytest.approx(getattr(expected, name), rel=1e-9), name


def flips_of_the_library(part, flips=10_000):
    poses = len(estimate(part).poses)
    return simulate_flips(part, KICK, flips // poses, seed=1, workers=1)


class TestAfresh:
    def test_an_estimate_has_an_interval(self, cell):
        answer = cell.good("feeding", part_id=known_part(cell), **ASKED)
        check_numbers(answer, drop_afresh(pose_shares(estimate(library_part(WEDGE))), [0, 2],
                                          40.0))
        assert 0.0 < answer.accepted_low < answer.accepted < answer.accepted_high < 1.0
        assert answer.message == "From an estimate (split)." and not answer.transition

    def test_drops_once_they_are_latched(self, cell):
        part_id = known_part(cell)
        before = cell.good("feeding", part_id=part_id, **ASKED)
        job = finished(cell, start(cell, part_id, 20_000, seed=3))
        answer = cell.good("feeding", part_id=part_id, **ASKED)
        counted = simulate(library_part(WEDGE), 20_000, seed=3)
        check_numbers(answer, drop_afresh(pose_shares(counted), [0, 2], 40.0))
        assert answer.message == "From 20000 drops (simulation)."
        assert job.statistics.drops == 20_000
        assert (answer.accepted_high - answer.accepted_low
                < before.accepted_high - before.accepted_low)

    def test_the_method_is_the_node_s(self, node_of, client_of):
        node_of(default_method="area").ready()
        client = client_of()
        answer = client.good("feeding", part_id=known_part(client), **ASKED)
        check_numbers(answer, drop_afresh(pose_shares(estimate(library_part(WEDGE), "area")),
                                          [0, 2], 40.0))
        assert answer.message == "From an estimate (area)."


class TestFlips:
    def test_numbers_are_those_of_the_library(self, cell):
        answer = cell.good("feeding", part_id=known_part(cell), kick_height=KICK, **ASKED)
        part = library_part(WEDGE)
        found = flips_of_the_library(part)
        expected = flip_wrong_ones(pose_shares(estimate(part)), found.counts, [0, 2], 40.0, 0.5)
        if f"{found.flips} flips" not in answer.message:  # a starved machine: ended by the time
            assert answer.flips_low < expected.flips.value < answer.flips_high
            return
        check_numbers(answer, expected)
        np.testing.assert_array_equal(answer.transition, found.transition.ravel())
        assert answer.accepted == 1.0 and 0.0 < answer.flips_low < answer.flips
        assert answer.message == f"From an estimate (split) and {found.flips} flips."

    def test_once_flipped_is_remembered(self, cell):
        part_id = known_part(cell)
        first = cell.good("feeding", part_id=part_id, kick_height=2 * KICK, **ASKED)
        begin = time.monotonic()
        again = cell.good("feeding", part_id=part_id, kick_height=2 * KICK, wanted=[1],
                          rate=10.0, cycle_time=1.0)
        assert time.monotonic() - begin < 0.5
        assert again.transition == first.transition and again.flips != first.flips

    def test_the_flips_of_a_goal_serve_if_there_are_enough(self, cell):
        part_id, goals = known_part(cell), Goals(cell, "simulate_flips")
        kick = 3 * KICK
        goals.send(part_id=part_id, kick_height=kick, drops=1, seed=5).result()
        few = cell.good("feeding", part_id=part_id, kick_height=kick, **ASKED)
        _, many = goals.send(part_id=part_id, kick_height=kick, drops=3000, seed=5).result()
        answer = cell.good("feeding", part_id=part_id, kick_height=kick, **ASKED)
        goals.close()
        assert answer.transition == many.transition != few.transition
        assert f"{sum(many.flips)} flips" in answer.message

    def test_neither_drops_nor_goals_are_in_the_way(self, cell):
        """Both run for minutes meanwhile, and go on afterwards."""
        part_id, goals = known_part(cell), Goals(cell, "simulate_flips")
        job_id = start(cell, part_id, LONG)
        goal = goals.send(part_id=part_id, kick_height=KICK, drops=LONG // 10)
        goal.first_feedback()
        answer = cell.good("feeding", part_id=part_id, kick_height=4 * KICK, **ASKED)
        assert answer.flips > 0.0 and not goal.ended
        assert reached(cell, job_id, RUNNING).drops_done > 0
        goal.cancel()
        goal.result()
        goals.close()

    def test_the_node_answers_others_while_it_flips(self, node_of, client_of):
        """A part that rolls for long: its flips take all the time that there is for them."""
        node_of(drops=10**7, max_job_seconds=3.0).ready()
        client = client_of()
        part_id = known_part(client)
        late = [client.send("feeding", part_id=part_id, kick_height=KICK, **ASKED)
                for _ in range(3)]
        begin = time.monotonic()
        for _ in range(5):
            client.good("get_statistics", part_id=part_id)
        assert time.monotonic() - begin < 2.0 and not any(one.done() for one in late)
        answers = [wait_for(one) for one in late]
        assert time.monotonic() - begin < 30.0  # of the three questions one was worked on
        assert all(one.success for one in answers)
        assert len({one.message for one in answers}) == 1

    def test_the_node_s_own_kick(self, node_of, client_of):
        node_of(flip_height=KICK).ready()
        client = client_of()
        part_id = known_part(client)
        asked = {"part_id": part_id, **ASKED}
        own = client.good("feeding", kick_height=-1.0, **asked)
        assert numbers(own) == numbers(client.good("feeding", kick_height=KICK, **asked))
        assert client.good("feeding", **asked).flips == 0.0
        client.set(flip_height=0.0)
        assert client.good("feeding", kick_height=-1.0, **asked).flips == 0.0

    def test_who_waits_when_the_node_ends_is_told(self, node_of, client_of):
        node = node_of(drops=10**7).ready()
        client = client_of()
        coming = client.send("feeding", part_id=known_part(client), kick_height=KICK, **ASKED)
        time.sleep(0.5)
        node.send(signal.SIGINT)
        answer = wait_for(coming)
        assert not answer.success and "one that is ending" in answer.message
        assert node.ended() == 0


class TestRefusals:
    @pytest.mark.parametrize(("asked", "said"), [
        ({"part_id": "nobody"}, "'nobody'"),
        ({"wanted": [POSES]}, f"got {POSES}"),
        ({"wanted": []}, "got none"),
        ({"rate": 0.0}, "a rate above 0"),
        ({"rate": math.nan}, "a rate above 0"),
        ({"cycle_time": -1.0}, "a cycle time of 0 s or more"),
        ({"kick_height": math.nan}, "a kick_height in metres"),
        ({"kick_height": math.inf}, "a kick_height in metres"),
    ])
    @pytest.mark.parametrize("kick", [0.0, KICK])
    def test_in_one_line(self, cell, asked, said, kick):
        fields = {"part_id": known_part(cell), "kick_height": kick, **ASKED, **asked}
        assert said in cell.refused("feeding", **fields)

    def test_a_full_queue(self, node_of, client_of):
        node_of(drops=10**7, max_queued_jobs=1).ready()
        client = client_of()
        part_id = known_part(client)
        first = client.send("feeding", part_id=part_id, kick_height=KICK, **ASKED)
        time.sleep(0.5)
        others = [client.send("feeding", part_id=part_id, kick_height=n * KICK, **ASKED)
                  for n in (2, 3)]
        answers = [wait_for(one) for one in (first, *others)]
        assert [one.success for one in answers] == [True, True, False]
        assert "max_queued_jobs" in answers[2].message


def test_a_part_that_is_one_pose_needs_nothing(cell):
    """A body that always comes to rest alike."""
    from ros_pose_stats import shapes

    part_id = new_id()
    sphere = shapes.hull_mesh(np.array(  # one flat end under a dome
        [(math.cos(a), math.sin(a), 0.0) for a in np.linspace(0.0, 2.0 * math.pi, 12, False)]
        + [(0.0, 0.0, 0.05)]) * 0.02)
    answer = cell.call("estimate", part=flat(sphere, part_id))
    assert answer.success
    poses = len(answer.statistics.poses)
    found = cell.good("feeding", part_id=part_id, kick_height=KICK, wanted=list(range(poses)),
                      rate=30.0, cycle_time=1.0)
    assert (found.accepted, found.flips, found.accepted_per_minute) == (1.0, 0.0, 30.0)

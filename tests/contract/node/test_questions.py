# Copyright 2026 ros_pose_stats authors
#
# Licensed under the Apache License, Version 2.0 (the "License"); you may not use this
# file except in compliance with the License. You may obtain a copy of the License at
#
#     http://www.apache.org/licenses/LICENSE-2.0
#
# Unless required by applicable law or agreed to in writing, software distributed under
# the License is distributed on an "AS IS" BASIS, WITHOUT WARRANTIES OR CONDITIONS OF
# ANY KIND, either express or implied. See the License for the specific language
# governing permissions and limitations under the License.

"""A planner's questions: what a feeder gets out of a part (`~/plan_feeding`)."""

import math

import numpy as np
import pytest
from action_msgs.msg import GoalStatus
from ros_pose_stats_msgs.msg import Code

from lab.bodies import shapes
from ros_pose_stats import estimate, learn_flips, resting_poses, simulate_flips
from tests.running import answer_json

from .harness.camera import counted, counting
from .harness.cell import Health, latched
from .harness.client import RUNNING, until
from .harness.goals import Goals, planned, plans, refused_plan
from .harness.jobs import LONG, known_part, reached, start
from .harness.parts import (
    WEDGE,
    fine_box,
    flat,
    library_part,
    new_id,
    probabilities,
)

KICK = 0.012
POSES = resting_poses(library_part(WEDGE)).group.size
WANTED = [0, 2]
RATE = 40.0
CYCLE = 0.5
ASKED = {"wanted": WANTED, "dropped_per_minute": RATE, "cycle_seconds": CYCLE}


def interval(answer, name):
    return (
        getattr(answer, name + "_low"),
        getattr(answer, name),
        getattr(answer, name + "_high"),
    )


def by_index(statistics):
    """Probabilities in the order of the poses' numbers."""
    return np.array(
        [share for _, share in sorted(probabilities(statistics.poses).items())]
    )


class TestDropping:
    def test_wrong_ones_are_dropped_again(self, cell):
        """accepted = sum of the wanted, passes = 1 / accepted, a minute: rate x
        accepted.
        """
        part_id = known_part(cell)
        answer = planned(cell, part_id=part_id, **ASKED)
        share = by_index(latched(cell, part_id))[WANTED].sum()
        for name, value in (
            ("accepted", share),
            ("passes", 1.0 / share),
            ("accepted_per_minute", RATE * share),
        ):
            low, middle, high = interval(answer, name)
            assert middle == pytest.approx(value, rel=1e-9) and low < middle < high
        assert answer.accepted_low > 0.0 and answer.accepted_high < 1.0
        assert interval(answer, "flips") == (0.0, 0.0, 0.0)
        drops = latched(cell, part_id).drops
        assert answer.message.startswith("Parts come singly, no plate. ")
        assert " picked a minute, not kicked. " in answer.message
        assert answer.message.endswith(f" From {drops} drops (hybrid).")
        assert not answer.transition
        assert list(answer.action) == [
            answer.PICK if pose in WANTED else answer.LEAVE for pose in range(POSES)
        ]

    def test_the_estimate_is_the_node_s(self, tuned):
        assert tuned.set(default_method="area") == {}
        answer = planned(tuned, part_id=known_part(tuned), **ASKED)
        shares = by_index(estimate(library_part(WEDGE), "area"))
        assert answer.accepted == pytest.approx(shares[WANTED].sum(), rel=1e-9)
        assert answer.message.endswith(" From an estimate (area).")
        slab = known_part(tuned, shapes.box(0.03, 0.02, 0.01))
        answer = planned(tuned, part_id=slab, wanted=[0], dropped_per_minute=RATE)
        assert answer.message.endswith(" From an estimate (area).")
        [warning] = [
            warning for warning in answer.warnings if warning.code == "WANTED_ALIKE"
        ]
        assert warning.acts
        assert warning.text.startswith("pose 1 looks the same as pose 0")


class TestFlips:
    def test_wrong_ones_are_flipped_until_they_lie_right(self, cell):
        """Out of pose i it takes n_i = 1 + sum of T_ij n_j flips, none out of a wanted
        one.
        """
        part_id = known_part(cell)
        answer = planned(cell, part_id=part_id, kick_height=KICK, **ASKED)
        shares = by_index(latched(cell, part_id))
        moves = np.reshape(answer.transition, (POSES, POSES))
        np.testing.assert_allclose(moves.sum(axis=1), 1.0)
        wrong = np.setdiff1d(np.arange(POSES), WANTED)
        needed = np.linalg.solve(
            np.eye(len(wrong)) - moves[np.ix_(wrong, wrong)], np.ones(len(wrong))
        )
        flips = shares[wrong] @ needed
        low, value, high = interval(answer, "flips")
        assert value == pytest.approx(flips, rel=1e-9) and 0.0 < low < value < high
        low, value, high = interval(answer, "accepted_per_minute")
        assert value == pytest.approx(60.0 / (60.0 / RATE + CYCLE * flips), rel=1e-9)
        assert low < value < high
        assert set(np.flatnonzero(np.array(answer.action) == answer.FLIP)) == set(wrong)
        assert interval(answer, "parts_per_minute") == (low, value, high)
        assert (
            interval(answer, "accepted")
            == interval(answer, "passes")
            == (1.0, 1.0, 1.0)
        )
        assert " drops (hybrid) and " in answer.message
        repeated = planned(
            cell,
            part_id=part_id,
            kick_height=KICK,
            wanted=[1],
            dropped_per_minute=10.0,
            cycle_seconds=1.0,
        )
        assert (
            repeated.transition == answer.transition and repeated.flips != answer.flips
        )

    def test_those_of_a_goal_serve_if_they_are_enough(self, cell):
        part_id = known_part(cell)
        goals = Goals(cell, "simulate_flips")
        fields = {"part_id": part_id, "kick_height": 3 * KICK, **ASKED}
        goals.send(part_id=part_id, kick_height=3 * KICK, drops=1, seed=5).result()
        unplanned = planned(cell, **fields)
        _, flipped = goals.send(
            part_id=part_id, kick_height=3 * KICK, drops=10_000 // POSES + 1, seed=5
        ).result()
        answer = planned(cell, **fields)
        goals.close()
        assert answer.transition == flipped.transition != unplanned.transition
        assert f"{sum(flipped.flips)} flips" in answer.message

    def test_neither_drops_nor_goals_are_in_the_way(self, cell):
        """Both run for minutes meanwhile, and go on afterwards."""
        part_id = known_part(cell)
        goals = Goals(cell, "simulate_flips")
        job_id = start(cell, part_id, LONG)
        goal = goals.send(part_id=part_id, kick_height=KICK, drops=LONG // 10)
        goal.first_feedback()
        assert planned(cell, part_id=part_id, kick_height=4 * KICK, **ASKED).flips > 0.0
        assert not goal.ended and reached(cell, job_id, RUNNING).status.drops_done > 0
        goal.cancel()
        goal.result()
        goals.close()

    def test_others_are_answered_while_it_flips(self, tuned):
        """Equal questions share flips, as the queue has no room for more, and hear
        how far they are; also where one of them is cancelled.
        """
        assert tuned.set(drops=10**7, max_queued_jobs=1) == {}
        part_id = known_part(tuned)
        goals = plans(tuned)
        first, *others = [
            goals.send(part_id=part_id, kick_height=KICK, **ASKED) for _ in range(3)
        ]
        feedback = first.first_feedback()
        assert (feedback.kick_heights_done, feedback.kick_heights_total) == (0, 1)
        assert 0 < feedback.flips_done <= feedback.flips_total
        for goal in others:
            assert goal.first_feedback().flips_done > 0
        tuned.good("get_statistics", part_id=part_id)
        first.cancel()
        status, result = first.result()
        assert status == GoalStatus.STATUS_CANCELED
        assert (result.success, result.message) == (False, "cancelled by a client")
        assert result.code == Code.CANCELLED
        for goal in others:
            goal.cancel()
            assert goal.result()[0] == GoalStatus.STATUS_CANCELED

    def test_a_cancelled_plan_flips_no_more(self, tuned):
        """Of three kicks, each of which may take minutes."""
        assert tuned.set(drops=10**7) == {}
        part_id = known_part(tuned)
        health = Health(tuned)
        goal = plans(tuned).send(
            part_id=part_id,
            plate_length=0.3,
            plate_width=0.2,
            kick_heights=[KICK, 2 * KICK, 3 * KICK],
            **ASKED,
        )
        assert goal.first_feedback().kick_heights_total == 3
        goal.cancel()
        assert goal.result()[0] == GoalStatus.STATUS_CANCELED
        health.line("flips", lambda line, _: line.message == "idle")

    def test_the_node_s_own_kick(self, tuned):
        assert tuned.set(flip_height=KICK, drops=300) == {}
        fields = {"part_id": known_part(tuned), **ASKED}
        answer = planned(tuned, kick_height=-1.0, **fields)
        assert (
            answer == planned(tuned, kick_height=KICK, **fields) and answer.flips > 0.0
        )
        assert planned(tuned, **fields).flips == 0.0
        tuned.set(flip_height=0.0)
        assert planned(tuned, kick_height=-1.0, **fields).flips == 0.0

    def test_a_full_queue_is_refused(self, tuned):
        assert tuned.set(drops=10**7, max_job_seconds=0.6, max_queued_jobs=1) == {}
        part_id = known_part(tuned)
        goals = [
            plans(tuned).send(part_id=part_id, kick_height=n * KICK, **ASKED)
            for n in range(1, 7)
        ]
        (_, first), *others = [goal.result() for goal in goals]
        assert first.success
        assert any("max_queued_jobs" in result.message for _, result in others)
        # A question that was accepted needs no further place.
        assert tuned.set(max_queued_jobs=0, drops=300) == {}
        planned(
            tuned,
            part_id=part_id,
            plate_length=0.3,
            plate_width=0.2,
            kick_heights=[0.5 * KICK, 0.4 * KICK, 0.3 * KICK],
            **ASKED,
        )


def flip(cell, part_id, *kicks):
    """Flip a part as often as a question does, by goals, which have all the time they
    need.
    """
    goals = Goals(cell, "simulate_flips")
    for kick in kicks:
        goals.send(
            part_id=part_id, kick_height=kick, drops=10_000 // POSES, seed=1
        ).result()
    goals.close()


class TestPlan:
    def test_service_and_command_plan_alike(self, cell, tmp_path):
        """Equal numbers to the last bit: shares, kicks and their seed are the same."""
        file = tmp_path / "wedge.obj"
        file.write_text(
            "".join(
                [f"v {x!r} {y!r} {z!r}\n" for x, y, z in WEDGE[0].tolist()]
                + [f"f {a + 1} {b + 1} {c + 1}\n" for a, b, c in WEDGE[1]]
            )
        )
        part_id = new_id()
        statistics = cell.good("estimate", part=flat(WEDGE, part_id)).statistics
        flip(cell, part_id, 0.03, 0.011)
        answer = planned(
            cell,
            part_id=part_id,
            plate_length=0.3,
            plate_width=0.2,
            clearance=0.002,
            kick_heights=[0.03, 0.011],
            **ASKED,
        )
        printed = answer_json(
            "feeding",
            file,
            "--unit",
            "m",
            "--plate",
            0.3,
            0.2,
            "--clearance",
            0.002,
            "--kicks",
            0.011,
            0.03,
            "--rate",
            RATE,
            "--cycle-time",
            CYCLE,
            "--wanted",
            "0,2",
            "--seed",
            1,
        )
        assert printed["part_digest"] == statistics.part_digest
        names = [
            {answer.PICK: "pick", answer.FLIP: "flip", answer.LEAVE: "leave"}[action]
            for action in answer.action
        ]
        assert names == printed["actions"] and "flip" in names
        assert (
            answer.kick_height,
            answer.parts_on_plate,
            answer.kicks,
            answer.pickable,
        ) == tuple(
            printed[name] for name in ("kick_height", "parts", "kicks", "pickable")
        )
        assert answer.message.startswith(
            printed["cell"][0].upper() + printed["cell"][1:] + ". "
        )
        for field, name in (
            ("accepted", "accepted"),
            ("passes", "passes"),
            ("flips", "flips"),
            ("accepted_per_minute", "per_minute"),
            ("parts_per_minute", "per_minute"),
        ):
            low, value, high = interval(answer, field)
            assert printed[name] == {"value": value, "low": low, "high": high}
        assert answer.kick_height > 0.0 and answer.flips > 0.0 and low < value < high
        assert "a kick height of 0 m" in refused_plan(
            cell,
            part_id=part_id,
            plate_length=0.3,
            plate_width=0.2,
            kick_heights=[-1],
            **ASKED,
        )
        assert "a kick height of 0 m or more and at most" in refused_plan(
            cell,
            part_id=part_id,
            plate_length=0.3,
            plate_width=0.2,
            kick_heights=[0.011, 1e99],
            **ASKED,
        )

    def test_a_part_of_many_triangles_is_planned_too(self, tuned):
        """In a process of its own."""
        assert tuned.set(drops=2000) == {}
        part_id = known_part(tuned, fine_box(6000))
        answer = planned(
            tuned,
            part_id=part_id,
            plate_length=0.3,
            plate_width=0.2,
            kick_heights=[0.011],
            **ASKED,
        )
        low, value, high = interval(answer, "parts_per_minute")
        assert answer.parts_on_plate > 1 and low < value < high

    def test_flips_that_were_counted_take_the_place_of_the_model_s(self, cell):
        part_id = known_part(cell)
        statistics = latched(cell, part_id)
        fields = {
            "part_id": part_id,
            "kick_height": 0.011,
            "feeder_setting": "slow",
            **ASKED,
        }
        assert "got 'slow'; there is none" in refused_plan(cell, **fields)
        from_pose = statistics.poses[0].index
        flip(cell, part_id, 0.011)
        counting(cell).publish(
            *(
                counted(statistics, [1, 2], from_pose=from_pose, feeder_setting=setting)
                for setting in ("", "slow")
            )
        )

        def plan():
            _, result = plans(cell).send(**fields).result()
            return result if result.success else None

        answer = until(plan, "a plan by counted flips")
        counts = np.zeros((POSES, POSES), np.int64)
        counts[from_pose, [statistics.poses[0].index, statistics.poses[1].index]] = 1, 2
        model = simulate_flips(library_part(WEDGE), 0.011, 10_000 // POSES, seed=1)
        expected = learn_flips([model], counts)
        np.testing.assert_allclose(
            answer.transition, expected.transition.ravel(), rtol=1e-12
        )
        assert "'fast'; there is 'slow'" in refused_plan(
            cell, **{**fields, "feeder_setting": "fast"}
        )


@pytest.mark.parametrize("kick", [0.0, KICK])
@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"part_id": "nobody"}, "'nobody'"),
        ({"wanted": [POSES]}, f"got {POSES}"),
        ({"wanted": []}, "got none"),
        ({"dropped_per_minute": 0.0}, "a rate above 0"),
        ({"dropped_per_minute": math.nan}, "a rate above 0"),
        ({"cycle_seconds": -1.0}, "a cycle time of 0 s or more"),
        ({"kick_height": math.nan}, "a kick_height in metres"),
        ({"kick_height": math.inf}, "a kick_height in metres"),
        ({"plate_width": -1.0}, "a plate with sides above 0 m"),
        (
            {"plate_width": 0.2, "plate_length": 0.3, "look_seconds": -1.0},
            "a look_seconds of 0 or more",
        ),
    ],
)
def test_what_is_no_question_is_refused_in_one_line(cell, fields, words, kick):
    request = {"part_id": known_part(cell), "kick_height": kick, **ASKED, **fields}
    assert words in refused_plan(cell, **request)


def test_where_every_pose_is_wanted_there_is_nothing_to_do(cell):
    part_id = new_id()
    statistics = cell.good("estimate", part=flat(WEDGE, part_id)).statistics
    answer = planned(
        cell,
        part_id=part_id,
        kick_height=KICK,
        dropped_per_minute=30.0,
        cycle_seconds=1.0,
        wanted=list(range(len(statistics.poses))),
    )
    assert (answer.accepted, answer.flips, answer.accepted_per_minute) == (
        1.0,
        0.0,
        30.0,
    )

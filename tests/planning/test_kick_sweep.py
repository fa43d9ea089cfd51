"""Sweeps over kick heights: their ends, their pairing, and the kick that they name."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats import PoseStatsError, part_from_mesh, shapes, simulate, simulate_flips
from ros_pose_stats.planning.kick_sweep import sweep_kicks, usual_kicks
from ros_pose_stats.statistics.feeding import flip_wrong_ones
from ros_pose_stats.statistics.pose_shares import pose_shares

ASKED = {"wanted": [0, 1], "rate": 60.0, "cycle_time": 1.0}
"""Of the box: its two largest faces."""


@pytest.fixture(scope="module")
def box():
    return part_from_mesh(*shapes.box(1.0, 2.0, 3.0))


@pytest.fixture(scope="module")
def dropped(box):
    return simulate(box, 4000, seed=1)


@pytest.fixture(scope="module")
def swept(box, dropped):
    return sweep_kicks(box, dropped, **ASKED, drops=300, seed=7)


def test_each_kick_is_as_if_alone(box, dropped, swept):
    assert [one.kick_height for one in swept.kicks] == list(usual_kicks(dropped.radius))
    one = swept.kicks[6]
    alone = simulate_flips(box, one.kick_height, 300, seed=7)
    np.testing.assert_array_equal(one.flips.counts, alone.counts)
    assert one.feeding == flip_wrong_ones(pose_shares(dropped), alone.counts, [0, 1], 60.0, 1.0)


def test_both_ends(swept):
    """The lowest kick leaves parts where they lie; after the highest they lie as if dropped."""
    first, last = swept.kicks[0].feeding, swept.kicks[-1].feeding
    assert first.flips.value == math.inf and first.per_minute.value == 0.0
    # Flips take the part's share of wrong ones over that of right ones, as drops would.
    share = swept.afresh.accepted
    assert last.flips.value == pytest.approx((1.0 - share.value) / share.value, rel=0.15)


def test_the_fastest_is_in_between(swept):
    best = swept.best
    assert swept.kicks[0] is not best is not swept.kicks[-1]
    rates = [one.feeding.per_minute.value for one in swept.kicks]
    assert best.feeding.per_minute.value == max(rates)
    assert best in swept.near_best and swept.kicks[0] not in swept.near_best


def test_the_fastest_is_found_again(box, dropped, swept):
    """With other flips, four times as many: the first sweep's winner is not far behind."""
    again = sweep_kicks(box, dropped, **ASKED, drops=1200, seed=8)
    place = swept.kicks.index(swept.best)
    value, low, high = again.kicks[place].feeding.per_minute
    noise = math.hypot((high - low) / 3.29, *np.diff(swept.best.feeding.per_minute[1:]) / 3.29)
    assert value >= again.best.feeding.per_minute.value - 4.0 * noise


def test_a_stop_leaves_whole_kicks(box, dropped):
    done = []
    cut = sweep_kicks(box, dropped, **ASKED, kicks=[2.0, 0.5, 1.0, 1.0], drops=400, seed=7,
                      workers=1, on_progress=lambda flips, total: done.append((flips, total)),
                      should_stop=lambda: bool(done) and done[-1][0] > 5000)
    assert {total for _, total in done} == {3 * 6 * 400}
    assert [one.kick_height for one in cut.kicks] == [0.5, 1.0]
    assert all(one.flips.flips == 2400 for one in cut.kicks)


def test_a_stop_before_the_first_is_complete(box, dropped):
    assert sweep_kicks(box, dropped, **ASKED, should_stop=lambda: True).kicks == ()


@pytest.mark.parametrize(("changed", "words"), [
    ({"wanted": [6]}, "wanted poses out of 0 to 5"), ({"rate": -1.0}, "a rate above 0"),
    ({"cycle_time": math.nan}, "a cycle time"), ({"kicks": [-0.1]}, "a kick height of 0 m"),
])
def test_refusals(box, dropped, changed, words):
    with pytest.raises(PoseStatsError, match=words):
        sweep_kicks(box, dropped, **{**ASKED, **changed}, drops=1)

"""Drops of several variants from the same starts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats import DropScene, part_from_mesh, shift_center, simulate
from ros_pose_stats.design.paired_drops import begin_pairs, drop_more, drop_together
from ros_pose_stats.errors import RequestError
from tests.bodies import moved, random_polyhedron, rotation

STONE = random_polyhedron(9, seed=11)


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*STONE)


@pytest.fixture(scope="module")
def shifted(part):
    return shift_center(part, (0.01, 0.0, -0.01))


def test_the_first_variant_is_dropped_as_by_itself(part, shifted):
    found = drop_together([part, shifted], 300, DropScene(restitution=0.3), seed=5)
    alone = simulate(part, 300, restitution=0.3, seed=5)
    assert {pose.index: pose.count for pose in alone.poses} == dict(
        enumerate(found.counts(0).tolist()))


def test_steps_make_no_difference(part, shifted):
    parts, scene = [part, shifted], DropScene()
    at_once = drop_together(parts, 90, scene, seed=8, workers=1)
    pairs = begin_pairs(parts, scene, 8)
    for drops in (20, 20, 65, 90):
        pairs = drop_more(pairs, parts, drops, workers=2)
        assert pairs.drops == drops
    assert np.array_equal(pairs.outcome, at_once.outcome)


def test_all_are_released_at_one_height(part):
    larger = part_from_mesh(*moved(STONE, scale=1.5))
    pairs = begin_pairs([part, larger], DropScene(), 1)
    assert pairs.scene.drop_height == pytest.approx(20.0 * pairs.resting[0].body.radius)


def test_a_part_against_itself_differs_in_nothing(part):
    found = drop_together([part, part], 200, DropScene(), seed=2)
    difference = found.difference(0, [0], 1, [0])
    assert (difference.value, difference.standard_error) == (0.0, 0.0)
    assert difference.p_value == 1.0


def test_a_turned_part_is_released_as_the_first_one_is(part):
    turn = rotation(3)
    turned = part_from_mesh(*moved(STONE, turn))
    parts, scene = [part, turned], DropScene(restitution=0.1)
    pairs = drop_more(begin_pairs(parts, scene, 4), parts, 400, [None, turn])
    downs = [np.array([pose.down for pose in one.poses]) for one in pairs.resting]
    partner = np.argmax((downs[0] @ turn.T) @ downs[1].T, axis=1)
    alike = np.mean(partner[pairs.outcome[0]] == pairs.outcome[1])
    # Rounding grows from impact to impact; from other starts it would be a quarter or so.
    assert alike > 0.9


def test_what_the_pairs_share_cancels(part):
    """A small shift: the joint counts know the difference better than two independent runs."""
    nudged = shift_center(part, (1e-4, 0.0, 0.0))
    found = drop_together([part, nudged], 2000, DropScene(restitution=0.1), seed=6)
    pose = int(found.counts(0).argmax())
    share = found.counts(0)[pose] / 2000
    apart = math.sqrt(2.0 * share * (1.0 - share) / 2000)
    assert found.difference(0, [pose], 1, [pose]).standard_error < 0.7 * apart


def test_a_stop_keeps_what_all_variants_have_done(part, shifted):
    seen = []
    pairs = drop_more(begin_pairs([part, shifted], DropScene(), 1), [part, shifted], 5000,
                      workers=1, on_progress=lambda done, total: seen.append((done, total)),
                      should_stop=lambda: bool(seen) and seen[-1][0] > 5100)
    assert 0 < pairs.drops < 5000
    assert pairs.outcome.shape == (2, pairs.drops)
    assert all(total == 10000 for _, total in seen)


def test_nothing_to_drop_is_refused():
    with pytest.raises(RequestError, match="at least one part"):
        begin_pairs([], DropScene(), 1)

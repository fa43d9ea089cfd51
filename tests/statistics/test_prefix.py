"""Checkpoints and the stop rule."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_pose_stats.statistics.error_bound import Judged
from ros_pose_stats.statistics.prefix import (
    AHEAD,
    Judge,
    Prefix,
    next_checkpoint,
    sooner_checkpoint,
    target_reached,
)
from tests.statistics.simulations import checkpoints


def test_the_first_ones():
    assert list(checkpoints(2000)) == [100, 150, 225, 337, 505, 757, 1135, 1702, 2000]


@pytest.mark.parametrize(("drops", "expected"), [
    (1, [1]), (99, [99]), (100, [100]), (101, [100, 101]), (150, [100, 150]),
])
def test_the_bound_is_the_last(drops, expected):
    assert list(checkpoints(drops)) == expected


@given(st.integers(1, 10_000_000))
def test_rising_to_the_bound(drops):
    found = list(checkpoints(drops))
    assert found[-1] == drops
    assert all(a < b for a, b in pairwise(found))
    assert all(b == a * 3 // 2 for a, b in pairwise(found[:-1]))


@given(st.integers(1, 10_000_000), st.integers(1, 10_000_000))
def test_a_larger_bound_looks_at_the_same_prefixes(drops, more):
    # All but the bound itself: a run stops at the same prefix whatever its bound.
    shorter = list(checkpoints(drops))[:-1]
    assert list(checkpoints(drops + more))[:len(shorter)] == shorter


@given(st.integers(0, 2_000_000), st.integers(1, 1_000_000))
def test_next_is_the_first_beyond(done, drops):
    beyond = [n for n in checkpoints(drops) if n > done]
    assert next_checkpoint(done, drops) == (beyond[0] if beyond else drops)


@pytest.mark.parametrize(("bound", "target", "stops"), [
    (0.01, 0.01, True), (0.009, 0.01, True), (0.011, 0.01, False), (0.0, 0.0, False),
    (0.0, 0.01, True), (math.inf, 0.01, False), (0.01, 0.0, False),
])
def test_target(bound, target, stops):
    assert target_reached(bound, target) is stops


def test_an_earlier_first_look():
    done, found = 0, []
    while done < 100:
        done = next_checkpoint(done, 100, 10)
        found.append(done)
    assert found == [10, 15, 22, 33, 49, 73, 100]


def test_a_judge_stops_in_place_of_the_counts():
    told = []

    def error(counts):
        told.append(int(counts.sum()))
        return Judged(0.3, 0.5 if counts.sum() < 15 else 0.01)

    prefix = Prefix(2, 1000, 0.02, False, Judge(error, first=10))
    assert prefix.wanted == 10
    assert prefix.add(np.zeros(40, np.int64)) == 15
    assert prefix.finished and prefix.judged() == (0.3, 0.01)
    assert told == [10, 15]


@given(st.integers(1, 10_000_000), st.floats(1.0001, 100.0))
def test_a_look_comes_a_little_after_the_root_law_at_the_latest(done, above):
    found = sooner_checkpoint(done, 0.01 * above, 0.01)
    assert found == int(found) > done
    root_law = math.ceil(AHEAD * done * above ** 2 * (1.0 + 1e-9))
    assert found <= max(done + 8, math.ceil(1.1 * done), root_law)
    assert sooner_checkpoint(done, math.inf, 0.01) == math.inf


def test_a_judge_is_asked_again_where_the_target_may_be_reached():
    asked = []

    def error(counts):
        asked.append(int(counts.sum()))
        return Judged(math.nan, 0.2 / math.sqrt(counts.sum()))

    prefix = Prefix(2, 10_000, 0.01, False, Judge(error, first=390))
    prefix.add(np.zeros(10_000, np.int64))
    assert asked[0] == 390 and 440 <= asked[1] <= 441  # a tenth beyond 400
    assert asked[1:] == [prefix.drops]


def test_what_is_only_shown_is_not_judged_at_every_drop():
    asked = []

    def error(counts):
        asked.append(int(counts.sum()))
        return Judged(0.3, 0.5)

    prefix = Prefix(2, 1000, 0.02, False, Judge(error, first=500, pause=3600.0))
    shown = []
    for _ in range(100):
        prefix.add(np.zeros(1, dtype=int))
        shown.append(prefix.recently_judged().bound)
    assert set(shown) == {0.5}
    assert asked == [1]
    prefix.add(np.zeros(900, dtype=int))
    assert prefix.finished and prefix.recently_judged().bound == 0.5 and asked[-1] == 1000

"""What counts add on a real plate: Budden's dice, half of their rolls told, the others judge."""

from __future__ import annotations

import math
from collections import defaultdict
from dataclasses import replace
from functools import partial

import numpy as np
import pytest

from ros_pose_stats import simulate
from ros_pose_stats.planning.observed import observe_counts
from ros_pose_stats.plates import fit_plate
from ros_pose_stats.statistics.posterior.shortest import shortest_interval
from ros_pose_stats.study.plates.runs import FITTED, counted_die
from ros_pose_stats.study.prisms.dice import DICE
from ros_pose_stats.study.prisms.prism_runs import on_squares, square_prism

FITS, SPLITS = 3, 20
SEEN = (0, 10, 30, 100, 300)
WORSE = 1.03
"""Most of the error of the better one of model and counts."""

ONE_IN_A_HUNDRED = 2.326
"""Standard errors that a mean exceeds by chance so rarely; it is looked at five times."""


def predicted_dice(number):
    """Ten dice as a plate predicts them that was fitted to the other five."""
    random = np.random.default_rng((17, number))
    fitted = set(random.choice(len(DICE), FITTED, replace=False).tolist())
    fit = fit_plate([counted_die(DICE[k]) for k in sorted(fitted)], seed=number)
    drop = partial(simulate, drops=2000, restitution=fit.restitution[0], seed=number,
                   drop_height=fit.drop_height[0], cluster_tolerance=0.0, round_sides=0)
    return [(die, replace(drop(square_prism(die.ratio)), plate_error=fit.plate_error))
            for k, die in enumerate(DICE) if k not in fitted]


def share_on_squares(found):
    return sum(pose.probability for pose in on_squares(found.poses))


def observed(model, on_square, seen):
    """The share on the squares and its standard error, those of a pose times the two alike."""
    squares = [pose.index for pose in on_squares(model.poses)]
    side = next(pose.index for pose in model.poses if pose.index not in squares)
    counts = np.zeros(len(model.poses), dtype=np.int64)
    counts[[squares[0], side]] = on_square, seen - on_square
    one = on_squares(observe_counts(model, counts).poses)[0]
    return 2.0 * one.probability, 2.0 * one.standard_error


def holds(share, error, judge):
    """Whether an interval of 90 %, with the noise of the rolls that judge, holds their share."""
    variance = np.array([[error**2 + share * (1.0 - share) / judge.size]])
    low, high = shortest_interval(np.ones((1, 1)), np.array([[share]]), variance, 0.9)
    return low[0] <= judge.mean() <= high[0]


def judge_half(die, model, seen, random):
    """Square errors (own, model's, counts') of one random half, and whether the interval holds.

    The noise of the rolls that judge is taken off; so a square may come out below 0.
    """
    rolled = np.repeat([True, False], [die.rolls - die.rolls_on_sides, die.rolls_on_sides])
    told, judge = np.split(random.permutation(rolled), [die.rolls // 2])
    on_square, truth = int(told[:seen].sum()), judge.mean()
    own, error = observed(model, on_square, seen)
    counted = on_square / seen if seen else math.inf
    noise = truth * (1.0 - truth) / (judge.size - 1)
    squares = [(one - truth) ** 2 - noise for one in (own, share_on_squares(model), counted)]
    return [*squares, seen and holds(own, error, judge)]


@pytest.fixture(scope="module")
def judged():
    """By parts seen: what `judge_half` says of each die (D, 4), in the mean over fits and halves.

    A die that has not so many rolls in a half is left out.
    """
    random, predicted = np.random.default_rng(5), defaultdict(list)
    for number in range(FITS):
        for die, model in predicted_dice(number):
            predicted[die].append(model)
    return {seen: np.array([
        np.mean([judge_half(die, model, seen, random)
                 for model in models for _ in range(SPLITS)], axis=0)
        for die, models in predicted.items() if seen <= die.rolls // 2]) for seen in SEEN}


def error_of_mean(values):
    return values.std(ddof=1) / math.sqrt(len(values))


@pytest.mark.long
@pytest.mark.parametrize("seen", SEEN)
def test_never_worse_than_the_better_of_model_and_counts(judged, seen):
    """In the mean over the dice, which stand for the plate; their scatter is the noise."""
    squares = judged[seen][:, :3]
    better = squares.mean(axis=0)[1:].argmin() + 1
    beyond = squares[:, 0] - WORSE**2 * squares[:, better]
    assert beyond.mean() <= ONE_IN_A_HUNDRED * error_of_mean(beyond)


@pytest.mark.long
@pytest.mark.parametrize("seen", SEEN[1:])
def test_intervals_of_ninety_per_cent(judged, seen):
    """Those of one die go together, so the dice are the sample."""
    inside = judged[seen][:, 3]
    print(f"{seen} parts: {100.0 * inside.mean():.0f} % of the intervals hold")
    assert abs(inside.mean() - 0.9) <= ONE_IN_A_HUNDRED * error_of_mean(inside)

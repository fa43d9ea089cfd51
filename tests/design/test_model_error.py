"""How much of the plate's error is left in a difference, on rolled dice and simulated plates.

The functions print what they measure: `pytest -s -m long tests/design/test_model_error.py`.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats import DropScene, part_from_mesh, resting_poses, shapes, shift_center, simulate
from ros_pose_stats.design.correspondence import find_correspondence
from ros_pose_stats.design.model_error import KEPT, LEFT, plate_part
from ros_pose_stats.design.paired_drops import drop_together
from ros_pose_stats.study.prisms.dice import DICE
from ros_pose_stats.study.prisms.prism_runs import on_squares, square_prism
from tests.bodies import random_polyhedron


def kept_share(model, real, variance):
    """Root mean square error of differences over their size, the noise of counts taken off."""
    error = np.mean((real - model) ** 2 - variance)
    return math.sqrt(max(float(error), 0.0) / float(np.mean(model ** 2)))


def test_alike_variants_keep_little_and_strangers_all():
    assert plate_part(0.0, 0.05) == pytest.approx(LEFT * 0.05)
    assert plate_part(-0.1, 0.05) == plate_part(0.1, 0.05) == pytest.approx(KEPT * 0.1, rel=0.05)
    assert plate_part(0.9, 0.05) == pytest.approx(0.05 * math.sqrt(2.0))
    assert plate_part(0.9, 0.0) == 0.0


@pytest.mark.long
def test_rolled_dice():
    """Fifteen bars, each beside those of nearly its length: what the model says of the difference
    of two, and what came of rolling both."""
    drops = 10_000
    model = np.array([sum(pose.probability for pose in on_squares(simulate(
        square_prism(die.ratio), drops, seed=k, cluster_tolerance=0.0, round_sides=0).poses))
        for k, die in enumerate(DICE)])
    real = np.array([die.on_squares for die in DICE])
    noise = (real * (1.0 - real) / np.array([die.rolls for die in DICE])
             + model * (1.0 - model) / drops)
    one, other = np.triu_indices(len(DICE), 1)
    near = np.array([DICE[j].ratio / DICE[i].ratio < 1.35 for i, j in zip(one, other,
                                                                          strict=True)])
    one, other = one[near], other[near]
    found = kept_share(model[other] - model[one], real[other] - real[one],
                       noise[one] + noise[other])
    print(f"{len(one)} pairs of dice: the difference errs by {found:.2f} of itself")
    assert 0.5 * KEPT < found < 1.5 * KEPT


def random_variants(random, number):
    """A part, stretched by up to 6 %, and with its centre of mass moved by up to 0.06 radii."""
    surface = (random_polyhedron(int(random.integers(6, 14)), number) if number % 3 else
               shapes.box(*random.uniform(0.6, 1.4, 3)))
    part = part_from_mesh(*surface)
    amounts, stretch, offset = np.exp(random.uniform(*np.log([0.005, 0.06]), 2)), np.ones(3), \
        random.normal(size=3)
    stretch[number % 3] += amounts[0]
    shift = amounts[1] * resting_poses(part).body.radius * offset / np.linalg.norm(offset)
    return [part, part_from_mesh(surface[0] * stretch, surface[1]), shift_center(part, shift)]


def differences_on_a_plate(random, number, drops):
    """Differences of shares in the model and on a plate (n, 2), the variance of the noise of both
    (n,), and the plate's error of single shares: it has another restitution and drop height."""
    variants = random_variants(random, number)
    radius = resting_poses(variants[0]).body.radius
    scenes = [DropScene(0.5, 20.0 * radius), DropScene(
        float(random.uniform(0.15, 0.8)), radius * float(np.exp(random.uniform(1.1, 3.7))))]
    pairs = [drop_together(variants, drops, scene, number + 100 * k)
             for k, scene in enumerate(scenes)]
    shares = np.array([one.counts(0) / drops for one in pairs])
    noise = (shares * (1.0 - shares)).sum(axis=0) / drops
    plate = math.sqrt(max(float(np.mean(np.diff(shares, axis=0) ** 2 - noise)), 0.0))
    known = [[one.difference(0, poses.first, other, poses.second) for one in pairs]
             for other in (1, 2) for poses in find_correspondence(
                 pairs[0].resting[0], pairs[0].resting[other]).matches if poses.is_pair]
    return (np.array([[one.value for one in both] for both in known]),
            np.array([sum(one.standard_error ** 2 for one in both) for both in known]), plate)


@pytest.mark.long
def test_simulated_plates():
    """Differences on a plate, small and large, are as far off the model's as `plate_part` says."""
    random, beyond, sizes = np.random.default_rng(7), [], []
    for number in range(40):
        values, variance, plate = differences_on_a_plate(random, number, 5000)
        told = np.array([plate_part(one, plate) for one in values[:, 0]])
        beyond += (np.diff(values, axis=1)[:, 0] / np.sqrt(variance + told ** 2)).tolist()
        sizes += np.abs(values[:, 0]).tolist()
    groups = np.digitize(sizes, [0.01, 0.03])
    found = [math.sqrt(np.mean(np.array(beyond)[groups == group] ** 2)) for group in range(3)]
    print(f"{len(sizes)} differences, below 1, 3 points and above, err by", *np.round(found, 2),
          "of what is told")
    # Differences of one part go together: about a hundred are independent, 30 of the largest.
    assert all(0.6 < one < 1.0 + 3.0 / math.sqrt(60.0) for one in found)

"""How much of the plate's error is left in a difference, on rolled dice and simulated plates.

The functions print what they measure: `pytest -s -m long tests/design/test_model_error.py`.
"""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats import DropScene, part_from_mesh, resting_poses, shapes, shift_center, simulate
from ros_pose_stats.design.correspondence import find_correspondence
from ros_pose_stats.design.model_error import KEPT, plate_part
from ros_pose_stats.design.paired_drops import drop_together
from ros_pose_stats.study.prisms.dice import DICE
from ros_pose_stats.study.prisms.prism_runs import on_squares, square_prism
from tests.bodies import random_polyhedron

OF_DICE = 0.05
"""Error of a single share on the plate of the dice, rms (docs/study/accuracy.md)."""


def kept_share(model, real, variance):
    """Root mean square error of differences over their size, the noise of counts taken off."""
    error = np.mean((real - model) ** 2 - variance)
    return math.sqrt(max(float(error), 0.0) / float(np.mean(model ** 2)))


def test_alike_variants_keep_little_and_strangers_all():
    assert plate_part(0.0, 0.05) == 0.0
    assert plate_part(-0.02, 0.05) == plate_part(0.02, 0.05) == pytest.approx(0.006)
    assert plate_part(0.9, 0.05) == pytest.approx(0.05 * math.sqrt(2.0))


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
    assert 0.5 * KEPT * OF_DICE < found < 1.7 * KEPT * OF_DICE


@pytest.mark.long
def test_simulated_plates():
    """A plate is another restitution and drop height: its differences are nearly the model's."""
    random, rows = np.random.default_rng(7), []
    for number in range(12):
        surface = (random_polyhedron(int(random.integers(6, 14)), number) if number % 2 else
                   shapes.box(*random.uniform(0.6, 1.4, 3)))
        part = part_from_mesh(*surface)
        stretch = np.ones(3)
        stretch[number % 3] += random.uniform(0.02, 0.1)
        offset = random.normal(size=3)
        radius = resting_poses(part).body.radius
        variants = [part, part_from_mesh(surface[0] * stretch, surface[1]),
                    shift_center(part, 0.05 * radius * offset / np.linalg.norm(offset))]
        scenes = [DropScene(0.5, 20.0 * radius), DropScene(
            float(random.uniform(0.15, 0.8)), radius * float(np.exp(random.uniform(1.1, 3.7))))]
        model, plate = (drop_together(variants, 4000, scene, number + 100 * k)
                        for k, scene in enumerate(scenes))
        for other in (1, 2):
            match = find_correspondence(model.resting[0], model.resting[other])
            for poses in match.matches:
                if poses.is_pair:
                    both = [one.difference(0, poses.first, other, poses.second)
                            for one in (model, plate)]
                    rows.append((both[0].value, both[1].value,
                                 sum(one.standard_error ** 2 for one in both)))
    told, real, variance = np.array(rows).T
    found = kept_share(told, real, variance)
    print(f"{len(rows)} differences on simulated plates err by {found:.2f} of themselves")
    assert found < KEPT * OF_DICE
    sure = np.abs(told) > 3.0 * np.sqrt(variance)
    assert sure.sum() > 10
    assert np.mean(np.sign(told[sure]) == np.sign(real[sure])) > 0.95

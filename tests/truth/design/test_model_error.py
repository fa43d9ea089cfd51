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

"""How much of a plate's error is left in a difference, on rolled dice and simulated
plates.

The tests print what they measure: `pytest -s -m long
tests/truth/design/test_model_error.py`.
"""

import math

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.dice import DICE, on_squares, square_prism
from lab.bodies.samples import random_polyhedron
from ros_pose_stats import (
    compare,
    part_from_mesh,
    resting_poses,
    shift_center,
    simulate,
)


def differences(comparison):
    """Variant and poses -> difference, its standard error squared, and what a plate
    adds.
    """
    return {
        (variant.second, pose.poses.first): (
            pose.share.difference.value,
            pose.share.difference.standard_error**2,
            pose.share.plate_error,
        )
        for variant in comparison.variants
        for pose in variant.poses
        if pose.poses.is_pair
    }


@pytest.mark.long
def test_rolled_dice():
    """Fifteen bars, each beside those of nearly its length: what the model says of the
    difference of two, and what came of rolling both, is off by about as much as is
    told.
    """
    drops = 10_000
    model = np.array(
        [
            sum(
                pose.probability
                for pose in on_squares(
                    simulate(
                        square_prism(die.ratio),
                        drops,
                        seed=k,
                        cluster_tolerance=0.0,
                        round_sides=0,
                    ).poses
                )
            )
            for k, die in enumerate(DICE)
        ]
    )
    real = np.array([die.on_squares for die in DICE])
    noise = (
        real * (1.0 - real) / np.array([die.rolls for die in DICE])
        + model * (1.0 - model) / drops
    )
    first, second = np.triu_indices(len(DICE), 1)
    similar = np.array(
        [
            DICE[j].ratio / DICE[i].ratio < 1.35
            for i, j in zip(first, second, strict=True)
        ]
    )
    first = first[similar]
    second = second[similar]
    difference = model[second] - model[first]
    error = np.mean(
        (real[second] - real[first] - difference) ** 2 - noise[first] - noise[second]
    )
    measured = math.sqrt(max(error, 0.0) / np.mean(difference**2))
    print(
        f"{len(first)} pairs of dice: the difference errs by {measured:.2f} of itself"
    )
    bars = compare([square_prism(1.0), square_prism(1.2)], seed=1)
    value, _, added = max(differences(bars).values(), key=lambda rate: abs(rate[0]))
    stated_error = added / abs(value)
    assert 0.5 * stated_error < measured < 1.5 * stated_error


def random_variants(random, number):
    """A part, stretched by up to 6 %, and with its centre of mass moved by up to 0.06
    radii.
    """
    surface = (
        random_polyhedron(int(random.integers(6, 14)), number)
        if number % 3
        else shapes.box(*random.uniform(0.6, 1.4, 3))
    )
    part = part_from_mesh(*surface)
    amounts = np.exp(random.uniform(*np.log([0.005, 0.06]), 2))
    stretch = np.ones(3)
    stretch[number % 3] += amounts[0]
    offset = random.normal(size=3)
    shift = (
        amounts[1] * resting_poses(part).body.radius * offset / np.linalg.norm(offset)
    )
    return [
        part,
        part_from_mesh(surface[0] * stretch, surface[1]),
        shift_center(part, shift),
    ]


@pytest.mark.long
def test_simulated_plates():
    """Differences on a plate of another restitution and drop height, small and large,
    are as far off those of the model as is told, for the plate's own error of single
    shares.
    """
    random = np.random.default_rng(7)
    beyond = []
    sizes = []
    drops = 5000
    for number in range(40):
        variants = random_variants(random, number)
        radius = resting_poses(variants[0]).body.radius
        model = {"restitution": 0.5, "drop_height": 20.0 * radius}
        real = {
            "restitution": float(random.uniform(0.15, 0.8)),
            "drop_height": radius * float(np.exp(random.uniform(1.1, 3.7))),
        }
        shares = np.array(
            [
                [
                    pose.probability
                    for pose in sorted(
                        simulate(variants[0], drops, seed=number + k, **scene).poses,
                        key=lambda pose: pose.index,
                    )
                ]
                for k, scene in enumerate((model, real))
            ]
        )
        noise = (shares * (1.0 - shares)).sum(axis=0) / drops
        plate = math.sqrt(
            max(float(np.mean(np.diff(shares, axis=0) ** 2 - noise)), 0.0)
        )
        stated, counted = (
            differences(
                compare(
                    variants,
                    drops=drops,
                    seed=number + 100 * k,
                    plate_error=plate,
                    **scene,
                )
            )
            for k, scene in enumerate((model, real))
        )
        for pair, (value, variance, added) in stated.items():
            counted_value, other_variance, _ = counted[pair]
            beyond.append(
                (counted_value - value)
                / math.sqrt(variance + other_variance + added**2)
            )
            sizes.append(abs(value))
    groups = np.digitize(sizes, [0.01, 0.03])
    ratios = [
        math.sqrt(np.mean(np.array(beyond)[groups == group] ** 2)) for group in range(3)
    ]
    print(
        f"{len(sizes)} differences, below 1, 3 points and above, err by",
        *np.round(ratios, 2),
        "of what is told",
    )
    # Differences of one part go together: about a hundred are independent, 30 of the
    # largest.
    assert all(0.6 < ratio < 1.0 + 3.0 / math.sqrt(60.0) for ratio in ratios)

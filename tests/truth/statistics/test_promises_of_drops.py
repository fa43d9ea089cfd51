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

"""What counted drops promise: intervals, bounds and targets, over many runs of known
truth.

Of a regular solid every share is known; of another part a long run tells it to 0.003.
"""

import math

import numpy as np
import pytest
from scipy.stats import beta, binom

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from ros_pose_stats import auto, part_from_mesh, simulate
from tests.answers import by_index

LONG = 30_000


def long_run(part, restitution):
    """Probabilities by index."""
    statistics = simulate(part, LONG, restitution, 1)
    return by_index(statistics, "count") / LONG


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*random_polyhedron(9, 3))


@pytest.fixture(scope="module")
def truth(part):
    return long_run(part, 0.3)


RUNS = 120


@pytest.fixture(scope="module")
def hundreds(part):
    """Runs of 100 drops."""
    return [simulate(part, 100, 0.3, 1000 + seed, workers=1) for seed in range(RUNS)]


def test_intervals_cover_as_they_promise(hundreds, truth):
    """How often a Jeffreys interval of 100 drops holds p is known for each p.

    Within the central 99.99 % of the binomial around that.
    """
    low, high = (
        np.array([by_index(run, f"probability_{end}") for run in hundreds])
        for end in ("low", "high")
    )
    covered = ((low <= truth) & (truth <= high)).sum(axis=0)
    count = np.arange(101)
    ends = (
        np.where(count == 0, 0.0, beta.ppf(0.05, count + 0.5, 100.5 - count)),
        np.where(count == 100, 1.0, beta.ppf(0.95, count + 0.5, 100.5 - count)),
    )
    for pose, p in enumerate(truth):
        promised = binom.pmf(count, 100, p)[(ends[0] <= p) & (p <= ends[1])].sum()
        least, most = binom.ppf((5e-5, 1.0 - 5e-5), RUNS, promised)
        assert least <= covered[pose] <= most


def test_errors_and_the_bound_of_every_pose(hundreds, truth):
    """A mean square over 120 runs of some five free shares is known to 6 %."""
    away = np.array([by_index(run, "probability") for run in hundreds]) - truth
    stated_error = np.mean([run.expected_error**2 for run in hundreds])
    assert np.mean(away**2) / stated_error == pytest.approx(1.0, abs=0.24)
    within = np.abs(away).max(axis=1) <= [run.largest_error for run in hundreds]
    assert within.mean() == pytest.approx(0.9, abs=4.0 * math.sqrt(0.09 / RUNS))


@pytest.mark.parametrize(
    ("surface", "true", "target"),
    [
        (shapes.tetrahedron(), 0.25, 0.03),
        pytest.param(shapes.box(1.0, 1.0, 2.0), None, 0.02, marks=pytest.mark.long),
    ],
    ids=["tetrahedron", "bar"],
)
def test_a_target_is_kept_in_nine_of_ten_runs(surface, true, target):
    """Though the counts choose when to stop; three standard errors of 120 runs are
    0.08.
    """
    solid = part_from_mesh(*surface)
    hits = []
    true = long_run(solid, 0.0) if true is None else true
    for seed in range(RUNS):
        statistics = simulate(solid, 10**6, 0.0, seed, target_error=target, workers=1)
        away = by_index(statistics, "probability") - true
        hits.append(math.sqrt(np.mean(away**2)) <= target)
    assert np.mean(hits) >= 0.9 - 3.0 * math.sqrt(0.09 / RUNS)


def test_stopping_at_a_target_hardly_biases(part, truth):
    """The mean over runs that stop at one of two checkpoints is right within 0.002.

    And 4.5 of its standard errors. A look at the error favours prefixes that happen to
    look even; few looks, far apart, keep that small.
    """
    estimates_of_runs = [
        simulate(part, 225, 0.3, 5000 + seed, target_error=0.0429, workers=1)
        for seed in range(RUNS)
    ]
    assert 0.1 < np.mean([run.drops < 225 for run in estimates_of_runs]) < 0.9
    shares = np.array([by_index(run, "probability") for run in estimates_of_runs])
    error = shares.std(axis=0, ddof=1) / math.sqrt(RUNS) + np.sqrt(truth / LONG)
    assert (np.abs(shares.mean(axis=0) - truth) < 4.5 * error + 0.002).all()


@pytest.mark.long
def test_auto_keeps_a_target_whatever_it_answers_by():
    """Parts that no fit has seen, against 3000 drops, whose noise is taken off.

    Three standard errors of 40 parts are 0.14. The square of the noise is a tenth of
    that of the narrower target, and known to a fifth of itself.
    """
    targets = (0.05, 0.02)
    drops = 3000
    hits = []
    for number in range(40):
        part = part_from_mesh(*random_polyhedron(5 + number % 9, 7000 + number))
        scene = {"restitution": (0.2, 0.5, 0.8)[number % 3], "cluster_tolerance": 0.0}
        true = by_index(simulate(part, drops, seed=number, **scene), "probability")
        noise = true * (1.0 - true) / drops
        away = [
            by_index(auto(part, target, seed=900 + number, **scene), "probability")
            - true
            for target in targets
        ]
        hits.append(np.mean(np.square(away) - noise, axis=1) <= np.square(targets))
    assert np.mean(hits, axis=0).min() >= 0.9 - 3.0 * math.sqrt(0.09 / 40)

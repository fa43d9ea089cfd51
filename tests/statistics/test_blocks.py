"""Variance from rotated blocks, on made-up outcomes whose true variance is known."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from ros_pose_stats.errors import RequestError
from ros_pose_stats.statistics.blocks import BLOCK, BlockSums

RUNS = 400


def summed(outcomes, poses):
    sums = BlockSums(poses)
    sums.add(outcomes)
    return sums


def stratified(rng, drops, strata, probability=(0.2, 0.3, 0.5)):
    """Outcomes of drops that fill `strata` equal parts of each block one after the other.

    Each block begins at a part of [0, 1) of its own; the outcome is the interval of the
    cumulative probabilities that the number falls into.
    """
    begin = rng.integers(0, strata, drops // BLOCK + 1).repeat(BLOCK)[:drops]
    place = ((np.arange(drops) + begin) % strata + rng.random(drops)) / strata
    return np.searchsorted(np.cumsum(probability)[:-1], place)


def true_factor(strata, probability=(0.2, 0.3, 0.5)):
    """Variance of `stratified` over that of independent drops, for whole blocks."""
    edges = np.cumsum((0.0, *probability))
    reach = np.clip(edges * strata - np.arange(strata)[:, None], 0.0, 1.0)
    inside = np.diff(reach, axis=1)
    p = np.asarray(probability)
    return (inside * (1.0 - inside)).sum() / strata / (p * (1.0 - p)).sum()


def by_definition(outcomes, poses):
    """Between-block variances, block by block in a loop."""
    blocks = [outcomes[i:i + BLOCK] for i in range(0, len(outcomes), BLOCK)]
    counts = np.array([[(block == k).sum() for k in range(poses)] for block in blocks])
    settled = counts.sum(axis=1)
    n = settled.sum()
    rest = counts - counts.sum(axis=0) / n * settled[:, None]
    return (rest ** 2).sum(axis=0) / n ** 2 / (1.0 - (settled ** 2).sum() / n ** 2)


@pytest.mark.parametrize("drops", [8 * BLOCK, 20 * BLOCK + 1, 20 * BLOCK + 48])
@pytest.mark.parametrize("strata", [1, 4, 16])
def test_the_estimate_is_right_on_the_whole(drops, strata):
    # The factor of a run has about 2 (blocks - 1) degrees of freedom; five standard errors
    # of the mean of 400 runs.
    rng = np.random.default_rng(2)
    found = [summed(stratified(rng, drops, strata), 3).factor() for _ in range(RUNS)]
    error = np.std(found) / np.sqrt(RUNS)
    assert np.mean(found) == pytest.approx(true_factor(strata), abs=5 * error + 0.003)
    assert error < 0.02


@pytest.mark.parametrize("strata", [1, 4, 16])
def test_the_variance_is_that_of_repeated_runs(strata):
    # 2000 runs: a variance is known to sqrt(2/2000) = 3.2 %; the mean of the estimates, of 15
    # degrees of freedom each, to 0.8 %. Five times their sum of squares.
    rng = np.random.default_rng(3)
    runs = [summed(stratified(rng, 16 * BLOCK, strata), 3) for _ in range(2000)]
    real = np.var([run.counts / run.settled for run in runs], axis=0, ddof=1)
    told = np.mean([run.block_variances() for run in runs], axis=0)
    np.testing.assert_allclose(told, real, rtol=0.17)


def test_unsettled_drops_and_an_open_block():
    # A third of the drops never settles: the ratio estimator still finds the truth, here that
    # of independent drops. Five standard errors of the mean.
    rng = np.random.default_rng(4)
    found = []
    for _ in range(RUNS):
        outcomes = rng.choice(3, 12 * BLOCK + 17, p=(0.2, 0.3, 0.5))
        outcomes[rng.random(len(outcomes)) < 1 / 3] = -1
        found.append(summed(outcomes, 3).factor())
    assert np.mean(found) == pytest.approx(1.0, abs=5 * np.std(found) / np.sqrt(RUNS))


@given(st.integers(0, 40 * BLOCK), st.integers(0, 2 ** 32 - 1), st.data())
def test_incremental_equals_batch(drops, seed, data):
    rng = np.random.default_rng(seed)
    outcomes = rng.integers(-1, 5, drops)
    cuts = sorted(data.draw(st.lists(st.integers(0, drops), max_size=12)))
    grown = BlockSums(5)
    for piece in np.split(outcomes, cuts):
        grown.add(piece)
    batch = summed(outcomes, 5)
    assert (grown.drops, grown.settled) == (drops, int((outcomes >= 0).sum()))
    assert grown.counts.tolist() == [int((outcomes == k).sum()) for k in range(5)]
    assert grown.factor() == batch.factor()
    assert grown.factors().tolist() == batch.factors().tolist()
    np.testing.assert_array_equal(grown.block_variances(), batch.block_variances())


@pytest.mark.parametrize("drops", [2 * BLOCK, 9 * BLOCK + 5, 30 * BLOCK + 63])
def test_the_sums_are_the_definition(drops):
    outcomes = np.random.default_rng(5).integers(-1, 4, drops)
    np.testing.assert_allclose(summed(outcomes, 4).block_variances(),
                               by_definition(outcomes, 4), rtol=1e-12)


def test_few_blocks_are_not_trusted():
    outcomes = np.arange(8 * BLOCK) % 2
    sums = summed(outcomes[:-1], 2)
    assert sums.factor() == 1.0
    assert sums.factors().tolist() == [1.0, 1.0]
    sums.add(outcomes[-1:])
    assert sums.factor() == 1.0 / BLOCK
    assert (sums.factors() < 1.0).all()


@pytest.mark.parametrize("outcomes", [
    np.zeros(0, int), np.full(20 * BLOCK, -1), np.zeros(20 * BLOCK, int),
    np.where(np.arange(20 * BLOCK) < 5, np.arange(20 * BLOCK) % 2, -1),
])
def test_nothing_to_learn_from(outcomes):
    sums = summed(outcomes, 2)
    assert sums.factor() == 1.0
    assert sums.factors().tolist() == [1.0, 1.0]


def test_a_rare_pose_is_judged_by_itself():
    # Pose 0 comes at random once in 200 drops; poses 1 and 2 alternate otherwise.
    rng = np.random.default_rng(6)
    outcomes = 1 + np.arange(100 * BLOCK) % 2
    outcomes[rng.random(len(outcomes)) < 0.005] = 0
    sums = summed(outcomes, 3)
    assert sums.factor() < 0.1
    # 99 degrees of freedom: known to 14 %; three times that.
    assert sums.factors()[0] == pytest.approx(1.0, abs=0.43)
    assert (sums.factors()[1:] < 0.15).all()


def test_many_poses_take_no_table_of_blocks_and_poses():
    outcomes = np.random.default_rng(7).integers(0, 20_000, 2000 * BLOCK)
    assert summed(outcomes, 20_000).factor() == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("outcomes", [[0, 3], [-2, 0]])
def test_refused(outcomes):
    with pytest.raises(RequestError, match="pose indices from -1 to 2"):
        summed(outcomes, 3)

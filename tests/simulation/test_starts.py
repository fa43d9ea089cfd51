"""Starting directions: the same in every slice, uniform, and even where they should be."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import chi2

from ros_pose_stats.errors import RequestError
from ros_pose_stats.records.scene import SAMPLINGS
from ros_pose_stats.simulation.starts import (
    lattice_starts,
    random_starts,
    starting_directions,
)
from ros_pose_stats.statistics.blocks import BLOCK, BlockSums
from ros_pose_stats.statistics.intervals import jeffreys_interval
from tests.statistics.simulations import checkpoints

BOTH = pytest.mark.parametrize("starts", [random_starts, lattice_starts])
SEEDS = st.integers(0, 2 ** 64 - 1)


def mean_square_discrepancies(points):
    """Cap discrepancies of every prefix (n,), over the mean of random directions.

    Over all caps, by Stolarsky's principle: 4 D² = 4/3 - the mean distance of two points;
    the mean of D² is 1/(3 n) for random ones.
    """
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    sums = np.cumsum(2.0 * np.tril(distances).sum(axis=1))
    n = np.arange(1, len(points) + 1)
    return 0.75 * n * (4.0 / 3.0 - sums / n ** 2)


@BOTH
@given(seed=SEEDS, first=st.integers(0, 3000), count=st.integers(0, 700))
def test_slices_agree(starts, seed, first, count):
    whole = starts(seed, 0, 3700)
    np.testing.assert_array_equal(starts(seed, first, count), whole[first:first + count])


@BOTH
@given(seed=SEEDS, first=st.integers(2 ** 40, 2 ** 50), cut=st.integers(0, 200))
def test_far_along(starts, seed, first, cut):
    parts = (starts(seed, first, cut), starts(seed, first + cut, 200 - cut))
    np.testing.assert_array_equal(np.concatenate(parts), starts(seed, first, 200))


@BOTH
def test_unit_vectors(starts):
    found = starts(1, 0, 10_000)
    assert found.shape == (10_000, 3)
    np.testing.assert_allclose(np.linalg.norm(found, axis=1), 1.0, rtol=0, atol=1e-15)


@BOTH
@pytest.mark.parametrize("other", [0, 2, 2 ** 32 + 1, 2 ** 63 + 1, 2 ** 64 - 1])
def test_other_seeds_other_drops(starts, other):
    ours, theirs = starts(1, 0, 640), starts(other, 0, 640)
    # No drop recurs elsewhere either: the closest of 640² random pairs are far apart.
    assert np.abs(ours @ theirs.T).max() < 1.0 - 1e-9


def test_the_samplings_have_nothing_in_common():
    assert np.abs(random_starts(1, 0, 640) @ lattice_starts(1, 0, 640).T).max() < 1.0 - 1e-9


@BOTH
def test_nothing_recurs_within_a_run(starts):
    found = starts(3, 0, 2000)
    assert (found @ found.T - 2.0 * np.eye(2000)).max() < 1.0 - 1e-9


RANDOM_7 = ((-0.43807788535891384, 0.47219091624007153, 0.7649336605090824),
            (-0.49129081916362266, 0.8703262796967014, 0.034139388905422674))
LATTICE_7 = ((0.5967212724322675, -0.7910253799912029, 0.13491690493258826),
             (-0.5144623063548511, 0.783164071787918, -0.3492600349318773))


def test_the_stream_stays_what_it_was():
    # Recorded jobs are made again from their seed: these are part of the contract.
    assert random_starts(7, 0, 2) == pytest.approx(np.array(RANDOM_7), abs=1e-15)
    assert lattice_starts(7, 64, 2) == pytest.approx(np.array(LATTICE_7), abs=1e-15)


@pytest.mark.parametrize("seed", [0, 1, 2 ** 64 - 1])
def test_random_cells_are_equally_full(seed):
    # 16 x 32 cells of equal area, 100 000 directions: within the central 99.9 % of chi-square.
    x, y, z = random_starts(seed, 0, 100_000).T
    rows = np.minimum((8.0 * (z + 1.0)).astype(int), 15)
    columns = np.minimum((16.0 * (np.arctan2(y, x) / np.pi + 1.0)).astype(int), 31)
    count = np.bincount(32 * rows + columns, minlength=512)
    expected = 100_000 / 512
    statistic = ((count - expected) ** 2 / expected).sum()
    assert chi2.ppf(0.0005, 511) < statistic < chi2.isf(0.0005, 511)


@BOTH
@pytest.mark.parametrize("seed", [0, 5])
def test_moments(starts, seed):
    # Of n random directions: variances 1/3 of x, 4/45 of x², 1/15 of x y. Five standard errors;
    # a lattice must be at least as good.
    n = 100_000
    found = starts(seed, 0, n)
    assert np.abs(found.mean(axis=0)).max() < 5 * np.sqrt(1 / 3 / n)
    second = found.T @ found / n - np.eye(3) / 3
    assert np.abs(np.diag(second)).max() < 5 * np.sqrt(4 / 45 / n)
    assert np.abs(np.triu(second, 1)).max() < 5 * np.sqrt(1 / 15 / n)


@BOTH
def test_successive_random_drops_are_independent(starts):
    # Products of drops 64 apart, in neighbouring blocks: mean 0, variance 1/3.
    found = starts(2, 0, 64_000)
    product = (found[:-BLOCK] * found[BLOCK:]).sum(axis=1)
    # The rotation is common to a block of the lattice: 1000 blocks are what counts there.
    count = 1000 if starts is lattice_starts else len(product)
    assert abs(product.mean()) < 5 * np.sqrt(1 / 3 / count)


@pytest.mark.parametrize("place", [0, 1, 17, 63])
def test_each_drop_of_a_block_is_uniform(place):
    # 3000 blocks, as in `test_moments`: rotated at random, a place of the pattern goes anywhere.
    found = lattice_starts(4, 0, 3000 * BLOCK)[place::BLOCK]
    assert np.abs(found.mean(axis=0)).max() < 5 * np.sqrt(1 / 3 / 3000)
    second = found.T @ found / 3000 - np.eye(3) / 3
    assert np.abs(second).max() < 5 * np.sqrt(4 / 45 / 3000)


def test_blocks_are_turned_uniformly():
    # The spin too: a fixed vector of the pattern's frame, seen along another.
    blocks = lattice_starts(4, 0, 3000 * BLOCK).reshape(-1, BLOCK, 3)
    pattern = blocks[0]
    turns = np.linalg.lstsq(pattern, blocks.transpose(1, 0, 2).reshape(BLOCK, -1), rcond=None)[0]
    turns = turns.reshape(3, 3000, 3).transpose(1, 2, 0)
    np.testing.assert_allclose(turns @ turns.transpose(0, 2, 1), np.eye(3) + np.zeros_like(turns),
                               atol=1e-13)
    assert np.linalg.det(turns) == pytest.approx(np.ones(3000))
    # Entries of a uniform rotation: mean 0, variance 1/3. The trace: mean 0, variance 1.
    assert np.abs(turns.mean(axis=0)).max() < 5 * np.sqrt(1 / 3 / 3000)
    assert abs(np.trace(turns, axis1=1, axis2=2).mean()) < 5 * np.sqrt(1 / 3000)


def test_every_beginning_of_a_block_is_even():
    # The pattern itself, whatever the rotation: what `lattice_starts` says of it.
    found = mean_square_discrepancies(lattice_starts(8, 0, BLOCK))
    assert found[9:].max() < 0.28
    assert found[-1] == pytest.approx(0.077, abs=0.001)


def test_the_order_is_the_best_one_step_ahead():
    points = lattice_starts(8, 0, BLOCK)
    distances = np.linalg.norm(points[:, None] - points[None], axis=2)
    for k in range(1, BLOCK):
        gain = distances[k:, :k].sum(axis=1)
        assert gain[0] > gain.max() - 1e-9


@pytest.mark.parametrize("seed", range(4))
def test_prefixes_are_more_even_than_random_ones(seed):
    # Random prefixes have 1 on average; a lattice scatters about 0.28 at most, seldom above
    # twice that.
    found = mean_square_discrepancies(lattice_starts(seed, 0, 1135))
    random = mean_square_discrepancies(random_starts(seed, 0, 1135))
    at = np.array([10, 16, 24, 36, 50, 64, *checkpoints(1135)]) - 1
    assert (found[at] < random[at]).all()
    assert found[9:].max() < 0.56


def test_long_prefixes_on_chosen_caps():
    # 300 caps up to 10 000 drops: the mean square error of their areas, over the binomial.
    rng = np.random.default_rng(9)
    centres, edges = random_starts(99, 0, 300), rng.uniform(-1.0, 1.0, 300)
    area = (1.0 - edges) / 2.0
    at = np.array(list(checkpoints(10_000)))
    ratio = {}
    for name in SAMPLINGS:
        inside = starting_directions(name, 11, 0, 10_000) @ centres.T > edges
        share = np.cumsum(inside, axis=0)[at - 1] / at[:, None]
        ratio[name] = at * ((share - area) ** 2).sum(axis=1) / (area * (1.0 - area)).sum()
    assert (ratio["lattice"] < ratio["random"]).all()
    assert ratio["lattice"].max() < 0.25


def test_blocks_tell_how_even_a_lattice_is():
    # Poses by the nearest of five directions. 16 blocks x 200 runs: the mean of the told factors
    # and the real variance are each known to some 10 %; four times that.
    centres = random_starts(123, 0, 5)
    shares, told = [], []
    for run in range(200):
        outcomes = (lattice_starts(run, 0, 16 * BLOCK) @ centres.T).argmax(axis=1)
        sums = BlockSums(5)
        sums.add(outcomes)
        shares.append(sums.counts / sums.settled)
        told.append(sums.factor())
    p = np.mean(shares, axis=0)
    real = np.var(shares, axis=0, ddof=1).sum() / (p * (1.0 - p) / (16 * BLOCK)).sum()
    assert np.mean(told) == pytest.approx(real, rel=0.4)
    assert real < 0.2


def test_intervals_of_a_lattice_cover_rare_poses_too():
    # A cap with 1 % of the sphere, one with 10 %, the rest. 300 runs: coverage of 0.9 is known
    # to 0.017; three times that below (above it is the price of mixing in the binomial).
    axis = random_starts(5, 0, 1)[0]
    truth, edges = np.array((0.01, 0.1, 0.89)), (0.98, 0.78)
    covered = np.zeros(3)
    for run in range(300):
        height = lattice_starts(run, 0, 1702) @ axis
        sums = BlockSums(3)
        sums.add((height <= edges[0]).astype(int) + (height <= edges[1]))
        factors = sums.factors()
        low, high = jeffreys_interval(sums.counts / factors, sums.settled / factors)
        covered += (low <= truth) & (truth <= high)
    assert (covered / 300 > 0.85).all()


def test_by_name():
    assert SAMPLINGS == ("random", "lattice")
    for name, starts in zip(SAMPLINGS, (random_starts, lattice_starts), strict=True):
        np.testing.assert_array_equal(starting_directions(name, 5, 30, 100), starts(5, 30, 100))
    with pytest.raises(RequestError, match="random, lattice"):
        starting_directions("sobol", 5, 0, 10)

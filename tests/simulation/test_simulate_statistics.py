"""Numbers that a run of drops reports: their formulas, and what they promise."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.stats import beta, binom

from ros_pose_stats import part_from_mesh, resting_poses, shapes, simulate
from ros_pose_stats.statistics.blocks import BLOCK

from ..bodies import random_polyhedron
from .dropping import counts, dropped

RESTITUTION = 0.3
LONG = 60_000


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*random_polyhedron(9, 3))


@pytest.fixture(scope="module")
def truth(part):
    """Probabilities by index from a long run: known to 0.002."""
    return np.array(counts(simulate(part, LONG, RESTITUTION, 1))) / LONG


def by_index(found, name):
    return np.array([getattr(p, name) for p in sorted(found.poses, key=lambda p: p.index)])


def unlucky():
    """A run of 200 drops, five of which start balanced on an edge of a cube and stay there."""
    starts = np.random.default_rng(1).standard_normal((200, 3))
    starts[::40] = (1.0, 1.0, 0.0)
    cube = part_from_mesh(*shapes.box(2.0, 2.0, 2.0))
    return simulate(cube, restitution=0.0, starts=starts)


@pytest.mark.parametrize("drops", [1, 10, 1000])
def test_the_formulas_of_the_contract(part, drops):
    for found in (simulate(part, drops, RESTITUTION, 2), unlucky()):
        count, settled = by_index(found, "count"), found.drops - found.unsettled
        assert count.sum() == settled
        assert by_index(found, "probability").tolist() == (count / settled).tolist()
        q = (count + 0.5) / (settled + 0.5 * len(count))
        errors = np.sqrt(q * (1.0 - q) / settled)
        assert by_index(found, "standard_error") == pytest.approx(errors, rel=1e-12)
        assert found.expected_error == pytest.approx(math.sqrt((errors**2).mean()), rel=1e-12)
        a, b = count + 0.5, settled - count + 0.5
        low = np.where(count == 0, 0.0, beta.ppf(0.05, a, b))
        high = np.where(count == settled, 1.0, beta.ppf(0.95, a, b))
        assert by_index(found, "probability_low") == pytest.approx(low, abs=1e-9)
        assert by_index(found, "probability_high") == pytest.approx(high, abs=1e-9)


def test_most_probable_first_and_all_poses(part):
    found = simulate(part, 50, RESTITUTION, 2)
    known = [(-pose.probability, pose.index) for pose in found.poses]
    assert known == sorted(known)
    assert {pose.index for pose in found.poses} == set(range(len(resting_poses(part).poses)))
    assert 0 in by_index(found, "count")
    assert (found.method, found.seed, found.restitution) == ("simulation", 2, RESTITUTION)


def test_unsettled_drops_are_never_hidden():
    found = unlucky()
    assert (found.drops, found.unsettled) == (200, 5)
    text, = (text for text in found.warnings if text.startswith("UNSETTLED: "))
    assert "5 of 200" in text


@pytest.mark.long
def test_a_lattice_takes_its_errors_from_its_blocks(part):
    """Whole blocks: the scatter of their counts, mean square over the poses."""
    drops = 40 * BLOCK
    found = simulate(part, drops, 0.0, 4, drop_height=0.01, sampling="lattice")
    binomial = simulate(part, drops, 0.0, 4, drop_height=0.01)
    assert found.expected_error < 0.7 * binomial.expected_error
    shares = [(np.array(counts(simulate(part, (b + 1) * BLOCK, 0.0, 4, drop_height=0.01,
                                        sampling="lattice")))) for b in range(40)]
    scatter = np.diff(shares, axis=0, prepend=np.zeros((1, len(shares[0]))))
    variance = scatter.var(axis=0, ddof=1).sum() / BLOCK**2 / 40
    p = shares[-1] / drops
    factor = variance / (p * (1.0 - p) / drops).sum()
    q = (shares[-1] + 0.5) / (drops + 0.5 * len(p))
    errors = np.sqrt(factor * q * (1.0 - q) / drops)
    assert by_index(found, "standard_error") == pytest.approx(errors, rel=1e-9)


def test_a_lattice_and_random_drops_agree(part, truth):
    """Five standard errors of 6400 drops, as if they were random."""
    found = simulate(part, 100 * BLOCK, RESTITUTION, 6, sampling="lattice")
    error = np.sqrt(truth * (1.0 - truth) / (100 * BLOCK)) + 1e-3
    assert (np.abs(by_index(found, "probability") - truth) < 5.0 * error).all()


@pytest.mark.parametrize("surface", [shapes.cylinder(32, 1.0, 1.0), shapes.box(1.0, 0.001, 0.002)])
def test_clustered_counts_add_over_the_members(surface):
    """The very same drops, each in the cluster that its face is a member of."""
    part = part_from_mesh(*surface)
    pose_of = {member: pose.index for pose in resting_poses(part, 0.005, round_sides=0).poses
               for member in pose.members}
    fine, coarse = (dropped(part, 0.1, 300, tolerance=t) for t in (0.0, 0.005))
    assert len(set(pose_of.values())) < len(pose_of)
    assert [pose_of[i] for i in fine.pose.tolist()] == coarse.pose.tolist()
    by_face = simulate(part, 300, 0.1, 1, cluster_tolerance=0.0, round_sides=0)
    gathered = simulate(part, 300, 0.1, 1, cluster_tolerance=0.005, round_sides=0)
    for pose in gathered.poses:
        assert pose.count == sum(counts(by_face)[i] for i in pose.members)
    assert any(text.startswith("CLUSTERED") for text in gathered.warnings)


@pytest.mark.long
@pytest.mark.parametrize("sampling", ["random", "lattice"])
def test_intervals_cover_as_they_promise(part, truth, sampling):
    """200 runs of 100 drops: how often a Jeffreys interval holds p is known for each p.

    Random drops: within the central 99.99 % of the binomial around the exact coverage. Lattice
    drops scatter less, so that only the lower limit is sure.
    """
    runs = [simulate(part, 100, RESTITUTION, 1000 + seed, sampling=sampling, workers=1)
            for seed in range(200)]
    low, high = (np.array([by_index(run, name) for run in runs])
                 for name in ("probability_low", "probability_high"))
    covered = ((low <= truth) & (truth <= high)).sum(axis=0)
    count = np.arange(101)
    ends = (np.where(count == 0, 0.0, beta.ppf(0.05, count + 0.5, 100.5 - count)),
            np.where(count == 100, 1.0, beta.ppf(0.95, count + 0.5, 100.5 - count)))
    for pose, p in enumerate(truth):
        promised = binom.pmf(count, 100, p)[(ends[0] <= p) & (p <= ends[1])].sum()
        least, most = binom.ppf((5e-5, 1.0 - 5e-5), 200, promised)
        assert covered[pose] >= least
        assert covered[pose] <= most or sampling == "lattice"


@pytest.mark.long
@pytest.mark.parametrize(("sampling", "target", "bound", "runs"), [
    ("random", 0.0429, 225, 250), ("lattice", 0.019, 1135, 100)])
def test_stopping_at_a_target_hardly_biases(part, truth, sampling, target, bound, runs):
    """The mean over runs that stop at one of two checkpoints is right within 0.002.

    And 4.5 of its standard errors. A look at the error favours prefixes that happen to look
    even; few looks, far apart, keep that small. A lattice's factor is known from 757 drops on.
    """
    found = [simulate(part, bound, RESTITUTION, 5000 + seed, target_error=target, workers=1,
                      sampling=sampling) for seed in range(runs)]
    short = np.mean([run.drops < bound for run in found])
    assert 0.1 < short < 0.9
    shares = np.array([by_index(run, "probability") for run in found])
    error = shares.std(axis=0, ddof=1) / math.sqrt(runs) + np.sqrt(truth / LONG)
    assert (np.abs(shares.mean(axis=0) - truth) < 4.5 * error + 0.002).all()

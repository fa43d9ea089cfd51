"""What a feeder gets by kicking wrong parts: the means of a Markov chain, and their intervals."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats import load_part, simulate
from tests.bodies import random_polyhedron, write_stl
from tests.running import answer_json

RATE, CYCLE, KICK = 40.0, 2.0, 0.004
WANTED = [0, 1]


@pytest.fixture(scope="module")
def part(tmp_path_factory):
    """A body some 2 cm large, of several poses and no symmetry."""
    vertices, triangles = random_polyhedron(8, 21)
    return write_stl(tmp_path_factory.mktemp("fed") / "part.stl", (0.01 * vertices, triangles))


def fed(part, flips, drops, seed, wanted=WANTED, kick=KICK):
    return answer_json("flips", part, "--kick", kick, "--flips", flips, "--drops", drops,
                       "--seed", seed, "--rate", RATE, "--cycle-time", CYCLE, "--wanted", *wanted)


def shares(part, drops, seed):
    """Of dropped parts, by pose."""
    found = simulate(load_part(part), drops, seed=seed)
    return np.array([pose.probability for pose in sorted(found.poses, key=lambda p: p.index)])


def test_the_means_are_those_of_the_chain(part):
    """(I - T)⁻¹ 1 flips out of each wrong pose, 60 / rate and a cycle a flip for each part."""
    found, fresh = fed(part, 2000, 10_000, 5), shares(part, 10_000, 5)
    wrong = [pose for pose in range(len(fresh)) if pose not in WANTED]
    moves = np.array(found["transition"])[np.ix_(wrong, wrong)]
    flips = fresh[wrong] @ np.linalg.solve(np.eye(len(wrong)) - moves, np.ones(len(wrong)))
    kicked, again = found["feeding"]["kicked"], found["feeding"]["dropped_again"]
    assert kicked["flips"]["value"] == pytest.approx(flips, rel=1e-9) and flips > 0.2
    assert kicked["per_minute"]["value"] == pytest.approx(60.0 / (60.0 / RATE + CYCLE * flips))
    assert kicked["accepted"]["value"] == kicked["passes"]["value"] == 1.0
    share = fresh[WANTED].sum()
    assert again["accepted"]["value"] == pytest.approx(share)
    assert again["passes"]["value"] == pytest.approx(1.0 / share)
    assert again["per_minute"]["value"] == pytest.approx(RATE * share)


@pytest.mark.long
def test_intervals_are_kept(part):
    """Nine in ten of 120 trials, but for three standard errors, and 0.01 for the first order."""
    truth = fed(part, 20_000, 60_000, 1)["feeding"]
    kept = []
    for seed in range(100, 220):
        found = fed(part, 100, 300, seed)["feeding"]
        kept.append([found[way]["per_minute"]["low"] <= truth[way]["per_minute"]["value"]
                     <= found[way]["per_minute"]["high"] for way in ("kicked", "dropped_again")])
    assert np.mean(kept, axis=0) == pytest.approx(0.9, abs=3.0 * math.sqrt(0.09 / 120) + 0.01)


def test_a_kick_that_frees_no_part_feeds_none(part):
    """Those that lie right at once are accepted; nobody knows a bound."""
    kicked = fed(part, 50, 400, 5, kick=0.0)["feeding"]["kicked"]
    assert kicked["flips"] == {"value": None, "low": None, "high": None}
    assert kicked["per_minute"]["value"] == 0.0
    assert kicked["accepted"]["value"] == pytest.approx(shares(part, 400, 5)[WANTED].sum())

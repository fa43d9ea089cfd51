"""The stability study: what it finds is there, and what is there it finds."""

from __future__ import annotations

import json
import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats

from ros_pose_stats import resting_poses
from ros_pose_stats.estimators import ESTIMATORS
from ros_pose_stats.study.stability import (
    StabilityResults,
    as_dict,
    stability_page,
    stability_text,
    write_stability,
)
from ros_pose_stats.study.stability.jumps import change, spread
from ros_pose_stats.study.stability.lessons import LESSONS
from ros_pose_stats.study.stability.walk import along, towards
from ros_pose_stats.study.stability.walk_runs import measured, reliability
from ros_pose_stats.study.stability.walks import walks
from tests.study.tables import shipped, some

WALKS = {walk.name: walk for walk in walks()}
JUMPING = ("area", "csae", "adre", "qse")
"""Estimators that jump where a face becomes unstable; EAE and MEAE do not."""


@pytest.fixture(scope="module")
def leaning():
    return measured(WALKS["marginal_face"], 300)


def curve(found, method):
    return next(one for one in found.curves if one.method == method)


class TestChange:
    @given(st.floats(0.05, 0.95), st.floats(0.01, 0.5), st.floats(0.0, 0.3))
    def test_a_jump_on_a_slope(self, at, size, slope):
        def probability(x):
            return slope * x + (size if x > at else 0.0)

        places = np.linspace(0.0, 1.0, 7)
        found = change(places, np.array([probability(x) for x in places]), probability, False)
        assert len(found.jumps) == 1
        assert found.jumps[0].place == pytest.approx(at, abs=1e-8)
        assert found.jumps[0].size == pytest.approx(size, abs=1e-8)
        assert found.slope == pytest.approx(slope, abs=1e-6)

    @given(st.floats(-3.0, 3.0), st.floats(1.0, 1e4))
    def test_a_steep_curve_is_no_jump(self, at, steepness):
        def probability(x):
            return 0.5 + 0.5 * math.tanh(steepness * (x - at))

        places = np.linspace(-4.0, 4.0, 9)
        found = change(places, np.array([probability(x) for x in places]), probability, False)
        assert found.jumps == ()

    def test_the_steepest_step(self):
        found = change(np.array((0.0, 1.0, 3.0)), np.array((0.0, 0.1, 0.5)), float, True)
        assert found.slope == pytest.approx(0.2) and found.slope_at == 1.0

    def test_whole_numbers_have_no_jumps(self):
        def never(_):
            raise AssertionError

        assert change(np.arange(3.0), np.array((0.0, 0.5, 0.0)), never, True).jumps == ()


def test_every_walk_has_its_lesson():
    assert LESSONS.keys() == WALKS.keys()


def test_spread():
    place, apart = spread([np.array((0.1, 0.2)), np.array((0.1, 0.5)), np.array((0.2, 0.4))])
    assert place == 1 and apart == pytest.approx(0.3)


def test_masks():
    downs = np.array([(0, 0, 1), (0, 0, -1), (1, 0, 0), (0.6, 0, 0.8)], dtype=float)
    assert along(2)(downs).tolist() == [True, True, False, False]
    assert towards((0, 0, 2.0), 0.7)(downs).tolist() == [True, False, False, True]


@pytest.mark.parametrize("walk", WALKS.values(), ids=WALKS)
class TestWalks:
    def test_values_rise_and_places_are_inverse(self, walk):
        assert (np.diff(walk.values) > 0.0).all() and len(walk.values) >= 12
        for value in walk.values[[0, -1]].tolist():
            assert walk.value(walk.place(value)) == pytest.approx(value, rel=1e-12)

    def test_something_is_watched_at_both_ends(self, walk):
        """But that the leaning prism's base is no pose any more at one of them."""
        seen = []
        for value in walk.values[[0, -1]].tolist():
            step = walk.make(value)
            poses = resting_poses(step.part, walk.tolerance(step), walk.round_sides).poses
            seen.append(bool(walk.watched(np.array([pose.down for pose in poses])).any()))
        assert any(seen)


class TestMarginalFace:
    def test_the_base_stops_being_stable_at_the_mark(self):
        walk = WALKS["marginal_face"]

        def bases(lean):
            poses = resting_poses(walk.make(lean).part, 0.0).poses
            return int(walk.watched(np.array([pose.down for pose in poses])).sum())

        assert bases(1.0 - 1e-6) == 2 and bases(1.0 + 1e-6) == 0

    @pytest.mark.parametrize("method", JUMPING)
    def test_older_estimators_jump_there(self, leaning, method):
        (jump,) = curve(leaning, method).change.jumps
        assert jump.place == pytest.approx(1.0, abs=1e-7) and jump.size < -0.02

    @pytest.mark.parametrize("method", ["eae", "meae"])
    def test_those_on_the_splitting_graph_do_not(self, leaning, method):
        assert curve(leaning, method).change.jumps == ()
        assert curve(leaning, method).values[-1] == 0.0


class TestLimits:
    def test_plate_and_needle(self):
        found = measured(WALKS["needle"], 50, 24)
        for one in found.curves:
            # Where length/width is a: the square faces' share is near 1 - O(a), and O(1/a).
            assert one.values[0] > 0.97 and one.values[-1] < 0.01
        np.testing.assert_array_equal(found.simulated.values, (1.0, 0.0))

    def test_an_unbroken_cube(self):
        found = measured(WALKS["broken_symmetry"], 600, 22)
        for one in found.curves:
            assert one.values[0] == pytest.approx(1.0 / 6.0, abs=1e-7)
        # 600 drops: 0.015 standard error
        assert found.simulated.values[0] == pytest.approx(1.0 / 6.0, abs=0.06)

    def test_the_scene_changes_the_simulation_and_what_knows_it(self):
        found = measured(WALKS["restitution"], 1500, 18)
        for one in found.curves:
            assert (np.ptp(one.values) == 0.0) == (one.method != "split")
        assert found.simulated.low[0] > found.simulated.high[-1] or \
            found.simulated.low[-1] > found.simulated.high[0]


class TestParts:
    """What users have: turned, toothed and drilled parts, and the nudge that makes poses."""

    def test_from_fifteen_sides_on_a_cylinder_is_round_however_the_file_cuts_it(self):
        """CSAE: the two discs span 4 pi (1 - cos 45 degrees) of a cylinder as high as wide."""
        walk = WALKS["cylinder_sides"]
        round_ones = walk.values >= walk.mark
        found = measured(walk, 400)
        assert round_ones.sum() >= 10
        assert set(found.poses[round_ones]) == {3}
        for one in found.curves:
            assert np.ptp(one.values[round_ones]) < 0.005, one.method
        csae = curve(found, "csae").values[round_ones]
        assert csae == pytest.approx(np.full(round_ones.sum(), 1.0 - math.sqrt(0.5)), abs=2e-3)
        drops = found.simulated.values[round_ones]
        expected = drops.mean() * (1.0 - drops.mean()) / 400
        chi = ((drops - drops.mean()) ** 2).sum() / expected
        assert chi < stats.chi2.ppf(0.9999, round_ones.sum() - 1)

    def test_teeth_become_one_rim(self):
        walk = WALKS["gear_teeth"]
        many = walk.values >= walk.mark
        poses = [len(resting_poses(walk.make(teeth).part).poses) for teeth in walk.values.tolist()]
        assert np.all(np.array(poses)[many] == 3)
        assert min(np.array(poses)[~many]) > 3

    def test_a_blind_hole_makes_the_closed_end_heavier(self):
        """The centre of mass in closed form: a block less a prism of 64 sides, millimetres."""
        walk = WALKS["hole_size"]
        block, depth = 20.0 * 20.0 * 22.0, 0.9 * 22.0
        for diameter in (0.0, 0.5, 0.96):
            hole = 32.0 * math.sin(2.0 * math.pi / 64.0) * (10.0 * diameter) ** 2 * depth
            height = (block * 11.0 - hole * (22.0 - depth / 2.0)) / (block - hole)
            part = walk.make(diameter).part
            assert part.center_of_mass[2] * 1e3 == pytest.approx(height, abs=1e-4)
        found = measured(walk, 2000, 16)
        for one in found.curves:
            if one.method != "area":  # of the hull, which stays
                assert one.values[1] > one.values[0] + 0.01, one.method
        assert found.simulated.low[1] > found.simulated.high[0]

    def test_a_larger_nudge_lists_fewer_poses_and_pours_the_shallow_ones_into_others(self):
        found = measured(WALKS["nudge"], 20, 4)
        assert found.poses[0] == 20 and found.poses[-1] == 2
        assert np.all(np.diff(found.poses) <= 0)
        for method in ("area", "csae", "adre", "qse"):
            assert np.all(np.diff(curve(found, method).values) >= -1e-12), method


@pytest.fixture(scope="module")
def whole(leaning):
    return StabilityResults((leaning,), reliability([some(100)]))


class TestReliability:
    @pytest.mark.long
    def test_larger_expected_errors_mean_larger_true_ones(self):
        """From the lowest to the highest bin; and each within a third, or three errors."""
        for bins in reliability([shipped()]).values():
            assert sum(one.parts for one in bins) == 3 * 1057
            assert all(a.expected <= b.expected for a, b in pairwise(bins))
            assert bins[-1].true > 1.3 * bins[0].true
            for one in bins:
                assert abs(one.true - one.expected) < one.expected / 3.0 + 3.0 * one.error

    def test_it_speaks_of_every_method_and_the_simulation(self, whole):
        assert whole.reliability.keys() == {*ESTIMATORS, "simulation, n = 100"}


@pytest.mark.long
class TestDocuments:
    def test_text_and_page(self, whole):
        text, page = stability_text(whole), stability_page(whole)
        for entry in ESTIMATORS.values():
            assert f"| {entry.title} " in text
        assert "(../figures/stability_marginal_face.png)" in page and text.split("\n\n")[2] in page
        csae = next(line for line in text.splitlines() if line.startswith("| CSAE"))
        assert csae.split("|")[2].strip() == "1"

    def test_files(self, whole, tmp_path):
        files = write_stability(whole, tmp_path)
        assert {file.name for file in files} == {
            "stability_marginal_face.png", "stability_marginal_face.svg", "stability.json",
            "stability_reliability.png", "stability_reliability.svg", "stability.md"}
        assert tmp_path / "study" / "stability.md" in files
        stored = json.loads((tmp_path / "benchmarks/stability.json").read_text())
        assert stored == as_dict(whole)
        assert len(stored["walks"][0]["methods"]) == len(ESTIMATORS)

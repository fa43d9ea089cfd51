"""Fits of plates, small ones: what they find, what they promise, and what they refuse."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats import PoseStatsError, part_from_mesh, shapes, simulate
from ros_pose_stats.plates import count_part, fit, fit_plate
from ros_pose_stats.plates.evidence import ExplainedPart, conclude
from ros_pose_stats.plates.fit import refuse_undecided
from ros_pose_stats.plates.likelihood import scene_likelihood
from ros_pose_stats.plates.response import Shares
from ros_pose_stats.plates.scenes import SceneGrid, SceneRange
from ros_pose_stats.study.plates.runs import cover

SIZES = ((0.02, 0.03, 0.012), (0.01, 0.01, 0.0075), (0.016, 0.022, 0.02))


def boxes():
    return [part_from_mesh(*shapes.box(*size)) for size in SIZES]


def dropped(part, restitution, height, drops=400, seed=11):
    found = simulate(part, drops, restitution, seed, height)
    return count_part(part, {pose.index: pose.count for pose in found.poses})


@pytest.fixture
def coarse(monkeypatch):
    """Fewer scenes and drops than usual."""
    for name, value in (("FIRST_POINTS", 48), ("FIRST_DROPS", 60), ("ROUNDS", 1), ("POINTS", 16),
                        ("GRID", 20), ("FINER", 10)):
        monkeypatch.setattr(fit, name, value)


@pytest.fixture(scope="module")
def counted():
    return [dropped(part, 0.3, 0.05) for part in boxes()]


class TestFit:
    def test_a_simulated_plate(self, coarse, counted):
        shares = []
        found = fit_plate(counted, seed=5, on_progress=shares.append)
        for value, (best, low, high) in ((0.3, found.restitution), (0.05, found.drop_height)):
            assert low <= best <= high and low <= value <= high
        assert found.p_value > 0.01 and 0.0 < found.plate_error < 0.08
        assert found.counted == 1200 and found.drops == 3 * (48 * 60 + 16 * 150)
        assert shares == sorted(shares) and shares[-1] == 1.0
        for one, part in zip(counted, found.parts, strict=True):
            assert sorted(k for poses in part.poses for k in poses) == list(range(6))
            assert part.observed == pytest.approx(one.by_group / 400)
            assert part.expected.sum() == pytest.approx(1.0)
            assert part.alone.restitution[1] <= part.alone.restitution[2]

    def test_the_same_seed_gives_the_same_fit(self, coarse, counted):
        first, second = (fit_plate(counted[:2], seed=5, workers=k) for k in (1, 2))
        assert first.restitution == second.restitution
        assert first.drop_height == second.drop_height

    def test_a_plate_unlike_the_model(self, coarse, counted):
        """A fifth of the parts is moved from the most frequent pose to the rarest."""
        moved = []
        for one in counted:
            count = one.count.copy()
            count[count.argmin()] += 80
            count[count.argmax()] -= 80
            moved.append(count_part(one.part, dict(enumerate(count.tolist()))))
        found, good = fit_plate(moved, seed=5), fit_plate(counted, seed=5)
        assert found.p_value < 0.01 < good.p_value
        assert found.plate_error > 0.03

    def test_it_can_be_stopped(self, counted):
        assert fit_plate(counted, should_stop=lambda: True) is None


class TestRefusals:
    def refused(self, counted):
        with pytest.raises(PoseStatsError) as refusal:
            fit_plate(counted)
        return str(refusal.value)

    def test_too_few_kinds_of_poses(self):
        cube, die = (part_from_mesh(*shapes.box(0.01, 0.01, z), part_id=name)
                     for name, z in (("cube", 0.01), ("die", 0.012)))
        assert "0 numbers from 0 parts" in self.refused([])
        message = self.refused([count_part(cube, {0: 500}), count_part(die, {0: 90})])
        assert "1 number from 1 part (cube can lie in one way only" in message
        assert "count another part" in message

    def test_too_few_counts(self):
        part = boxes()[0]
        assert "got 49; count 1 more" in self.refused([count_part(part, {0: 49})])

    def test_counts_that_leave_everything_open(self):
        grid = SceneGrid.over(SceneRange.of_radii([0.02]).bounds, 8)
        counted = dropped(boxes()[0], 0.3, 0.05, drops=60)
        share = counted.by_group / counted.counted
        shares = Shares(np.tile(share, (64, 1)), np.zeros(64))
        one = ExplainedPart(counted, shares, scene_likelihood(share * 60.0, shares))
        with pytest.raises(PoseStatsError, match="60 of 1 part that fit all of them alike"):
            refuse_undecided(grid, SceneRange.of_radii([0.02]), {192: [one]})


class TestPlateError:
    """Parts whose shares are the same in every scene, so that nothing is fitted."""

    @staticmethod
    def concluded(off, parts=3, counted=40_000):
        grid = SceneGrid.over(SceneRange.of_radii([0.02]).bounds, 4)
        explained = []
        for number, part in enumerate(boxes()[:1] * parts):
            away = off * (-1.0) ** number
            known = np.array([0.5, 0.3, 0.2])
            unknown = count_part(part, {})
            group = unknown.resting.group
            met = {int(np.flatnonzero(group == k)[0]): round(counted * (known[k] + away * turn))
                   for k, turn in enumerate((1.0, -1.0, 0.0))}
            shares = Shares(np.tile(known, (16, 1)), np.zeros(16))
            one = count_part(part, met)
            explained.append(ExplainedPart(one, shares, scene_likelihood(
                one.by_group.astype(float), shares)))
        return conclude(grid, {192: explained})

    def test_it_is_what_the_parts_left_out_err_by(self):
        found = self.concluded(0.06, parts=4)
        # Over three groups, of which one has no error; the root of four squares is biased.
        assert found.plate_error == pytest.approx(
            0.06 * math.sqrt(2.0 / 3.0) * math.sqrt(4.0 / 3.5), rel=0.01)
        assert found.p_value < 1e-6

    def test_three_parts_that_agree_may_promise_less_than_two_points(self):
        assert 0.0 < self.concluded(0.0).plate_error < 0.005
        assert self.concluded(0.0, parts=2).plate_error == 0.02

    def test_counts_too_few_to_show_an_error_promise_little(self):
        few, many = (self.concluded(0.0, counted=n).plate_error for n in (400, 40_000))
        assert few == pytest.approx(10.0 * many, rel=0.01)

    def test_one_part_that_the_fit_uses_up_tests_nothing(self):
        found = self.concluded(0.0, parts=1)
        assert found.plate_error == 0.05 and math.isnan(found.p_value)
        assert math.isnan(found.parts[0].left_out_error)


@pytest.mark.long
def test_intervals_of_simulated_plates():
    """Of 24 intervals of 90 %, fewer than 15 hold in one case of ten thousand."""
    found = cover(12, seed=2)
    assert found.restitution + found.drop_height >= 15

"""The reference datasets: what they hold, and that this program still makes them."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats.errors import DatasetError
from ros_pose_stats.study.dataset import make_chunk, shipped_datasets
from ros_pose_stats.study.dataset.dataset import SHIPPED, shipped_dataset, shipped_file
from tests.study.tables import shipped

SPREAD = (0, 528, 1056)
"""Bodies that are made anew."""


def span(lengths, body):
    """Rows of a body in an array of all bodies'."""
    end = int(lengths[:body + 1].sum(dtype=np.int64))
    return slice(end - int(lengths[body]), end)


class TestTheFiles:
    def test_together_they_are_small(self):
        assert len(SHIPPED) == 4
        assert sum(shipped_file(*one).stat().st_size for one in SHIPPED) < 5_000_000

    @pytest.mark.parametrize(("shift", "moment"), SHIPPED)
    def test_specification(self, shift, moment):
        spec = shipped(shift, moment).spec
        assert (spec.bodies, spec.drops, spec.restitutions) == (1057, 1000, (0.2, 0.5, 0.8))
        assert (spec.shift, spec.shift_moment, spec.seed, spec.drop_height) == (
            shift, moment, 1, 20.0)

    @pytest.mark.parametrize(("shift", "moment"), SHIPPED)
    def test_counts(self, shift, moment):
        dataset = shipped(shift, moment)
        settled = dataset.arrays["settled"].sum(axis=2)
        assert settled.shape == (1057, 3)
        assert settled.max() == 1000
        assert settled.min() >= 990  # an unstable equilibrium may hold a drop up
        for restitution in dataset.spec.restitutions:
            simulated = dataset.simulated(restitution)
            sums = np.bincount(simulated.body, simulated.probability)
            assert sums == pytest.approx(np.ones(1057), abs=1e-12)

    @pytest.mark.parametrize(("shift", "moment"), SHIPPED)
    def test_restitutions_differ(self, shift, moment):
        """Equal starts would show as equal counts of many poses."""
        dataset = shipped(shift, moment)
        one, other = (dataset.simulated(each).count for each in (0.2, 0.8))
        sure = (one == 0) | (one == 1000)
        assert np.mean((one == other)[~sure]) < 0.06

    def test_all_of_them_by_rising_shift(self):
        specs = [dataset.spec for dataset in shipped_datasets()]
        assert [(spec.shift, spec.shift_moment) for spec in specs] == list(SHIPPED)

    @pytest.mark.parametrize(("shift", "moment"), [(0.5, "inertia"), (0.65, "inertia"),
                                                   (0.0, "second"), (float("nan"), "inertia")])
    def test_any_other_is_refused(self, shift, moment):
        with pytest.raises(DatasetError, match=r"0.65 \(second\).*ros_pose_stats dataset"):
            shipped_dataset(shift, moment)


class TestMadeAnew:
    @pytest.mark.parametrize(("shift", "moment"), SHIPPED)
    def test_bodies_and_counts(self, shift, moment):
        """Everything exactly, on any machine."""
        dataset = shipped(shift, moment)
        there = dataset.arrays
        for body in SPREAD:
            made = make_chunk(dataset.spec, body, 1)
            poses = span(there["poses"], body)
            assert np.array_equal(made["count"], there["count"][poses]), body
            assert np.array_equal(made["settled"][0], there["settled"][body])
            assert made["redraws"][0] == there["redraws"][body]
            assert np.array_equal(made["triangle"],
                                  there["triangle"][span(there["triangles"], body)])
            for name, rows in (("vertex", span(there["vertices"], body)), ("down", poses),
                               ("height", poses), ("center_of_mass", slice(body, body + 1))):
                assert np.array_equal(made[name], there[name][rows]), (name, body)

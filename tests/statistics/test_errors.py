"""Standard errors as the contract defines them."""

from __future__ import annotations

import math

import numpy as np
import pytest

from ros_pose_stats.errors import RequestError
from ros_pose_stats.statistics.errors import expected_error, standard_errors


def test_by_hand():
    # q = 30.5/101 and 70.5/101.
    q = 30.5 / 101.0
    expected = math.sqrt(q * (1.0 - q) / 100.0)
    assert standard_errors([30, 70], 100) == pytest.approx([expected, expected])


def test_never_seen_is_not_certain():
    errors = standard_errors([0, 1000], 1000)
    assert (errors > 0.0).all()
    assert errors[0] == pytest.approx(errors[1])


def test_a_single_pose_is_certain():
    assert standard_errors([57], 57).tolist() == [0.0]
    assert expected_error(standard_errors([57], 57)) == 0.0


@pytest.mark.parametrize("counts", [[0], [0, 0, 0]])
def test_nothing_settled(counts):
    errors = standard_errors(counts, 0)
    assert errors.shape == (len(counts),)
    assert np.isnan(errors).all()
    assert math.isnan(expected_error(errors))


def test_expected_error_is_the_root_mean_square():
    assert expected_error([0.03, 0.04]) == pytest.approx(math.sqrt(0.00125))
    assert math.isnan(expected_error([]))


@pytest.mark.parametrize("total", [200, 5000])
def test_right_on_the_whole(total):
    # 4000 runs of known probabilities: the mean square error is known to sqrt(2/4000) = 2.2 %
    # a pose at most; five times that.
    truth = np.array((0.5, 0.3, 0.15, 0.05))
    counts = np.random.default_rng(1).multinomial(total, truth, size=4000)
    real = math.sqrt(np.mean((counts / total - truth) ** 2))
    told = math.sqrt(np.mean([expected_error(standard_errors(one, total)) ** 2
                              for one in counts]))
    assert told == pytest.approx(real, rel=0.06)


@pytest.mark.parametrize("counts", [[5, 6], [-1, 3], [math.nan, 1]])
def test_refused(counts):
    with pytest.raises(RequestError, match="settled"):
        standard_errors(counts, 5)

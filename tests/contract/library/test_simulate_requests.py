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

"""What a simulation may be asked for: seeds, given starts, and refusals in one line."""

import threading
from fractions import Fraction

import numpy as np
import pytest

from lab.bodies.samples import random_polyhedron
from ros_pose_stats import part_from_mesh, record_drop, resting_poses, simulate
from tests.answers import counts
from tests.running import refusal_of

NAN = float("nan")
INF = float("inf")


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*random_polyhedron(9, 3))


@pytest.mark.parametrize(
    ("name", "values"),
    [
        ("drops", [0, -1, 1.5, 10.0, True, "10", 10**9 + 1, NAN]),
        ("restitution", [1, 1.0, -0.1, NAN, INF, None, True, "hard", 1j]),
        ("seed", [-1, 2**64, 1.0, True, "1"]),
        ("workers", [0, -1, 1.0, True, 100_000]),
        ("target_error", [1, -0.1, NAN, INF, True, "small", None]),
        ("drop_height", [0, 0.0, -1, NAN, INF, True, "high", 10**400]),
        ("cluster_tolerance", [1, -0.1, NAN, True, None]),
    ],
)
def test_bad_values_are_refused(part, name, values):
    for value in values:
        refusal_of(simulate, part, **{"drops": 5, name: value})


@pytest.mark.parametrize("value", [0, 2**64 - 1, np.int64(5), np.uint64(2**63)])
def test_any_whole_seed_serves(part, value):
    statistics = simulate(
        part, np.int32(20), np.float32(0.5), value, drop_height=Fraction(1, 4)
    )
    assert statistics.seed == int(value)
    assert (
        statistics.scene
        == "released 250 mm above a frictionless plate, restitution 0.5"
    )


@pytest.mark.parametrize(
    "options",
    [
        {"interval": 1e-13},
        {"interval": 1e-320},
        {"interval": 1j},
        {"start": [[1], [2, 3]]},
        {"start": np.eye(3)},
        {"drop": 2**300},
        {"drop": -1},
        {"drop_height": 1e100},
    ],
)
def test_no_such_drop_is_recorded(part, options):
    refusal_of(record_drop, part, **options)


def test_workers_that_cannot_all_be_started_do_not_go_on(part, monkeypatch):
    begin = threading.Thread.start

    def start(thread):
        if thread.name == "drops-2":
            raise RuntimeError("can't start new thread")
        begin(thread)

    monkeypatch.setattr(threading.Thread, "start", start)
    with pytest.raises(RuntimeError, match="new thread"):
        simulate(part, 10**9, workers=3)
    assert not [
        thread for thread in threading.enumerate() if thread.name.startswith("drops-")
    ]


def test_a_fresh_seed_can_be_used_again(part):
    statistics = simulate(part, 500)
    second = simulate(part, 500)
    assert statistics.seed != second.seed
    assert counts(simulate(part, 500, seed=statistics.seed)) == counts(statistics)


def test_given_starts_are_what_is_dropped(part):
    """In order; as many as there are, or the first few of them; of any length."""
    starts = np.array(
        [record_drop(part, drop, seed=5, interval=1e6).down for drop in range(100)]
    )
    usual = counts(simulate(part, 100, 0.4, 5))
    assert counts(simulate(part, restitution=0.4, starts=starts.tolist())) == usual
    assert counts(simulate(part, restitution=0.4, starts=starts, workers=3)) == usual
    statistics = simulate(part, 40, 0.4, starts=starts)
    assert counts(statistics) == counts(simulate(part, 40, 0.4, 5))
    longer = simulate(part, restitution=0.4, starts=starts * np.arange(1, 101)[:, None])
    assert longer.drops == 100
    # Rounding of the length may turn a chaotic drop over.
    assert np.abs(np.subtract(counts(longer), usual)).sum() <= 10


def test_starts_point_down(part):
    """Set down at rest, the lowest pose stays where it is."""
    pose = resting_poses(part).poses[0]
    assert counts(simulate(part, starts=[pose.down] * 5, drop_height=0.001))[0] == 5


@pytest.mark.parametrize(
    "starts",
    [
        [1.0, 2.0, 3.0],
        np.zeros((0, 3)),
        np.ones((2, 2)),
        5.0,
        {},
        "abc",
        [[0.0, 0.0, 0.0]],
        [[0.0, 0.0, 1.0], [NAN, 0.0, 1.0]],
        [[INF, 0.0, 0.0]],
        [[None, 1, 2]],
        [["a", "b", "c"]],
        [[1, 2, 3], [1, 2]],
        np.array([[1j, 0.0, 0.0]]),
        [["0", "0", "1"]],
        [[True, False, False]],
    ],
)
def test_bad_starts_are_refused(part, starts):
    refusal_of(simulate, part, starts=starts)


def test_the_row_of_a_bad_start_is_named_and_what_goes_with_none_is_refused(part):
    starts = np.tile((0.0, 0.0, 1.0), (20, 1))
    starts[17] = 0.0
    assert "row 17" in refusal_of(simulate, part, starts=starts)
    assert "(3)" in refusal_of(simulate, part, 4, starts=np.eye(3))
    refusal_of(simulate, part, seed=-1, starts=np.eye(3))


@pytest.mark.parametrize("length", [1e-200, 1e200])
def test_a_start_of_any_finite_length_is_a_direction(part, length):
    """Squares under- and overflow there."""
    trajectory = record_drop(part, start=length * np.array((0.6, 0.0, 0.8)))
    assert trajectory.down == pytest.approx((0.6, 0.0, 0.8), abs=1e-15)

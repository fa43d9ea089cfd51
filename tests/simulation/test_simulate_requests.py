"""What a simulation may be asked for: given starts, and refusals in one line."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, record_drop, resting_poses, shapes, simulate
from ros_pose_stats.errors import RequestError
from ros_pose_stats.simulation.starts import random_starts

from ..bodies import random_polyhedron
from .dropping import counts

NAN, INF = float("nan"), float("inf")


@pytest.fixture(scope="module")
def part():
    return part_from_mesh(*random_polyhedron(9, 3))


def refused(call):
    """The one line of a refusal."""
    with pytest.raises(RequestError) as caught:
        call()
    text = str(caught.value)
    assert text.startswith("expected ") and ", got " in text and "; " in text
    assert "\n" not in text
    return text


@pytest.mark.parametrize(("name", "values"), [
    ("drops", [0, -1, 1.5, 10.0, True, "10", 10**9 + 1, NAN]),
    ("restitution", [1, 1.0, -0.1, NAN, INF, None, True, "hard", 1j]),
    ("seed", [-1, 2**64, 1.0, True, "1"]),
    ("workers", [0, -1, 1.0, True, 100_000]),
    ("sampling", ["x", None, "Random", 0]),
    ("target_error", [1, -0.1, NAN, INF, True, "small", None]),
    ("drop_height", [0, 0.0, -1, NAN, INF, True, "high"]),
    ("cluster_tolerance", [1, -0.1, NAN, True, None]),
])
def test_bad_values_are_refused(part, name, values):
    for value in values:
        refused(lambda value=value: simulate(part, **{"drops": 5, name: value}))


@pytest.mark.parametrize("value", [0, 2**64 - 1, np.int64(5), np.uint64(2**63)])
def test_any_whole_seed_serves(part, value):
    assert simulate(part, np.int32(20), np.float32(0.5), value).seed == int(value)


def test_what_is_no_part_is_refused():
    assert "a Part" in refused(lambda: simulate("clamp.stl"))


def test_a_fresh_seed_can_be_used_again(part):
    found, other = simulate(part, 500), simulate(part, 500)
    assert found.seed != other.seed
    assert counts(simulate(part, 500, seed=found.seed)) == counts(found)


def test_given_starts_are_what_is_dropped(part):
    """Any length, in order; as many as there are, or the first few of them."""
    starts = random_starts(5, 0, 300)
    usual = simulate(part, 300, 0.4, 5)
    given = simulate(part, restitution=0.4, starts=starts * np.arange(1, 301)[:, None])
    assert given.drops == 300
    # Rounding of the length may turn a chaotic drop over.
    assert np.abs(np.subtract(counts(given), counts(usual))).sum() <= 20
    exact = simulate(part, restitution=0.4, starts=starts.tolist())
    few = simulate(part, 40, 0.4, starts=starts)
    assert counts(few) == counts(simulate(part, restitution=0.4, starts=starts[:40]))
    assert counts(exact) == counts(simulate(part, restitution=0.4, starts=starts, workers=3))


def test_starts_point_down(part):
    """Set down at rest, the lowest pose stays where it is."""
    pose = resting_poses(part).poses[0]
    found = simulate(part, starts=np.tile(pose.down, (5, 1)), drop_height=0.001)
    assert counts(found)[0] == 5


@pytest.mark.parametrize("starts", [
    [1.0, 2.0, 3.0], np.zeros((0, 3)), np.ones((2, 2)), np.ones((1, 3, 1)), 5.0, {}, "abc",
    [[0.0, 0.0, 0.0]], [[0.0, 0.0, 1.0], [NAN, 0.0, 1.0]], [[INF, 0.0, 0.0]], [[None, 1, 2]],
    [["a", "b", "c"]],
])
def test_bad_starts_are_refused(part, starts):
    refused(lambda: simulate(part, starts=starts))


def test_the_row_of_a_bad_start_is_named(part):
    starts = np.tile((0.0, 0.0, 1.0), (20, 1))
    starts[17] = 0.0
    assert "row 17" in refused(lambda: simulate(part, starts=starts))


@pytest.mark.parametrize("starts", [[[1, 2, 3], [1, 2]], np.array([[1j, 0.0, 0.0]])])
def test_ragged_and_complex_starts_are_refused_in_one_line_too(part, starts):
    refused(lambda: simulate(part, starts=starts))


def test_more_drops_than_starts_are_refused(part):
    assert "(3)" in refused(lambda: simulate(part, 4, starts=np.eye(3)))


@pytest.mark.parametrize("length", [1e-160, 1e-200, 1e160, 1e200])
def test_starts_of_any_finite_length_are_directions(part, length):
    """Squares under- and overflow there."""
    found = record_drop(part, start=length * np.array((0.6, 0.0, 0.8)))
    assert found.down == pytest.approx((0.6, 0.0, 0.8), abs=1e-15)


def test_a_recorded_drop_has_one_start(part):
    refused(lambda: record_drop(part, start=np.eye(3)))


def test_refused_before_anything_is_done(part):
    """Also where starts make the seed superfluous."""
    refused(lambda: simulate(part, seed=-1, starts=np.eye(3)))


@pytest.mark.parametrize("options", [{"drop": -1}, {"drop": 1.5}, {"drop": True},
                                     {"interval": 0.0}, {"interval": NAN}, {"interval": "x"},
                                     {"start": (0.0, 0.0)}, {"seed": -1}, {"sampling": "x"}])
def test_bad_recordings_are_refused(options):
    refused(lambda: record_drop(part_from_mesh(*shapes.octahedron()), **options))

"""The error that an estimate says is to be expected of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from benchmarks.fit_expected_errors import MODULE, fitted, samples, source
from ros_pose_stats import estimate, estimate_all, part_from_mesh, resting_poses
from ros_pose_stats.estimators.error_weights import ERROR_AT, ERROR_WEIGHTS, USUAL_ERRORS
from ros_pose_stats.estimators.expected import error_terms, expected_error
from ros_pose_stats.estimators.registry import ESTIMATORS
from ros_pose_stats.geometry.shapes import box, dodecahedron, tetrahedron
from ros_pose_stats.geometry.shapes.random_polyhedra import random_polyhedron
from ros_pose_stats.records import DropScene


def told(part, method, restitution=0.5):
    resting = resting_poses(part, 0.0)
    probability = ESTIMATORS[method].function(resting, DropScene(restitution))
    return expected_error(method, resting, probability, restitution)


@pytest.fixture(scope="module")
def polyhedron():
    return random_polyhedron(5, 2, 0.25).part()


@pytest.fixture(scope="module")
def fits():
    return samples()


def test_every_method_has_one_and_every_answer_carries_it(polyhedron):
    assert ERROR_WEIGHTS.keys() == USUAL_ERRORS.keys() == ESTIMATORS.keys()
    for found in estimate_all(polyhedron, restitution=0.3, cluster_tolerance=0.0):
        assert found.expected_error == told(polyhedron, found.method, 0.3).here
        assert 0.0 < found.expected_error < 1.0


@pytest.mark.parametrize("surface", [box(1, 1, 1), tetrahedron(), dodecahedron()],
                         ids=["cube", "tetrahedron", "dodecahedron"])
def test_symmetry_makes_no_errors(surface):
    """All poses are equal by symmetry, and every method says so."""
    for method in ESTIMATORS:
        assert told(part_from_mesh(*surface), method).here == pytest.approx(0.0, abs=1e-7)


@pytest.mark.parametrize("method", ESTIMATORS)
def test_between_and_beyond_the_measured_restitutions(polyhedron, method):
    """For one and the same estimate."""
    resting = resting_poses(polyhedron, 0.0)
    probability = ESTIMATORS[method].function(resting, DropScene())

    def square(restitution):
        return expected_error(method, resting, probability, restitution).here ** 2

    at = [square(one) for one in ERROR_AT]
    assert square(0.35) == pytest.approx(0.5 * (at[0] + at[1]))
    assert square(0.0) == pytest.approx(at[0])
    assert square(0.95) == pytest.approx(at[2])


def test_an_unmeasured_method(polyhedron):
    resting = resting_poses(polyhedron, 0.0)
    found = expected_error("unheard of", resting, np.ones(len(resting.poses)), 0.5)
    assert math.isnan(found.here) and not found.unusual


def test_terms_by_their_definition(polyhedron):
    resting = resting_poses(polyhedron, 0.0)
    p = {name: entry.function(resting, DropScene()) for name, entry in ESTIMATORS.items()}
    pairs = (("adre", "meae"), ("meae", "nqse"), ("meae", "eae"), ("meae", "qse"))
    expected = [np.mean((p[one] - p[other]) ** 2) for one, other in pairs]
    np.testing.assert_allclose(error_terms(resting, p["adre"]),
                               [*expected, np.mean(p["adre"] * (1.0 - p["adre"]))])


def test_methods_that_disagree_are_told():
    """A slender leaning body on which the old estimators see a base that drops never find."""
    for number in range(400):
        part = random_polyhedron(5, number, 1.0).part()
        found = estimate(part, "csae", cluster_tolerance=0.0)
        warned = any(one.startswith("METHODS_DISAGREE: ") for one in found.warnings)
        assert warned == told(part, "csae").unusual
        if warned:
            return
    raise AssertionError("no such body among 400")


class TestFit:
    def test_the_source_is_what_the_command_writes(self, fits):
        assert MODULE.read_text(encoding="utf-8") == source(fits)

    @pytest.mark.parametrize("method", ESTIMATORS)
    def test_held_out_parts_are_met(self, fits, method):
        """Weights from every other part; the error of the other half, in four bins, within a
        quarter and three standard errors of what is expected."""
        one = fits[method]
        for restitution in ERROR_AT:
            squares = one.squares[restitution]
            weights = fitted(one.terms[restitution][::2], squares[::2])
            expected, true = one.terms[restitution][1::2] @ weights, squares[1::2]
            for some in np.array_split(np.argsort(expected), 4):
                scatter = true[some].std() / math.sqrt(len(some))
                off = abs(math.sqrt(expected[some].mean()) - math.sqrt(max(true[some].mean(), 0)))
                allowed = 0.25 * math.sqrt(expected[some].mean())
                assert off < allowed + 1.5 * scatter / math.sqrt(expected[some].mean())

    def test_known_weights_are_found(self):
        rng = np.random.default_rng(1)
        terms = rng.gamma(1.0, 1.0, (4000, 5)) * 1e-2
        weights = np.array((0.5, 0.0, 2.0, 0.1, 1.0))
        squares = terms @ weights * rng.gamma(2.0, 0.5, 4000)
        np.testing.assert_allclose(fitted(terms, squares), weights, atol=0.1)


@pytest.mark.parametrize("method", ESTIMATORS)
def test_errors_of_poses_add_up_to_the_expected_one(polyhedron, method):
    found = estimate(polyhedron, method, cluster_tolerance=0.0)
    errors = np.array([pose.standard_error for pose in found.poses])
    assert math.sqrt(np.mean(errors ** 2)) == pytest.approx(found.expected_error, rel=1e-12)
    for pose in found.poses:
        assert 0.0 <= pose.probability_low <= pose.probability <= pose.probability_high <= 1.0


def test_poses_of_a_group_share_their_error():
    found = estimate(part_from_mesh(*box(1.0, 2.0, 3.0)))
    for group in range(3):
        assert len({pose.standard_error for pose in found.poses if pose.group == group}) == 1

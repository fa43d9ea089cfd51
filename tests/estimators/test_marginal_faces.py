"""A face that is about to lose its stability: some estimates jump there, two must not."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, shapes
from tests.bodies import oblique_prism

DOWN = np.array((0.0, 0.0, -1.0))


def probability_on_the_base(method, overhang, height=0.5):
    """Of a box whose centre of mass is `overhang` beyond the base's edge; 0 if unstable."""
    vertices, triangles = oblique_prism(1.2, 2.0)
    part = part_from_mesh(vertices, triangles,
                          center_of_mass=(1.0 + overhang, 0.1, height))
    found = estimate(part, method, cluster_tolerance=0.0)
    return sum(pose.probability for pose in found.poses if pose.down @ DOWN > 1.0 - 1e-9)


@pytest.mark.parametrize("method", ["eae", "meae"])
def test_energy_estimates_vanish_as_the_face_becomes_marginal(method):
    inside = np.array([probability_on_the_base(method, -10.0**-k) for k in range(1, 9)])
    assert inside[0] > 1e-4
    # To leading order a power of the way to the edge, at least the first; below 1e-14 noise.
    assert np.all(inside[1:] < np.maximum(0.2 * inside[:-1], 1e-14))
    assert inside[-1] < 1e-9
    assert probability_on_the_base(method, 1e-8) == 0.0


@pytest.mark.parametrize("method", ["eae", "meae"])
def test_the_other_poses_pass_the_edge_without_a_step(method):
    vertices, triangles = oblique_prism(1.2, 2.0)
    shares = []
    for overhang in (-1e-7, 1e-7):
        part = part_from_mesh(vertices, triangles, center_of_mass=(1.0 + overhang, 0.1, 0.5))
        found = estimate(part, method, cluster_tolerance=0.0)
        shares.append({tuple(np.round(pose.down, 3)): pose.probability for pose in found.poses})
    kept = shares[0].keys() & shares[1].keys()
    assert len(kept) == len(shares[1])
    assert len(shares[0]) == len(shares[1]) + 1
    for down in kept:
        assert shares[0][down] == pytest.approx(shares[1][down], abs=1e-6)


@pytest.mark.parametrize("method", ["area", "csae", "adre", "qse"])
def test_the_others_jump(method):
    assert probability_on_the_base(method, -1e-7) > 0.1
    assert probability_on_the_base(method, 1e-7) == 0.0


@pytest.mark.parametrize("overhang", [-1e-9, -1e-10, -1e-12, 0.0, 1e-12, 1e-10, 1e-9])
def test_the_edge_itself_is_answered_soberly(overhang):
    vertices, triangles = oblique_prism(1.2, 2.0)
    part = part_from_mesh(vertices, triangles, center_of_mass=(1.0 + overhang, 0.1, 0.5))
    for method in ("csae", "qse", "pqse", "eae", "meae", "combined"):
        for tolerance in (0.0, 0.005):
            found = estimate(part, method, cluster_tolerance=tolerance)
            probability = np.array([pose.probability for pose in found.poses])
            assert probability.min() >= 0.0
            assert probability.sum() == pytest.approx(1.0, abs=1e-12)
            assert all(pose.margin > 0.0 and pose.barrier > 0.0 for pose in found.poses)


@pytest.mark.parametrize("depth", [1e-1, 1e-4, 1e-8, 1e-11])
def test_a_centre_of_mass_close_to_a_face_inside(depth):
    part = part_from_mesh(*shapes.box(1.0, 1.0, 1.0),
                          center_of_mass=(0.1, -0.2, -0.5 + depth))
    for method in ("area", "csae", "qse", "pqse", "nqse", "eae", "meae", "combined"):
        found = estimate(part, method)
        best = found.poses[0]
        assert best.down == pytest.approx(DOWN)
        assert best.height == pytest.approx(depth, rel=1e-4)
        assert sum(pose.probability for pose in found.poses) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("size", [(1.0, 0.001, 0.002), (1.0, 1.0, 1e-5), (1.0, 1e-4, 1e-4)])
def test_needles_and_plates(size):
    part = part_from_mesh(*shapes.box(*size))
    for method in ("area", "csae", "adre", "qse", "pqse", "nqse", "eae", "meae", "combined"):
        found = estimate(part, method, cluster_tolerance=0.0)
        probability = np.array([pose.probability for pose in found.poses])
        assert len(probability) == 6
        assert np.all(np.isfinite(probability))
        assert probability.min() >= 0.0
        assert probability.sum() == pytest.approx(1.0, abs=1e-12)
        lowest = min(pose.height for pose in found.poses)
        assert found.poses[0].height == pytest.approx(lowest, rel=1e-9)

"""Hulls as Qhull and files leave them: folded facets, twin corners, rough planes."""

import gc
import weakref

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from ros_pose_stats import estimate, estimate_all, part_from_mesh, resting_poses
from ros_pose_stats.resting.equilibria import equilibria
from ros_pose_stats.shapes import box, hull_mesh


def points_on_a_box(rng, count, roughness=0.0):
    """Random points on the faces of a 2 x 3 x 4 box, off by a normal `roughness`."""
    points = rng.uniform(-1.0, 1.0, (count, 3))
    axis = rng.integers(0, 3, count)
    points[np.arange(count), axis] = np.sign(points[np.arange(count), axis])
    corners = np.array(np.meshgrid([-1, 1], [-1, 1], [-1, 1])).reshape(3, -1).T
    points = np.vstack([corners, points]) * [1.0, 1.5, 2.0]
    return points + roughness * rng.normal(size=points.shape)


def test_box_of_scattered_points_has_six_faces():
    # Qhull cuts facets of many corners into triangles that may be slivers or fold back.
    for seed in range(40):
        rng = np.random.default_rng(seed)
        points = points_on_a_box(rng, 200, 10.0 ** rng.uniform(-15, -9))
        points = Rotation.random(random_state=seed).apply(points) + rng.normal(size=3)
        found = equilibria(part_from_mesh(*hull_mesh(points),
                                          center_of_mass=points[:8].mean(axis=0)), 0)
        assert found.body.faces == 6
        assert found.poincare_hopf == 2
        assert found.heights * found.body.radius == pytest.approx(
            [1, 1, 1.5, 1.5, 2, 2], abs=1e-7)


@pytest.mark.parametrize(("gap", "seed"), [
    (1e-9, 0), (1e-8, 1), (1e-7, 2), (1e-7, 3), (1e-6, 4), (1e-5, 5)])
def test_twin_corners_change_no_pose(seed, gap):
    # Of two corners 1e-7 apart the difference points anywhere.
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(12, 3))
    twins = points + gap * rng.normal(size=points.shape)
    plain = estimate(part_from_mesh(*hull_mesh(points)), "meae", cluster_tolerance=1e-4)
    part = part_from_mesh(*hull_mesh(np.vstack([points, twins])))
    doubled = estimate(part, "meae", cluster_tolerance=1e-4)
    likely = [pose for pose in plain.poses if pose.margin > 1e-3 and pose.probability > 1e-3]
    assert likely
    for pose in likely:
        near = [other for other in doubled.poses if other.down @ pose.down > 1.0 - 1e-6]
        total = sum(other.probability for other in near)
        assert total == pytest.approx(pose.probability, abs=200.0 * gap)


@pytest.mark.parametrize("roughness", [1e-7, 1e-6, 1e-5, 1e-4])
def test_rough_box_keeps_its_poses_as_clusters(roughness):
    smooth = estimate(part_from_mesh(*box(2.0, 3.0, 4.0)), "meae")
    expected = {round(pose.height, 3): 0.0 for pose in smooth.poses}
    for pose in smooth.poses:
        expected[round(pose.height, 3)] += pose.probability
    rng = np.random.default_rng(5)
    part = part_from_mesh(*hull_mesh(points_on_a_box(rng, 300, roughness)), center_of_mass=[0] * 3)
    rough = estimate(part, "meae")
    assert len(rough.poses) == 6
    found = dict.fromkeys(expected, 0.0)
    for pose in rough.poses:
        found[round(pose.height, 3)] += pose.probability
    assert found == pytest.approx(expected, abs=100.0 * roughness)


def test_a_part_is_let_go():
    part = part_from_mesh(*box(1.0, 2.0, 3.0))
    estimate_all(part)
    resting_poses(part, 0.0)
    alive = weakref.ref(part)
    del part
    gc.collect()
    assert alive() is None

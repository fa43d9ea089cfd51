"""Stable, saddle and unstable equilibria, and the numbering of poses."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh, resting_poses, shapes
from ros_pose_stats.resting.equilibria import equilibria, pose_order, ties
from tests.bodies import (
    REGULAR_SOLIDS,
    moved,
    oblique_prism,
    random_polyhedron,
    rotation,
    subdivided,
)


def counts(surface, **properties):
    """Stable, saddle and unstable equilibria."""
    found = equilibria(part_from_mesh(*surface, **properties), 0)
    return len(found.faces), len(found.saddles), len(found.unstable)


@pytest.mark.parametrize(("surface", "expected"), [
    (REGULAR_SOLIDS["tetrahedron"], (4, 6, 4)),
    (REGULAR_SOLIDS["cube"], (6, 12, 8)),
    (REGULAR_SOLIDS["octahedron"], (8, 12, 6)),
    (REGULAR_SOLIDS["dodecahedron"], (12, 30, 20)),
    (REGULAR_SOLIDS["icosahedron"], (20, 30, 12)),
    (shapes.box(1.0, 2.0, 3.0), (6, 12, 8)),
    (shapes.prism(7, 1.0, 1.0), (9, 21, 14)),
    (oblique_prism(3.0, 4.0), (4, 6, 4)),
], ids=["tetrahedron", "cube", "octahedron", "dodecahedron", "icosahedron", "box", "prism",
        "leaning prism"])
def test_counted_by_hand(surface, expected):
    for seed in range(3):
        assert counts(moved(surface, rotation(seed), (1.0, 2.0, 3.0))) == expected


def test_a_centre_of_mass_close_to_a_corner_leaves_few():
    # Of a box: three faces at the corner, and those opposite, whose feet are near their rims.
    assert counts(shapes.box(1.0, 1.0, 1.0), center_of_mass=(0.4, 0.4, 0.4)) == (6, 12, 8)


@pytest.mark.parametrize("seed", [0, 6, 19])
def test_every_equilibrium_is_one_of_the_distance(seed):
    # Local extrema of r, tried on directions around them.
    part = part_from_mesh(*random_polyhedron(6 + seed, seed))
    found = equilibria(part, 0)
    body = found.body
    for down in found.downs:
        ring = down + 1e-5 * shapes.sphere_points(50, seed)
        ring /= np.linalg.norm(ring, axis=1)[:, None]
        assert body.r(ring).min() >= body.r(down) - 1e-14
        assert body.R(ring).min() >= body.R(down) - 1e-14
    for corner in body.points[found.unstable]:
        up = corner / np.linalg.norm(corner)
        ring = up + 1e-5 * shapes.sphere_points(50, seed)
        ring /= np.linalg.norm(ring, axis=1)[:, None]
        assert body.r(ring).max() <= body.r(up) + 1e-14
        assert body.R(ring).max() <= body.R(up) + 1e-14


@pytest.mark.parametrize("tolerance", [0.0, 0.005])
@pytest.mark.parametrize("roughness", [3e-7, 1e-6, 1e-5])  # about the tolerance of a plane
def test_rough_faces_give_no_pose_that_the_part_falls_out_of(roughness, tolerance):
    # Fine meshes with noise about as large as what still counts as planar.
    impossible = []
    for name, surface in REGULAR_SOLIDS.items():
        vertices, _ = subdivided(subdivided(surface))
        noise = roughness * np.linalg.norm(vertices, axis=1).max()
        for seed in range(3):
            rough = vertices + noise * np.random.default_rng(seed).normal(size=vertices.shape)
            poses = resting_poses(part_from_mesh(*shapes.hull_mesh(rough)), tolerance).poses
            impossible += [(name, seed, pose.index, pose.margin, pose.barrier)
                           for pose in poses if min(pose.margin, pose.barrier) <= 0.0]
    assert impossible == []


def test_tilts_lead_over_each_side():
    part = part_from_mesh(*shapes.box(2.0, 4.0, 6.0))
    found = equilibria(part, 0)
    arrays = found.body.arrays
    on_largest = arrays.face == found.faces[0]
    expected = np.repeat(np.arctan2((2.0, 3.0), 1.0), 2)
    assert np.sort(found.tilts[on_largest]) == pytest.approx(expected)


class TestTies:
    def test_runs_within_the_tolerance_share_a_number(self):
        values = np.array([0.3, 0.1, 0.3 + 1e-7, 0.2, 0.1 - 1e-7])
        assert ties((values, 1e-6)).tolist() == [2, 0, 2, 1, 0]

    def test_a_dense_run_is_cut_up(self):
        values = np.linspace(0.0, 1.0, 1001)
        numbers = ties((values, 0.01))
        assert np.all(np.diff(numbers) >= 0)
        for number in range(numbers.max() + 1):
            assert np.ptp(values[numbers == number]) <= 0.01 + 1e-12

    def test_earlier_groups_come_first(self):
        values = np.array([0.5, 0.1, 0.9, 0.1])
        assert ties((values, 1e-6), within=np.array([1, 1, 0, 0])).tolist() == [3, 2, 1, 0]

    def test_the_next_key_decides_among_ties(self):
        first, second = np.array([0.5, 0.5, 0.1, 0.5]), np.array([0.2, 0.1, 0.9, 0.2])
        assert ties((first, 1e-6), (second, 1e-6)).tolist() == [2, 1, 0, 2]


class TestPoseOrder:
    def test_by_height_then_down(self):
        heights = np.array([0.5, 0.3, 0.3 + 1e-9, 0.3])
        downs = np.array(((1.0, 0.0, 0.0), (0.0, 0.0, 1.0), (0.0, 0.0, -1.0), (0.0, -1.0, 1e-9)))
        assert pose_order(heights, downs).tolist() == [3, 2, 1, 0]

    def test_noise_changes_nothing(self):
        random = np.random.default_rng(0)
        downs = np.vstack((np.eye(3), -np.eye(3)))
        heights = np.array([0.5, 0.7, 0.5, 0.5, 0.7, 0.5])
        for _ in range(10):
            noisy = pose_order(heights + random.uniform(-2e-7, 2e-7, 6),
                               downs + random.uniform(-2e-6, 2e-6, (6, 3)))
            assert noisy.tolist() == pose_order(heights, downs).tolist()


@pytest.mark.parametrize("seed", range(2))
def test_faces_merged_within_the_tolerance_stay_stable(seed):
    # Among thousands of facets some pairs are coplanar to 1e-7; their merged face has corners
    # off its plane by more than a shallow pose is deep.
    points = shapes.ellipsoid_points(4000, seed, (1.0, 0.995, 0.99))
    found = equilibria(part_from_mesh(*shapes.hull_mesh(points)), 0)
    arrays = found.body.arrays
    margin = np.minimum.reduceat(arrays.inset, arrays.face_start[:-1])
    assert set(np.flatnonzero(margin > 1e-6)) <= set(arrays_stable(found))
    assert found.poincare_hopf == 2


def arrays_stable(found):
    return found.arrays.stable.tolist()

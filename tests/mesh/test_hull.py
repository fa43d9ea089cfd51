"""Hulls with thousands of corners on one face: found in time, and the same as without help."""

from __future__ import annotations

import time

import numpy as np
import pytest
import trimesh

from ros_pose_stats import estimate, part_from_mesh
from ros_pose_stats.errors import MeshError
from ros_pose_stats.mesh import hull as hull_module
from ros_pose_stats.mesh.hull import CROWD, hull_of, is_crowded
from tests.bodies import moved, rotation
from tests.matching import values


def surface(mesh):
    return np.array(mesh.vertices), np.array(mesh.faces)


def ring(sections):
    return surface(trimesh.creation.annulus(0.01, 0.02, 0.03, sections=sections))


def cone(sections):
    return surface(trimesh.creation.cone(0.01, 0.02, sections=sections))


@pytest.mark.parametrize("shape", [ring, cone])
@pytest.mark.parametrize("turn", [None, rotation(1)])
def test_the_same_poses_as_from_the_points_as_given(shape, turn, monkeypatch):
    given = moved(shape(CROWD + CROWD // 2), turn, (0.1, 0.2, 0.3))
    helped = part_from_mesh(*given)
    assert is_crowded((given[0] - given[0].mean(axis=0)) / np.ptp(given[0]))
    monkeypatch.setattr(hull_module, "is_crowded", lambda points: False)
    plain = part_from_mesh(*given)
    assert plain.digest == helped.digest
    expected, found = estimate(plain).poses, estimate(helped).poses
    for name in ("index", "group", "members"):
        assert [getattr(pose, name) for pose in found] == [getattr(pose, name)
                                                           for pose in expected]
    for name in ("probability", "height", "margin", "barrier", "top", "down"):
        assert values(found, name) == pytest.approx(values(expected, name), abs=1e-12)


@pytest.mark.parametrize("shape", [ring, cone])
def test_many_thousand_corners_take_seconds_at_most(shape):
    begin = time.perf_counter()
    part = part_from_mesh(*moved(shape(12_000), rotation(2)))
    assert len(estimate(part).poses) == (3 if shape is ring else 2)
    assert time.perf_counter() - begin < 15.0  # half a minute to minutes without help


@pytest.mark.parametrize("points", [
    np.random.default_rng(0).normal(size=(20_000, 3)),
    np.random.default_rng(0).uniform(size=(20_000, 3)),
    np.array(np.meshgrid(*[np.linspace(0.0, 1.0, 40)] * 3)).reshape(3, -1).T,
    np.array(trimesh.creation.torus(1.0, 0.3, major_sections=400, minor_sections=60).vertices),
    np.array(trimesh.creation.icosphere(5).vertices),
], ids=["cloud", "cube", "lattice", "torus", "ball"])
def test_points_as_they_are_as_a_rule(points):
    size = np.ptp(points, axis=0).max()
    assert not is_crowded(points / size)
    assert hull_of(points).qhull.points.shape == points.shape


def test_flat_points_stay_flat():
    angle = np.linspace(0.0, 2.0 * np.pi, 5000, endpoint=False)
    disc = np.column_stack((np.cos(angle), np.sin(angle), np.zeros(5000))) @ rotation(3).T
    with pytest.raises(MeshError, match="plane or line"):
        hull_of(disc)

"""Tetrahedra, planar regions and moments of surfaces against whole-array formulas."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given
from hypothesis import strategies as st

from ros_pose_stats.kernels.features.surface_features import regions_and_corners
from ros_pose_stats.kernels.features.surface_moments import moments_along
from ros_pose_stats.kernels.mesh.measures import solid_moments, tetrahedra
from tests.bodies import rotation, starred, subdivided


@given(st.integers(1, 30), st.integers(0, 2**32 - 1))
def test_tetrahedra(count, seed):
    random = np.random.default_rng(seed)
    points, triangles = random.normal(size=(12, 3)), random.integers(0, 12, (count, 3))
    expected = np.linalg.det(points[triangles])
    assert tetrahedra(points, triangles) == pytest.approx(expected, abs=1e-13)
    assert solid_moments(points, triangles)[0] == pytest.approx(expected.sum() / 6.0, abs=1e-13)


@pytest.mark.parametrize("seed", range(3))
def test_moments_of_a_solid(seed):
    """Those of a box from its sides; the sum's error does not grow with the triangles."""
    sides, middle = np.array([1.0, 2.0, 3.0]) / 3.0, np.array([0.1, -0.2, 0.05])
    turn = rotation(seed)
    surface = trimesh.creation.box(sides)
    vertices, triangles = np.asarray(surface.vertices), np.asarray(surface.faces)
    for _ in range(5):
        vertices, triangles = subdivided((vertices, triangles))
    volume = float(np.prod(sides))
    second = volume * (turn @ np.diag(sides**2 / 12.0) @ turn.T + np.outer(middle, middle))
    found = solid_moments(vertices @ turn.T + middle, triangles)
    expected = [volume, *(volume * middle), *np.diag(second), second[0, 1], second[0, 2],
                second[1, 2]]
    assert len(triangles) == 12 * 4**5
    assert found == pytest.approx(expected, rel=0.0, abs=4e-16)


@given(st.integers(1, 40), st.integers(1, 5), st.integers(0, 2**32 - 1))
def test_moments(count, directions, seed):
    random = np.random.default_rng(seed)
    regions, along = random.normal(size=(count, 7)), random.normal(size=(directions, 3))
    height = regions[:, :3] @ along.T
    facing = regions[:, 3:6] @ along.T * regions[:, 6:]
    area = regions[:, 6:] ** 2
    expected = np.column_stack(
        [(area * height**k).sum(axis=0) for k in (2, 3, 4)]
        + [(area * facing * height**k).sum(axis=0) for k in (0, 1, 2, 3)])
    found = moments_along(regions, along)
    assert np.abs(found - expected).max() <= 1e-11 * max(1.0, np.abs(expected).max())


def box_regions(surface):
    return regions_and_corners(*surface, 1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_regions_do_not_depend_on_how_faces_are_cut(seed):
    mesh = trimesh.creation.box((1.0, 2.0, 3.0))
    plain = np.asarray(mesh.vertices) @ rotation(seed).T, np.asarray(mesh.faces)
    expected, corners = box_regions(plain)
    assert len(expected) == 6
    assert corners.tolist() == list(range(8))
    assert expected[:, 6] ** 2 == pytest.approx([6.0, 6.0, 3.0, 3.0, 2.0, 2.0])
    for surface in (subdivided(subdivided(plain)), starred(plain, seed)):
        found, corners = box_regions(surface)
        assert corners.tolist() == list(range(8))
        order = np.lexsort(np.round(found[:, :3], 6).T)
        assert found[order] == pytest.approx(expected[np.lexsort(np.round(expected[:, :3], 6).T)])


def test_regions_of_a_ball_are_its_triangles():
    mesh = trimesh.creation.icosphere(3)
    regions, corners = regions_and_corners(np.array(mesh.vertices), np.array(mesh.faces), 1e-6)
    order = np.argsort(-mesh.area_faces, kind="stable")
    assert corners.tolist() == list(range(len(mesh.vertices)))
    assert regions[:, 6] ** 2 == pytest.approx(mesh.area_faces[order])
    assert np.sort(regions[:, 0]) == pytest.approx(np.sort(mesh.triangles_center[:, 0]))
    normals = regions[:, 3:6] / regions[:, 6:]
    assert np.sort(normals[:, 2]) == pytest.approx(np.sort(mesh.face_normals[:, 2]))


def test_a_triangle_without_area_is_no_region_of_its_own():
    # A corner of a tetrahedron's edge on that edge: two slivers, one of them without area.
    points = np.array([(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0.5, 0, 0)], dtype=float)
    triangles = np.array([(0, 2, 1), (0, 4, 3), (4, 1, 3), (1, 2, 3), (0, 3, 2), (0, 1, 4)])
    regions, corners = regions_and_corners(points, triangles, 1e-9)
    assert len(regions) == 4
    assert corners.tolist() == [0, 1, 2, 3]

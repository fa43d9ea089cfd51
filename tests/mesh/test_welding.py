"""Welding of coincident vertices and clearing of repeated triangles."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from ros_pose_stats.mesh.welding import weld, without_repeated
from ros_pose_stats.tolerances import WELD


def soup(mesh):
    triangles = np.asarray(mesh.faces, dtype=np.int64)
    return np.asarray(mesh.vertices)[triangles].reshape(-1, 3), \
        np.arange(triangles.size).reshape(-1, 3)


def corner_sets(vertices, triangles):
    return sorted(map(tuple, vertices[triangles].reshape(-1, 9).tolist()))


@pytest.mark.parametrize("mesh", [trimesh.creation.box(), trimesh.creation.icosphere(4),
                                  trimesh.creation.cylinder(1.0, 3.0, sections=500)])
def test_a_soup_is_welded_back_to_the_mesh_it_came_from(mesh):
    vertices, triangles = soup(mesh)
    welded, corners = weld(vertices, triangles)
    assert len(welded) == len(mesh.vertices)
    assert corner_sets(welded, corners) == corner_sets(vertices, triangles)


def test_a_clean_mesh_is_returned_untouched():
    mesh = trimesh.creation.icosphere(2)
    vertices, triangles = np.array(mesh.vertices), np.array(mesh.faces)
    welded, corners = weld(vertices, triangles)
    assert welded is vertices
    assert corners is triangles


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-9, 1.0, 1e9]))
def test_vertices_merge_within_the_tolerance_and_not_beyond(seed, scale):
    random = np.random.default_rng(seed)
    places = random.uniform(size=(20, 3))
    places[:2] = [[0, 0, 0], [1, 1, 1]]
    twins = places[random.integers(0, 20, 200)]
    step = random.normal(size=twins.shape)
    step /= np.linalg.norm(step, axis=1)[:, None]
    near, _ = weld(scale * np.concatenate((places, twins + 0.45 * WELD * step)),
                   np.arange(219).reshape(-1, 3))
    far, _ = weld(scale * np.concatenate((places, twins[:1] + 3.0 * WELD * step[:1])),
                  np.arange(21).reshape(-1, 3))
    assert len(near) == 20
    assert len(far) == 21


def test_foreign_vertices_of_equal_projection_do_not_hide_twins():
    direction = np.sqrt([2.0, 3.0, 5.0])
    across = np.cross(direction, [1.0, 0.0, 0.0])
    places = np.outer(np.linspace(-1, 1, 15), across)
    vertices = np.concatenate((places, places, places, [direction]))
    triangles = np.stack((np.arange(45), np.full(45, 45), (np.arange(45) + 1) % 45), axis=1)
    welded, _ = weld(vertices, triangles)
    assert len(welded) == 16


def test_vertices_keep_the_order_and_place_of_the_first_of_their_kind():
    vertices = np.array([[9, 9, 9], [1, 0, 0], [0, 0, 0], [1, 0, 1e-12], [0, 1, 0]], dtype=float)
    welded, corners = weld(vertices, np.array([[2, 1, 4], [2, 4, 3]]))
    assert welded.tolist() == [[1, 0, 0], [0, 0, 0], [0, 1, 0]]
    assert corners.tolist() == [[1, 0, 2], [1, 2, 0]]


def test_collapsed_triangles_and_their_lone_vertices_vanish():
    mesh = trimesh.creation.box()
    vertices = np.concatenate((mesh.vertices, [[5.0, 5.0, 5.0]]))
    welded, corners = weld(vertices, np.concatenate((mesh.faces, [[8, 8, 0], [1, 1, 1]])))
    assert len(welded) == 8
    assert len(corners) == 12


def test_repeats_of_one_orientation_leave_one():
    triangles = np.array([[0, 1, 2], [3, 4, 5], [1, 2, 0], [2, 0, 1]])
    assert without_repeated(triangles).tolist() == [[0, 1, 2], [3, 4, 5]]


def test_opposite_pairs_cancel():
    triangles = np.array([[0, 1, 2], [3, 4, 5], [1, 0, 2]])
    assert without_repeated(triangles).tolist() == [[3, 4, 5]]


def test_a_double_sided_mesh_keeps_the_first_of_each_pair():
    faces = np.array(trimesh.creation.box().faces)
    doubled = np.concatenate((faces, faces[::-1, ::-1]))
    assert without_repeated(doubled).tolist() == faces.tolist()

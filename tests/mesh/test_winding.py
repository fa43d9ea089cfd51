"""Closedness, shells, consistent winding, nesting and overlap."""

from __future__ import annotations

import time

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from ros_pose_stats.mesh.crossings import crossings
from ros_pose_stats.mesh.mass_properties import solid_of
from ros_pose_stats.mesh.shells import oriented_outward
from ros_pose_stats.mesh.winding import closed_shells

SECONDS_OF_NEEDLES = 10.0
"""It takes one; to test every pair took thirty."""


def box(extents, at=(0, 0, 0), inward=False):
    mesh = trimesh.creation.box(extents)
    mesh.apply_translation(at)
    if inward:
        mesh.invert()
    return mesh


def arrays(*meshes):
    mesh = trimesh.util.concatenate(meshes)
    return np.array(mesh.vertices), np.array(mesh.faces, dtype=np.int64)


def volume_and_overlap(*meshes):
    vertices, triangles = arrays(*meshes)
    shells = closed_shells(vertices, triangles)
    oriented, overlap = oriented_outward(vertices, shells)
    return solid_of(vertices, oriented).volume, overlap


def test_an_open_surface_is_not_closed():
    vertices, triangles = arrays(box((1, 1, 1)))
    assert closed_shells(vertices, triangles[1:]) is None


def test_a_klein_bottle_is_closed_but_has_no_inside():
    n = 8
    i, j = np.meshgrid(np.arange(n), np.arange(n), indexing="ij")

    def vertex(row, column):
        return np.where(row < n, row * n + column % n, (-column) % n)

    a, b = vertex(i, j), vertex(i + 1, j)
    c, d = vertex(i + 1, j + 1), vertex(i, j + 1)
    triangles = np.concatenate((np.stack((a, b, c), -1), np.stack((a, c, d), -1))).reshape(-1, 3)
    vertices = np.random.default_rng(0).normal(size=(n * n, 3))
    assert closed_shells(vertices, triangles) is None


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0.0, 0.4))
def test_turned_triangles_are_turned_back_to_what_most_of_the_area_had(seed, share):
    random = np.random.default_rng(seed)
    vertices, triangles = arrays(trimesh.creation.icosphere(2))
    turned = random.permutation(len(triangles)) < share * len(triangles)
    messy = np.where(turned[:, None], triangles[:, ::-1], triangles)
    shells = closed_shells(vertices, messy)
    assert shells.total == 1
    assert np.array_equal(shells.triangles, np.where(turned[:, None], messy[:, ::-1], messy))


def test_boxes_that_share_an_edge_are_two_shells():
    vertices, triangles = arrays(box((1, 1, 1)), box((1, 1, 1), (1, 1, 0)))
    _, first, where = np.unique(vertices, axis=0, return_index=True, return_inverse=True)
    shared = first[where.ravel()][triangles]
    assert len(np.unique(shared)) == 14
    shells = closed_shells(vertices, shared)
    assert shells.total == 2
    turned = shared.copy()
    turned[12:] = turned[12:, ::-1]
    shells = closed_shells(vertices, turned)
    oriented, overlap = oriented_outward(vertices, shells)
    assert solid_of(vertices, oriented).volume == pytest.approx(2.0)
    assert not overlap


def test_an_internal_wall_between_two_bodies_is_removed():
    mesh = arrays(box((1, 1, 1)), box((1, 1, 1), (1, 0, 0)))
    vertices, where = np.unique(mesh[0], axis=0, return_inverse=True)
    triangles = where.ravel()[mesh[1]]
    left, right = vertices[triangles][:, :, 0].T[0], triangles
    assert len(left) == len(right) == 24
    wall = (vertices[triangles][:, :, 0] == 0.5).all(axis=1)
    low, high = np.flatnonzero(wall)[:2], np.flatnonzero(wall)[2:]
    triangles[high] = triangles[low][:, ::-1]
    shells = closed_shells(vertices, triangles)
    assert shells.total == 1
    assert len(shells.triangles) == 20
    assert solid_of(vertices, shells.triangles).volume == pytest.approx(2.0)


@pytest.mark.parametrize(("inverted", "closed"), [(False, True), (True, False)])
def test_stacked_boxes_with_unlike_diagonals_wound_against_each_other(inverted, closed):
    below, above = box((1, 1, 1)), box((1, 1, 1), (0, 0, 1))
    vertices, triangles = arrays(below, above)
    vertices, where = np.unique(vertices, axis=0, return_inverse=True)
    triangles = where.ravel()[triangles]
    bottom = np.flatnonzero((vertices[triangles[12:]][:, :, 2] == 0.5).all(axis=1)) + 12
    square = np.flatnonzero(vertices[:, 2] == 0.5)
    a, b, d, c = square[np.lexsort((vertices[square, 1], vertices[square, 0]))]
    other = [[a, b, c], [a, c, d]]
    shared = {tuple(sorted(row)) for row in triangles.tolist()}
    if tuple(sorted(other[0])) in shared:
        other = [[b, c, d], [b, d, a]]
    triangles[bottom] = other
    if inverted:
        triangles[12:] = triangles[12:, ::-1]
    shells = closed_shells(vertices, triangles)
    assert (shells is not None) == closed
    if shells is not None:
        oriented, _ = oriented_outward(vertices, shells)
        assert solid_of(vertices, oriented).volume == pytest.approx(2.0)


@pytest.mark.parametrize("outer_inward", [False, True])
@pytest.mark.parametrize("inner_inward", [False, True])
def test_nesting_of_two_shells(outer_inward, inner_inward):
    volume, overlap = volume_and_overlap(box((4, 4, 4), inward=outer_inward),
                                         box((1, 1, 1), (0.7, 0, 0), inward=inner_inward))
    second_body = not outer_inward and not inner_inward
    assert volume == pytest.approx(65.0 if second_body else 63.0)
    assert overlap == second_body


@pytest.mark.parametrize("inverted", [False, True])
@pytest.mark.parametrize("shuffle", [0, 1, 2])
def test_a_body_inside_a_void_is_a_body(inverted, shuffle):
    meshes = [box((9, 9, 9), inward=inverted), box((5, 5, 5), inward=not inverted),
              box((1, 1, 1), inward=inverted)]
    order = np.random.default_rng(shuffle).permutation(3)
    volume, overlap = volume_and_overlap(*(meshes[k] for k in order))
    assert volume == pytest.approx(729 - 125 + 1)
    assert not overlap


def test_an_inward_shell_inside_a_void_is_turned_into_a_body():
    volume, overlap = volume_and_overlap(box((9, 9, 9)), box((5, 5, 5), inward=True),
                                         box((1, 1, 1), inward=True))
    assert volume == pytest.approx(729 - 125 + 1)
    assert not overlap


def test_an_inward_box_that_touches_the_wall_from_inside_is_a_void():
    volume, _ = volume_and_overlap(box((4, 4, 4)), box((2, 2, 2), (1, 0, 0), inward=True))
    assert volume == pytest.approx(64 - 8)


def test_a_shell_beside_another_with_boxes_nested_is_not_inside_it():
    # A frame around a pin: the pin is within the frame's box but not within its metal.
    ring = trimesh.creation.annulus(2.0, 3.0, 4.0, sections=24)
    pin = trimesh.creation.cylinder(1.0, 2.0, sections=16)
    inverted = pin.copy()
    inverted.invert()
    for body in (pin, inverted):
        volume, overlap = volume_and_overlap(ring, body)
        assert volume == pytest.approx(ring.volume + pin.volume)
        assert not overlap


@pytest.mark.parametrize(("turn", "height"), [(0.0, 0.8), (0.0, 1.0), (0.3, 1.0), (0.3, 1.3)])
def test_crossed_bars_overlap(turn, height):
    bars = [box((6, 1, 1)), box((1, 6, height))]
    turned = trimesh.transformations.rotation_matrix(turn, (1, 2, 3))
    for bar in bars:
        bar.apply_transform(turned)
    volume, overlap = volume_and_overlap(*bars)
    assert overlap
    assert volume == pytest.approx(6 + 6 * height)


@pytest.mark.parametrize("turn", [0.0, 0.3])
@pytest.mark.parametrize("extents", [(1, 6, 1), (6, 1, 1), (6, 6, 1), (0.4, 0.5, 1)])
def test_bars_that_touch_face_to_face_do_not_overlap(turn, extents):
    bars = [box((6, 1, 1)), box(extents, (0, 0, 1))]
    turned = trimesh.transformations.rotation_matrix(turn, (1, 2, 3))
    for bar in bars:
        bar.apply_transform(turned)
    assert not volume_and_overlap(*bars)[1]


@pytest.mark.parametrize(("distance", "expected"), [(1.7, True), (1.99, True), (2.01, False)])
def test_mirrored_balls_overlap_when_they_are_closer_than_two_radii(distance, expected):
    ball = trimesh.creation.icosphere(4)
    other = ball.copy()
    other.apply_translation((distance, 0, 0))
    assert volume_and_overlap(ball, other)[1] == expected


def test_a_peg_flush_in_its_hole_does_not_overlap():
    ring = trimesh.creation.annulus(1.0, 2.0, 1.0, sections=24)
    peg = trimesh.creation.cylinder(1.0, 3.0, sections=24)
    assert not volume_and_overlap(ring, peg)[1]
    peg.apply_translation((0.05, 0.0, 0.0))
    assert volume_and_overlap(ring, peg)[1]


def needles(count):
    """Tetrahedra a million times longer than thick that lie all across each other."""
    chance = np.random.default_rng(0)
    ends = chance.uniform(-0.5, 0.5, (2, count, 3))
    aside = 1e-6 * chance.normal(size=(2, count, 3))
    corners = np.stack([ends[0], ends[1], ends[0] + aside[0], ends[1] + aside[1]], axis=1)
    volume = np.linalg.det(corners[:, 1:] - corners[:, :1])
    corners[volume < 0.0, 2:] = corners[volume < 0.0, 3:1:-1]
    rows = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    return trimesh.Trimesh(corners.reshape(-1, 3),
                           (rows + 4 * np.arange(count)[:, None, None]).reshape(-1, 3),
                           process=False)


def test_thousands_of_needles_do_not_take_long():
    begin = time.monotonic()
    assert not volume_and_overlap(needles(2500))[1]
    assert time.monotonic() - begin < SECONDS_OF_NEEDLES


def test_hundreds_of_shells_in_one_body_are_all_voids():
    grid = [(x, y, z) for x in range(7) for y in range(7) for z in range(7)]
    voids = [box((0.5, 0.5, 0.5), at, inward=True) for at in grid]
    volume, overlap = volume_and_overlap(*voids, box((20, 20, 20), (3, 3, 3)))
    assert volume == pytest.approx(8000 - len(grid) / 8)
    assert not overlap


@settings(max_examples=60, deadline=None)
@given(st.integers(-4, 4), st.integers(-4, 4), st.integers(0, 2**32 - 1))
def test_a_line_through_edges_and_vertices_goes_in_as_often_as_out(x, y, seed):
    random = np.random.default_rng(seed)
    vertices = random.integers(-2, 3, size=(12, 3)).astype(float)
    vertices = np.unique(vertices, axis=0)
    pick = random.integers(0, len(vertices), size=(6, 4))
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])
    _, _, sign = crossings(vertices, pick[:, faces].reshape(-1, 3), x / 2, y / 2)
    assert sign.sum() == 0


def test_crossings_of_a_box_through_its_diagonal_edges():
    vertices, triangles = arrays(box((2, 2, 2)))
    which, height, sign = crossings(vertices, triangles, 0.0, 0.0)
    assert sorted(zip(height, sign, strict=True)) == [(-1.0, -1), (1.0, 1)]
    assert len(which) == 2
    assert len(crossings(vertices, triangles, 3.0, 0.0)[0]) == 0

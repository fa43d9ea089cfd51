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

"""The triangles that a part is drawn by: near its surface, with teeth, gaps, bores and
threads.
"""

from functools import cache

import numpy as np
import pytest
import trimesh
from hypothesis import given, strategies
from scipy.spatial import cKDTree

from lab.bodies import fine_parts, shapes
from ros_pose_stats import part_from_mesh
from ros_pose_stats.core.mesh.decimation import visible_triangles

FINEST = 20_000


@cache
def surface_of(name):
    return getattr(fine_parts, name)()


@cache
def part_of(name):
    return part_from_mesh(*surface_of(name))


def mesh_of(triangles):
    return trimesh.Trimesh(
        triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3)
    )


def pierced(triangles, x, y):
    """Heights at which the vertical through (x, y) passes through triangles,
    ascending.
    """
    corners = triangles - np.array([x, y, 0.0])
    a = corners[:, 0]
    b = corners[:, 1]
    c = corners[:, 2]
    parts = [p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] for p, q in ((b, c), (c, a), (a, b))]
    inside = (np.minimum.reduce(parts) > 0.0) | (np.maximum.reduce(parts) < 0.0)
    heights = sum(share * p[:, 2] for share, p in zip(parts, (a, b, c), strict=True))
    return np.sort(heights[inside] / sum(parts)[inside])


def assert_near(true, visible, distance):
    """No point of one surface is farther from the other."""
    first, two = (
        trimesh.sample.sample_surface(mesh_of(triangles), 200_000, seed=1)[0]
        for triangles in (true, visible)
    )
    distances = (
        0.006 * np.ptp(true.reshape(-1, 3), axis=0).max()
    )  # of the points themselves
    assert cKDTree(first).query(two[:20_000])[0].max() < distance + distances
    assert cKDTree(two).query(first[:20_000])[0].max() < distance + distances


@pytest.mark.parametrize(("most", "share"), [(FINEST, 0.002), (1000, 0.02)])
@pytest.mark.parametrize("name", ["gear", "screw"])
def test_they_stay_near_the_surface_and_leave_out_nothing(name, most, share):
    part = part_of(name)
    true = part.surface_vertices[part.surface_triangles]
    visible = visible_triangles(part, most)
    assert len(visible) <= most < len(true)
    mesh = mesh_of(visible)
    assert mesh.is_watertight
    assert mesh.volume == pytest.approx(mesh_of(true).volume, rel=2.5 * share)
    assert_near(true, visible, share * np.ptp(part.vertices, axis=0).max())


@pytest.mark.parametrize("most", [FINEST, 4000, 1000])
def test_a_line_passes_through_every_gap_and_the_bore_and_meets_every_tooth(most):
    visible = visible_triangles(part_of("gear"), most)
    middle = 0.5 * (fine_parts.TIP + fine_parts.ROOT)
    for k in range(fine_parts.TEETH):
        for turn, hits in ((0.25, [0.0, fine_parts.FACE]), (0.75, [])):
            angle = 2.0 * np.pi * (k + turn) / fine_parts.TEETH
            heights = pierced(visible, middle * np.cos(angle), middle * np.sin(angle))
            assert heights == pytest.approx(hits, abs=2e-5)
    for angle in np.arange(0.1, 6.0, 0.7):
        reach = 0.6 * fine_parts.BORE
        assert len(pierced(visible, reach * np.cos(angle), reach * np.sin(angle))) == 0


def test_few_triangles_are_drawn_as_they_are_and_many_the_same_in_any_unit():
    part = part_from_mesh(*shapes.box(0.04, 0.03, 0.02))
    assert (
        visible_triangles(part, 100) == part.surface_vertices[part.surface_triangles]
    ).all()
    vertices, triangles = surface_of("gear")
    visible = visible_triangles(part_of("gear"), 2000)
    for scale in (1.0, 2.0**-40, 2.0**40):
        scaled = part_from_mesh(scale * vertices, triangles)
        assert (visible_triangles(scaled, 2000) == scale * visible).all()


def test_an_open_mesh_is_drawn_as_received_from_both_sides():
    vertices, triangles = surface_of("gear")
    part = part_from_mesh(vertices, triangles[1000:])
    assert part.is_open
    visible = visible_triangles(part, 4000)
    assert 2000 < len(visible) <= 4000
    half = len(visible) // 2
    assert (visible[:half] == visible[half:, ::-1]).all()
    share = 0.02 * 1000 / 2000  # of flat facets, inversely as their number
    assert_near(
        vertices[triangles[1000:]],
        visible[:half],
        share * np.ptp(vertices, axis=0).max(),
    )
    assert len(pierced(visible, 0.5 * fine_parts.BORE, 0.0)) == 0


@given(
    strategies.integers(0, 2**32 - 1),
    strategies.integers(12, 2000),  # of fewer corners some are too flat for a part
    strategies.integers(12, 3000),
    strategies.sampled_from([1e-4, 1.0]),
    strategies.integers(100, 1000),
)
def test_any_mesh_is_drawn_by_few_triangles_between_its_own_vertices(
    seed, vertices, triangles, height, most
):
    """Edges of many triangles, repeated ones, loose points."""
    random = np.random.default_rng(seed)
    places = random.normal(size=(vertices, 3)) * (1.0, 1.0, height)
    part = part_from_mesh(
        places,
        np.vstack(
            (random.integers(vertices, size=(triangles, 3)), [(0, 1, 2), (1, 2, 3)])
        ),
        body="all",
    )
    visible = visible_triangles(part, most)
    assert len(visible) <= most
    corners = {tuple(corner) for corner in places.tolist()}
    assert {tuple(corner) for corner in visible.reshape(-1, 3).tolist()} <= corners

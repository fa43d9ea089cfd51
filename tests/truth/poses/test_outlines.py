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

"""Silhouettes and sections, against closed forms, volumes and points that are looked at
singly.
"""

import math
from functools import cache

import numpy as np
import pytest
from manifold3d import Manifold, Mesh64
from matplotlib.path import Path
from scipy.spatial.transform import Rotation

from lab.bodies import shapes
from lab.bodies.fine_parts import surface
from lab.bodies.samples import random_polyhedron
from lab.bodies.variants import moved, rotation
from ros_pose_stats import PoseStatsError, outline_at, part_from_mesh, resting_poses
from ros_pose_stats.core.shapes import demo_parts

MM = 1e-3


def area_of(ring):
    x, y = ring.T
    return 0.5 * float((x * np.roll(y, -1) - y * np.roll(x, -1)).sum())


def holds(polygons, points):
    """Whether points (n, 2) are in a polygon and in none of its holes; as matplotlib
    sees it.
    """
    inside = np.zeros(len(points), dtype=bool)
    for boundary, *holes in polygons:
        within = Path(boundary).contains_points(points)
        for hole in holes:
            within &= ~Path(hole).contains_points(points)
        inside |= within
    return inside


def crossings(part, pose, points):
    """Where vertical lines through points (n, 2) meet the surface: which line, and
    heights.
    """
    position = (
        Rotation.from_quat(pose.orientation).apply(part.surface_vertices)
        + pose.position
    )
    a, b, c = position[part.surface_triangles].transpose(1, 0, 2)[:, None]
    p = points[:, None]

    def turn(u, v):
        return (v[..., 0] - u[..., 0]) * (p[..., 1] - u[..., 1]) - (
            v[..., 1] - u[..., 1]
        ) * (p[..., 0] - u[..., 0])

    w = np.stack([turn(b, c), turn(c, a), turn(a, b)])
    line, triangle = np.nonzero((w > 0).all(axis=0) | (w < 0).all(axis=0))
    w = w[:, line, triangle]
    return line, (w * np.stack([a, b, c])[:, 0, triangle, 2]).sum(axis=0) / w.sum(
        axis=0
    )


@cache
def part_of(name):
    return part_from_mesh(*demo_parts.DEMO_PARTS[name](), unit="mm")


POSES = [
    ("clamp", 0),
    ("clamp", 3),
    ("bracket", 1),
    ("bracket", 2),
    ("gear", 0),
    ("gear", 2),
]


@pytest.mark.parametrize(("name", "index"), POSES)
def test_silhouette_and_sections_are_where_a_line_from_above_meets_the_part(
    name, index
):
    part = part_of(name)
    pose = resting_poses(part).poses[index]
    points = np.random.default_rng(index).uniform(-0.04, 0.04, (3000, 2))
    line, height = crossings(part, pose, points)
    hit = np.bincount(line, minlength=len(points)) > 0
    assert 100 < hit.sum() < 2900
    assert (holds(outline_at(part, pose), points) == hit).all()
    for share in (0.11, 0.37, 0.81):
        level = share * pose.top
        above = np.bincount(line[height > level], minlength=len(points))
        assert (holds(outline_at(part, pose, level), points) == (above % 2 == 1)).all()


@pytest.mark.parametrize(
    "body",
    [
        *(random_polyhedron(25, seed) for seed in range(3)),
        moved(shapes.box(1.0, 1e-6, 2e-6), rotation(3)),
    ],
)
def test_a_convex_part_has_the_outline_of_its_hull(body):
    part = part_from_mesh(*body)
    for pose in resting_poses(part).poses:
        ((boundary,),) = outline_at(part, pose)
        assert area_of(boundary) == pytest.approx(area_of(pose.outline), rel=1e-6)
        ((foot,),) = outline_at(part, pose, 0.0)
        assert area_of(foot) == pytest.approx(area_of(pose.support_polygon), rel=1e-5)


def block_with_a_hole():
    """40 by 30 by 10 mm, with a hole 8 mm wide at (5, 3) and a groove 4 deep and 6 wide
    below.
    """
    block = Manifold.cube((40.0, 30.0, 10.0)).translate((-20.0, -15.0, 0.0))
    hole = Manifold.cylinder(12.0, 4.0, circular_segments=64).translate(
        (5.0, 3.0, -1.0)
    )
    groove = Manifold.cube((6.0, 30.0, 5.0)).translate((-15.0, -15.0, -1.0))
    return surface(block - hole - groove)


@pytest.fixture(
    scope="module", params=[np.eye(3), rotation(4)], ids=["as drawn", "turned"]
)
def block(request):
    """The block lying on its groove; turned and rounded as an STL file rounds it."""
    vertices, triangles = block_with_a_hole()
    turned = (vertices @ request.param.T).astype(np.float32)
    part = part_from_mesh(turned, triangles, unit="mm")
    down = request.param @ (0.0, 0.0, -1.0)
    pose = min(
        resting_poses(part).poses, key=lambda candidate: math.dist(candidate.down, down)
    )
    return part, pose


def test_a_hole_is_a_ring_of_its_own_and_no_groove_shows_from_above(block):
    ((boundary, hole),) = outline_at(*block)
    assert area_of(boundary) == pytest.approx(1200.0 * MM**2, rel=1e-5)
    sides = len(hole)
    bore = 0.5 * sides * 16.0 * math.sin(2.0 * math.pi / sides) * MM**2
    assert area_of(hole) == pytest.approx(-bore, rel=1e-4)


def test_rounding_leaves_no_spurs(block):
    """A ring that goes somewhere and comes back the same way."""
    for polygon in (*outline_at(*block), *outline_at(*block, 5.0 * MM)):
        for ring in polygon:
            back = np.roll(ring, 1, axis=0) - ring
            edges = np.roll(ring, -1, axis=0) - ring
            along = (back * edges).sum(axis=1)
            across = np.abs(back[:, 0] * edges[:, 1] - back[:, 1] * edges[:, 0])
            assert not ((along > 0.0) & (across < 1e-4 * along)).any()
            assert np.hypot(*edges.T).min() > 1e-7


def test_the_foot_is_what_touches_the_plate(block):
    """Two strips beside the groove, of which one has the hole."""
    wide, narrow = outline_at(*block, 0.0)
    assert len(wide) == 2 and len(narrow) == 1
    assert area_of(wide[0]) == pytest.approx(29.0 * 30.0 * MM**2, rel=1e-5)
    assert area_of(narrow[0]) == pytest.approx(5.0 * 30.0 * MM**2, rel=1e-5)


def test_at_a_step_it_is_the_section_just_above(block):
    part, pose = block
    for height, pieces in (
        (3.9, 2),
        (4.0, 1),
        (9.99, 1),
        (10.0, 0),
        (-0.1, 0),
        (50.0, 0),
    ):
        assert len(outline_at(part, pose, height * MM)) == pieces


def test_bodies_that_reach_into_each_other_are_one():
    first = shapes.box(0.02, 0.02, 0.01)
    second = first[0] + (0.01, 0.01, 0.0), first[1] + len(first[0])
    part = part_from_mesh(
        np.vstack([first[0], second[0]]), np.vstack([first[1], second[1]])
    )
    pose = resting_poses(part).poses[0]
    ((boundary,),) = outline_at(part, pose, 0.005)
    assert area_of(boundary) == pytest.approx(7e-4, rel=1e-6)


ANGLE = (0, 0), (2, 0), (2, 1), (1, 1), (1, 2), (0, 2)
SLOTTED = (
    *((4, 0), (4, 5), (6, 5), (6, 0)),
    *((10, 0), (10, 5), (10, 10), (5, 10), (0, 10), (0, 5), (0, 0)),
)
"""Corners of faces with a bay; some of the second are in between on its sides."""


def block_of_fans(face, turn):
    """A block 1.5 high, whose ends are fans from a corner of theirs.

    Not every corner sees all of the end: then triangles of the fan lie on each other,
    and some without area may be in between.
    """
    corners = np.roll(np.array(face, dtype=float), turn, axis=0)
    count = len(corners)
    k = np.arange(1, count - 1)
    fan = np.stack((np.zeros_like(k), k, k + 1), axis=1)
    begin = np.arange(count)
    end = (begin + 1) % count
    triangles = np.concatenate(
        (
            fan[:, ::-1],
            fan + count,
            np.stack((begin, end, end + count), axis=1),
            np.stack((begin, end + count, begin + count), axis=1),
        )
    )
    vertices = np.column_stack((np.tile(corners, (2, 1)), np.repeat([0.0, 1.5], count)))
    return vertices, triangles


@pytest.mark.parametrize(
    ("face", "area", "turn"),
    [
        *((ANGLE, 3.0, turn) for turn in range(len(ANGLE))),
        *((SLOTTED, 90.0, turn) for turn in range(len(SLOTTED))),
    ],
)
def test_however_its_faces_are_cut_a_part_covers_the_same(face, area, turn):
    part = part_from_mesh(*block_of_fans(face, turn))
    ends = [pose for pose in resting_poses(part).poses if abs(pose.down[2]) > 0.9]
    assert len(ends) == 2
    for pose in ends:
        ((boundary,),) = outline_at(part, pose)
        assert area_of(boundary) == pytest.approx(area, rel=1e-6)


def test_a_finer_mesh_covers_the_same(block):
    part, pose = block
    mesh = Mesh64(
        part.surface_vertices.copy(), part.surface_triangles.astype(np.uint64)
    )
    fine_part = part_from_mesh(*surface(Manifold(mesh).refine(12)), unit="m")
    assert len(fine_part.triangles) > 100 * len(part.triangles)
    (outline,) = outline_at(part, pose)
    (fine_outline,) = outline_at(fine_part, pose)
    for ring, fine_ring in zip(outline, fine_outline, strict=True):
        assert area_of(fine_ring) == pytest.approx(area_of(ring), rel=1e-7)


def test_what_is_no_height_part_or_pose_is_refused():
    part = part_of("clamp")
    pose = resting_poses(part).poses[0]
    for height in (math.nan, math.inf, "high", (0.1, 0.2)):
        with pytest.raises(PoseStatsError, match="metres"):
            outline_at(part, pose, height)
    for arguments in ((part, 0), (pose, part), (part, None)):
        with pytest.raises(PoseStatsError, match="a Part and one of its poses"):
            outline_at(*arguments)


def test_for_an_open_surface_its_hull_stands_in():
    vertices, triangles = demo_parts.DEMO_PARTS["clamp"]()
    part = part_from_mesh(vertices, triangles[100:], unit="mm")
    assert any(warning.code == "OPEN_MESH" for warning in part.warnings)
    pose = resting_poses(part).poses[0]
    ((boundary,),) = outline_at(part, pose)
    assert area_of(boundary) == pytest.approx(area_of(pose.outline), rel=1e-6)

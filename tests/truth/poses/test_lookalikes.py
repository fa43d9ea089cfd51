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

"""Poses that look alike from above: closed forms, and points looked at singly."""

import math
from itertools import combinations
from typing import NamedTuple

import numpy as np
import pytest
from manifold3d import CrossSection, Manifold
from matplotlib.path import Path

from lab.bodies import shapes
from lab.bodies.catalogue_parts import random_part
from lab.bodies.fine_parts import surface
from lab.bodies.variants import moved, rotation
from ros_pose_stats import (
    PoseStatsError,
    estimate,
    find_lookalikes,
    outline_at,
    part_from_mesh,
)
from ros_pose_stats.core.resting.silhouettes import ALIKE
from ros_pose_stats.core.shapes import demo_parts

MM = 1e-3
PLATE = (40.0, 30.0)
TALL = [(0.0, 0.0), (30.0, 0.0), (30.0, 8.0), (8.0, 8.0), (8.0, 20.0), (0.0, 20.0)]
EVEN = [(0.0, 0.0), (30.0, 0.0), (30.0, 8.0), (8.0, 8.0), (8.0, 30.0), (0.0, 30.0)]
"""Angles with arms of two lengths and of one."""


def pairs_of(body, pixel=None):
    """The part's answer, and pairs of its poses that look alike, of two groups."""
    part = part_from_mesh(*body, unit="mm")
    statistics = find_lookalikes(estimate(part, "area"), part, pixel)
    poses = statistics.by_index
    pairs = {
        (index, other)
        for index, pose in poses.items()
        for other in pose.alike_from_above
    }
    assert pairs == {(other, index) for index, other in pairs}
    assert all(index != other for index, other in pairs)
    for index, other in combinations(poses, 2):
        if poses[index].group == poses[other].group:
            assert (index, other) in pairs
    return statistics, {
        (index, other)
        for index, other in pairs
        if index < other and poses[index].group != poses[other].group
    }


def look_alike(body, first_down, second_down, pixel=None):
    """Whether two sides that it can lie on look alike, by their `down`."""
    statistics, _ = pairs_of(body, pixel)
    first, second = (
        max(statistics.poses, key=lambda pose, down=down: pose.down @ down)
        for down in (np.array(first_down), np.array(second_down))
    )
    assert first.index != second.index
    return second.index in first.alike_from_above


def on_its_faces(body, pixel=None):
    """The same of the two ends along z."""
    return look_alike(body, (0.0, 0.0, -1.0), (0.0, 0.0, 1.0), pixel)


def plate(*cutters, thickness=6.0):
    """40 by 30 by 6 mm about the origin, without what cutters take away."""
    block = Manifold.cube((*PLATE, thickness), center=True)
    for cutter in cutters:
        block -= cutter
    return surface(block)


def hole(radius, x, y, depth=20.0):
    """A hole that is that deep from z = -10 on; a pocket where it ends in the plate."""
    cylinder = Manifold.cylinder(depth, radius, circular_segments=96)
    return cylinder.translate((x, y, -10.0))


def test_a_cube_looks_the_same_on_all_sides():
    statistics, pairs = pairs_of(shapes.box(20.0, 20.0, 20.0))
    assert not pairs
    for pose in statistics.poses:
        others = set(range(6)) - {pose.index}
        assert set(pose.alike_from_above) == others


def test_the_sides_of_a_box_are_alike_in_twos():
    statistics, pairs = pairs_of(shapes.box(50.0, 30.0, 20.0))
    assert not pairs
    for pose in statistics.poses:
        (opposite,) = pose.alike_from_above
        assert statistics.by_index[opposite].down == pytest.approx(-pose.down)


@pytest.mark.parametrize("factor", [0.9, 1.1])
@pytest.mark.parametrize("pixel", [None, 0.05, 0.5])
def test_two_rectangles_of_one_length_differ_by_a_strip(factor, pixel):
    """A rectangle of 50 by 20, and one wider by as much as is open, times a factor.

    The wider one has the narrow one in it at best, so they differ by 50 times that.
    """
    open_area = 0.5 * pixel * 140.0 if pixel else ALIKE * 1000.0
    width = 20.0 + factor * open_area / 50.0
    body = shapes.box(50.0, width, 20.0)
    alike = look_alike(body, (0, 0, -1.0), (0, -1.0, 0), pixel and pixel * MM)
    assert alike == (factor < 1.0)


@pytest.mark.parametrize(("depth", "alike"), [(2.9, True), (3.4, False)])
def test_a_corner_that_is_missing_is_laid_on_the_other_corners(depth, alike):
    """A groove of 3 mm along one edge, of 0.9 or 1 % of what is seen along it.

    Centroid on centroid the outlines would differ by up to three times that.
    """
    bar = Manifold.cube((50.0, 20.0, 20.0)).translate((-25.0, -10.0, -10.0))
    groove = Manifold.cube((3.0, depth, 40.0)).translate((22.0, -10.0, -20.0))
    body = moved(surface(bar - groove), rotation(2))
    down = rotation(2) @ np.eye(3)
    assert look_alike(body, -down[:, 2], -down[:, 1]) == alike


def test_mirror_images_are_not_alike():
    angle = Manifold.extrude(CrossSection([np.array(TALL)]), 5.0)
    for body in (angle, angle.mirror((1.0, 0.0, 0.0))):
        assert not on_its_faces(surface(body))
        # Arm on arm, one upside down, they differ by two ends of 8 by 10 mm.
        assert not on_its_faces(surface(body), 1.0 * MM)
        assert on_its_faces(surface(body), 8.0 * MM)


def test_an_angle_that_is_its_own_mirror_image_looks_the_same_on_both_sides():
    angle = Manifold.extrude(CrossSection([np.array(EVEN)]), 5.0).translate((0, 0, -3))
    pocket = Manifold.cube((4.0, 4.0, 4.0)).translate((2.0, 20.0, -5.0))
    assert pairs_of(surface(angle - pocket))[1]
    assert on_its_faces(surface(angle - pocket))


def test_a_pocket_is_not_seen_from_above():
    assert on_its_faces(plate(hole(3.0, 0.0, 0.0, 10.0)))
    assert on_its_faces(plate(hole(3.0, 7.0, 5.0, 10.0)), 0.01 * MM)


@pytest.mark.parametrize(("radius", "alike"), [(1.3, True), (1.46, False)])
def test_a_hole_is_seen_at_two_places_if_it_is_large(radius, alike):
    """Off both axes it lies mirrored, so that all of two holes differs.

    They have 1 % of the area at a radius of 1.38 mm, less what they take away.
    """
    pocket = hole(1.0, -8.0, 0.0, 9.0)
    assert on_its_faces(plate(hole(radius, 7.0, 5.0), pocket)) == alike


def test_a_pixel_decides_whether_a_hole_is_seen():
    """Two holes of 3 mm differ; half a pixel along all edges of the plate is open."""
    body = plate(hole(1.5, 7.0, 5.0), hole(1.0, -8.0, 0.0, 9.0))
    pixel = 2.0 * 2.0 * math.pi * 1.5**2 / (140.0 + math.pi * 3.0)
    assert on_its_faces(body, 1.05 * pixel * MM)
    assert not on_its_faces(body, 0.95 * pixel * MM)


def disc(*cutters):
    """30 mm wide, 5 mm thick, without what cutters take away, turned anyhow."""
    body = Manifold.cylinder(5.0, 15.0, circular_segments=192, center=True)
    for cutter in cutters:
        body -= cutter
    return surface(body.rotate((0.0, 0.0, 17.3)))


def test_a_disc_with_one_hole_is_its_own_mirror_image():
    assert on_its_faces(disc(hole(3.0, 8.0, 1.0)), 0.05 * MM)
    pocket = hole(2.0, -3.0, 4.0, 10.0)
    assert on_its_faces(disc(hole(3.0, 8.0, 1.0), pocket), 0.05 * MM)


def test_holes_tell_the_sides_of_a_disc_apart():
    holes = hole(3.0, 9.0, 0.0), hole(2.0, -1.0, 9.0), hole(1.0, -5.0, -4.0)
    assert not on_its_faces(disc(*holes))


def test_an_edge_may_run_through_the_centroid():
    """Of a fork whose slot ends just there; a pocket parts its two faces."""
    depth = 0.5 * (36.0 - math.sqrt(864.0))
    ends = [(4.0, 6.0), (4.0, 6.0 - depth), (2.0, 6.0 - depth), (2.0, 6.0)]
    fork = [(0.0, 0.0), (6.0, 0.0), (6.0, 6.0), *ends, (0.0, 6.0)]
    body = Manifold.extrude(CrossSection([np.array(fork)]), 1.0)
    pocket = Manifold.cube((1.0, 1.0, 1.0)).translate((0.5, 0.5, 0.5))
    for turn in (0.0, 31.0):
        assert on_its_faces(surface((body - pocket).rotate((0.0, 0.0, turn))))


def test_neither_place_nor_size_matters():
    for number in (1, 4, 6):
        body = random_part(5, number)
        _, pairs = pairs_of(body)
        for pose in range(2):
            turned, triangles = moved(body, rotation(pose))
            assert pairs_of((0.1 * turned, triangles))[1] == pairs


class PolarPicture(NamedTuple):
    """A silhouette as points (360 yaws, 40) about its centroid see it, equally."""

    seen: np.ndarray
    radius: float  # of the outermost points, metres


def polar_picture(part, pose):
    """Look at the points singly."""
    polygons = outline_at(part, pose)
    rings = [ring for polygon in polygons for ring in polygon]
    weights = [cross_of(ring) for ring in rings]
    middles = [ring + np.roll(ring, -1, axis=0) for ring in rings]
    moment = sum(
        weight @ middle for weight, middle in zip(weights, middles, strict=True)
    )
    centroid = moment / (3.0 * sum(weight.sum() for weight in weights))
    radius = max(np.hypot(*(ring - centroid).T).max() for ring in rings)
    angle = 2.0 * np.pi * np.arange(360)[:, None] / 360.0
    distance = radius * np.sqrt((np.arange(40) + 0.5) / 40.0)
    points = np.stack((distance * np.cos(angle), distance * np.sin(angle)), axis=-1)
    crossings = sum(
        Path(ring).contains_points(points.reshape(-1, 2) + centroid).astype(int)
        for ring in rings
    )
    return PolarPicture(crossings.reshape(360, 40) % 2 == 1, radius)


def cross_of(ring):
    """Vector products of following corners."""
    x, y = ring.T
    return x * np.roll(y, -1) - y * np.roll(x, -1)


def least_difference(first, second):
    """Share of the area by which two pictures differ at the best of 360 yaws."""
    if not 0.8 < first.radius / second.radius < 1.25:
        return 1.0
    shares = [
        (first.seen != np.roll(second.seen, turn, axis=0)).mean() for turn in range(360)
    ]
    return min(shares) / min(first.seen.mean(), second.seen.mean())


def twin_indices(statistics, pose):
    """Of the poses of a group."""
    return [twin.index for twin in statistics.poses if twin.group == pose.group]


@pytest.mark.parametrize("name", ["clamp", "hex_bolt", "gear", "bracket"])
def test_points_of_all_yaws_agree(name):
    """Where they say that little or much differs, so does the answer."""
    body = demo_parts.DEMO_PARTS[name]()
    statistics, pairs = pairs_of(body)
    part = part_from_mesh(*body, unit="mm")
    pictures = {
        pose.index: polar_picture(part, pose)
        for pose in statistics.poses
        if pose.index == min(twin_indices(statistics, pose))
    }
    for first, second in combinations(sorted(pictures), 2):
        difference = least_difference(pictures[first], pictures[second])
        is_alike = (first, second) in pairs
        if difference < 0.5 * ALIKE:
            assert is_alike
        elif difference > 4.0 * ALIKE:
            assert not is_alike


def test_pictures_of_one_outline_differ_by_up_to_half_a_pixel_along_it():
    """Of an angle that lies anyhow, as two rasters of points see it."""
    draw = np.random.default_rng(3)
    pixel = 0.7
    node = np.arange(-60.0, 60.0, pixel)
    points = np.stack(np.meshgrid(node, node), axis=-1).reshape(-1, 2)
    length = sum(
        math.dist(a, b) for a, b in zip(TALL, TALL[1:] + TALL[:1], strict=True)
    )
    shares = []
    for _ in range(60):
        turn = draw.uniform(0.0, 2.0 * np.pi)
        matrix = np.array(
            [[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]]
        )
        outline = np.array(TALL) @ matrix
        pictures = [
            Path(outline + draw.uniform(0.0, pixel, 2) + shift).contains_points(points)
            for shift in (0.0, draw.uniform(-0.5 * pixel, 0.5 * pixel, 2))
        ]
        shares.append((pictures[0] != pictures[1]).sum() * pixel / length)
    assert 0.2 < np.mean(shares) < 0.5


def test_what_is_no_pixel_or_of_another_part_is_refused():
    part = part_from_mesh(*shapes.box(1.0, 2.0, 3.0))
    statistics = estimate(part, "area")
    for pixel in (0.0, -1e-4, math.nan, math.inf, "fine"):
        with pytest.raises(PoseStatsError, match="a pixel larger than 0 m"):
            find_lookalikes(statistics, part, pixel)
    other = part_from_mesh(*shapes.box(1.0, 2.0, 4.0))
    with pytest.raises(PoseStatsError, match="statistics of the part"):
        find_lookalikes(statistics, other)
    with pytest.raises(PoseStatsError, match="got Part"):
        find_lookalikes(part, statistics)

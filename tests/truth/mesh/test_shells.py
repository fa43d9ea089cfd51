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

"""Several closed surfaces in one mesh, wound as they may be: voids, bodies and
overlap.
"""

import numpy as np
import pytest
import trimesh
from hypothesis import given, strategies

from ros_pose_stats import part_from_mesh
from tests.answers import acting_codes, codes

WATER = 1000.0
TURN = trimesh.transformations.rotation_matrix(0.3, (1, 2, 3))


def box(extents, center=(0, 0, 0), inward=False):
    mesh = trimesh.creation.box(extents)
    mesh.apply_translation(center)
    if inward:
        mesh.invert()
    return mesh


def part_of(*meshes, unit="cm"):
    mesh = trimesh.util.concatenate(meshes)
    return part_from_mesh(
        np.array(mesh.vertices), np.array(mesh.faces), unit=unit, body="all"
    )


def volume_and_overlap(*meshes):
    part = part_of(*meshes)
    assert acting_codes(part) in ([], ["BODIES_OVERLAP"])
    surface = trimesh.Trimesh(
        part.surface_vertices, part.surface_triangles, process=False
    )
    assert surface.is_winding_consistent
    return surface.volume * 1e6, "BODIES_OVERLAP" in codes(part)


@given(strategies.integers(0, 2**32 - 1), strategies.floats(0.0, 1.0))
def test_turned_triangles_are_turned_back(seed, share):
    ball = trimesh.creation.icosphere(2)
    turned = np.random.default_rng(seed).uniform(size=len(ball.faces)) < share
    triangles = np.where(turned[:, None], ball.faces[:, ::-1], ball.faces)
    volume, overlap = volume_and_overlap(
        trimesh.Trimesh(ball.vertices, triangles, process=False)
    )
    assert volume == pytest.approx(ball.volume)
    assert not overlap


@pytest.mark.parametrize("outer_inward", [False, True])
@pytest.mark.parametrize("inner_inward", [False, True])
@pytest.mark.parametrize("turned", [0, 5])
def test_of_two_shells_the_inner_one_is_a_void_unless_both_face_outward(
    outer_inward, inner_inward, turned
):
    outer = box((4, 4, 4), inward=outer_inward)
    inner = box((2, 2, 2), (0.5, 0, 0), inner_inward)
    pair = trimesh.util.concatenate([outer, inner])
    random = np.random.default_rng(turned)
    flipped = random.permutation(12)[:turned]
    pair.faces[flipped] = pair.faces[flipped][:, ::-1]
    pair.faces = random.permutation(pair.faces)
    part = part_of(pair)
    is_body = not outer_inward and not inner_inward
    weight = 8 if is_body else -8
    assert acting_codes(part) == ["BODIES_OVERLAP"] * is_body
    assert part.center_of_mass == pytest.approx(
        [0.005 * weight / (64 + weight), 0, 0], abs=1e-15
    )


@pytest.mark.parametrize(
    "inward", [(False, True, False), (True, False, True), (False, True, True)]
)
@pytest.mark.parametrize("shuffle", [0, 1])
def test_a_body_inside_a_void_is_a_body(inward, shuffle):
    meshes = [
        box((size,) * 3, inward=turned)
        for size, turned in zip((9, 5, 1), inward, strict=True)
    ]
    order = np.random.default_rng(shuffle).permutation(3)
    volume, overlap = volume_and_overlap(*(meshes[k] for k in order))
    assert volume == pytest.approx(729 - 125 + 1)
    assert not overlap


def test_an_inward_box_that_touches_the_wall_from_inside_is_a_void():
    volume, _ = volume_and_overlap(
        box((4, 4, 4)), box((2, 2, 2), (1, 0, 0), inward=True)
    )
    assert volume == pytest.approx(64 - 8)


def test_hundreds_of_shells_in_a_body_are_voids():
    grid = [(x, y, z) for x in range(7) for y in range(7) for z in range(7)]
    volume, overlap = volume_and_overlap(
        *(box((0.5, 0.5, 0.5), center, inward=True) for center in grid),
        box((20, 20, 20), (3, 3, 3)),
    )
    assert volume == pytest.approx(8000 - len(grid) / 8)
    assert not overlap


@pytest.mark.parametrize("inward", [False, True])
def test_bodies_beside_each_other_are_one_part_whatever_their_winding(inward):
    part = part_of(box((1, 1, 1)), box((1, 1, 3), (4, 0, 0), inward))
    assert acting_codes(part) == []
    assert part.center_of_mass == pytest.approx([0.03, 0, 0], abs=1e-15)
    # A pin in a frame is within the frame's box, but not within its metal.
    ring = trimesh.creation.annulus(2.0, 3.0, 4.0, sections=24)
    pin = trimesh.creation.cylinder(1.0, 2.0, sections=16)
    expected = ring.volume + pin.volume
    if inward:
        pin.invert()
    volume, overlap = volume_and_overlap(ring, pin)
    assert volume == pytest.approx(expected)
    assert not overlap


@pytest.mark.parametrize("inward", [False, True])
def test_boxes_that_share_an_edge_are_two_bodies(inward):
    volume, overlap = volume_and_overlap(
        box((1, 1, 1)), box((1, 1, 1), (1, 1, 0), inward)
    )
    assert volume == pytest.approx(2.0)
    assert not overlap


def test_the_wall_between_two_bodies_goes_if_both_have_it():
    first = box((1, 1, 1))
    right = box((1, 1, 1), (1, 0, 0))
    right.vertices = right.vertices * (-1, 1, 1) + (
        2,
        0,
        0,
    )  # so that the diagonals are alike
    right.invert()
    part = part_of(first, right)
    assert len(part.surface_triangles) == 20
    assert acting_codes(part) == []
    assert part.center_of_mass == pytest.approx([0.005, 0, 0], abs=1e-15)
    volume, overlap = volume_and_overlap(first, box((1, 1, 1), (1, 0, 0)))
    assert (volume, overlap) == (pytest.approx(2.0), False)


@pytest.mark.parametrize("turn", [np.eye(4), TURN], ids=["straight", "turned"])
class TestOverlap:
    @pytest.mark.parametrize("height", [0.8, 1.0, 1.3])
    def test_crossed_bars_overlap(self, turn, height):
        bars = [box((6, 1, 1)), box((1, 6, height))]
        for bar in bars:
            bar.apply_transform(turn)
        assert volume_and_overlap(*bars) == (pytest.approx(6 + 6 * height), True)

    @pytest.mark.parametrize(
        "extents", [(1, 6, 1), (6, 1, 1), (6, 6, 1), (0.4, 0.5, 1)]
    )
    def test_bars_that_touch_face_to_face_do_not(self, turn, extents):
        bars = [box((6, 1, 1)), box(extents, (0, 0, 1))]
        for bar in bars:
            bar.apply_transform(turn)
        assert not volume_and_overlap(*bars)[1]

    @pytest.mark.parametrize(
        ("distance", "overlap"), [(1.7, True), (1.99, True), (2.01, False)]
    )
    def test_balls_do_when_they_are_closer_than_two_radii(
        self, turn, distance, overlap
    ):
        ball = trimesh.creation.icosphere(4)
        second = trimesh.creation.icosphere(4)
        second.apply_translation((distance, 0, 0))
        for mesh in (ball, second):
            mesh.apply_transform(turn)
        assert volume_and_overlap(ball, second)[1] == overlap

    @pytest.mark.parametrize(("depth", "share"), [(6e-3, "0.12"), (2e-3, "0.04")])
    def test_a_share_too_small_to_move_the_centre_of_mass_is_a_note(
        self, turn, depth, share
    ):
        part = part_of(
            *(
                bar.apply_transform(turn)
                for bar in (box((1, 1, 1)), box((1, 0.5, 0.5), (1 - depth, 0, 0)))
            )
        )
        (warning,) = part.warnings
        assert (warning.code, warning.acts) == ("BODIES_OVERLAP", depth == 6e-3)
        assert f" and {share} % of the volume" in warning.text

    def test_a_peg_flush_in_its_hole_does_not(self, turn):
        ring = trimesh.creation.annulus(1.0, 2.0, 1.0, sections=24)
        for shift, overlap in ((0.0, False), (0.05, True)):
            peg = trimesh.creation.cylinder(1.0, 3.0, sections=24)
            peg.apply_translation((shift, 0.0, 0.0))
            pair = [ring.copy(), peg]
            for mesh in pair:
                mesh.apply_transform(turn)
            assert volume_and_overlap(*pair)[1] == overlap


def test_thousands_of_needles_that_lie_across_each_other():
    """Every pair of their boxes meets; to test them all took minutes."""
    count = 3000
    chance = np.random.default_rng(0)
    ends = chance.uniform(-0.5, 0.5, (2, count, 3))
    offsets = 4e-6 * chance.normal(size=(2, count, 3))
    corners = np.stack(
        [ends[0], ends[1], ends[0] + offsets[0], ends[1] + offsets[1]], axis=1
    )
    rows = np.array([(0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)])
    needles = trimesh.Trimesh(
        corners.reshape(-1, 3),
        (rows + 4 * np.arange(count)[:, None, None]).reshape(-1, 3),
        process=False,
    )
    assert acting_codes(part_of(needles)) == []

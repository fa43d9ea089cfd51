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

"""Round surfaces stand as polygons of one number of sides, whatever the file's own
division.

At a cluster tolerance of 0 the stable poses show the polygons: one for each facet that
holds.
"""

import numpy as np
import pytest
import trimesh

from lab.bodies import exports, shapes
from lab.bodies.samples import random_polyhedron
from lab.bodies.variants import in_float32, moved, printed, rotation, shuffled
from ros_pose_stats import estimate, part_from_mesh, resting_poses
from tests.matching import downs

SIDES = 192
ARC = 1.0 - np.cos(np.pi / SIDES)
"""Height of the arc over a side, in radii: 1.3e-4."""

EXPORTED = (16, 24, 64, 512, 2048)

TURNED = {
    "coin": lambda n, a: exports.cylinder(n, 0.3, a),
    "rod": lambda n, a: exports.cylinder(n, 3.0, a),
    "ring": exports.ring,
    "shaft": exports.shaft,
    "frustum": exports.frustum,
}


def poses_of(surface, tolerance=0.0, sides=SIDES):
    return resting_poses(part_from_mesh(*surface), tolerance, sides).poses


def answer(surface):
    """Poses in the order of their index, with probabilities."""
    statistics = estimate(part_from_mesh(*surface), "meae")
    return sorted(statistics.poses, key=lambda pose: pose.index)


def is_rounded(surface):
    return any(
        warning.code == "ROUNDED"
        for warning in estimate(part_from_mesh(*surface), "csae").warnings
    )


def of_size(poses, members):
    """The pose that gathers so many faces."""
    (pose,) = (pose for pose in poses if len(pose.members) == members)
    return pose


@pytest.mark.parametrize("name", TURNED)
def test_turned_parts_are_alike_from_every_file(name):
    """Float32 rounds to 6e-8 of the size; facets of 1/30 radius turn by some 2e-6."""
    starts = np.random.default_rng(1).uniform(0.0, 6.0, len(EXPORTED))
    answers = [
        answer(in_float32(TURNED[name](n, a)))
        for n, a in zip(EXPORTED, starts, strict=True)
    ]
    for poses in answers:
        assert of_size(poses, SIDES).rolls
        for field in ("height", "top", "barrier", "margin", "probability"):
            assert [getattr(pose, field) for pose in poses] == pytest.approx(
                [getattr(pose, field) for pose in answers[0]], abs=5e-6
            )


@pytest.mark.parametrize(
    ("sides", "round_sides"), [(15, 192), (64, 16), (64, 48), (64, 360), (500, 192)]
)
def test_a_cylinder_has_as_many_facets_as_asked_for_and_its_corners_on_the_circle(
    sides, round_sides
):
    poses = poses_of(in_float32(exports.cylinder(sides, 1.0)), 0.0025, round_sides)
    ends = poses_of(exports.cylinder(sides, 1.0), 0.0, round_sides)
    assert len(ends) == round_sides + 2
    assert min(pose.height for pose in poses) == pytest.approx(
        0.5 * np.cos(np.pi / round_sides), rel=1e-6
    )


@pytest.mark.parametrize("make", [exports.d_shaft, exports.notched_disc, exports.screw])
def test_parts_that_are_round_in_part_differ_by_the_files_own_volume_alone(make):
    """Of a polygon of n sides (2 pi / n)^2 / 6 of the area is missing, the whole shift
    at most.
    """
    finest = answer(in_float32(make(2048)))
    for sides in EXPORTED[:-1]:
        poses = answer(in_float32(make(sides)))
        lost = (2.0 * np.pi / sides) ** 2 / 6.0
        assert len(poses) == len(finest)
        for field in ("height", "barrier", "probability"):
            assert [getattr(pose, field) for pose in poses] == pytest.approx(
                [getattr(pose, field) for pose in finest], abs=lost + ARC
            )


class TestWhatStays:
    @pytest.mark.parametrize(
        ("teeth", "tip", "chamfer"),
        [
            (12, 0.0, 0.03),
            (12, 0.5, 0.0),
            (15, 0.0, 0.0),
            (15, 0.5, 0.03),
            (60, 0.0, 0.03),
            (60, 0.5, 0.0),
        ],
    )
    def test_gears(self, teeth, tip, chamfer):
        surface = in_float32(exports.gear(teeth, tip, chamfer=chamfer))
        assert np.array_equal(
            downs(poses_of(surface)), downs(poses_of(surface, sides=0))
        )
        assert not is_rounded(surface)

    def test_an_open_gear(self):
        vertices, triangles = exports.gear(24, 0.5)
        assert not is_rounded((vertices, triangles[1:]))

    @pytest.mark.parametrize(
        "surface",
        [
            shapes.box(3.0, 2.0, 1.0),
            exports.cylinder(14, 1.0),
            exports.ellipse(64),
            *(random_polyhedron(20 + 40 * seed, seed) for seed in range(20)),
            shapes.hull_mesh(shapes.sphere_points(1000, 1)),
            trimesh.creation.icosphere(subdivisions=2),
        ],
    )
    def test_what_has_no_circle_of_surface(self, surface):
        if isinstance(surface, trimesh.Trimesh):
            surface = surface.vertices, surface.faces
        assert not is_rounded(surface)
        assert np.array_equal(
            downs(poses_of(surface)), downs(poses_of(surface, sides=0))
        )

    @pytest.mark.parametrize("sides", [48, 512])
    @pytest.mark.parametrize("width", [5.0, 20.0])
    def test_a_chord_over_a_notch(self, sides, width):
        poses = poses_of(in_float32(exports.notched_disc(sides, width)))
        half = np.radians(0.5 * width)
        (chord,) = (pose for pose in poses if pose.down[0] > np.cos(0.4 * half))
        lengths = np.linalg.norm(np.diff(chord.support_polygon, axis=0), axis=1)
        assert np.abs(lengths - 2.0 * np.sin(half)).min() < 1e-6

    @pytest.mark.parametrize(
        "angles",
        [np.radians(np.linspace(10.0, 350.0, 341)), exports.circle(15)[1:]],
        ids=["shallow flat of a fine shaft", "a corner of fifteen left out"],
    )
    def test_flats(self, angles):
        """The flat's width is that of the file; 192 sides of a round one would be 0.033
        wide.
        """
        outline = np.column_stack((np.cos(angles), np.sin(angles)))
        poses = poses_of(in_float32(exports.extruded(outline, 0.5)))
        flat = max(poses, key=lambda pose: pose.down[0])
        assert (
            np.abs(np.ptp(flat.support_polygon, axis=0) - 2.0 * np.sin(angles[0])).min()
            < 1e-6
        )


@pytest.mark.parametrize(
    "make",
    [
        lambda: exports.capsule(128),
        lambda: trimesh.creation.icosphere(subdivisions=5),
    ],
    ids=["capsule", "ball"],
)
def test_other_fine_surfaces_are_thinned_to_4000_corners(make):
    surface = make()
    if isinstance(surface, trimesh.Trimesh):
        surface = surface.vertices * (1.0, 0.8, 0.6), surface.faces
    part = part_from_mesh(*in_float32(surface))
    plain, thin = (resting_poses(part, 0.0025, sides) for sides in (0, SIDES))
    assert len(plain.body.points) > 4000 >= len(thin.body.points)
    assert [pose.top for pose in thin.poses] == pytest.approx(
        [pose.top for pose in plain.poses], abs=3e-3 * plain.body.radius
    )


@pytest.mark.parametrize("turn", [np.eye(3), rotation(1)], ids=["straight", "turned"])
def test_flats_between_fine_fillets_are_those_of_the_file(turn):
    """A corner of a flat is farthest out in few directions, and was left out."""
    part = part_from_mesh(*moved(exports.filleted_box(128), turn))
    plain, thin = (resting_poses(part, 0.0025, sides) for sides in (0, SIDES))
    assert len(plain.body.points) > 4000 >= len(thin.body.points)
    assert sorted(np.bincount(plain.group)) == [2, 2, 2]
    np.testing.assert_array_equal(thin.group, plain.group)
    np.testing.assert_array_equal(thin.unit, plain.unit)
    assert thin.symmetries.shape == plain.symmetries.shape == (8, 6)
    for plain_pose, thin_pose in zip(plain.poses, thin.poses, strict=True):
        assert thin_pose.support_polygon == pytest.approx(
            plain_pose.support_polygon, abs=1e-9
        )
        assert thin_pose.height == pytest.approx(plain_pose.height, abs=1e-9)


class TestRoughFiles:
    @pytest.mark.parametrize("sides", [16, 64, 2048])
    @pytest.mark.parametrize(
        "make",
        [exports.ring, lambda n: exports.cylinder(n, 0.02, 0.1)],
        ids=["ring", "disc"],
    )
    def test_six_digits(self, make, sides):
        turn = np.eye(3) if sides == 64 else rotation(5)
        assert len(poses_of(printed(moved(make(sides), turn)))) == SIDES + 2

    @pytest.mark.parametrize("sides", [32, 2048])
    def test_five_digits(self, sides):
        surface = printed(moved(exports.d_shaft(sides), rotation(6)), 5)
        assert len(poses_of(surface)) == 51

    def test_six_digits_of_a_gear_leave_its_ends_flat(self):
        assert len(poses_of(printed(moved(exports.gear(60), rotation(5))))) == 122

    @pytest.mark.parametrize("sides", [24, 64, 512])
    @pytest.mark.parametrize("extra", [-0.5, 0.5])
    def test_half_a_step_at_the_seam(self, sides, extra):
        profile = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.7), (0.0, 0.7)]
        angles = 2.0 * np.pi * np.arange(sides) / (sides + extra)
        assert len(poses_of(in_float32(exports.turned(profile, angles)))) == SIDES + 2

    @pytest.mark.parametrize("last", [(0.5 + 1e-4, -1e-5), (0.5 - 1e-7, -5e-5)])
    def test_a_circle_that_does_not_quite_close(self, last):
        for sides in (16, 512):
            angles = exports.circle(sides)
            outline = np.vstack(
                (0.5 * np.column_stack((np.cos(angles), np.sin(angles))), [last])
            )
            poses = poses_of(in_float32(exports.extruded(outline, 0.7)))
            assert len(poses) == SIDES + 2

    def test_facets_that_are_divided_along_the_rims(self):
        assert is_rounded(trimesh.remesh.subdivide(*exports.cylinder(24, 1.0)))


@pytest.mark.parametrize("make", [exports.screw, exports.d_shaft, exports.ring])
def test_turned_and_in_another_order(make):
    plain = answer(make(50))
    for seed in range(3):
        surface = shuffled(moved(make(50), rotation(seed), (0.3, 0.1, -0.2)), seed)
        poses = answer(surface)
        assert sorted(len(pose.members) for pose in poses) == sorted(
            len(pose.members) for pose in plain
        )
        for field in ("height", "probability"):
            assert sorted(getattr(pose, field) for pose in poses) == pytest.approx(
                sorted(getattr(pose, field) for pose in plain), abs=2.0 * ARC
            )


def test_a_finely_stacked_dome_beside_the_axis_is_thinned():
    """Two hundred rims with forty corners each; of some no corner is left."""
    angle, turn = np.meshgrid(
        np.linspace(0.002, np.pi / 2, 200), 2.0 * np.pi / 40 * np.arange(40)
    )
    dome = 0.2 * np.stack(
        [np.sin(angle) * np.cos(turn), np.sin(angle) * np.sin(turn), np.cos(angle)], -1
    )
    dome += np.array([0.6, 0.6, 0.1])
    plate = shapes.box(2.0, 2.0, 0.2)[0]
    fine, coarse = (
        answer(shapes.hull_mesh(np.vstack([corners.reshape(-1, 3), plate])))
        for corners in (dome, dome[:, ::10])
    )
    for pose, coarse_pose in zip(fine, coarse, strict=True):
        assert pose.probability == pytest.approx(coarse_pose.probability, abs=0.01)

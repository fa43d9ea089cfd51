"""Round surfaces stand as polygons of one number of sides, whatever the file's own division."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from benchmarks.exports import parts as exports
from ros_pose_stats import part_from_mesh, shapes
from ros_pose_stats.resting.convex_body import convex_body
from tests.bodies import moved, rotation

SIDES = 192
HEIGHT_OF_ARC = 1.0 - np.cos(np.pi / SIDES)
EXPORTED = (16, 24, 32, 64, 128, 512, 2048)

# Shape, and its faces once its rounds have 192 sides: ends and strips.
TURNED = {
    "coin": (lambda n, a: exports.cylinder(n, 0.3, a), 194),
    "cylinder": (lambda n, a: exports.cylinder(n, 1.0, a), 194),
    "rod": (lambda n, a: exports.cylinder(n, 3.0, a), 194),
    "ring": (exports.ring, 578),
    "shaft": (exports.shaft, 578),
    "frustum": (exports.frustum, 194),
}


def body_of(surface, sides=SIDES):
    return convex_body(part_from_mesh(*surface), sides)


def sticking_out(points, body):
    """How far the farthest of some points is outside of a body."""
    return max(float((some @ body.arrays.normal.T - body.arrays.distance).max())
               for some in np.array_split(points, len(points) // 500 + 1))


def corners_of(body):
    return body.points[np.unique(body.arrays.corner)]


@pytest.mark.parametrize("name", TURNED)
def test_turned_parts_are_alike_from_every_file(name):
    make, faces = TURNED[name]
    starts = np.random.default_rng(1).uniform(0.0, 6.0, len(EXPORTED))
    bodies = [body_of(exports.in_float32(make(n, a)))
              for n, a in zip(EXPORTED, starts, strict=True)]
    for body in bodies:
        assert body.faces == faces
        for one in ("distance", "area"):
            assert np.sort(getattr(body.arrays, one)) == pytest.approx(
                np.sort(getattr(bodies[0].arrays, one)), abs=2e-6)


@pytest.mark.parametrize("sides", EXPORTED)
@pytest.mark.parametrize(("make", "faces"), [
    (exports.screw, 206), (exports.d_shaft, 163), (exports.notched_disc, 189)],
    ids=("screw", "d_shaft", "notched_disc"))
def test_parts_that_are_round_in_part(make, faces, sides):
    start = {"start": 0.4}
    assert body_of(exports.in_float32(make(sides, **start))).faces == faces


@pytest.mark.parametrize("sides", [16, 24, 32, 64])
def test_corners_of_the_file_stay_where_their_number_divides(sides):
    part = part_from_mesh(*exports.in_float32(exports.ring(sides, 0.2)))
    fine = convex_body(part, SIDES).points
    for corner in convex_body(part, 0).points:
        near = np.linalg.norm(fine - corner, axis=1).min()
        assert near < (3e-7 if SIDES % sides == 0 else 1.0)


@pytest.mark.parametrize("sides", EXPORTED)
def test_nothing_is_lost_beyond_the_height_of_arc(sides):
    for make in (exports.ring, exports.screw, exports.d_shaft, exports.notched_disc):
        part = part_from_mesh(*exports.in_float32(make(sides)))
        plain, body = convex_body(part, 0), convex_body(part, SIDES)
        metres = plain.points * (plain.radius / body.radius)
        assert sticking_out(metres, body) < HEIGHT_OF_ARC + 1e-5
        assert sticking_out(body.points * (body.radius / plain.radius), plain) < (
            1.0 - np.cos(np.pi / min(sides - 1, SIDES)) + 1e-5)  # arcs have longer sides
        assert body.radius == pytest.approx(plain.radius, rel=2e-4)
        assert np.linalg.norm(body.points, axis=1).max() <= 1.0 + 1e-15


class TestWhatStays:
    def test_zero_sides_take_the_file(self):
        part = part_from_mesh(*exports.ring(32))
        assert convex_body(part, 0) is convex_body(part, 0)
        assert convex_body(part, SIDES) is convex_body(part, SIDES)
        assert convex_body(part, 0).faces == 98

    @pytest.mark.parametrize("teeth", [12, 15, 24, 60, 200])
    @pytest.mark.parametrize("tip", [0.0, 0.5])
    def test_gears(self, teeth, tip):
        for chamfer in (0.0, 0.03):
            part = part_from_mesh(*exports.in_float32(exports.gear(teeth, tip, chamfer=chamfer)))
            body = convex_body(part, SIDES)
            assert body.arrays is convex_body(part, 0).arrays and body.rounded == 0

    @pytest.mark.parametrize("sides", [48, 64, 512])
    @pytest.mark.parametrize("width", [5.0, 12.0, 20.0])
    def test_chord_over_a_notch(self, sides, width):
        body = body_of(exports.in_float32(exports.notched_disc(sides, width)))
        half = np.radians(0.5 * width)
        facets = np.abs(body.arrays.normal[:, 2]) < 0.5
        chord = facets & (body.arrays.normal[:, 0] > np.cos(0.4 * half))
        assert chord.sum() == 1
        ends = body.polygon(int(np.flatnonzero(chord)[0]))
        assert np.ptp(ends[:, 1]) == pytest.approx(2.0 * np.sin(half) / body.radius, rel=1e-6)

    def test_shallow_flat_of_a_fine_shaft(self):
        """Its 20 degrees are surface of the part, and no run ends at so small an angle."""
        angles = np.radians(np.linspace(10.0, 350.0, 341))
        outline = np.column_stack((np.cos(angles), np.sin(angles)))
        body = body_of(exports.in_float32(exports.extruded(outline, 0.5)))
        ends = np.abs(body.arrays.normal[:, 2]) > 0.5
        largest = body.arrays.area[~ends].max()
        assert largest > 8.0 * np.median(body.arrays.area[~ends])

    def test_flat_of_a_coarse_shaft(self):
        """A corner left out of fifteen is a flat of 48 degrees."""
        angles = exports.circle(15)[1:]
        outline = np.column_stack((np.cos(angles), np.sin(angles)))
        body = body_of(exports.in_float32(exports.extruded(outline, 0.5)))
        assert body.arrays.area[body.arrays.normal[:, 0].argmax()] > 0.7 * 0.5 / body.radius**2

    @pytest.mark.parametrize("sides", [24, 64, 256, 1024])
    @pytest.mark.parametrize("make", [exports.ellipse, exports.slot, exports.lobed])
    def test_top_and_bottom_are_alike(self, make, sides):
        corners = corners_of(body_of(exports.in_float32(make(sides))))
        low, high = (corners[np.sign(corners[:, 2]) == sign] for sign in (-1, 1))
        assert len(low) == len(high)
        apart = np.abs(low[:, None, :2] - high[None, :, :2]).max(axis=2).min(axis=1)
        assert apart.max() < 1e-6


class TestSize:
    @pytest.mark.parametrize("sides", [16, 32, 64, 128])
    def test_filleted_box(self, sides):
        part = part_from_mesh(*exports.in_float32(exports.filleted_box(sides)))
        most = min(2 * len(convex_body(part, 0).points), 4001)
        assert len(convex_body(part, SIDES).points) < most

    @pytest.mark.parametrize("sides", [16, 32, 64, 128])
    def test_capsule(self, sides):
        body = body_of(exports.in_float32(exports.capsule(sides)))
        assert len(body.points) <= 4000
        # The cylinder between the domes has all its sides.
        facets = np.abs(body.arrays.normal[:, 2]) < 1e-6
        assert facets.sum() == SIDES

    @pytest.mark.parametrize("axes", [(1.0, 1.0, 1.0), (1.0, 0.8, 0.6)])
    def test_blob(self, axes):
        ball = trimesh.creation.icosphere(subdivisions=5)
        part = part_from_mesh(ball.vertices * axes, ball.faces)
        body = convex_body(part, SIDES)
        assert 2000 < len(body.points) <= 4000
        assert sticking_out(convex_body(part, 0).points, body) < 3e-3

    @pytest.mark.parametrize("sides", [16, 32, 64, 128])
    def test_dome(self, sides):
        """All its rims have as many sides, since these decide where it comes to rest."""
        steps = np.radians(np.linspace(0.0, 90.0, sides // 4 + 1))
        dome = [(0.5 * np.cos(a), 0.4 + 0.5 * np.sin(a)) for a in steps[:-1]]
        profile = [(0.0, 0.0), (0.5, 0.0), *dome, (0.0, 0.9)]
        body = body_of(exports.in_float32(exports.turned(profile, exports.circle(sides, 0.2))))
        assert len(body.points) <= 4000
        assert {run.sides for run in body.runs} == {SIDES}

    @pytest.mark.parametrize("sides", [12, 48, 96, 360])
    def test_other_numbers_of_sides(self, sides):
        assert body_of(exports.cylinder(64, 1.0), sides).faces == sides + 2


class TestRoughFiles:
    @pytest.mark.parametrize("sides", [16, 32, 64, 512, 2048])
    @pytest.mark.parametrize("make", [
        lambda n: exports.cylinder(n, 1.0, 0.1), lambda n: exports.cylinder(n, 0.02, 0.1),
        lambda n: exports.ring(n, 0.1)], ids=("cylinder", "disc", "ring"))
    def test_six_digits(self, make, sides):
        for turn in (np.eye(3), rotation(5)):
            body = body_of(exports.printed(moved(make(sides), turn)))
            assert body.faces == (578 if len(body.points) > 400 else 194)

    @pytest.mark.parametrize("sides", [32, 512, 2048])
    def test_five_digits(self, sides):
        surface = moved(exports.d_shaft(sides), rotation(6))
        assert body_of(exports.printed(surface, 5)).faces == 163

    def test_six_digits_of_a_gear_leave_its_ends_flat(self):
        surface = moved(exports.gear(60), rotation(5))
        assert body_of(exports.printed(surface)).faces == 122

    @pytest.mark.parametrize("sides", [16, 32, 64, 512, 2048])
    def test_half_a_step_at_the_seam(self, sides):
        profile = [(0.0, 0.0), (0.5, 0.0), (0.5, 0.7), (0.0, 0.7)]
        for more in (-0.5, 0.5):
            angles = 2.0 * np.pi * np.arange(sides) / (sides + more)
            faces = body_of(exports.in_float32(exports.turned(profile, angles))).faces
            if sides > 16 or more < 0.0:  # else one side takes 33 degrees
                assert faces == 194

    @pytest.mark.parametrize("sides", [16, 32, 64, 512, 2048])
    def test_circle_that_does_not_quite_close(self, sides):
        angles = exports.circle(sides)
        outline = 0.5 * np.column_stack((np.cos(angles), np.sin(angles)))
        for last in ((0.5 + 1e-4, -1e-5), (0.5 - 1e-7, -5e-5)):
            seamed = np.vstack((outline, [last]))
            assert body_of(exports.in_float32(exports.extruded(seamed, 0.7))).faces == 194


class TestStrips:
    def test_facets_of_a_cylinder(self):
        body = body_of(exports.cylinder(32, 1.0))
        around = np.abs(body.arrays.normal[:, 2]) < 0.5
        assert np.array_equal(body.run_of_face, np.where(around, 0, -1))

    def test_each_cone_of_a_ring_has_its_own(self):
        body = body_of(exports.ring(32))
        numbers, faces = np.unique(body.run_of_face, return_counts=True)
        assert numbers.tolist() == [-1, 0, 1, 2] and faces.tolist() == [2, 192, 192, 192]
        for number in numbers[1:]:
            heights = body.arrays.normal[body.run_of_face == number, 2]
            assert np.ptp(heights) < 1e-6

    def test_tip_of_a_cone(self):
        profile = [(0.0, 0.0), (0.5, 0.0), (0.0, 0.7)]
        body = body_of(exports.turned(profile, exports.circle(24)))
        assert (body.run_of_face >= 0).sum() == SIDES

    def test_flat_of_a_shaft_is_none(self):
        body = body_of(exports.d_shaft(48))
        flat = int(body.arrays.normal[:, 0].argmax())
        assert body.run_of_face[flat] == -1
        assert (body.run_of_face >= 0).sum() == 160

    def test_facets_over_the_gaps_of_a_gear(self):
        body = body_of(exports.gear(24, 0.5))
        assert (body.run_of_face >= 0).sum() == 48


class TestTheSamePartDifferently:
    @pytest.mark.parametrize("make", [exports.screw, exports.d_shaft, exports.ring],
                             ids=("screw", "d_shaft", "ring"))
    def test_turned_and_shuffled(self, make):
        vertices, triangles = make(50)
        plain = body_of((vertices, triangles))
        for seed in range(3):
            numbers = np.random.default_rng(seed).permutation(len(vertices))
            turned = moved((vertices, triangles), rotation(seed), (0.3, 0.1, -0.2))[0]
            body = body_of((turned[np.argsort(numbers)], numbers[triangles]))
            assert body.faces == plain.faces
            assert np.sort(body.arrays.distance) == pytest.approx(
                np.sort(plain.arrays.distance), abs=2e-3)

    def test_shuffled_alone_changes_nothing_but_rounding(self):
        vertices, triangles = exports.in_float32(exports.screw(50, 0.2))
        plain = body_of((vertices, triangles))
        numbers = np.random.default_rng(2).permutation(len(vertices))
        body = body_of((vertices[np.argsort(numbers)], numbers[triangles]))
        for point in body.points:
            assert np.abs(plain.points - point).max(axis=1).min() < 1e-12

    def test_box_is_left_alone(self):
        part = part_from_mesh(*shapes.box(3.0, 2.0, 1.0))
        assert convex_body(part, SIDES).arrays is convex_body(part, 0).arrays

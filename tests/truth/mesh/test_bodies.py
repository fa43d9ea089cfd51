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

"""Several bodies in one mesh: what is one part, what are several, and what is loose."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, strategies
from manifold3d import Manifold

from ros_pose_stats import PoseStatsError, estimate, part_from_mesh
from ros_pose_stats.core.mesh.bodies import separation
from tests.answers import codes

TURN = trimesh.transformations.rotation_matrix(0.7, (1, 2, 3))


def box(extents, center=(0, 0, 0)):
    mesh = trimesh.creation.box(extents)
    mesh.apply_translation(center)
    return mesh


def wedge(center=(0, 0, 0), mirrored=False):
    """A body without any symmetry."""
    corners = np.array([(0, 0, 0), (6, 0, 0), (0, 4, 0), (0, 1, 3), (2, 1, 1.5)])
    mesh = trimesh.convex.convex_hull(corners * ((-1, 1, 1) if mirrored else (1, 1, 1)))
    mesh.apply_translation(center)
    return mesh


def part_of(*meshes, **options):
    mesh = trimesh.util.concatenate(meshes)
    return part_from_mesh(mesh.vertices, mesh.faces, unit="mm", **options)


def turned(mesh, seed):
    """The mesh turned and moved, with its vertices in another order."""
    random = np.random.default_rng(seed)
    moved = mesh.copy()
    moved.apply_transform(
        trimesh.transformations.random_rotation_matrix(random.random(3))
    )
    moved.apply_translation((0, 50, 0))
    order = random.permutation(len(mesh.vertices))
    corners = np.argsort(order)[moved.faces]
    return trimesh.Trimesh(moved.vertices[order], corners, process=False)


@given(strategies.integers(0, 2**32 - 1))
def test_hulls_are_near_where_the_solid_modeller_says_so(seed):
    random = np.random.default_rng(seed)
    first = random.normal(size=(20, 3)) * random.uniform(0.05, 0.3, 3)
    second = random.normal(size=(15, 3)) * 0.1 + random.normal(size=3) * 0.4
    gap = Manifold.hull_points(first).min_gap(Manifold.hull_points(second), 9.0)
    if abs(gap - separation.NEAR) > 1e-9:
        assert separation.hulls_are_near(first, second) == (gap < separation.NEAR)


@pytest.mark.parametrize("place", [np.eye(4), TURN], ids=["straight", "turned"])
@pytest.mark.parametrize(("gap", "count"), [(0.019, 1), (0.021, 2)])
def test_bodies_nearer_than_two_hundredths_of_the_radius_are_one_part(
    place, gap, count
):
    """Two boxes in a row, whose radius is half the diagonal around both."""
    radius = np.linalg.norm((10.0, 3.0, 3.0))
    pair = [box((10, 6, 6)), box((10 - gap * radius, 6, 6))]
    pair[0].apply_translation((-5, 0, 0))
    pair[1].apply_translation((5 + gap * radius / 2, 0, 0))
    for mesh in pair:
        mesh.apply_transform(place)
    if count == 1:
        part = part_of(*pair)
        assert (part.bodies, len(part.triangles)) == (1, 24)
    else:
        with pytest.raises(PoseStatsError, match="2 that stand apart and differ"):
            part_of(*pair)


def test_what_joins_a_hull_may_meet_what_was_apart():
    """A ball within four bars that make a frame, and beside none of them."""
    ball = trimesh.creation.icosphere(1, radius=2)
    bars = [
        box((40, 2, 2), (0, 19, 0)),
        box((40, 2, 2), (0, -19, 0)),
        box((2, 40, 2), (19, 0, 2)),
        box((2, 40, 2), (-19, 0, 2)),
    ]
    part = part_of(ball, *bars)
    assert (part.bodies, codes(part)) == (1, ["BODIES_LOOSE"])
    assert part_of(*bars).warnings == ()


@pytest.mark.parametrize("seed", range(3))
def test_equal_bodies_are_one_part_wherever_they_lie(seed):
    alone = part_of(wedge())
    part = part_of(wedge(), turned(wedge(), seed), wedge((0, -50, 0)))
    assert (part.bodies, codes(part)) == (3, ["BODIES_APART"])
    assert part.digest == alone.digest
    assert (part.vertices == alone.vertices).all()
    shares = [pose.probability for pose in estimate(part, "split").poses]
    assert shares == [pose.probability for pose in estimate(alone, "split").poses]
    round_body = trimesh.creation.cylinder(3, 8, sections=60)
    assert part_of(round_body, turned(round_body, seed)).bodies == 2


def test_a_mirrored_body_is_another_one():
    with pytest.raises(PoseStatsError, match="2 that stand apart and differ"):
        part_of(wedge(), wedge((50, 0, 0), mirrored=True))
    # Of a body with a plane of symmetry both are the same.
    pair = box((1, 2, 3)), box((1, 2, 3), (40, 0, 0))
    pair[1].vertices[:, 0] *= -1
    pair[1].invert()
    assert part_of(*pair).bodies == 2


def test_bodies_are_numbered_by_size_and_equal_ones_as_they_come():
    meshes = [box((2, 2, 2)), box((3, 4, 5), (20, 0, 0)), box((2, 2, 2), (40, 0, 0))]
    with pytest.raises(PoseStatsError) as refusal:
        part_of(*meshes)
    assert "0: 3 x 4 x 5, 1: 2 x 2 x 2, 2: 2 x 2 x 2 mm" in str(refusal.value)
    centers = [part_of(*meshes, body=k).center_of_mass[0] for k in range(3)]
    assert centers == pytest.approx([0.02, 0.0, 0.04])
    part = part_of(*meshes, body=1)
    assert (part.bodies, codes(part)) == (3, [])
    assert part.digest == part_of(meshes[0]).digest
    everything = part_of(*meshes, body="all")
    assert (everything.bodies, codes(everything)) == (1, ["BODIES_LOOSE"])
    with pytest.raises(PoseStatsError, match="a body from 0 to 2, got 3"):
        part_of(*meshes, body=3)
    with pytest.raises(PoseStatsError, match="a body from 0 to 0, got 1"):
        part_of(meshes[0], body=1)
    assert part_of(meshes[0], body=0).bodies == 1


@pytest.mark.parametrize("body", [-1, 0.5, "first", "0", np.nan, [0]])
def test_what_is_no_number_of_a_body_is_refused(body):
    with pytest.raises(PoseStatsError, match="number of a body, 0 or more, or `all`"):
        part_of(wedge(), body=body)


def test_a_void_is_no_body():
    inner = trimesh.creation.icosphere(2, radius=3)
    inner.invert()
    part = part_of(box((10, 10, 10)), inner)
    assert (part.bodies, codes(part)) == (1, [])


@pytest.mark.parametrize(
    ("gap", "is_loose"), [(0.0, False), (0.02, False), (0.1, True)]
)
def test_a_gap_is_one_where_it_is_wider_than_both_chord_errors(gap, is_loose):
    """A pin in a hole of 48 sides, which is off by r (1 - cos(pi / 48)) = .0107 mm."""
    ring = trimesh.creation.annulus(5, 8, 4, sections=48)
    pin = trimesh.creation.cylinder(5 - gap, 6, sections=48)
    part = part_of(ring, pin)
    assert codes(part) == ["BODIES_LOOSE"] * is_loose


def test_a_long_chain_is_one_loose_part():
    link = trimesh.creation.torus(5, 1, major_sections=12, minor_sections=6)
    links = []
    for k in range(100):
        angle = np.pi / 2 * (k % 2)
        place = trimesh.transformations.rotation_matrix(angle, (1, 0, 0))
        place[0, 3] = 7.5 * k
        links.append(link.copy().apply_transform(place))
    part = part_of(*links)
    assert (part.bodies, codes(part)) == (1, ["BODIES_LOOSE"])


def extruded(outline):
    """A body over an outline (n, 2) that may cross itself."""
    count = len(outline)
    levels = [np.column_stack((outline, np.full(count, z))) for z in (0.0, 0.7)]
    sides = [(k, (k + 1) % count) for k in range(count)]
    walls = [(a, b, b + count) for a, b in sides]
    walls += [(a, b + count, a + count) for a, b in sides]
    fan = range(1, count - 1)
    ends = [(0, k + 1, k) for k in fan] + [
        (count, count + k, count + k + 1) for k in fan
    ]
    return trimesh.Trimesh(np.vstack(levels), walls + ends, process=False)


@pytest.mark.parametrize("place", [np.eye(4), TURN], ids=["straight", "turned"])
@pytest.mark.parametrize("corners", [5, 7])
def test_a_surface_that_runs_through_itself_is_told(place, corners):
    """A star whose outline goes twice around the middle."""
    angle = 4.0 * np.pi / corners * np.arange(corners)
    mesh = extruded(np.column_stack((np.cos(angle), np.sin(angle))))
    mesh.apply_transform(place)
    part = part_of(mesh)
    assert codes(part) == ["BODIES_OVERLAP"]
    assert "the mesh runs through itself" in part.warnings[0].text
    # Sides pass the centre at cos(2 pi / n), and those of the middle end at 1 / cos.
    inner = np.cos(2.0 * np.pi / corners) / np.cos(np.pi / corners)
    middle = inner**2 * np.sin(2.0 * np.pi / corners) / np.sin(4.0 * np.pi / corners)
    told = float(part.warnings[0].text.split(" %")[0].split()[-1])
    assert told == pytest.approx(100.0 * middle, abs=1.0)


def test_a_surface_may_enclose_more_than_its_hull():
    """A coil of two turns, each as good as the whole."""
    angle = np.pi / 4.0 * np.arange(17)
    radius = 1.0 + 0.01 * angle
    coil = radius[:, None] * np.column_stack((np.cos(angle), np.sin(angle)))
    assert codes(part_of(extruded(coil))) == ["BODIES_OVERLAP"]

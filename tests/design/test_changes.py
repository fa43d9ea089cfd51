"""Changed parts against parts that were modelled anew, and shares with a closed form."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import estimate, part_from_mesh, shapes
from ros_pose_stats.design.changes import DesignSpace
from ros_pose_stats.design.describe import name_step
from ros_pose_stats.design.shares import WantedShare
from ros_pose_stats.errors import MeshError
from ros_pose_stats.mesh.hull import hull_of_corners
from ros_pose_stats.records import DropScene
from ros_pose_stats.shapes.demo_parts import clamp

SIZES = (20e-3, 30e-3, 50e-3)


def space_of(part):
    return DesignSpace(part)


def box_part(*sizes):
    return part_from_mesh(*shapes.box(*sizes))


def feature(space, kind, near):
    """Number of the feature of a kind whose anchor is nearest to a direction."""
    anchors = [one.anchor @ np.array(near) if one.kind == kind else -np.inf
               for one in space.features]
    return int(np.argmax(anchors))


def assert_same_body(part, other):
    assert part.mass == pytest.approx(other.mass, rel=1e-9)
    np.testing.assert_allclose(part.center_of_mass, other.center_of_mass, atol=1e-11)
    np.testing.assert_allclose(part.inertia, other.inertia, rtol=1e-8,
                               atol=1e-9 * other.inertia.max())
    for one in (part.surface_vertices, other.surface_vertices):
        assert len(one) == len(other.surface_vertices)
    gap = np.linalg.norm(part.surface_vertices[:, None] - other.surface_vertices[None], axis=2)
    assert gap.min(axis=1).max() < 1e-9


@pytest.fixture(scope="module")
def space():
    """Of the box."""
    return space_of(box_part(*SIZES))


class TestBox:
    """Mass 1 kg as it is; a sliver has its density."""

    def test_nothing_changed_is_the_part(self, space):
        assert_same_body(space.change_one(0, 0.0).part, space.part)

    def test_six_faces_and_twelve_edges(self, space):
        kinds = [one.kind for one in space.features]
        assert [kinds.count(kind) for kind in ("centre", "stretch", "face", "edge")] == [
            3, 3, 6, 12]

    def test_stretched(self, space):
        steps = np.zeros(len(space.features))
        steps[3:6] = 0.1, -0.2, 0.05
        expected = part_from_mesh(*shapes.box(*np.array(SIZES) * (1.1, 0.8, 1.05)))
        assert_same_body(space.change(steps).part, expected)

    @pytest.mark.parametrize("step", [3e-3, -3e-3])
    def test_a_face_moved(self, space, step):
        number = feature(space, "face", (0.0, 1.0, 0.0))
        vertices, triangles = shapes.box(SIZES[0], SIZES[1] + step, SIZES[2])
        expected = part_from_mesh(vertices + np.array([0.0, 0.5 * step, 0.0]), triangles,
                                  mass=1.0 + step / SIZES[1])
        assert_same_body(space.change_one(number, step).part, expected)

    def test_an_edge_cut(self, space):
        leg = 4e-3
        number = feature(space, "edge", (1.0, 1.0, 0.0))
        x, y, z = 0.5 * np.array(SIZES)
        outline = [(x, -y), (x, y - leg), (x - leg, y), (-x, y), (-x, -y)]
        points = np.array([(*one, side) for one in outline for side in (-z, z)])
        expected = part_from_mesh(*shapes.hull_mesh(points),
                                  mass=1.0 - 0.5 * leg * leg / (SIZES[0] * SIZES[1]))
        assert_same_body(space.change_one(number, leg).part, expected)

    def test_the_centre_of_mass_moved_keeps_the_inertia(self, space):
        part = space.change_one(1, 2e-3).part
        np.testing.assert_allclose(part.center_of_mass, (0.0, 2e-3, 0.0), atol=1e-15)
        np.testing.assert_allclose(part.inertia, space.part.inertia, rtol=1e-12)

    def test_too_far(self, space):
        with pytest.raises(MeshError, match="change the part less"):
            space.change_one(feature(space, "face", (0.0, 0.0, 1.0)), -60e-3)
        with pytest.raises(MeshError):
            space.change_one(0, 15e-3)


def test_an_estimate_of_a_changed_part_is_that_of_one_modelled_anew(space):
    number = feature(space, "face", (0.0, 0.0, 1.0))
    vertices, triangles = shapes.box(SIZES[0], SIZES[1], SIZES[2] - 8e-3)
    anew = part_from_mesh(vertices - np.array([0.0, 0.0, 4e-3]), triangles)
    for method in ("split", "meae", "area"):
        np.testing.assert_allclose(
            [pose.probability for pose in estimate(space.change_one(number, -8e-3).part,
                                                   method).poses],
            [pose.probability for pose in estimate(anew, method).poses], atol=1e-6)


def test_a_part_with_rounded_edges_and_holes_keeps_its_own_mass_properties():
    part = part_from_mesh(*clamp(), unit="mm")
    space = space_of(part)
    same = space.change_one(0, 0.0).part
    np.testing.assert_allclose(same.center_of_mass, part.center_of_mass, atol=1e-12)
    np.testing.assert_allclose(same.inertia, part.inertia, rtol=1e-9, atol=1e-16)
    before, after = estimate(part), estimate(same)
    assert [pose.index for pose in before.poses] == [pose.index for pose in after.poses]
    np.testing.assert_allclose([pose.probability for pose in after.poses],
                               [pose.probability for pose in before.poses], atol=1e-9)
    # All of its outline's fillets, and the edges between them and the two flat sides.
    assert sum(bool(len(one.planes)) for one in space.features if one.kind == "edge") == 5


def test_a_cylinder_has_two_ends_a_mantle_and_two_rims():
    space = space_of(part_from_mesh(*shapes.cylinder(64, 9e-3, 22e-3)))
    faces = [one for one in space.features if one.kind == "face"]
    assert sorted(len(one.planes) for one in faces) == [1, 1, 192]
    assert [len(one.pairs) for one in space.features if one.kind == "edge"] == [192, 192]
    mantle = [one.kind == "face" and len(one.planes) > 1 for one in space.features].index(True)
    wider = space.change_one(mantle, 0.5e-3)
    assert len(estimate(wider.part).poses) == 3
    assert np.linalg.norm(wider.part.surface_vertices[:, :2], axis=1).max() == pytest.approx(
        9.5e-3, rel=1e-3)


def test_shares_of_a_stretched_box_have_closed_forms(space):
    """`area`: its area's share; `csae`: a rectangle's solid angle, 4 atan(ab / c |(a, b, c)|)."""
    part = space.change_one(5, 0.1).part
    a, b, c = 0.5 * SIZES[0], 0.5 * SIZES[1], 0.55 * SIZES[2]
    for method, share in (("area", 0.5 * a * b / (a * b + b * c + c * a)),
                          ("csae", np.arctan(a * b / (c * np.sqrt(a * a + b * b + c * c)))
                           / np.pi)):
        found = next(pose for pose in estimate(part, method).poses if pose.down[2] > 0.9)
        assert found.probability == pytest.approx(share, rel=1e-9)


class TestTracking:
    def test_poses_that_change_places_in_height_are_the_same_ones(self):
        space = space_of(box_part(20e-3, 21e-3, 50e-3))
        down = next(pose for pose in space.resting.poses if pose.down[0] < -0.9)
        model = WantedShare(space, [down.index], DropScene())
        changed = space.change_one(3, 0.1)
        found = model.estimate(changed)
        expected = next(pose.probability for pose in estimate(
            changed.part, drop_height=model.scene.drop_height).poses if pose.down[0] < -0.9)
        assert found == pytest.approx(expected, abs=1e-12)

    def test_a_pose_that_vanishes_is_named(self):
        space = space_of(part_from_mesh(*shapes.box(*SIZES), center_of_mass=(6e-3, 0.0, 0.0)))
        top = next(pose for pose in space.resting.poses if pose.down[2] > 0.9)
        model = WantedShare(space, [top.index], DropScene())
        # Cut so deep that the centre of mass stands over the cut, not over the face.
        number = feature(space, "edge", (1.0, 0.0, 1.0))
        changed = space.change_one(number, 6e-3)
        assert model.lost(changed) == (top.index,)
        assert model.estimate(changed) == 0.0


def test_a_rounded_edge_is_cut_from_the_chamfer_that_touches_its_rounding():
    radius, leg = 4e-3, 1e-3
    turns = np.linspace(0.0, 0.5 * np.pi, 13) + 0.5 * np.pi * np.arange(4)[:, None]
    middles = np.array([(16.0, 8.0), (-16.0, 8.0), (-16.0, -8.0), (16.0, -8.0)]) * 1e-3
    outline = middles[:, None] + radius * np.stack([np.cos(turns), np.sin(turns)], axis=-1)
    flat = np.concatenate((outline.reshape(-1, 2), np.zeros((52, 1))), axis=1)
    corners = np.concatenate((flat, flat + np.array([0.0, 0.0, 30e-3])))
    space = space_of(part_from_mesh(corners, hull_of_corners(corners)[0]))
    number = next(k for k, one in enumerate(space.features)
                  if one.is_rounded and one.anchor[0] > 0.0 and one.anchor[1] > 0.0)
    assert name_step(space, number, leg).endswith("by 1 mm more than its rounding")
    after = space.change_one(number, leg).part
    bisector = np.array([1.0, 1.0, 0.0]) / np.sqrt(2.0)
    touching = 24e-3 / np.sqrt(2.0) + radius
    assert (after.vertices @ bisector).max() == pytest.approx(touching - leg / np.sqrt(2.0),
                                                              abs=0.02 * radius)

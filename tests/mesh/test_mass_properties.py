"""Volume, centroid and inertia against closed forms, and the rules for given values."""

from __future__ import annotations

import math

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from ros_pose_stats.errors import MassPropertiesError
from ros_pose_stats.mesh.mass_properties import check_given, solid_of
from ros_pose_stats.mesh.parts import part_from_mesh


def box_inertia(x, y, z):
    return np.diag([y * y + z * z, x * x + z * z, x * x + y * y]) / 12.0


def arrays(mesh):
    return np.array(mesh.vertices), np.array(mesh.faces)


@settings(max_examples=50, deadline=None)
@given(st.floats(0.01, 10), st.floats(0.01, 10), st.floats(0.01, 10))
def test_box(x, y, z):
    solid = solid_of(*arrays(trimesh.creation.box((x, y, z))))
    assert solid.volume == pytest.approx(x * y * z, rel=1e-12)
    assert np.abs(solid.centroid).max() < 1e-14 * max(x, y, z)
    expected = x * y * z * box_inertia(x, y, z)
    assert np.abs(solid.inertia - expected).max() < 1e-12 * expected.max()


def test_tetrahedron():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
    solid = solid_of(vertices, np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]]))
    assert solid.volume == pytest.approx(1 / 6, rel=1e-14)
    assert solid.centroid == pytest.approx([0.25, 0.25, 0.25], rel=1e-14)
    # Second moments about the centroid: 1/160 on and -1/480 off the diagonal.
    expected = np.full((3, 3), 1 / 480) + np.eye(3) * (2 / 160 - 1 / 480)
    assert np.allclose(solid.inertia, expected, rtol=0, atol=1e-15)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_random_solids_against_trimesh(seed):
    random = np.random.default_rng(seed)
    mesh = trimesh.convex.convex_hull(random.normal(size=(30, 3)))
    mesh.vertices += 0.2 * random.normal(size=mesh.vertices.shape)
    solid = solid_of(*arrays(mesh))
    reference = mesh.mass_properties
    assert solid.volume == pytest.approx(mesh.volume, rel=1e-10)
    assert solid.centroid == pytest.approx(reference["center_mass"], rel=1e-9, abs=1e-10)
    size = np.abs(reference["inertia"]).max()
    assert np.abs(solid.inertia - reference["inertia"]).max() < 1e-9 * size


@pytest.mark.parametrize("scale", [1e-9, 1.0, 1e9])
@pytest.mark.parametrize("away", [0.0, 1000.0])
def test_scale_and_place_cost_no_digits(scale, away):
    mesh = trimesh.creation.box((1.0, 0.5, 0.25))
    vertices, triangles = arrays(mesh)
    solid = solid_of(scale * (vertices + away), triangles)
    assert solid.volume == pytest.approx(0.125 * scale**3, rel=1e-10)
    expected = 0.125 * box_inertia(1.0, 0.5, 0.25) * scale**5
    assert np.abs(solid.inertia - expected).max() < 1e-10 * expected.max()


def test_a_surface_turned_inside_out_has_negative_volume():
    vertices, triangles = arrays(trimesh.creation.box())
    assert solid_of(vertices, triangles[:, ::-1]).volume == pytest.approx(-1.0)


def test_nothing_given_is_a_uniform_body_of_unit_mass():
    part = part_from_mesh(*arrays(trimesh.creation.box((1, 2, 3))), unit=0.1)
    assert part.mass == 1.0
    assert np.allclose(part.inertia, box_inertia(0.1, 0.2, 0.3), rtol=1e-13, atol=1e-18)


def test_a_centre_of_mass_alone_keeps_the_uniform_central_inertia():
    part = part_from_mesh(*arrays(trimesh.creation.box((1, 1, 1))), [0.2, 0.1, 0.0])
    assert part.center_of_mass.tolist() == [0.2, 0.1, 0.0]
    assert np.allclose(part.inertia, box_inertia(1, 1, 1))


@pytest.mark.parametrize("tensor", [None, np.zeros((3, 3))])
def test_mass_without_a_tensor_scales_the_uniform_one(tensor):
    part = part_from_mesh(*arrays(trimesh.creation.box((1, 1, 1))), None, 0.25, tensor)
    assert part.mass == 0.25
    assert np.allclose(part.inertia, 0.25 * box_inertia(1, 1, 1))


def test_given_properties_are_taken_as_they_are():
    tensor = np.array([[2.0, 0.1, 0.0], [0.1, 3.0, 0.2], [0.0, 0.2, 4.0]])
    part = part_from_mesh(*arrays(trimesh.creation.box()), [0.1, 0, 0], 7.0, tensor)
    assert part.mass == 7.0
    assert part.inertia.tolist() == tensor.tolist()


def test_a_flat_plates_printed_tensor_is_within_the_slack():
    tensor = np.diag([1.0, 1.0, 2.0000005])
    assert np.array_equal(check_given(None, 1.0, tensor).inertia, tensor)


@pytest.mark.parametrize(("mass", "tensor", "message"), [
    (0.0, None, "finite mass above 0 kg, got 0.0 kg"),
    (-1.0, None, "finite mass above 0 kg, got -1.0 kg"),
    (math.nan, None, "finite mass above 0 kg, got nan kg"),
    (math.inf, None, "finite mass above 0 kg"),
    ("heavy", None, "a mass in kilograms, got 'heavy'"),
    (None, np.eye(3), "a mass with the inertia tensor, got a tensor alone"),
    (1.0, np.eye(2), "3 x 3 finite numbers"),
    (1.0, np.full((3, 3), np.nan), "3 x 3 finite numbers"),
    (1.0, "round", "3 x 3 numbers"),
    (1.0, [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]], "symmetric inertia tensor, got opposite entries"),
    (1.0, np.diag([1.0, 1.0, -1.0]), "positive principal moments"),
    (1.0, np.diag([0.0, 1.0, 1.0]), "positive principal moments"),
    (1.0, np.diag([1.0, 1.0, 2.1]), "no one exceeds the sum of the others"),
])
def test_impossible_mass_properties_are_refused(mass, tensor, message):
    with pytest.raises(MassPropertiesError) as refusal:
        part_from_mesh(*arrays(trimesh.creation.box()), None, mass, tensor)
    assert message in str(refusal.value)


@pytest.mark.parametrize(("center", "message"), [
    ([0.7, 0, 0], "0.2 m outside"),
    ([0.5, 0, 0], "on its surface"),
    ([0.1, 0.1], "three finite numbers"),
    ([math.nan, 0, 0], "three finite numbers"),
    ("middle", "three numbers in metres"),
])
def test_an_impossible_centre_of_mass_is_refused(center, message):
    with pytest.raises(MassPropertiesError) as refusal:
        part_from_mesh(*arrays(trimesh.creation.box()), center)
    assert message in str(refusal.value)


def test_a_centre_of_mass_just_inside_is_accepted():
    part = part_from_mesh(*arrays(trimesh.creation.box()), [0.4999999, 0, 0])
    assert part.center_of_mass[0] == 0.4999999

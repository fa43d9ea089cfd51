"""Numbers of a wrong kind or size at the library's door: refused, and nothing dropped unsaid."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import part_from_mesh
from ros_pose_stats.errors import MassPropertiesError, MeshError, RequestError
from ros_pose_stats.resting.convex_body import convex_body
from ros_pose_stats.shapes import box

VERTICES, TRIANGLES = box(1.0, 2.0, 3.0)
EYE = np.eye(3)
HUGE = 10**400


def with_mask(array):
    """The first number masked; what lies under the mask is of no concern."""
    mask = np.zeros(array.shape, dtype=bool)
    mask[0, 0] = True
    return np.ma.masked_array(array, mask)


@pytest.mark.parametrize("vertices", [
    VERTICES + 1j, (VERTICES + 1j).tolist(), (VERTICES * 9).astype("M8[s]"),
    (VERTICES * 9).astype("m8[s]"), [[HUGE, 0, 0]] * 8], ids=[
    "complex", "list of complex", "dates", "durations", "too large a whole number"])
def test_coordinates_that_are_no_real_numbers(vertices):
    with pytest.raises(MeshError, match="vertices as rows of three numbers"):
        part_from_mesh(vertices, TRIANGLES)


def test_masked_coordinates_are_missing():
    with pytest.raises(MeshError, match=r"finite vertices, got \[nan"):
        part_from_mesh(with_mask(VERTICES), TRIANGLES)
    assert len(part_from_mesh(np.ma.masked_invalid(VERTICES), TRIANGLES).triangles) == 12


@pytest.mark.parametrize("vertices", [
    VERTICES.astype(np.longdouble) * np.longdouble("1e400"), VERTICES * 1e308], ids=str)
def test_coordinates_beyond_float64_are_infinite(vertices):
    with pytest.raises(MeshError, match="finite vertices"):
        part_from_mesh(vertices, TRIANGLES, unit=1e3)


@pytest.mark.parametrize("triangles", [
    TRIANGLES.astype(complex), TRIANGLES.astype("M8[s]"), TRIANGLES.astype("m8[s]")])
def test_vertex_numbers_that_are_no_numbers(triangles):
    with pytest.raises(MeshError, match="triangles as rows of three numbers"):
        part_from_mesh(VERTICES, triangles)


def test_masked_vertex_numbers_are_missing():
    with pytest.raises(MeshError, match="whole vertex numbers, got nan in triangle 0"):
        part_from_mesh(VERTICES, with_mask(TRIANGLES))


@pytest.mark.parametrize("properties", [
    {"mass": HUGE}, {"mass": np.array([2.0])}, {"mass": 1j}, {"mass": np.complex128(2.0)},
    {"mass": 1e308}, {"mass": 1e-310},
    {"center_of_mass": np.zeros(3, complex)}, {"center_of_mass": [HUGE, 0, 0]},
    {"center_of_mass": [1e300, 0, 0]}, {"center_of_mass": np.ma.masked_less([-1.0, 0, 0], 0)},
    {"mass": 1.0, "inertia": EYE + 0j}, {"mass": 1.0, "inertia": [[HUGE, 0, 0]] * 3},
    {"mass": 1.0, "inertia": EYE * 1.2e308}, {"mass": 1.0, "inertia": EYE * 1e-320},
    {"mass": 1.0, "inertia": with_mask(EYE)},
], ids=str)
def test_mass_properties_that_are_no_numbers_to_compute_with(properties):
    with pytest.raises(MassPropertiesError):
        part_from_mesh(VERTICES, TRIANGLES, **properties)


@pytest.mark.parametrize("unit", [HUGE, np.array([1.0]), 1j, np.complex128(1.0)], ids=type)
def test_units_that_are_no_number(unit):
    with pytest.raises(RequestError, match="mesh unit"):
        part_from_mesh(VERTICES, TRIANGLES, unit=unit)


@pytest.mark.parametrize("name", [3, np.zeros(3), None], ids=type)
def test_a_name_is_text(name):
    with pytest.raises(RequestError, match="text for part_id"):
        part_from_mesh(VERTICES, TRIANGLES, part_id=name)


def test_a_far_vertex_of_no_triangle_does_not_roughen_the_part():
    # It decides nothing about how well the coordinates of the others are known.
    part = part_from_mesh(np.vstack((VERTICES, np.full(3, 1e9))), TRIANGLES)
    assert part.rounding == part_from_mesh(VERTICES, TRIANGLES).rounding
    assert convex_body(part, 0).tolerance == 1e-6


@pytest.mark.parametrize("mass", [np.eye(3), [1.0] * 100_000, "heavy\nload"], ids=type)
def test_a_refusal_is_one_line_whatever_was_given(mass):
    with pytest.raises(MassPropertiesError) as refusal:
        part_from_mesh(VERTICES, TRIANGLES, mass=mass)
    assert len(str(refusal.value).splitlines()) == 1
    assert len(str(refusal.value)) < 600
    assert str(refusal.value).endswith("give one number")

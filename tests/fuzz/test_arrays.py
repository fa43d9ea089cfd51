"""Arrays of any shape, type and content: a part with sound answers, or one clear error."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays

from ros_pose_stats import PoseStatsError, part_from_mesh
from ros_pose_stats.shapes import box
from tests.fuzz.invariants import faults

VERTICES, TRIANGLES = box(1.0, 2.0, 3.0)

numbers = st.one_of(
    st.floats(), st.floats(-1.0, 1.0), st.floats(-1e9, 1e9), st.integers(-3, 3).map(float))
any_array = arrays.arrays(
    st.one_of(arrays.scalar_dtypes(), st.just(np.dtype(object))),
    arrays.array_shapes(min_dims=0, max_dims=3, min_side=0, max_side=6))
anything = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.complex_numbers() | st.text()
    | st.binary(), lambda inner: st.lists(inner, max_size=4), max_leaves=12)
vertices = arrays.arrays(np.float64, st.tuples(st.integers(0, 9), st.just(3)), elements=numbers)
indices = arrays.arrays(np.int64, st.tuples(st.integers(0, 12), st.just(3)),
                        elements=st.integers(-1, 9))


def judge(*mesh, **options):
    """A part with sound answers or a refusal in one line; anything else is an error."""
    try:
        part = part_from_mesh(*mesh, **options)
        wrong = list(faults(part, np.random.default_rng(0), thorough=False))
    except PoseStatsError as error:
        wrong = [] if len(str(error).splitlines()) == 1 else [str(error)]
    assert wrong == []


@given(vertices, indices)
def test_any_coordinates_and_indices(points, triangles):
    judge(points, triangles)


@given(arrays.arrays(np.float64, (8, 3), elements=st.floats(-1.0, 1.0)))
def test_any_eight_corners(points):
    judge(points, TRIANGLES)


@given(arrays.arrays(np.int64, (8, 3), elements=st.integers(-2, 2)))
def test_corners_of_a_lattice(points):
    judge(points, TRIANGLES)


@given(arrays.arrays(np.int64, st.tuples(st.integers(1, 30), st.just(3)),
                     elements=st.integers(0, 7)))
def test_any_triangles_between_the_corners_of_a_box(triangles):
    judge(VERTICES, triangles)


@given(st.one_of(any_array, anything), st.booleans())
def test_any_object_for_an_array(value, first):
    judge(*((value, TRIANGLES) if first else (VERTICES, value)))


@given(st.sampled_from(("mass", "center_of_mass", "inertia", "unit", "part_id")),
       st.one_of(any_array, anything))
def test_any_object_for_an_option(name, value):
    judge(VERTICES, TRIANGLES, **{name: value})


@given(arrays.arrays(np.float64, 3, elements=numbers), st.floats(),
       arrays.arrays(np.float64, (3, 3), elements=numbers))
def test_any_mass_properties(center, mass, tensor):
    judge(VERTICES, TRIANGLES, center, mass, tensor)
    judge(VERTICES, TRIANGLES, None, mass, 0.5 * tensor + 0.5 * tensor.T)


def test_a_warning_would_be_an_error():
    # The properties above rely on it.
    with pytest.raises(RuntimeWarning):
        np.float64(1e308) * np.float64(1e308)

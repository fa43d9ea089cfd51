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

"""The few inputs of a part that random searches once tripped over, each as small as it
can be.
"""

import json

import numpy as np
import pytest

from lab.bodies import shapes
from lab.bodies.samples import REGULAR_SOLIDS
from lab.bodies.variants import moved, rotation
from ros_pose_stats import (
    estimate,
    estimate_all,
    part_from_mesh,
    resting_poses,
    splitting_graph,
)
from tests.running import refusal_of

VERTICES, TRIANGLES = shapes.box(1.0, 2.0, 3.0)
EYE = np.eye(3)
HUGE = 10**400


def refused(vertices=VERTICES, triangles=TRIANGLES, **options):
    """The one line of a refusal; a warning of numpy would be an error."""
    return refusal_of(part_from_mesh, vertices, triangles, **options)


@pytest.mark.parametrize(
    "options",
    [
        {"mass": 1e-310},
        {"mass": np.array([2.0])},
        {"mass": np.complex128(2.0)},
        {"mass": EYE},
        {"mass": 1.0, "inertia": EYE * 1.2e308},
        {"mass": 1.0, "inertia": [[HUGE, 0, 0]] * 3},
        {"center_of_mass": [HUGE, 0, 0]},
        {"center_of_mass": [1e300, 1e300, 0]},
        {"unit": HUGE},
        {"unit": 1j},
        {"unit": np.array([1.0])},
        {"unit": 1e308},
        {"part_id": None},
        {"triangles": TRIANGLES.astype("M8[s]")},
        {"triangles": TRIANGLES.astype(np.uint64) + 2**63},
        {"vertices": VERTICES.astype("m8[s]")},
        {"vertices": VERTICES * 1e200},
    ],
    ids=str,
)
def test_numbers_beyond_what_can_be_computed_with_are_refused_in_a_line(options):
    refused(**options)


def signalling(kind, bits):
    """Vertices of which one is a NaN of the kind that processors complain of."""
    vertices = VERTICES.astype(f"f{kind}")
    vertices.view(f"u{kind}")[0, 0] = bits
    return vertices


@pytest.mark.parametrize(
    "vertices",
    [signalling(4, 0x7FA00000), signalling(8, 0x7FF4 << 48)],
    ids=["float32", "float64"],
)
def test_a_signalling_nan_is_refused_without_a_warning(vertices):
    assert "finite vertices" in refused(vertices)


@pytest.mark.parametrize(
    "options",
    [
        {"mass": np.array(np.complex128(2 + 1j), dtype=object)},
        {"vertices": [[np.complex128(1 + 1j), 0.0, 0.0], *VERTICES[1:].astype(object)]},
    ],
    ids=str,
)
def test_complex_numbers_among_objects_are_refused(options):
    refused(**options)


def test_a_far_vertex_of_no_triangle_does_not_roughen_the_part():
    """It says nothing of how well the coordinates of the others are known."""
    corners, _ = shapes.box(1.0, 1.0, 1.0)
    corners[0, 0] -= (
        5e-5  # bends faces by less than what rounding at the far vertex would excuse
    )
    vertices, triangles = shapes.hull_mesh(corners)
    plain, with_vertex = (
        resting_poses(part_from_mesh(points, triangles), 0.0).poses
        for points in (vertices, np.vstack((vertices, np.full(3, 1e12))))
    )
    assert [pose.down.tolist() for pose in plain] == [
        pose.down.tolist() for pose in with_vertex
    ]


@pytest.mark.parametrize(
    "surface",
    [
        shapes.box(1.0, 1e-6, 2e-6),
        shapes.prism(24, 1.0, 1e-6),
        (VERTICES * 1e-45, TRIANGLES),
        (VERTICES * 1e45, TRIANGLES),
    ],
    ids=["needle", "plate", "tiny", "huge"],
)
@pytest.mark.parametrize("scene", [{}, {"restitution": 0.999999, "drop_height": 1e100}])
def test_answers_far_from_anything_known_are_numbers(surface, scene):
    """An infinite deviation has once become the error."""
    for answer in estimate_all(part_from_mesh(*surface), **scene):
        json.dumps(answer.as_dict(), allow_nan=False)
        assert sum(pose.probability for pose in answer.poses) == pytest.approx(
            1.0, abs=1e-9
        )


@pytest.mark.parametrize("name", REGULAR_SOLIDS)
def test_saddles_that_tie_but_for_rounding_are_passed_in_order(name):
    """All saddles of a regular solid are as high; a later one may lie lower by
    rounding.
    """
    for seed in range(8):
        part = part_from_mesh(*moved(REGULAR_SOLIDS[name], rotation(seed)))
        resting = resting_poses(part, 0.0)
        for function in ("r", "R"):
            nodes = list(splitting_graph(resting, function).walk())
            assert sum(not node.parts for node in nodes) == len(resting.poses)
            assert all(
                low.level is None or low.level <= node.level
                for node in nodes
                for low in node.parts
            )


def test_split_gives_a_box_the_same_answer_however_it_is_turned():
    """Its saddles tie in fours, and rounding says which comes first."""
    box = shapes.box(1.18968573, 1.32466623, 1.6979521)
    answers = [
        [
            pose.probability
            for pose in estimate(
                part_from_mesh(*moved(box, rotation(seed))),
                "split",
                cluster_tolerance=0.0,
                round_sides=0,
            ).poses
        ]
        for seed in range(20)
    ]
    assert np.ptp(answers, axis=0).max() < 1e-9


@pytest.mark.parametrize(
    "surface",
    [
        # The hull was stalled by thousands of corners on a circle.
        shapes.prism(5_000, 1.0, 0.5),
        (
            np.random.default_rng(1).standard_normal(
                (1000, 3)
            ),  # every edge is shared by hundreds
            np.random.default_rng(1).integers(1000, size=(20_000, 3)),
        ),
    ],
    ids=["ring", "tangle"],
)
def test_large_bad_meshes_come_to_an_end(surface):
    assert estimate(part_from_mesh(*surface), "area").poses

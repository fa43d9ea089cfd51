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

"""Parts from arrays: what is kept, the rules for given mass properties, and what is
refused.
"""

import math
from functools import partial

import numpy as np
import pytest
import trimesh

from lab.bodies import shapes
from lab.bodies.samples import random_polyhedron
from lab.bodies.variants import rotation
from ros_pose_stats import load_part, part_from_mesh, shift_center
from tests.running import answer_json, refusal, refusal_of

BOX = VERTICES, TRIANGLES = shapes.box(1.0, 2.0, 3.0)
UNIFORM = np.diag([13.0, 10.0, 5.0]) / 12.0
EYE = np.eye(3)
HUGE = 10**400

refused = partial(refusal_of, part_from_mesh)


def with_mask(array):
    """The first number masked; what lies under the mask is of no concern."""
    mask = np.zeros(array.shape, dtype=bool)
    mask[(0,) * array.ndim] = True
    return np.ma.masked_array(array, mask)


def test_a_mesh_of_lists_of_whole_floats_and_of_masked_arrays_without_a_mask_is_taken():
    whole = part_from_mesh(*BOX)
    for vertices, triangles in (
        (VERTICES.tolist(), TRIANGLES.tolist()),
        (np.ma.masked_invalid(VERTICES), TRIANGLES.astype(float)),
    ):
        assert part_from_mesh(vertices, triangles).digest == whole.digest
    assert part_from_mesh(trimesh.Trimesh(*BOX, process=False)).digest == whole.digest
    assert "list alone" in refused(VERTICES.tolist())
    assert part_from_mesh(*BOX, unit="cm").vertices == pytest.approx(
        VERTICES * 0.01, rel=1e-15
    )


def test_only_vertices_of_triangles_count():
    lone = np.vstack((VERTICES, np.full(3, 1e9)))
    part = part_from_mesh(lone, TRIANGLES)
    whole = part_from_mesh(*BOX)
    assert part.warnings == whole.warnings
    assert part.rounding == whole.rounding
    assert "outside" in refused(lone, TRIANGLES, [5.0, 0.0, 0.0])


@pytest.mark.parametrize(
    ("properties", "mass", "tensor"),
    [
        ({}, 1.0, UNIFORM),
        ({"center_of_mass": [0.2, 0.1, 0.0]}, 1.0, UNIFORM),
        ({"mass": 0.25}, 0.25, 0.25 * UNIFORM),
        ({"mass": 0.25, "inertia": np.zeros((3, 3))}, 0.25, 0.25 * UNIFORM),
        (
            {
                "mass": 7.0,
                "inertia": [[2.0, 0.1, 0.0], [0.1, 3.0, 0.2], [0.0, 0.2, 4.0]],
            },
            7.0,
            [[2.0, 0.1, 0.0], [0.1, 3.0, 0.2], [0.0, 0.2, 4.0]],
        ),
        # A flat plate's tensor, as CAD systems print it, is within the slack.
        (
            {"mass": 1.0, "inertia": np.diag([1.0, 1.0, 2.0000005])},
            1.0,
            np.diag([1, 1, 2.0000005]),
        ),
        ({"density": 1000.0}, 6000.0, 6000.0 * UNIFORM),
        ({"density": 1000.0, "inertia": EYE}, 6000.0, EYE),
    ],
)
def test_the_rules_for_given_mass_properties(properties, mass, tensor):
    part = part_from_mesh(*BOX, **properties)
    assert part.mass == pytest.approx(mass, rel=1e-14)
    assert part.inertia == pytest.approx(
        np.array(tensor, float), rel=1e-13, abs=1e-15 * mass
    )
    assert part.center_of_mass == pytest.approx(
        properties.get("center_of_mass", [0.0] * 3), abs=1e-16
    )


def test_a_density_is_of_what_the_surface_encloses():
    block = trimesh.creation.box((20.0, 30.0, 40.0))
    hollow = trimesh.util.concatenate([block, trimesh.creation.box((10.0, 10.0, 10.0))])
    hollow.faces[12:] = hollow.faces[12:, ::-1]
    for vertices, triangles, litres in (
        (block.vertices, block.faces[1:], 0.024),  # a hole in it
        (hollow.vertices, hollow.faces, 0.023),
    ):
        assert part_from_mesh(
            vertices, triangles, unit="mm", density=1000
        ).mass == pytest.approx(litres)
    loose = np.random.default_rng(3).uniform(size=(90, 3))
    refusal = refused(loose, np.arange(90).reshape(-1, 3), density=1000)
    assert "volume is not known" in refusal and "give the mass instead" in refusal


def test_the_command_has_mass_and_density_too(tmp_path):
    path = tmp_path / "block.stl"
    trimesh.creation.box((20.0, 30.0, 40.0)).export(path)
    request = "estimate", path, "--unit", "mm", "--method", "area"
    for option, value in (("mass", 0.024), ("density", 1000.0)):
        digest = load_part(path, "mm", **{option: value}).digest
        assert answer_json(*request, f"--{option}", value)["part_digest"] == digest
    assert "not allowed with argument" in refusal(
        *request, "--mass", 1, "--density", 1000
    )
    assert "got 7.85 kg/m³; 1 g/cm³ is 1000" in refusal(*request, "--density", 7.85)
    assert "above 0 kg" in refusal(*request, "--mass", -1)


def test_an_inertia_that_no_material_inside_can_have_is_pointed_out():
    part = part_from_mesh(*shapes.box(0.03, 0.02, 0.01), mass=1.0, inertia=EYE)
    assert any(warning.code == "INERTIA_SUSPECT" for warning in part.warnings)
    end = np.array((0.015, 0.01, 0.005))  # masses at both ends of a diagonal can
    possible = 0.99 * (end @ end * EYE - np.outer(end, end) + 1e-9 * EYE)
    assert (
        part_from_mesh(
            *shapes.box(0.03, 0.02, 0.01), mass=1.0, inertia=possible
        ).warnings
        == ()
    )


@pytest.mark.parametrize(
    ("vertices", "triangles", "message"),
    [
        (np.vstack((VERTICES[:7], [[np.nan] * 3])), TRIANGLES, "nan] at vertex 7"),
        (VERTICES * 1e308, TRIANGLES * 1, "expected an extent from 1e-50 to 1e+50 m"),
        (
            VERTICES.astype(np.longdouble) * np.longdouble("1e400"),
            TRIANGLES,
            "finite vertices",
        ),
        (with_mask(VERTICES), TRIANGLES, "finite vertices, got [nan"),
        (VERTICES[:, :2], TRIANGLES, "vertices of shape (V, 3), got shape (8, 2)"),
        (VERTICES.ravel(), TRIANGLES, "vertices of shape (V, 3), got shape (24,)"),
        ([[0, 0], [1]], TRIANGLES, "vertices as rows of three numbers"),
        ("points", TRIANGLES, "vertices as rows of three numbers"),
        (VERTICES + 1j, TRIANGLES, "vertices as rows of three numbers"),
        (
            (VERTICES * 9).astype("M8[s]"),
            TRIANGLES,
            "vertices as rows of three numbers",
        ),
        ([[HUGE, 0, 0]] * 8, TRIANGLES, "vertices as rows of three numbers"),
        (np.zeros((0, 3)), TRIANGLES, "in triangle 0"),
        (np.ones((8, 3)), TRIANGLES, "only triangles with coincident corners"),
        (VERTICES, TRIANGLES[:, :2], "triangles of shape (T, 3), got shape (12, 2)"),
        (VERTICES, [[0, 1, 2], [0, 1, 2, 3]], "triangles of shape (T, 3)"),
        (VERTICES, [], "at least four triangles, got none"),
        (VERTICES, TRIANGLES + 1, "from 0 to 7, got 8 in triangle"),
        (VERTICES, TRIANGLES - 1, "from 0 to 7, got -1 in triangle"),
        (VERTICES, TRIANGLES + 0.5, "whole vertex numbers, got"),
        (VERTICES, with_mask(TRIANGLES), "whole vertex numbers, got nan in triangle 0"),
        (VERTICES, TRIANGLES.astype("m8[s]"), "triangles as rows of three numbers"),
        (VERTICES, [["a", "b", "c"]], "triangles as rows of three numbers"),
    ],
)
def test_what_is_no_mesh_is_refused_with_the_reason(vertices, triangles, message):
    assert message in refused(vertices, triangles)


@pytest.mark.parametrize("turn", [EYE, rotation(7)], ids=["straight", "turned"])
@pytest.mark.parametrize(
    "extents", [(1, 5e-8, 5e-8), (1, 1, 1e-8), (1, 1, 0), (1, 1e-3, 2e-8)]
)
def test_flat_and_needle_like_point_sets_are_refused(turn, extents):
    flat = shapes.box(1.0, 1.0, 1.0)[0] * extents @ turn.T
    assert "a part at least 1e-07 of its length thick" in refused(flat, TRIANGLES)


@pytest.mark.parametrize(
    ("properties", "message"),
    [
        ({"mass": 0.0}, "finite mass above 0 kg, got 0.0 kg"),
        ({"mass": math.nan}, "finite mass above 0 kg, got nan kg"),
        ({"mass": 1e308}, "a mass from 1e-100 to 1e+100 kg"),
        ({"mass": "heavy\nload"}, "a mass in kilograms, got 'heavy"),
        ({"mass": HUGE}, "a mass in kilograms"),
        ({"mass": 1j}, "a mass in kilograms"),
        ({"mass": [1.0] * 100_000}, "give one number"),
        ({"inertia": EYE}, "a mass with the inertia tensor, got a tensor alone"),
        ({"mass": 1.0, "inertia": np.eye(2)}, "3 x 3 finite numbers"),
        ({"mass": 1.0, "inertia": with_mask(EYE)}, "3 x 3 finite numbers"),
        ({"mass": 1.0, "inertia": "round"}, "3 x 3 finite numbers"),
        ({"mass": 1.0, "inertia": EYE + 0j}, "3 x 3 finite numbers"),
        *(
            (
                {"mass": 1.0, "inertia": EYE * moment},
                "moments of inertia from 3.5e-07 to 3.5e+10 kg m²",
            )
            for moment in (1e-320, 1e-12, 1e30, 1e200)
        ),
        (
            {"mass": 1.0, "inertia": [[1, 0.1, 0], [0, 1, 0], [0, 0, 1]]},
            "symmetric inertia tensor",
        ),
        (
            {"mass": 1.0, "inertia": np.diag([1.0, 1.0, -1.0])},
            "positive principal moments",
        ),
        (
            {"mass": 1.0, "inertia": np.full((3, 3), 1e308)},
            "positive principal moments",
        ),
        (
            {"mass": 1.0, "inertia": np.diag([1.0, 1.0, 2.1])},
            "exceeds the sum of the others",
        ),
        ({"density": 7.85}, "from 20 to 25000 kg/m³, got 7.85 kg/m³; 1 g/cm³ is 1000"),
        ({"density": math.nan}, "got nan"),
        ({"density": "steel"}, "a density in kg/m³"),
        ({"density": 1000.0, "mass": 1.0}, "a mass or a density, got both"),
        ({"center_of_mass": [0.7, 0, 0]}, "(700, 0, 0) mm, 200 mm outside"),
        ({"center_of_mass": [0.5, 0, 0]}, "on its surface"),
        ({"center_of_mass": [1e300, 0, 0]}, "outside"),
        ({"center_of_mass": [1.5e308, 0, 0]}, "outside"),
        ({"center_of_mass": [0.1, 0.1]}, "three finite numbers"),
        ({"center_of_mass": with_mask(np.zeros(3))}, "three finite numbers"),
        ({"center_of_mass": np.zeros(3, complex)}, "three finite numbers in metres"),
        ({"part_id": 3}, "text for part_id"),
    ],
    ids=str,
)
def test_impossible_properties_are_refused_with_the_reason(properties, message):
    assert message in refused(*BOX, **properties)


class TestAShiftOfTheCentre:
    OFFSET = np.array([0.02, -0.03, 0.01])

    def test_gives_the_part_that_is_loaded_with_this_centre(self):
        part = part_from_mesh(*random_polyhedron(12, seed=4), mass=2.0, part_id="stone")
        shifted = shift_center(part, self.OFFSET)
        loaded = part_from_mesh(
            part.vertices,
            part.triangles,
            part.center_of_mass + self.OFFSET,
            2.0,
            part_id="stone",
        )
        assert shifted.digest == loaded.digest != part.digest
        assert np.array_equal(shifted.inertia, part.inertia)
        assert (shifted.part_id, shifted.warnings) == (loaded.part_id, loaded.warnings)
        assert shift_center(part, (0.0, 0.0, 0.0)) is part
        assert shift_center(shifted, -self.OFFSET).center_of_mass == pytest.approx(
            part.center_of_mass, abs=1e-16
        )

    @pytest.mark.parametrize("offset", [(np.nan, 0.0, 0.0), (0.0, 0.0), "up", None])
    def test_is_refused_where_it_is_none(self, offset):
        assert "a shift of the centre of mass of three" in refusal_of(
            shift_center, part_from_mesh(*BOX), offset
        )

    @pytest.mark.parametrize(
        "offset", [(0.6, 0.0, 0.0), (0.5, 0.0, 0.0), (1e30, 0.0, 0.0)]
    )
    def test_is_refused_out_of_the_hull_as_a_given_centre_is(self, offset):
        assert refusal_of(shift_center, part_from_mesh(*BOX), offset) == refused(
            *BOX, offset
        )

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

"""Holes of a mesh: closed where it is plain how, else the hull with the reason."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, strategies

from ros_pose_stats import part_from_mesh
from ros_pose_stats.core.mesh import files, mass_properties
from ros_pose_stats.core.mesh.parts import part_of_file
from ros_pose_stats.core.shapes import demo_parts
from tests.answers import codes
from tests.running import refusal_of

STATED = 1e-3
"""Radii by which the centre of mass may be off where holes were closed."""


def arrays(mesh):
    return np.array(mesh.vertices), np.array(mesh.faces)


def plate_with_bore():
    bore = trimesh.creation.cylinder(0.5, 3.0, sections=24)
    bore.apply_translation((1.0, 0.3, 0.0))
    return trimesh.creation.box((4, 2, 1)).difference(bore)


BODIES = {
    "ring": arrays(trimesh.creation.annulus(0.5, 1.0, 1.0)),
    "plate with a bore": arrays(plate_with_bore()),
    "bracket": demo_parts.DEMO_PARTS["bracket"](),
    "ball": arrays(trimesh.creation.icosphere(2)),
}


def part_of(vertices, triangles):
    return part_from_mesh(vertices, triangles, unit=1e-2)


WHOLE = {name: part_of(*body) for name, body in BODIES.items()}


def why_hull(vertices, triangles):
    """The sentence, of one warning, that the hull stands in."""
    (warning,) = part_of(vertices, triangles).warnings
    assert warning.code == "OPEN_MESH"
    return warning.text


def off(part, whole):
    """Distance of the centres of mass in radii."""
    radius = np.linalg.norm(whole.surface_vertices - whole.center_of_mass, axis=1).max()
    return np.linalg.norm(part.center_of_mass - whole.center_of_mass) / radius


@pytest.mark.parametrize("name", BODIES)
def test_any_one_triangle_may_be_missing(name):
    vertices, triangles = BODIES[name]
    for lost in range(0, len(triangles), max(1, len(triangles) // 40)):
        part = part_of(vertices, np.delete(triangles, lost, axis=0))
        assert codes(part) == ["HOLES_CLOSED"]
        assert "1 hole in the mesh was closed" in part.warnings[0].text
        assert off(part, WHOLE[name]) < 1e-12
        assert len(part.triangles) == len(triangles) - 1
        surface = trimesh.Trimesh(
            part.surface_vertices, part.surface_triangles, process=False
        )
        assert surface.is_watertight
        assert surface.is_winding_consistent


@given(strategies.sampled_from(sorted(BODIES)), strategies.integers(0, 2**32 - 1))
def test_of_a_mesh_with_one_triangle_in_twenty_missing_the_centre_is_right_or_hull(
    name, seed
):
    vertices, triangles = BODIES[name]
    random = np.random.default_rng(seed)
    remaining = random.permutation(triangles[random.random(len(triangles)) > 0.05])
    part = part_of(vertices, remaining)
    if len(remaining) == len(triangles):
        assert codes(part) == []
    elif codes(part) == ["HOLES_CLOSED"]:
        assert off(part, WHOLE[name]) < STATED
    else:
        assert codes(part) == ["OPEN_MESH"]


def test_of_a_ball_such_losses_are_closed_as_a_rule():
    vertices, triangles = BODIES["ball"]
    random = np.random.default_rng(5)
    closed = [
        codes(part_of(vertices, triangles[random.random(len(triangles)) > 0.05]))
        for _ in range(20)
    ]
    assert closed.count(["HOLES_CLOSED"]) == 20


def test_lost_flat_faces_are_closed_exactly():
    vertices, triangles = BODIES["ring"]
    on_top = (vertices[triangles][:, :, 2] > 0.4999).all(axis=1)
    part = part_of(vertices, triangles[~on_top])
    assert "2 holes in the mesh were closed" in part.warnings[0].text
    assert off(part, WHOLE["ring"]) < 1e-12
    surface = trimesh.Trimesh(part.surface_vertices, part.surface_triangles)
    assert surface.area == pytest.approx(
        trimesh.Trimesh(*BODIES["ring"]).area * 1e-4, rel=1e-9
    )  # a ring, not two discs


def test_a_side_divided_by_one_neighbour_only_is_a_slit_and_closed():
    vertices, triangles = arrays(trimesh.creation.box((1, 2, 3)))
    a, b, c = triangles[0]
    middle = 0.3 * vertices[a] + 0.7 * vertices[b]
    part = part_of(
        np.vstack((vertices, middle)), [[a, 8, c], [8, b, c], *triangles[1:].tolist()]
    )
    assert codes(part) == ["HOLES_CLOSED"]
    assert part.center_of_mass == pytest.approx([0, 0, 0], abs=1e-16)


def cracked_solid(width):
    """A box of a STEP file, of size 2, that lacks a sliver of its top."""
    box = trimesh.creation.box((2.0, 2.0, 1.0))
    a, b, c = box.faces[0]
    middle = (box.vertices[a] + box.vertices[c]) / 2.0
    to_corner = box.vertices[b] - middle
    to_corner *= 2.0 * width / np.linalg.norm(to_corner)  # a triangle has half of it
    return files.FileMesh(
        np.vstack((box.vertices, middle + to_corner)),
        [[a, b, 8], [b, c, 8], *box.faces[1:].tolist()],
        1e-2,
        of_solids=True,
    )


def test_of_a_solid_only_what_is_no_wider_than_a_crack_is_closed():
    properties = mass_properties.check_properties(None, None, None, None)
    part = part_of_file(cracked_solid(2.0 * 1e-3), properties, "box")
    assert codes(part) == ["HOLES_CLOSED"]
    assert part.error_known
    line = refusal_of(part_of_file, cracked_solid(2.0 * 2e-3), properties, "box")
    assert "3 open edges" in line and "wider than a crack" in line


class TestTheHullStandsIn:
    def test_for_a_bore_without_its_wall(self):
        vertices, triangles = BODIES["plate with a bore"]
        wall = (
            np.hypot(*(vertices[triangles][:, :, :2] - (1.0, 0.3)).transpose(2, 0, 1))
            < 0.51
        ).all(axis=1)
        assert "2 holes, of which two may be the ends of one bore" in why_hull(
            vertices, triangles[~wall]
        )

    def test_where_caps_over_a_crease_could_be_wrong(self):
        vertices, triangles = arrays(trimesh.creation.box())
        normals = np.cross(
            vertices[triangles[:, 1]] - vertices[triangles[:, 0]],
            vertices[triangles[:, 2]] - vertices[triangles[:, 0]],
        )
        neighbour = next(
            k
            for k in range(1, 12)
            if len(set(triangles[k]) & set(triangles[0])) == 2
            and not normals[k] @ normals[0]
        )
        # The two ways to close it differ by a tetrahedron, a sixth of the cube.
        assert "1 hole, whose caps may be wrong by" in why_hull(
            vertices, np.delete(triangles, [0, neighbour], axis=0)
        )

    def test_for_a_sheet_and_for_loose_triangles(self):
        across, up = np.meshgrid(np.arange(6.0), np.arange(6.0))
        vertices = np.column_stack(
            (across.ravel(), up.ravel(), 0.2 * np.sin(across.ravel()))
        )
        corner = (np.arange(5)[:, None] * 6 + np.arange(5)).ravel()
        triangles = np.concatenate(
            (
                np.stack((corner, corner + 1, corner + 7), axis=1),
                np.stack((corner, corner + 7, corner + 6), axis=1),
            )
        )
        assert "is a sheet, with 1 hole" in why_hull(vertices, triangles)
        folded = np.concatenate((triangles, triangles[:, ::-1]))
        assert codes(part_of(vertices, folded)) == ["OPEN_MESH"]
        loose = np.random.default_rng(3).uniform(size=(90, 3))
        assert "is made of loose triangles" in why_hull(
            loose, np.arange(90).reshape(-1, 3)
        )
        assert part_of(
            loose, np.arange(90).reshape(-1, 3)
        ).center_of_mass == pytest.approx(
            trimesh.convex.convex_hull(loose).center_mass * 1e-2, rel=1e-9
        )

    def test_for_a_strip_with_one_side(self):
        angle = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)
        half = 0.3 * np.array([[-1.0], [1.0]])
        radius = 1.0 + half * np.cos(angle / 2.0)
        strip = np.stack(
            (
                radius * np.cos(angle),
                radius * np.sin(angle),
                half * np.sin(angle / 2.0),
            ),
            axis=2,
        ).reshape(-1, 3)
        low = np.arange(24)
        high = np.arange(24, 48)
        following = np.roll(low, -1)
        shifted = np.roll(high, -1)
        following[-1], shifted[-1] = shifted[-1], following[-1]
        triangles = np.concatenate(
            (
                np.stack((low, following, shifted), axis=1),
                np.stack((low, shifted, high), axis=1),
            )
        )
        assert "is one-sided" in why_hull(strip, triangles)

    def test_where_something_pokes_through_the_opening(self):
        cup = trimesh.creation.box((2, 2, 2))
        lid = (cup.triangles[:, :, 2] > 0.9).all(axis=1)
        vertices, triangles = arrays(cup)
        rod = trimesh.creation.box((0.2, 0.3, 3))
        rod.apply_translation((0.31, 0.12, 1.2))
        assert "1 hole, whose caps would cross the surface" in why_hull(
            np.vstack((vertices, rod.vertices)),
            np.vstack((triangles[~lid], rod.faces + len(vertices))),
        )

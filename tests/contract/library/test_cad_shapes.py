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

"""Shapes of CAD systems as parts: by what all of them have, and by those at hand."""

from typing import NamedTuple

import numpy as np
import pytest

from lab.bodies import shapes
from ros_pose_stats import estimate, part_from_mesh
from tests.running import refusal_of


class CadQueryVector:
    """What is no sequence but has `toTuple`, as cadquery.Vector."""

    def __init__(self, *coordinates):
        self.coordinates = coordinates

    def toTuple(self):
        return self.coordinates


class Rod(NamedTuple):
    """A cylinder along z that is cut into as many sides as the tolerance asks for, each
    of its three faces with points of its own, as OpenCASCADE has them.
    """

    radius: float
    length: float
    vector: object
    lost_faces: int = 0

    def tessellate(self, tolerance):
        angle = 2.0 * np.arccos(1.0 - min(0.5, tolerance / self.radius))
        vertices, triangles = shapes.cylinder(
            int(np.ceil(2.0 * np.pi / angle)), self.radius, self.length
        )
        normals = np.cross(
            vertices[triangles[:, 1]] - vertices[triangles[:, 0]],
            vertices[triangles[:, 2]] - vertices[triangles[:, 0]],
        )
        up = normals[:, 2] / np.linalg.norm(normals, axis=1)
        faces = (up > 0.5).astype(int) - (up < -0.5)
        points, corners = [], []
        for face in np.unique(faces)[self.lost_faces :]:
            numbers = triangles[faces == face]
            corners += (np.arange(numbers.size).reshape(-1, 3) + len(points)).tolist()
            points += [self.vector(*row) for row in vertices[numbers.ravel()].tolist()]
        return points, corners


def tuple_of(*coordinates):
    return coordinates


@pytest.mark.parametrize("vector", [CadQueryVector, tuple_of])
def test_a_shape_is_taken_in_millimetres_and_finely_for_its_size(vector):
    part = part_from_mesh(Rod(9.0, 22.0, vector))
    assert np.ptp(part.vertices, axis=0).max() == pytest.approx(0.022, rel=1e-6)
    assert part.unit == 1e-3 and not part.unit_guessed and part.warnings == ()
    assert len(part.surface_vertices) > 80  # two rims


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
def test_its_size_and_unit_move_no_answer(scale):
    part = part_from_mesh(Rod(9.0 * scale, 22.0 * scale, tuple_of), unit=1e-3 / scale)
    usual = part_from_mesh(Rod(9.0, 22.0, tuple_of))
    assert len(part.triangles) == len(usual.triangles)
    assert [pose.probability for pose in estimate(part).poses] == pytest.approx(
        [pose.probability for pose in estimate(usual).poses], abs=1e-6
    )


def test_a_solid_that_comes_out_open_is_refused_like_a_file_of_one():
    rod = Rod(9.0, 22.0, tuple_of, lost_faces=1)
    assert "open edges" in refusal_of(part_from_mesh, rod)
    assert not part_from_mesh(rod, accept_open=True).error_known


class Broken(NamedTuple):
    """A shape that answers as no CAD system does."""

    answer: object

    def tessellate(self, _):
        return self.answer


class NullShapeError(Exception):
    """What a CAD system raises, of a type of its own."""


class Uncomputed:
    """A shape that its system cannot tessellate."""

    def tessellate(self, _):
        raise NullShapeError("the shape is null")


def test_a_shape_that_its_system_refuses_is_refused_with_its_words():
    assert "Uncomputed (the shape is null)" in refusal_of(part_from_mesh, Uncomputed())


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        (([], []), "without triangles"),
        (None, "tessellate"),
        (([(0.0, 1.0, "x")], [(0, 0, 0)]), "tessellate"),
        (([(0.0, 0.0, 0.0), (1.0, 1.0, 1.0)], [(0, 1)]), "tessellate"),
    ],
)
def test_what_is_no_shape_is_refused(answer, words):
    assert words in refusal_of(part_from_mesh, Broken(answer))


def test_what_only_holds_a_shape_is_refused_with_where_it_is():
    class Workplane:
        def faces(self):
            pass

    assert "Workplane alone" in refusal_of(part_from_mesh, Workplane())
    assert ".val()" in refusal_of(part_from_mesh, Workplane())


BLOCK = (20.0, 30.0, 40.0)
RADIUS = 4.0
VOLUME = 20.0 * 30.0 * 40.0 - np.pi * RADIUS**2 * 40.0


def of_cadquery():
    cadquery = pytest.importorskip("cadquery", reason="cadquery is not installed")
    block = cadquery.Workplane().box(*BLOCK).faces(">Z").workplane()
    return block.hole(2.0 * RADIUS).val()


def of_build123d():
    build123d = pytest.importorskip("build123d", reason="build123d is not installed")
    return build123d.Box(*BLOCK) - build123d.Cylinder(RADIUS, BLOCK[2])


def of_freecad():
    # Loaded before its module of shapes, which crashes alone.
    vector = pytest.importorskip("FreeCAD", reason="FreeCAD is not on the path").Vector
    part = pytest.importorskip("Part")
    drill = part.makeCylinder(RADIUS, BLOCK[2], vector(BLOCK[0] / 2, BLOCK[1] / 2, 0))
    return part.makeBox(*BLOCK).cut(drill)


@pytest.mark.filterwarnings("ignore")
@pytest.mark.parametrize("make", [of_cadquery, of_build123d, of_freecad])
def test_the_shapes_of_real_systems(make):
    part = part_from_mesh(make(), density=1000.0)
    assert np.ptp(part.vertices, axis=0) == pytest.approx(np.array(BLOCK) * 1e-3)
    assert part.mass == pytest.approx(VOLUME * 1e-6, rel=1e-3)
    assert part.warnings == ()

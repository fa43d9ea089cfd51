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

"""Shapes made by code: closed, outward, of the right size, and written the same every
time.
"""

import resource
from pathlib import Path

import numpy as np
import pytest
import trimesh

from lab.bodies import catalogue_parts, shapes
from ros_pose_stats import load_part, part_from_mesh, resting_poses
from ros_pose_stats.core.shapes import demo_parts
from tests.running import answer, command, refusal

ROOT_5 = np.sqrt(5.0)
CLOSED_FORMS = {  # volume, and length of the edges where these are equal
    "box": (shapes.box(2.0, 3.0, 5.0), 30.0, None),
    "triangular prism": (shapes.prism(3, 2.0, 5.0), 15.0 * np.sqrt(3.0), None),
    "seven-sided prism": (
        shapes.prism(7, 2.0, 0.5),
        7.0 * np.sin(2.0 * np.pi / 7.0),
        None,
    ),
    "cylinder": (shapes.cylinder(64, 3.0, 4.0), 1152.0 * np.sin(np.pi / 32.0), None),
    "tetrahedron": (shapes.tetrahedron(), 8.0 / 3.0, np.sqrt(8.0)),
    "octahedron": (shapes.octahedron(), 4.0 / 3.0, np.sqrt(2.0)),
    "icosahedron": (shapes.icosahedron(), 10.0 * (3.0 + ROOT_5) / 3.0, 2.0),
    "dodecahedron": (shapes.dodecahedron(), 10.0 + 2.0 * ROOT_5, ROOT_5 - 1.0),
}
DEMO = {  # extents in mm, and holes through
    "clamp": ((42.0, 36.0, 18.0), 3),
    "bracket": ((50.0, 42.0, 36.0), 4),
    "hex_bolt": ((26.0 / np.sqrt(3.0), 13.0, 35.3), 0),
    "gear": ((34.0, 34.0, 18.0), 1),
    "prism": ((20.0, 10.0 * np.sqrt(3.0), 24.0), 0),
    "cylinder": ((18.0, 18.0, 22.0), 0),
}


def solid(surface):
    """As trimesh has it: closed, outward, without slivers or corners that nothing
    uses.
    """
    vertices, triangles = surface
    mesh = trimesh.Trimesh(vertices, triangles, process=False)
    assert vertices.dtype == np.float64 and triangles.dtype == np.int64
    assert np.array_equal(np.unique(triangles), np.arange(len(vertices)))
    assert mesh.is_watertight and mesh.is_winding_consistent and mesh.volume > 0.0
    longest = mesh.edges_unique_length[mesh.faces_unique_edges].max(axis=1)
    assert np.all(2.0 * mesh.area_faces / longest > 2e-5 * mesh.extents.max())
    return mesh


@pytest.mark.parametrize("name", CLOSED_FORMS)
def test_closed_forms(name):
    surface, volume, edge = CLOSED_FORMS[name]
    mesh = solid(surface)
    assert mesh.volume == pytest.approx(volume, rel=1e-13)
    assert mesh.convex_hull.volume == pytest.approx(volume, rel=1e-12)
    assert np.abs(surface[0].mean(axis=0)).max() < 1e-14 * mesh.scale
    if edge:
        sharp = mesh.face_adjacency_edges[mesh.face_adjacency_angles > 1e-6]
        lengths = np.linalg.norm(np.diff(mesh.vertices[sharp], axis=1), axis=-1)
        assert lengths == pytest.approx(edge, rel=1e-14)


class TestHulls:
    def test_points_inside_are_left_out_and_order_is_kept(self):
        corners = shapes.box(1.0, 1.0, 1.0)[0]
        points = np.vstack((np.zeros((1, 3)), corners[:4], 0.1 * corners, corners[4:]))
        assert np.array_equal(shapes.hull_mesh(points)[0], corners)

    def test_random_points_are_uniform_on_the_sphere_and_seeded(self):
        """Second moments of 20 000 points have standard deviations of 0.0021 at the
        most.
        """
        points = shapes.sphere_points(20_000, seed=5)
        assert points.T @ points / 20_000 == pytest.approx(np.eye(3) / 3.0, abs=0.01)
        assert np.array_equal(points, shapes.sphere_points(20_000, seed=5))
        ellipsoid = shapes.ellipsoid_points(50, 1, (3.0, 2.0, 1.0)) / (3.0, 2.0, 1.0)
        assert np.linalg.norm(ellipsoid, axis=1) == pytest.approx(
            np.ones(50), abs=1e-14
        )
        solid(shapes.hull_mesh(shapes.sphere_points(200, seed=1)))


class TestDemoParts:
    @pytest.mark.parametrize("name", DEMO)
    def test_one_closed_body_of_its_size_in_coordinates_that_stl_holds(self, name):
        extents, holes = DEMO[name]
        surface = demo_parts.DEMO_PARTS[name]()
        mesh = solid(surface)
        assert (mesh.body_count, mesh.euler_number) == (1, 2 - 2 * holes)
        assert mesh.extents == pytest.approx(extents, rel=1e-3)
        assert np.array_equal(surface[0].astype(np.float32), surface[0])

    def test_files_are_named_read_back_and_the_same_from_another_process(
        self, tmp_path
    ):
        paths = [
            Path(line) for line in answer("shapes", tmp_path / "new" / "a").splitlines()
        ]
        assert command("shapes", tmp_path / "b").returncode == 0
        assert {path.stem for path in paths} == DEMO.keys()
        assert sorted(paths[0].parent.iterdir()) == sorted(paths)
        for path in paths:
            vertices, triangles = demo_parts.DEMO_PARTS[path.stem]()
            mesh = trimesh.load_mesh(path, process=False)
            assert np.array_equal(mesh.triangles, vertices[triangles])
            assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()
            part = load_part(path, unit="mm")
            assert not part.warnings and 2 < len(resting_poses(part).poses) < 10

    def test_a_file_in_the_way_is_refused(self, tmp_path):
        target = tmp_path / "parts"
        target.write_text("a file")
        for directory in (target, target / "below"):
            assert "name another directory" in refusal("shapes", directory)
        assert target.read_text() == "a file"

    def test_a_write_that_fails_leaves_nothing(self, tmp_path):
        limits = resource.getrlimit(resource.RLIMIT_FSIZE)
        resource.setrlimit(
            resource.RLIMIT_FSIZE, (100, limits[1])
        )  # bytes a file may have
        try:
            assert "File too large" in refusal("shapes", tmp_path)
        finally:
            resource.setrlimit(resource.RLIMIT_FSIZE, limits)
        assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("number", range(2 * len(catalogue_parts.KINDS)))
def test_random_machined_and_turned_parts_are_solids_with_few_poses(number):
    surface = catalogue_parts.random_part(3, number)
    vertices, triangles = surface
    body = trimesh.Trimesh(vertices, triangles, process=False)
    assert body.is_watertight and body.is_winding_consistent and body.volume > 0.0
    part = part_from_mesh(vertices, triangles, unit="mm")
    assert part.center_of_mass * 1e3 == pytest.approx(body.center_mass, abs=1e-3)
    assert 2 <= len(resting_poses(part).poses) <= 24
    repeated, different = (
        catalogue_parts.random_part(seed, number)[0] for seed in (3, 4)
    )
    assert np.array_equal(repeated, vertices)
    assert different.shape != vertices.shape or not np.array_equal(different, vertices)

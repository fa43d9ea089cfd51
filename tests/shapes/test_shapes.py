"""Shapes made by code: closed, outward, of the right size, and written the same every time."""

from __future__ import annotations

import subprocess
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
import trimesh

from ros_pose_stats import shapes
from ros_pose_stats.errors import MeshError, MeshFileError, RequestError
from ros_pose_stats.shapes import demo_parts
from ros_pose_stats.shapes.profiles import rounded_polygon, spur_gear, unit_circle

ROOT_5 = np.sqrt(5.0)
CLOSED_FORMS = {
    "box": (shapes.box(2.0, 3.0, 5.0), 30.0),
    "triangular prism": (shapes.prism(3, 2.0, 5.0), 15.0 * np.sqrt(3.0)),
    "square prism": (shapes.prism(4, 1.0, 3.0), 6.0),
    "seven-sided prism": (shapes.prism(7, 2.0, 0.5), 7.0 * np.sin(2.0 * np.pi / 7.0)),
    "cylinder": (shapes.cylinder(64, 3.0, 4.0), 1152.0 * np.sin(np.pi / 32.0)),
    "tetrahedron": (shapes.tetrahedron(), 8.0 / 3.0),
    "octahedron": (shapes.octahedron(), 4.0 / 3.0),
    "icosahedron": (shapes.icosahedron(), 10.0 * (3.0 + ROOT_5) / 3.0),
    "dodecahedron": (shapes.dodecahedron(), 10.0 + 2.0 * ROOT_5),
}
HULLS = {
    "sphere points": shapes.hull_mesh(shapes.sphere_points(200, seed=1)),
    "ellipsoid points": shapes.hull_mesh(shapes.ellipsoid_points(100, 2, (3.0, 2.0, 1.0))),
    "dodecahedron": shapes.hull_mesh(shapes.dodecahedron()[0]),
    "prism": shapes.hull_mesh(shapes.prism(64, 1.0, 2.0)[0]),
}
PARTS = {name: make() for name, make in demo_parts.DEMO_PARTS.items()}
SURFACES = {
    **{f"closed form: {name}": surface for name, (surface, _) in CLOSED_FORMS.items()},
    **{f"hull: {name}": surface for name, surface in HULLS.items()},
    **{f"part: {name}": surface for name, surface in PARTS.items()},
}
EXTENTS_MM = {
    "clamp": (42.0, 36.0, 18.0),
    "bracket": (50.0, 42.0, 36.0),
    "hex_bolt": (26.0 / np.sqrt(3.0), 13.0, 35.3),
    "gear": (34.0, 34.0, 18.0),
    "prism": (20.0, 10.0 * np.sqrt(3.0), 24.0),
    "cylinder": (18.0, 18.0, 22.0),
}
HOLES_THROUGH = {"clamp": 3, "bracket": 4, "hex_bolt": 0, "gear": 1, "prism": 0, "cylinder": 0}


def as_trimesh(surface):
    return trimesh.Trimesh(*surface, process=False)


def signed_volume(surface):
    vertices, triangles = surface
    return np.linalg.det(vertices[triangles]).sum() / 6.0


@pytest.mark.parametrize("surface", SURFACES.values(), ids=SURFACES)
class TestEverySurface:
    def test_arrays(self, surface):
        vertices, triangles = surface
        assert vertices.dtype == np.float64 and vertices.shape[1:] == (3,)
        assert triangles.dtype == np.int64 and triangles.shape[1:] == (3,)
        assert np.array_equal(np.unique(triangles), np.arange(len(vertices)))
        assert len(np.unique(vertices, axis=0)) == len(vertices)

    def test_closed_outward_and_without_degenerate_triangles(self, surface):
        edges = Counter(
            edge for a, b, c in surface[1].tolist() for edge in ((a, b), (b, c), (c, a))
        )
        assert set(edges.values()) == {1}
        assert all((b, a) in edges for a, b in edges)
        assert signed_volume(surface) > 0.0
        mesh = as_trimesh(surface)
        longest = mesh.edges_unique_length[mesh.faces_unique_edges].max(axis=1)
        assert np.all(2.0 * mesh.area_faces / longest > 2e-5 * mesh.extents.max())


@pytest.mark.parametrize(("surface", "volume"), CLOSED_FORMS.values(), ids=CLOSED_FORMS)
def test_closed_forms_are_convex_and_centred_with_the_right_volume(surface, volume):
    assert signed_volume(surface) == pytest.approx(volume, rel=1e-14)
    mesh = as_trimesh(surface)
    depth = (mesh.vertices[:, None] - mesh.triangles_center) * mesh.face_normals
    assert depth.sum(axis=-1).max() < 1e-14 * mesh.scale
    vertices = surface[0]
    assert np.abs(vertices.mean(axis=0)).max() < 1e-15 * np.abs(vertices).max()


@pytest.mark.parametrize(
    ("surface", "edges", "length"),
    [
        (shapes.tetrahedron(), 6, np.sqrt(8.0)),
        (shapes.octahedron(), 12, np.sqrt(2.0)),
        (shapes.icosahedron(), 30, 2.0),
        (shapes.dodecahedron(), 30, ROOT_5 - 1.0),
    ],
    ids=["tetrahedron", "octahedron", "icosahedron", "dodecahedron"],
)
def test_platonic_solids_have_equal_edges(surface, edges, length):
    mesh = as_trimesh(surface)
    sharp = mesh.face_adjacency_edges[mesh.face_adjacency_angles > 1e-6]
    lengths = np.linalg.norm(np.diff(mesh.vertices[sharp], axis=1), axis=-1)
    assert len(sharp) == edges
    assert lengths == pytest.approx(length, rel=1e-15)


@pytest.mark.parametrize("sides", [3, 4, 6, 63, 96])
def test_unit_circle_is_symmetric_to_the_last_bit(sides):
    circle = unit_circle(sides)
    angle = 2.0 * np.pi * np.arange(sides) / sides
    assert np.allclose(circle, np.column_stack((np.cos(angle), np.sin(angle))), atol=1e-15)
    corners = set(map(tuple, circle.tolist()))
    assert {(x, -y) for x, y in corners} == corners
    if sides % 2 == 0:
        assert {(-x, y) for x, y in corners} == corners
    if sides % 4 == 0:
        assert {(-y, x) for x, y in corners} == corners


def test_rounded_polygon_cuts_a_square_and_fills_a_recess():
    square = rounded_polygon([(0, 0, 1), (4, 0, 1), (4, 4, 1), (0, 4, 1)], steps=200)
    ell = rounded_polygon([(0, 0, 0), (4, 0, 0), (4, 2, 0), (2, 2, 1), (2, 4, 0), (0, 4, 0)], 200)
    removed = 1.0 - np.pi / 4.0
    assert area(square) == pytest.approx(16.0 - 4.0 * removed, abs=1e-4)
    assert area(ell) == pytest.approx(12.0 + removed, abs=1e-4)


def test_gear_teeth_are_half_a_pitch_wide_on_the_pitch_circle():
    outline = spur_gear(30, 2.0)
    radius = np.linalg.norm(outline, axis=1)
    assert radius.max() == pytest.approx(32.0) and radius.min() == pytest.approx(27.5)
    flank = outline[: len(outline) // 30 // 2]
    crossing = np.interp(30.0, np.linalg.norm(flank, axis=1), np.arctan2(*flank.T[::-1]))
    assert -2.0 * crossing * 30.0 == pytest.approx(np.pi, rel=0.01)


def area(outline):
    x, y = outline.T
    return 0.5 * np.sum(x * np.roll(y, -1) - y * np.roll(x, -1))


class TestHulls:
    def test_points_inside_are_left_out_and_order_is_kept(self):
        corners = shapes.box(1.0, 1.0, 1.0)[0]
        points = np.vstack((np.zeros((1, 3)), corners[:4], 0.1 * corners, corners[4:]))
        assert np.array_equal(shapes.hull_mesh(points)[0], corners)

    @pytest.mark.parametrize(
        "points",
        [np.zeros((3, 3)), np.eye(3, 3), shapes.sphere_points(9, 3) * (1.0, 1.0, 0.0),
         np.full((5, 3), np.nan), np.zeros((5, 2))],
        ids=["repeated", "three", "flat", "nan", "planar"],
    )
    def test_no_volume_is_refused(self, points):
        with pytest.raises(MeshError, match="not in one plane, got an array of shape"):
            shapes.hull_mesh(points)

    def test_sphere_points_are_uniform_and_seeded(self):
        points = shapes.sphere_points(20_000, seed=5)
        assert np.allclose(np.linalg.norm(points, axis=1), 1.0, atol=1e-15)
        assert np.allclose(points.T @ points / 20_000, np.eye(3) / 3.0, atol=0.01)
        assert np.array_equal(points, shapes.sphere_points(20_000, seed=5))
        assert not np.array_equal(points, shapes.sphere_points(20_000, seed=6))

    def test_ellipsoid_points_lie_on_the_ellipsoid(self):
        points = shapes.ellipsoid_points(50, 1, (3.0, 2.0, 1.0))
        assert np.allclose(((points / (3.0, 2.0, 1.0)) ** 2).sum(axis=1), 1.0, atol=1e-14)


@pytest.mark.parametrize(
    "make",
    [lambda: shapes.box(1.0, 0.0, 1.0), lambda: shapes.prism(2, 1.0, 1.0),
     lambda: shapes.prism(6, 1.0, -1.0), lambda: shapes.cylinder(9, float("nan"), 1.0),
     lambda: shapes.box(1.0, float("nan"), 1.0)],
    ids=["flat box", "two sides", "negative length", "nan radius", "nan edge"],
)
def test_sizes_that_enclose_nothing_are_refused(make):
    with pytest.raises(RequestError, match=r"above 0|at least 3 sides"):
        make()


@pytest.mark.parametrize("name", demo_parts.DEMO_PARTS)
class TestDemoParts:
    def test_one_closed_body(self, name):
        mesh = as_trimesh(PARTS[name])
        assert mesh.is_watertight and mesh.is_winding_consistent and mesh.is_volume
        assert mesh.body_count == 1
        assert mesh.euler_number == 2 - 2 * HOLES_THROUGH[name]

    def test_size_and_coordinates_that_stl_holds(self, name):
        vertices, triangles = PARTS[name]
        assert np.ptp(vertices, axis=0) == pytest.approx(EXTENTS_MM[name], rel=1e-3)
        assert 20 <= len(triangles) <= 4000
        assert np.array_equal(vertices.astype(np.float32), vertices)


def test_clamp_is_far_from_convex():
    mesh = as_trimesh(PARTS["clamp"])
    assert mesh.volume < 0.7 * mesh.convex_hull.volume


def test_clamp_is_asymmetric():
    mesh = as_trimesh(PARTS["clamp"])
    middle = mesh.bounds.mean(axis=0)
    assert np.all(np.abs(mesh.center_mass - middle) > 0.1)
    moments = np.sort(mesh.principal_inertia_components)
    assert np.all(np.diff(moments) > 0.03 * moments[-1])


class TestWriting:
    def test_files_read_back(self, tmp_path):
        paths = demo_parts.write_demo_parts(tmp_path / "new" / "parts")
        assert [path.name for path in paths] == [f"{name}.stl" for name in PARTS]
        for path, (vertices, triangles) in zip(paths, PARTS.values(), strict=True):
            mesh = trimesh.load_mesh(path, process=False)
            assert np.array_equal(mesh.triangles, vertices[triangles])
            assert path.stat().st_size == 84 + 50 * len(triangles)

    def test_only_the_parts_are_left(self, tmp_path):
        paths = demo_parts.write_demo_parts(tmp_path)
        assert sorted(tmp_path.iterdir()) == sorted(paths)

    def test_same_bytes_from_another_process(self, tmp_path):
        code = (
            "import sys; from ros_pose_stats.shapes import demo_parts;"
            "demo_parts.write_demo_parts(sys.argv[1])"
        )
        root = Path(demo_parts.__file__).parents[2]
        subprocess.run([sys.executable, "-c", code, tmp_path / "b"], check=True, cwd=root)
        for path in demo_parts.write_demo_parts(tmp_path / "a"):
            assert path.read_bytes() == (tmp_path / "b" / path.name).read_bytes()

    def test_a_file_in_the_way_is_refused(self, tmp_path):
        target = tmp_path / "parts"
        target.write_text("a file")
        for directory in (target, target / "below"):
            with pytest.raises(MeshFileError, match=r"a directory that can be written to"):
                demo_parts.write_demo_parts(directory)
        assert target.read_text() == "a file"

    def test_a_failed_write_leaves_nothing(self, tmp_path, monkeypatch):
        def full_disk(path, content):
            with path.open("wb") as file:
                file.write(content[:100])
            raise OSError(28, "No space left on device")

        monkeypatch.setattr(Path, "write_bytes", full_disk)
        with pytest.raises(MeshFileError, match="No space left on device"):
            demo_parts.write_demo_parts(tmp_path)
        assert list(tmp_path.iterdir()) == []


def test_closed_forms_do_not_load_the_modeller():
    code = (
        "import sys, ros_pose_stats.shapes as shapes; shapes.box(1, 1, 1);"
        "assert 'manifold3d' not in sys.modules"
    )
    root = Path(demo_parts.__file__).parents[2]
    subprocess.run([sys.executable, "-c", code], check=True, cwd=root)

"""From mesh to part: repairs, refusals, fallbacks and warnings."""

from __future__ import annotations

import gc
import weakref
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from ros_pose_stats.errors import MassPropertiesError, MeshError
from ros_pose_stats.mesh.hull import hull_of_part
from ros_pose_stats.mesh.parts import load_part, part_from_mesh

MESHES = Path(__file__).parents[3] / "shared" / "meshes"


def arrays(mesh):
    return np.array(mesh.vertices), np.array(mesh.faces)


def codes(part):
    return [warning.split(":")[0] for warning in part.warnings]


def hollow(outer_inward=False, inner_inward=True):
    """Make a box with an off-centre void: centre of mass (-0.5 * 8 / (64 - 8), 0, 0)."""
    outer, inner = trimesh.creation.box((4, 4, 4)), trimesh.creation.box((2, 2, 2))
    inner.apply_translation((0.5, 0, 0))
    for mesh, inward in ((outer, outer_inward), (inner, inner_inward)):
        if inward:
            mesh.invert()
    return outer, inner


HOLLOW_CENTER = [-0.5 * 8 / 56, 0.0, 0.0]


def test_a_part_holds_the_mesh_as_received_and_a_clean_surface():
    vertices, triangles = arrays(trimesh.creation.box((1, 2, 3)))
    soup = vertices[triangles].reshape(-1, 3)
    part = part_from_mesh(soup, np.arange(36).reshape(-1, 3), unit="cm")
    assert part.vertices.shape == (36, 3)
    assert part.triangles.dtype == np.uint32
    assert np.array_equal(part.vertices, soup * 0.01)
    assert part.surface_vertices.shape == (8, 3)
    assert part.surface_triangles.shape == (12, 3)
    assert part.part_id == f"mesh_{part.digest[:12]}"
    assert part.warnings == ()


def test_the_arrays_given_are_copied():
    vertices, triangles = arrays(trimesh.creation.box())
    part = part_from_mesh(vertices, triangles)
    vertices[:] = 0.0
    triangles[:] = 0
    assert np.ptp(part.vertices) == 1.0
    assert part.triangles.max() == 7
    assert vertices.flags.writeable


@pytest.mark.parametrize(("outer", "inner"), [(False, True), (True, False), (True, True)])
def test_a_hollow_box_in_every_winding(outer, inner):
    shell, void = hollow(outer, inner)
    for turned in (0, 3, 5):
        vertices, triangles = arrays(trimesh.util.concatenate([shell, void]))
        random = np.random.default_rng(turned)
        some = random.permutation(12)[:turned]
        triangles[some] = triangles[some][:, ::-1]
        part = part_from_mesh(vertices, random.permutation(triangles), unit=0.1)
        assert part.center_of_mass == pytest.approx(np.multiply(HOLLOW_CENTER, 0.1), abs=1e-14)
        assert codes(part) == []
        surface = trimesh.Trimesh(part.surface_vertices, part.surface_triangles, process=False)
        assert surface.volume == pytest.approx(0.056)


def test_two_outward_shells_one_in_the_other_are_two_bodies():
    part = part_from_mesh(*arrays(trimesh.util.concatenate(hollow(False, False))), unit=0.1)
    assert codes(part) == ["BODIES_OVERLAP"]
    assert part.center_of_mass == pytest.approx([0.05 * 8 / 72, 0, 0], abs=1e-14)


def test_two_bodies_are_one_rigid_part_whatever_their_winding():
    for inward in (False, True):
        one, two = trimesh.creation.box((1, 1, 1)), trimesh.creation.box((1, 1, 3))
        two.apply_translation((4, 0, 0))
        if inward:
            two.invert()
        part = part_from_mesh(*arrays(trimesh.util.concatenate([one, two])), unit=0.1)
        assert part.center_of_mass == pytest.approx([0.3, 0, 0], abs=1e-14)
        assert codes(part) == []


def test_crossed_bars_and_stacked_bars():
    across, along = trimesh.creation.box((6, 1, 1)), trimesh.creation.box((1, 6, 1.2))
    assert codes(part_from_mesh(*arrays(across + along), unit=0.1)) == ["BODIES_OVERLAP"]
    along.apply_translation((0, 0, 1.1))
    assert codes(part_from_mesh(*arrays(across + along), unit=0.1)) == []


def test_a_soup_of_loose_triangles_falls_back_to_its_hull():
    random = np.random.default_rng(3)
    vertices = random.uniform(size=(90, 3))
    part = part_from_mesh(vertices, np.arange(90).reshape(-1, 3))
    assert codes(part) == ["OPEN_MESH"]
    reference = trimesh.convex.convex_hull(vertices)
    assert part.center_of_mass == pytest.approx(reference.center_mass, rel=1e-9)


def test_a_folded_sheet_encloses_nothing_and_falls_back_to_its_hull():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0], [1, 1, 1]])
    sheet = np.array([[0, 1, 2], [0, 2, 3], [2, 4, 3]])
    part = part_from_mesh(vertices, np.concatenate((sheet, sheet[:, ::-1])))
    assert codes(part) == ["OPEN_MESH"]


def test_an_inverted_mesh_is_turned():
    vertices, triangles = arrays(trimesh.creation.icosphere(2))
    part = part_from_mesh(vertices, triangles[:, ::-1], unit=0.1)
    assert codes(part) == []
    assert trimesh.Trimesh(part.surface_vertices, part.surface_triangles).volume > 0.003


def test_duplicates_split_vertices_and_internal_walls_are_repaired():
    vertices, triangles = arrays(trimesh.creation.box())
    reference = part_from_mesh(vertices, triangles)
    wall = np.array([[0, 3, 7], [7, 3, 0]])
    soup = vertices[np.concatenate((triangles, triangles[3:5], wall))].reshape(-1, 3)
    part = part_from_mesh(soup, np.arange(len(soup)).reshape(-1, 3))
    assert codes(part) == []
    assert len(part.surface_triangles) == 12
    assert np.allclose(part.inertia, reference.inertia, rtol=1e-12)
    doubled = part_from_mesh(vertices, np.concatenate((triangles, triangles[:, ::-1])))
    assert np.allclose(doubled.inertia, reference.inertia, rtol=1e-12)


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-9, 1e-3, 1.0, 1e9]),
       st.sampled_from([0.0, 1000.0]))
def test_scale_and_place_do_not_matter(seed, scale, away):
    random = np.random.default_rng(seed)
    vertices, triangles = arrays(trimesh.convex.convex_hull(random.normal(size=(12, 3))))
    near = part_from_mesh(vertices, triangles)
    far = part_from_mesh(vertices + away, triangles, unit=scale)
    assert far.center_of_mass / scale - away == pytest.approx(near.center_of_mass, abs=1e-9)
    assert np.allclose(far.inertia / scale**2, near.inertia, rtol=1e-8, atol=1e-9)
    assert "OPEN_MESH" not in codes(far)


@pytest.mark.parametrize("turn", [0.0, 0.7])
@pytest.mark.parametrize("extents", [(1, 1e-4, 1e-4), (1, 1, 1e-6), (1, 1e-3, 1e-5)])
def test_thin_parts_are_parts(turn, extents):
    mesh = trimesh.creation.box(extents)
    mesh.apply_transform(trimesh.transformations.rotation_matrix(turn, (1, 2, 3)))
    part = part_from_mesh(*arrays(mesh))
    assert codes(part) == []
    assert np.linalg.eigvalsh(part.inertia)[0] == pytest.approx(
        (extents[1] ** 2 + extents[2] ** 2) / 12, rel=1e-3)


@pytest.mark.parametrize("turn", [0.0, 0.7])
@pytest.mark.parametrize("extents", [(1, 5e-8, 5e-8), (1, 1, 1e-8), (1, 1, 0), (1, 1e-3, 2e-8)])
def test_flat_and_needle_like_point_sets_are_refused(turn, extents):
    vertices, triangles = arrays(trimesh.creation.box((1, 1, 1)))
    turned = trimesh.transformations.rotation_matrix(turn, (1, 2, 3))[:3, :3]
    with pytest.raises(MeshError, match=r"a part at least 1e-07 of its length thick"):
        part_from_mesh(vertices * extents @ turned.T, triangles)


TETRAHEDRON = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])
FACES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]])


@pytest.mark.parametrize(("vertices", "triangles", "message"), [
    ([[0, 0, 0], [1, 0, 0], [0, np.nan, 0], [0, 0, 1]], FACES, "nan, 0.0] at vertex 2"),
    ([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, np.inf]], FACES, "inf] at vertex 3"),
    (TETRAHEDRON[:, :2], FACES, "vertices of shape (V, 3), got shape (4, 2)"),
    (TETRAHEDRON.ravel(), FACES, "vertices of shape (V, 3), got shape (12,)"),
    ([[0, 0], [1]], FACES, "vertices as rows of three numbers"),
    ("points", FACES, "vertices as rows of three numbers"),
    (TETRAHEDRON, FACES[:, :2], "triangles of shape (T, 3), got shape (4, 2)"),
    (TETRAHEDRON, [[0, 1, 2], [0, 1, 2, 3]], "triangles of shape (T, 3)"),
    (TETRAHEDRON, np.zeros((0, 3), int), "at least four triangles, got none"),
    (TETRAHEDRON, [], "at least four triangles, got none"),
    (TETRAHEDRON, FACES + 1, "from 0 to 3, got 4 in triangle 1"),
    (TETRAHEDRON, FACES - 1, "from 0 to 3, got -1 in triangle 0"),
    (TETRAHEDRON, FACES + 0.5, "whole vertex numbers, got 0.5 in triangle 0"),
    (TETRAHEDRON, np.full((4, 3), np.nan), "whole vertex numbers, got nan in triangle 0"),
    (TETRAHEDRON, [["a", "b", "c"]], "triangles as rows of three numbers"),
    (np.ones((4, 3)), FACES, "only triangles with coincident corners"),
    (TETRAHEDRON * 1e80, FACES, "an extent from 1e-50 to 1e+50 m, got 1e+80 m"),
    (np.zeros((0, 3)), FACES, "got 0 in triangle 0"),
])
def test_what_is_no_mesh_is_refused_with_the_reason(vertices, triangles, message):
    with pytest.raises(MeshError) as refusal:
        part_from_mesh(vertices, triangles)
    assert message in str(refusal.value)


def test_whole_numbers_may_come_as_floats():
    part = part_from_mesh(TETRAHEDRON, FACES.astype(float))
    assert part.center_of_mass == pytest.approx([0.25, 0.25, 0.25])


def test_only_vertices_of_triangles_count():
    vertices = np.concatenate((TETRAHEDRON, [[1000.0, 0, 0]]))
    part = part_from_mesh(vertices, FACES)
    assert codes(part) == []
    assert len(part.surface_vertices) == 4
    with pytest.raises(MassPropertiesError, match="outside"):
        part_from_mesh(vertices, FACES, [500.0, 0, 0])


def test_the_hull_is_kept_while_the_part_lives():
    part = part_from_mesh(*arrays(trimesh.creation.icosphere(2)))
    hull = hull_of_part(part)
    assert hull_of_part(part) is hull
    corners = hull.qhull.points[hull.qhull.vertices] * hull.scale + hull.shift
    assert np.allclose(corners, part.surface_vertices[hull.qhull.vertices], atol=1e-15)
    gone = weakref.ref(part)
    del part
    gc.collect()
    assert gone() is None


@pytest.mark.skipif(not MESHES.is_dir(), reason="the sample meshes are not here")
@pytest.mark.parametrize(("name", "open_mesh"), [
    ("featuretype.STL", False), ("angle_block.STL", False), ("plate_holes.STL", False),
    ("cylinder.stl", False), ("round.stl", False), ("ariac_sensor_collision.stl", False),
    ("soup.stl", True), ("multibody.stl", False),
])
def test_real_files(name, open_mesh):
    part = load_part(MESHES / name, 0.01)
    assert ("OPEN_MESH" in codes(part)) == open_mesh
    surface = trimesh.Trimesh(part.surface_vertices, part.surface_triangles, process=False)
    assert surface.is_watertight
    assert surface.volume > 0.0
    assert part.center_of_mass == pytest.approx(surface.center_mass, rel=1e-6, abs=1e-9)
    if not open_mesh and name != "multibody.stl":
        whole = trimesh.load_mesh(MESHES / name)
        assert part.center_of_mass == pytest.approx(whole.center_mass * 0.01, rel=1e-6, abs=1e-9)

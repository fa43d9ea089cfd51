"""A decimated part looks like the part: it keeps teeth, gaps, bores and threads."""

import threading

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from ros_pose_stats import part_from_mesh
from ros_pose_stats.mesh.decimation import FINEST, decimate, visible_triangles
from ros_pose_stats.shapes.closed_forms import box
from tests import fine_parts


@pytest.fixture(scope="module")
def gear():
    return part_from_mesh(*fine_parts.gear())


@pytest.fixture(scope="module")
def screw():
    return part_from_mesh(*fine_parts.screw())


def pierced(triangles, x, y):
    """Heights at which the vertical through (x, y) passes through triangles, ascending."""
    corners = triangles - np.array([x, y, 0.0])
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    parts = [p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] for p, q in ((b, c), (c, a), (a, b))]
    total = sum(parts)
    inside = (np.minimum.reduce(parts) > 0.0) | (np.maximum.reduce(parts) < 0.0)
    heights = sum(share * p[:, 2] for share, p in zip(parts, (a, b, c), strict=True))
    return np.sort(heights[inside] / total[inside])


def points_on(triangles, count=400_000):
    mesh = trimesh.Trimesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3),
                           process=False)
    return trimesh.sample.sample_surface(mesh, count, seed=1)[0]


@pytest.mark.parametrize(("most", "share"), [(FINEST, 0.002), (4000, 0.004), (1000, 0.02)])
@pytest.mark.parametrize("name", ["gear", "screw"])
def test_stays_near_the_surface_and_leaves_out_nothing(request, name, most, share):
    part = request.getfixturevalue(name)
    assert len(part.triangles) > FINEST
    true = part.surface_vertices[part.surface_triangles]
    shown = visible_triangles(part, most)
    assert most // 2 < len(shown) <= most
    extent = np.ptp(part.vertices, axis=0).max()
    one, two = points_on(true), points_on(shown)
    apart = 0.004 * extent  # of the points themselves
    assert cKDTree(one).query(two[:20_000])[0].max() < share * extent + apart
    assert cKDTree(two).query(one[:20_000])[0].max() < share * extent + apart


@pytest.mark.parametrize("most", [FINEST, 4000, 2000, 1000])
def test_a_line_passes_through_every_gap_and_the_bore_and_meets_every_tooth(gear, most):
    shown = visible_triangles(gear, most)
    middle = 0.5 * (fine_parts.TIP + fine_parts.ROOT)
    for k in range(fine_parts.TEETH):
        for turn, met in ((0.25, 2), (0.75, 0)):
            angle = 2.0 * np.pi * (k + turn) / fine_parts.TEETH
            heights = pierced(shown, middle * np.cos(angle), middle * np.sin(angle))
            assert len(heights) == met, (k, turn)
            if met:
                assert heights == pytest.approx([0.0, fine_parts.FACE], abs=2e-5)
    for angle in np.arange(0.1, 6.0, 0.7):
        reach = 0.6 * fine_parts.BORE
        assert len(pierced(shown, reach * np.cos(angle), reach * np.sin(angle))) == 0


@pytest.mark.parametrize("most", [FINEST, 4000, 2000])
def test_a_line_along_a_screw_meets_every_turn_of_its_thread(screw, most):
    shown = visible_triangles(screw, most)
    middle = 0.5 * (fine_parts.CREST + fine_parts.CORE)
    for angle in np.arange(0.1, 6.0, 0.7):
        heights = pierced(shown, middle * np.cos(angle), middle * np.sin(angle))
        assert len(heights[heights > 0.5 * fine_parts.PITCH]) >= 2 * (fine_parts.TURNS - 1)


def test_is_closed_outward_and_the_same_each_time(gear, screw):
    for part in (gear, screw):
        shown = visible_triangles(part, 4000)
        mesh = trimesh.Trimesh(shown.reshape(-1, 3), np.arange(3 * len(shown)).reshape(-1, 3))
        mesh.merge_vertices()
        assert mesh.is_watertight
        whole = trimesh.Trimesh(part.surface_vertices, part.surface_triangles)
        assert mesh.volume == pytest.approx(whole.volume, rel=5e-3)
        again = part_from_mesh(part.vertices, part.triangles)
        assert visible_triangles(again, 4000).tobytes() == shown.tobytes()


def test_a_part_of_few_triangles_is_shown_as_it_is():
    part = part_from_mesh(*box(0.04, 0.03, 0.02))
    true = part.surface_vertices[part.surface_triangles]
    assert (visible_triangles(part, 100) == true).all()


def test_an_open_mesh_is_shown_as_received_from_both_sides(gear):
    mouth = gear.triangles[1000:]
    part = part_from_mesh(gear.vertices, mouth)
    assert [line for line in part.warnings if line.startswith("OPEN_MESH:")]
    shown = visible_triangles(part, 4000)
    assert 2000 < len(shown) <= 4000
    half = len(shown) // 2
    assert (shown[:half] == shown[half:, ::-1]).all()
    assert len(pierced(shown, 0.5 * fine_parts.BORE, 0.0)) == 0


def test_far_from_the_origin_and_very_small_or_large(gear):
    triangles = gear.triangles
    expected = decimate(gear.vertices, triangles, 2000)
    for scale in (2.0**-80, 2.0**80):
        assert (decimate(scale * gear.vertices, triangles, 2000) == expected).all()
    moved = decimate(gear.vertices + 1.0, triangles, 2000)
    assert 1000 < len(moved) <= 2000


def test_other_threads_go_on_meanwhile():
    """A node answers while the mesh of a marker is decimated."""
    vertices, triangles = fine_parts.screw(384)
    assert len(triangles) > 250_000
    done, ticks = threading.Event(), []

    def work():
        decimate(vertices, triangles, 4000)
        done.set()

    worker = threading.Thread(target=work)
    worker.start()
    while not done.wait(0.002):
        ticks.append(1)
    worker.join()
    assert len(ticks) > 10


SOUPS = st.tuples(st.integers(0, 2**32 - 1), st.integers(3, 2000), st.integers(1, 3000),
                  st.sampled_from([0.0, 1e-12, 1.0]))


@settings(max_examples=40, deadline=None)
@given(SOUPS, st.integers(100, 1000))
def test_any_mesh_gets_few_triangles_of_its_own_vertices(soup, most):
    """Edges of many triangles, flat and repeated ones, loose points."""
    seed, vertices, triangles, height = soup
    rng = np.random.default_rng(seed)
    places = rng.normal(size=(vertices, 3)) * (1.0, 1.0, height)
    corners = rng.integers(vertices, size=(triangles, 3))
    found = decimate(places, corners, most)
    assert found.shape[1:] == (3,)
    assert len(found) <= most
    assert len(found) == 0 or found.max() < vertices
    if len(corners) <= most:
        assert len(found) <= len(corners)


def test_where_no_edge_can_go_the_largest_triangles_stay():
    """The triangles join any three of the vertices, so that there is no surface."""
    rng = np.random.default_rng(1)
    vertices, triangles = rng.normal(size=(1000, 3)), rng.integers(1000, size=(9000, 3))
    triangles = triangles[[len(set(one)) == 3 for one in triangles.tolist()]]
    found = decimate(vertices, triangles, 1000)
    assert len(found) == 1000

    def areas(some):
        a, b, c = (vertices[some[:, k]] for k in range(3))
        return np.linalg.norm(np.cross(b - a, c - a), axis=1)

    assert areas(found).min() >= np.sort(areas(triangles))[-1000] * (1.0 - 1e-6)

"""The coarse stand-in for pictures is a closed convex body inside the part's hull."""

import numpy as np
import pytest
import trimesh

from ros_pose_stats import part_from_mesh
from ros_pose_stats.resting.decimation import decimated_hull
from ros_pose_stats.shapes import demo_parts
from ros_pose_stats.shapes.closed_forms import box, cylinder, ellipsoid_points, hull_mesh

BODIES = {
    "box": box(0.04, 0.03, 0.02),
    "cylinder": cylinder(200, 0.01, 0.03),
    "ellipsoid": hull_mesh(ellipsoid_points(3000, 1, (0.03, 0.02, 0.01))),
    "clamp": tuple(0.001 * x if k == 0 else x for k, x in enumerate(demo_parts.clamp())),
    "far from its origin": (np.asarray(box(0.04, 0.03, 0.02)[0]) + 5.0, box(1, 1, 1)[1]),
}


@pytest.fixture(params=BODIES, ids=str)
def part(request):
    vertices, triangles = BODIES[request.param]
    return part_from_mesh(vertices, triangles)


def test_has_at_most_so_many_triangles_and_is_closed_and_outward(part):
    for most in (12, 40, 120):
        soup = decimated_hull(part, most)
        assert 4 <= len(soup) <= most
        mesh = trimesh.Trimesh(soup.reshape(-1, 3), np.arange(3 * len(soup)).reshape(-1, 3))
        mesh.merge_vertices()
        assert mesh.is_watertight
        assert mesh.volume > 0.0


def test_lies_in_the_hull_and_fills_most_of_it(part):
    hull = trimesh.convex.convex_hull(np.asarray(part.vertices))
    size = float(np.ptp(part.vertices, axis=0).max())
    origins, normals = hull.triangles_center, hull.face_normals
    for most, share in ((12, 0.3), (40, 0.6), (120, 0.8)):
        soup = decimated_hull(part, most).reshape(-1, 3)
        beyond = np.einsum("nfk,fk->nf", soup[:, None] - origins[None], normals).max()
        assert beyond < 1e-9 * size + 1e-12
        assert trimesh.convex.convex_hull(soup).volume > share * hull.volume


def test_a_body_with_few_corners_is_shown_as_it_is():
    part = part_from_mesh(*box(0.04, 0.03, 0.02))
    assert trimesh.convex.convex_hull(
        decimated_hull(part, 12).reshape(-1, 3)).volume == pytest.approx(0.04 * 0.03 * 0.02)

"""Parts as an STL file stores them, also in the frame of an assembly: the same poses."""

from __future__ import annotations

import numpy as np
import pytest

from ros_pose_stats import estimate_all, part_from_mesh, resting_poses, shapes
from ros_pose_stats.shapes import demo_parts
from tests.bodies import REGULAR_SOLIDS, in_float32, moved, random_polyhedron, rotation, size
from tests.matching import values

FLOATED = {
    "cube": REGULAR_SOLIDS["cube"], "icosahedron": REGULAR_SOLIDS["icosahedron"],
    **{name: make() for name, make in demo_parts.DEMO_PARTS.items()},
    "box": shapes.box(1.0, 2.0, 3.0), "triangular prism": shapes.prism(3, 1.0, 2.0),
    "flat cylinder": shapes.cylinder(48, 1.0, 0.2),
    "fine cylinder": shapes.cylinder(100, 1.0, 1.0),
    "odd cylinder": shapes.cylinder(33, 9.0, 22.0), "random": random_polyhedron(10, 2),
}


def rounded(surface, sizes_away, seed):
    """Turned (but for seed 0), moved off the origin, and rounded."""
    way = rotation(seed)[0] * sizes_away * size(surface)
    return in_float32(moved(surface, rotation(seed + 7) if seed else None, way))


def poses_of(surface, tolerance):
    return resting_poses(part_from_mesh(*surface), tolerance).poses


@pytest.mark.parametrize("surface", FLOATED.values(), ids=FLOATED)
class TestEveryBody:
    def test_the_same_poses(self, surface):
        exact = estimate_all(part_from_mesh(*surface))
        for sizes_away, seed in ((0.0, 0), (1.0, 1), (10.0, 2)):
            rough = estimate_all(part_from_mesh(*rounded(surface, sizes_away, seed)))
            for one, other in zip(exact, rough, strict=True):
                assert len(other.poses) == len(one.poses)
                assert np.sort(values(other.poses, "probability")) == pytest.approx(
                    np.sort(values(one.poses, "probability")),
                    abs=1e-3 if one.method == "split" else 3e-4)
                for name in ("height", "top", "barrier"):
                    assert np.sort(values(other.poses, name)) == pytest.approx(
                        np.sort(values(one.poses, name)), abs=1e-5 * one.radius)

    def test_the_same_faces(self, surface):
        expected = len(poses_of(surface, 0.0))
        for sizes_away, seed in ((0.0, 0), (0.0, 1), (1.0, 2)):
            assert len(poses_of(rounded(surface, sizes_away, seed), 0.0)) == expected


@pytest.mark.parametrize("name", ["box", "cube", "flat cylinder", "fine cylinder"])
def test_without_clusters_the_same_faces_ten_sizes_off_the_origin_in_float32(name):
    surface = FLOATED[name]
    counts = [len(poses_of(rounded(surface, 10.0, seed), 0.0))
              for seed in range(1, 7)]
    assert counts == [len(poses_of(surface, 0.0))] * 6

"""CSAE and QSE against trimesh.poses where the definitions agree.

Without noise (one sample, sigma 0) trimesh topples quasi-statically as QSE does. It merges
faces by rounded normals and measures them by arc cosines: good to some 1e-6 on round shapes.
"""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from ros_pose_stats import estimate, part_from_mesh, shapes
from tests.bodies import REGULAR_SOLIDS, random_polyhedron
from tests.matching import downs, values

SETTLED = {
    "dodecahedron": REGULAR_SOLIDS["dodecahedron"],
    "flat box": shapes.box(3.0, 2.0, 0.5),
    "triangular prism": shapes.prism(3, 1.0, 1.5),
    "octagonal prism": shapes.prism(8, 1.0, 0.7),
}


def trimesh_poses(surface):
    """Directions that point down, and probabilities."""
    mesh = trimesh.Trimesh(*surface, process=False)
    transforms, probability = trimesh.poses.compute_stable_poses(
        mesh, sigma=0.0, n_samples=1, threshold=0.0, seed=0)
    return -transforms[:, 2, :3], probability


def compared(surface, method):
    """Our probabilities and trimesh's, face by face."""
    found = estimate(part_from_mesh(*surface), method, cluster_tolerance=0.0)
    theirs, probability = trimesh_poses(surface)
    near = downs(found.poses) @ theirs.T
    assert near.max(axis=1).min() > 1.0 - 1e-6
    together = np.zeros(len(found.poses))
    np.add.at(together, near.argmax(axis=0), probability)
    return values(found.poses, "probability"), together


@pytest.mark.parametrize("method", ["csae", "qse"])
@pytest.mark.parametrize("surface", SETTLED.values(), ids=SETTLED)
def test_where_every_face_is_stable(surface, method):
    ours, theirs = compared(surface, method)
    assert ours == pytest.approx(theirs, abs=1e-6)


def test_random_polyhedra_topple_alike():
    # trimesh leaves a face over the edge nearest to the projected centre in angle, we over the
    # one between the face's centroid and the foot: few faces differ.
    for seed in range(10):
        ours, theirs = compared(random_polyhedron(6 + seed, 300 + seed), "qse")
        assert ours.sum() == pytest.approx(theirs.sum(), abs=1e-6)
        assert np.abs(ours - theirs).sum() < 0.25

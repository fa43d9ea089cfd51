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

"""QSE: toppling decided by hand, by an independent toppling, and by trimesh; solid
angles too.
"""

import numpy as np
import pytest
import trimesh

from lab.bodies import shapes
from lab.bodies.samples import REGULAR_SOLIDS, oblique_prism, random_polyhedron
from ros_pose_stats import estimate, part_from_mesh
from tests.matching import downs, values
from tests.truth.reference.toppling import Polyhedron, solid_angle


def compare(part, expected, method="qse"):
    """Probabilities against those of (direction, share) pairs, which are all there
    are.
    """
    statistics = estimate(part, method, cluster_tolerance=0.0)
    directions = np.array([direction for direction, _ in expected], dtype=float)
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    nearest = (downs(statistics.poses) @ directions.T).argmax(axis=1)
    assert sorted(nearest) == list(range(len(expected)))
    assert np.abs(downs(statistics.poses) - directions[nearest]).max() < 1e-9
    assert values(statistics.poses, "probability") == pytest.approx(
        [expected[k][1] for k in nearest], rel=1e-12
    )


def fraction(*corners):
    """Solid angle of a fan of corners over the whole sphere."""
    first, *rest = (np.array(corner, dtype=float) for corner in corners)
    return float(
        sum(solid_angle(first, rest[i], rest[i + 1]) for i in range(len(rest) - 1))
        / (4.0 * np.pi)
    )


def test_a_leaning_prism_topples_from_its_ends_onto_the_sides_that_overhang():
    """The centre of mass is above x = 1.5, beyond the base's edge at x = 1.

    By symmetry the other end topples the other way.
    """
    shift = 3.0
    length = 4.0
    center = np.array((shift / 2.0, 0.0, length / 2.0))
    base = (
        np.array(
            ((-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0))
        )
        - center
    )
    top = base + np.array((shift, 0.0, length))
    end = fraction(*base)
    leaning = fraction(base[1], base[2], top[2], top[1])
    upright = fraction(base[0], base[1], top[1], top[0])
    compare(
        part_from_mesh(*oblique_prism(shift, length)),
        [
            ((length, 0.0, -shift), leaning + end),
            ((-length, 0.0, shift), leaning + end),
            ((0.0, 1.0, 0.0), upright),
            ((0.0, -1.0, 0.0), upright),
        ],
    )
    assert end > 0.01


def test_a_pyramid_that_would_topple_over_a_corner_shares_between_both_sides():
    """Square base, the apex beyond a corner on the diagonal: both faces there take
    half.
    """
    corners = np.array(
        (
            (-1.0, -1.0, 0.0),
            (1.0, -1.0, 0.0),
            (1.0, 1.0, 0.0),
            (-1.0, 1.0, 0.0),
            (4.5, 4.5, 5.0),
        )
    )
    center = np.array((1.5, 1.5, 1.75))
    statistics = estimate(
        part_from_mesh(*shapes.hull_mesh(corners), center_of_mass=center),
        "qse",
        cluster_tolerance=0.0,
    )
    p = corners - center
    half = fraction(p[1], p[2], p[4]) + fraction(p[0], p[1], p[2], p[3]) / 2.0
    assert not (downs(statistics.poses)[:, 2] < -0.999).any()
    for direction in ((5.0, 0.0, -3.5), (0.0, 5.0, -3.5)):
        cosines = downs(statistics.poses) @ direction / np.linalg.norm(direction)
        assert cosines.max() > 1.0 - 1e-12
        assert statistics.poses[cosines.argmax()].probability == pytest.approx(
            half, rel=1e-12
        )


@pytest.mark.parametrize("seed", range(0, 40, 5))
def test_against_an_independent_toppling(seed):
    """Also the solid angles, areas and distances of `csae`, `area` and `adre`."""
    surface = random_polyhedron(5 + seed % 25, 100 + seed)
    center = None
    if seed % 3:
        weights = np.random.default_rng(len(surface[0])).dirichlet(
            np.ones(len(surface[0]))
        )
        center = weights @ surface[0]
    part = part_from_mesh(*surface, center_of_mass=center)
    reference = Polyhedron(surface[0], part.center_of_mass)
    stable = [
        face
        for face in range(len(reference.corners))
        if reference.topples_to(face) == face
    ]
    angle = np.array([reference.angle(face) for face in stable])
    weights = {
        "qse": reference.quasi_static()[stable],
        "csae": angle,
        "area": [reference.area_vector(face)[0] for face in stable],
        "adre": angle / [reference.distance(face) for face in stable],
    }
    for method, weight in weights.items():
        statistics = estimate(part, method, cluster_tolerance=0.0)
        match = (downs(statistics.poses) @ reference.normals[stable].T).argmax(axis=1)
        assert sorted(match) == list(range(len(stable)))
        assert values(statistics.poses, "probability") == pytest.approx(
            np.array(weight)[match] / np.sum(weight), abs=1e-11
        )


@pytest.mark.parametrize("method", ["csae", "qse"])
@pytest.mark.parametrize(
    "surface",
    [
        REGULAR_SOLIDS["dodecahedron"],
        shapes.box(3.0, 2.0, 0.5),
        shapes.prism(8, 1.0, 0.7),
    ],
    ids=["dodecahedron", "flat box", "octagonal prism"],
)
def test_against_trimesh_where_every_face_is_stable(surface, method):
    """Without noise (one sample, sigma 0) trimesh topples quasi-statically as QSE does.

    It merges faces by rounded normals and measures them by arc cosines: good to some
    1e-6.
    """
    statistics = estimate(part_from_mesh(*surface), method, cluster_tolerance=0.0)
    transforms, probability = trimesh.poses.compute_stable_poses(
        trimesh.Trimesh(*surface, process=False),
        sigma=0.0,
        n_samples=1,
        threshold=0.0,
        seed=0,
    )
    cosines = downs(statistics.poses) @ -transforms[:, 2, :3].T
    assert cosines.max(axis=1).min() > 1.0 - 1e-6
    sums = np.zeros(len(statistics.poses))
    np.add.at(sums, cosines.argmax(axis=0), probability)
    assert values(statistics.poses, "probability") == pytest.approx(sums, abs=1e-6)

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

"""Poses that a rotation or reflection of the dropped body exchanges are one unit."""

import numpy as np
import pytest
from manifold3d import Manifold
from scipy.stats import binomtest, chi2, chisquare

from lab.bodies import exports, fine_parts, shapes
from lab.bodies.families import family_part
from lab.bodies.samples import oblique_prism, random_polyhedron
from lab.bodies.variants import in_float32, moved, rotation, shuffled, size, subdivided
from ros_pose_stats import part_from_mesh, resting_poses, simulate, simulate_flips
from ros_pose_stats.core.shapes import demo_parts
from ros_pose_stats.core.simulation.flips import pool_flips
from ros_pose_stats.core.statistics.errors import standard_errors
from tests.matching import values
from tests.truth.drops.recorded import SURE


def clip():
    """A flat hook in the plane of x and y: its two faces are mirror images."""
    outline = [(0, 0), (5, 0), (5, 1), (1, 1), (1, 3), (2, 3), (2, 4), (0, 4)]
    return exports.extruded(np.array(outline, dtype=float), 0.8)


def twisted_prism():
    """Two triangles of which one is turned: no mirror, but turns about three axes."""
    angles = 2.0 * np.pi / 3.0 * np.arange(3)
    ends = [
        np.column_stack((np.cos(angles + turn), np.sin(angles + turn), [z] * 3))
        for turn, z in ((0.15, 0.7), (-0.15, -0.7))
    ]
    return shapes.hull_mesh(np.vstack(ends))


# Sizes of groups and of units, rising, and the number of motions of the body.
BODIES = {
    "clip, whose faces are mirror images": (clip(), [1] * 6, [1, 1, 1, 1, 2], 2),
    "bracket": (demo_parts.DEMO_PARTS["bracket"](), [1] * 5, [1, 1, 1, 2], 2),
    "leaning prism": (oblique_prism(0.5, 2.0), [1, 1, 2, 2], [2, 2, 2], 4),
    "box": (shapes.box(1.0, 2.0, 3.0), [2, 2, 2], [2, 2, 2], 8),
    "cube": (shapes.box(1.0, 1.0, 1.0), [6], [6], 48),
    "hexagonal prism": (shapes.prism(6, 1.0, 1.3), [2, 6], [2, 6], 24),
    "twisted prism, no mirror": (twisted_prism(), [2, 6], [2, 6], 6),
    "chiral polyhedron": (random_polyhedron(12, 3), [1] * 9, [1] * 9, 1),
}


def sizes(labels):
    return sorted(np.bincount(labels).tolist())


@pytest.mark.parametrize(
    ("surface", "groups", "units", "motions"), BODIES.values(), ids=BODIES
)
class TestUnits:
    def test_groups_units_and_motions(self, surface, groups, units, motions):
        """However the mesh is given."""
        for seed in range(3):
            shift = rotation(seed + 20)[0] * size(surface)
            changed = moved(subdivided(surface), rotation(seed), shift, 0.0254)
            for mesh in (shuffled(changed, seed), in_float32(changed)):
                resting = resting_poses(part_from_mesh(*mesh), 0.0, 0)
                assert sizes(resting.group) == groups
                assert sizes(resting.unit) == units
                assert resting.symmetries.shape == (motions, len(resting.poses))

    def test_motions_leave_heights_and_units(self, surface, groups, units, motions):
        resting = resting_poses(part_from_mesh(*surface), 0.0, 0)
        assert resting.symmetries[0].tolist() == list(range(len(resting.poses)))
        for image in resting.symmetries:
            assert sorted(image.tolist()) == list(range(len(resting.poses)))
            np.testing.assert_array_equal(resting.unit[image], resting.unit)
            np.testing.assert_allclose(
                resting.heights[image], resting.heights, atol=1e-12
            )
        for group in range(max(resting.group) + 1):
            assert len(np.unique(resting.unit[resting.group == group])) == 1


def test_mirror_images_are_equally_probable():
    """By drops, and what they are dropped with is no mirror image."""
    part = part_from_mesh(*clip())
    resting = resting_poses(part)
    counts = values(
        sorted(simulate(part, 4000, seed=3).poses, key=lambda pose: pose.index), "count"
    )
    faces = counts[resting.unit == np.bincount(resting.unit).argmax()]
    assert len(faces) == 2
    assert binomtest(int(faces[0]), int(faces.sum())).pvalue > SURE


def test_facets_of_a_coil_are_not_equally_probable():
    """Its ends put the centre of mass beside the axis by as much as they are deep.

    Of 400 drops five times as many come to rest on the lowest facets as on the highest:
    no unit may hold both.
    """
    part = family_part("springs", 4321, 2)
    resting = resting_poses(part)
    counts = values(
        sorted(simulate(part, 400, 0.2, seed=1).poses, key=lambda pose: pose.index),
        "count",
    )
    for unit in np.unique(resting.unit):
        alike = counts[resting.unit == unit]
        if len(alike) > 1 and alike.any():
            assert chisquare(alike).pvalue > SURE / len(counts)


def test_no_mirror_image_of_a_pocket_is_asked_for():
    """Pockets do not meet the plate; groups see them and units do not."""
    box = Manifold.cube((2.0, 3.0, 4.0), True)
    pocket = Manifold.cylinder(0.8, 0.2, 0.2, 24, True).rotate((0.0, 90.0, 0.0))
    solid = box - pocket.translate((1.0, 0.5, 0.7))
    resting = resting_poses(
        part_from_mesh(
            *fine_parts.surface(solid),
            center_of_mass=(0.0, 0.0, 0.0),
            mass=1.0,
            inertia=np.diag((2.0, 1.5, 1.0)),
        ),
        0.0,
        0,
    )
    assert sizes(resting.group) == [1] * 6
    assert sizes(resting.unit) == [2, 2, 2]


class TestFlips:
    def test_pairs_that_a_motion_exchanges_have_one_probability(self):
        for name in ("clip, whose faces are mirror images", "box", "bracket"):
            part = part_from_mesh(*BODIES[name][0])
            resting = resting_poses(part)
            flips = simulate_flips(part, 0.4 * resting.body.radius, 200, seed=5)
            for image in resting.symmetries:
                for matrix in (flips.transition, flips.standard_error):
                    turned = matrix[np.ix_(image, image)]
                    np.testing.assert_allclose(turned, matrix, rtol=1e-12)
            np.testing.assert_allclose(flips.transition.sum(axis=1), 1.0, rtol=1e-12)
            np.testing.assert_array_equal(
                flips.effective_counts.sum(axis=1),
                200 * np.bincount(resting.unit)[resting.unit],
            )
            assert flips.counts.sum() == 200 * len(resting.poses)

    def test_without_a_motion_each_row_stands_by_itself(self):
        part = part_from_mesh(*random_polyhedron(7, 3))
        flips = simulate_flips(part, 0.3, 200, seed=5)
        settled = flips.counts.sum(axis=1)
        np.testing.assert_array_equal(flips.transition, flips.counts / settled[:, None])
        for row, total, errors in zip(
            flips.counts, settled, flips.standard_error, strict=True
        ):
            np.testing.assert_array_equal(standard_errors(row, int(total)), errors)

    def test_what_is_pooled_agrees(self):
        """Of a box: counts of all pairs that its eight motions exchange are alike."""
        part = part_from_mesh(*shapes.box(1.0, 2.0, 3.0))
        flips = simulate_flips(part, 1.2, 3000, seed=8)
        expected = flips.transition * flips.counts.sum(axis=1)[:, None]
        is_counted = expected > 5.0
        scatter = (flips.counts - expected)[is_counted] ** 2 / expected[is_counted]
        # 6 rows of 6 poses; each of 3 units of rows has told 3 numbers besides its sum.
        freedom = is_counted.sum() - 6 - 9
        assert chi2.sf(scatter.sum(), freedom) > SURE

    def test_errors_are_those_of_repetitions(self):
        """The variance of 60 draws is known to 18 %, and those of 36 pairs go along."""
        draw = np.random.default_rng(4)
        images = resting_poses(part_from_mesh(*shapes.box(1.0, 2.0, 3.0))).symmetries
        truth, _, _ = pool_flips(draw.integers(20, 200, (6, 6)), images)
        repetitions = [
            pool_flips(np.array([draw.multinomial(400, row) for row in truth]), images)
            for _ in range(60)
        ]
        means = np.array([transition for transition, _, _ in repetitions])
        errors = np.mean([error for _, error, _ in repetitions], axis=0)
        ratio = means.var(axis=0) / errors**2
        assert 0.82 < ratio.mean() < 1.18

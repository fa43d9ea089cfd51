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

"""What no change of units, frame, triangulation or order may alter, on random
polyhedra.
"""

import numpy as np
import pytest
from hypothesis import given, settings, strategies

from lab.bodies.samples import random_polyhedron
from lab.bodies.variants import moved, rotation, shuffled, size, starred, subdivided
from ros_pose_stats import estimate_all, part_from_mesh
from tests.matching import matched, values

SAME_HEIGHT = 1e-6
"""Of the radius: heights this close are a tie in the numbering of poses."""

seeds = strategies.integers(0, 10_000)
polyhedra = strategies.builds(random_polyhedron, strategies.integers(4, 25), seeds)
tolerances = strategies.sampled_from([0.0, 0.005])


def assert_same_answers(
    first, second, turn=None, scale=1.0, tolerance=0.0, within=1e-9
):
    """All methods and the geometry of the poses agree, part by part.

    Lengths are compared relative to the radius. A split into two components of 1e-9 sr
    each, which one random body in some ten thousand has, would need a wider tolerance:
    their areas are differences of larger ones, good to 1e-16 sr.
    """
    for pose, partner in zip(
        estimate_all(first, cluster_tolerance=tolerance),
        estimate_all(second, cluster_tolerance=tolerance),
        strict=True,
    ):
        assert pose.method == partner.method
        assert partner.radius == pytest.approx(pose.radius * scale, rel=within)
        partners = matched(pose.poses, partner.poses, turn)
        for name in ("probability", "margin", "spread"):
            assert values(partners, name) == pytest.approx(
                values(pose.poses, name), abs=within
            )
        for name in ("height", "top", "barrier"):
            assert values(partners, name) == pytest.approx(
                values(pose.poses, name) * scale,
                rel=within,
                abs=within * partner.radius,
            )
        gap = np.diff(np.sort(values(pose.poses, "height"))).min(initial=np.inf)
        if gap > 2.0 * SAME_HEIGHT * pose.radius:  # else a tie, which `down` breaks
            assert (
                values(partners, "index").tolist()
                == values(pose.poses, "index").tolist()
            )
        assert (
            values(partners, "group").tolist() == values(pose.poses, "group").tolist()
        )


def in_other_units(surface, seed):
    """And of another density."""
    scale = 10.0 ** np.random.default_rng(seed).uniform(-9.0, 9.0)
    return part_from_mesh(*moved(surface, scale=scale), mass=1.0 / scale), {
        "scale": scale
    }


def turned(surface, seed):
    return part_from_mesh(*moved(surface, rotation(seed))), {"turn": rotation(seed)}


def far_from_its_origin(surface, seed):
    """Coordinates up to 1000 sizes off are rounded to 1e-13 of the size before anything
    else.
    """
    shift = rotation(seed)[0] * 10.0 ** (seed % 4) * size(surface)
    return part_from_mesh(*moved(surface, offset=shift)), {}


def shuffled_and_wound_inward(surface, seed):
    vertices, triangles = shuffled(surface, seed)
    return part_from_mesh(vertices, triangles[:, ::-1]), {"within": 1e-10}


def with_finer_triangles(surface, seed):
    return part_from_mesh(*subdivided(starred(surface, seed))), {}


def with_a_pocket_inside(surface, _):
    """Points inside the hull change the mass properties only, and those are given
    here.
    """
    part = part_from_mesh(*surface)
    vertices, triangles = surface
    inner = 0.3 * (vertices - part.center_of_mass) + part.center_of_mass
    return part_from_mesh(
        np.vstack((vertices, inner)),
        np.vstack((triangles, triangles[:, ::-1] + len(vertices))),
        part.center_of_mass,
        part.mass,
        part.inertia,
    ), {}


def everything_at_once(surface, seed):
    changed = moved(subdivided(surface), rotation(seed), (30.0, -20.0, 5.0), 25.4)
    return part_from_mesh(*shuffled(changed, seed)), {
        "turn": rotation(seed),
        "scale": 25.4,
    }


@pytest.mark.parametrize(
    "change",
    [
        in_other_units,
        turned,
        far_from_its_origin,
        shuffled_and_wound_inward,
        with_finer_triangles,
        with_a_pocket_inside,
        everything_at_once,
    ],
    ids=lambda change: change.__name__,
)
@settings(max_examples=14)
@given(polyhedra, seeds, tolerances)
def test_the_same_body_has_the_same_answers(change, surface, seed, tolerance):
    changed, expected = change(surface, seed)
    assert_same_answers(
        part_from_mesh(*surface), changed, tolerance=tolerance, **expected
    )


@settings(max_examples=30)
@given(polyhedra, tolerances)
def test_every_answer_is_a_distribution_over_the_same_sound_poses(surface, tolerance):
    first, *others = estimate_all(part_from_mesh(*surface), cluster_tolerance=tolerance)
    first_poses = {pose.index: pose for pose in first.poses}
    assert sorted(first_poses) == list(range(len(first_poses)))
    for statistics in (first, *others):
        probability = values(statistics.poses, "probability")
        assert probability.min() >= 0.0
        assert probability.sum() == pytest.approx(1.0, abs=1e-12)
        assert np.all(np.diff(probability) <= 1e-9)
        assert sorted(pose.index for pose in statistics.poses) == sorted(first_poses)
        for pose in statistics.poses:
            assert pose.down.tolist() == first_poses[pose.index].down.tolist()
            assert pose.members == first_poses[pose.index].members
    heights = [first_poses[index].height for index in sorted(first_poses)]
    assert np.diff(heights).min(initial=0.0) > -SAME_HEIGHT * first.radius
    for pose in first.poses:
        assert np.linalg.norm(pose.down) == pytest.approx(1.0, abs=1e-14)
        assert 0.0 < pose.height < first.radius
        assert pose.height < pose.top <= pose.height + first.radius * (1.0 + 1e-12)
        assert 0.0 < pose.margin <= np.pi / 2.0
        assert pose.barrier > 0.0 and (
            pose.barrier < first.radius or len(first.poses) == 1
        )

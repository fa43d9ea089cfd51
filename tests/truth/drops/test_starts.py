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

"""Where drops start, what alone they depend on, and what no turn or mirror changes.

20 000 drops betray a shift of one share of 1/6 by 0.014.
"""

import numpy as np
import pytest
from scipy.stats import chi2, chisquare

from lab.bodies import shapes
from lab.bodies.samples import REGULAR_SOLIDS, random_polyhedron
from lab.bodies.variants import moved, rotation, shuffled
from ros_pose_stats import part_from_mesh, record_drop, simulate
from ros_pose_stats.core.shapes.demo_parts import DEMO_PARTS
from ros_pose_stats.core.simulation.drops import round_length
from tests.matching import matched
from tests.truth.drops.recorded import SURE, alike, outcomes

TETRAHEDRON = part_from_mesh(*shapes.tetrahedron())
DROPS = 20_000
STREAM_7 = (
    (-0.43807788535891384, 0.47219091624007153, 0.7649336605090824),
    (-0.49129081916362266, 0.8703262796967014, 0.034139388905422674),
)


def starts(seed, drops):
    """Directions (drops, 3) that point down at release."""
    chunks = []
    simulate(
        TETRAHEDRON,
        drops,
        0.0,
        seed,
        drop_height=1e-9,
        workers=1,
        on_drops=chunks.append,
    )
    assert [chunk.first for chunk in chunks] == np.cumsum(
        [0, *(len(chunk.downs) for chunk in chunks[:-1])]
    ).tolist()
    return np.concatenate([chunk.downs for chunk in chunks])


ROUNDED = 2e-14
"""Components of directions are multiples of 2^-46, to half of that."""


def test_the_stream_stays_what_it_was():
    """Recorded jobs are made again from their seed: these numbers are part of the
    contract, in a frame of the part's own.
    """
    expected = np.array(STREAM_7)
    directions = starts(7, 2)
    np.testing.assert_allclose(
        directions @ directions.T, expected @ expected.T, rtol=0, atol=2.0 * ROUNDED
    )


@pytest.mark.parametrize("seed", [0, 2**64 - 1])
def test_equal_areas_are_equally_full(seed):
    """16 x 32 cells of the sphere, 30 000 drops: within the central 99.9 % of
    chi-square.
    """
    directions = starts(seed, 30_000)
    np.testing.assert_allclose(
        np.linalg.norm(directions, axis=1), 1.0, rtol=0, atol=ROUNDED
    )
    x, y, z = directions.T
    rows = np.minimum((8.0 * (z + 1.0)).astype(int), 15)
    columns = np.minimum((16.0 * (np.arctan2(y, x) / np.pi + 1.0)).astype(int), 31)
    expected = 30_000 / 512
    statistic = (
        (np.bincount(32 * rows + columns, minlength=512) - expected) ** 2 / expected
    ).sum()
    assert chi2.ppf(0.0005, 511) < statistic < chi2.isf(0.0005, 511)
    # Products of successive drops: mean 0, variance 1/3; five standard errors.
    product = (directions[:-1] * directions[1:]).sum(axis=1)
    assert abs(product.mean()) < 5.0 * np.sqrt(1.0 / 3.0 / len(product))


def test_other_seeds_and_numbers_are_other_drops():
    """None recurs elsewhere either: the closest of 640² random pairs are far apart."""
    for seed in (0, 2**32 + 1, 2**64 - 1):
        assert np.abs(starts(1, 640) @ starts(seed, 640).T).max() < 1.0 - 1e-9
    downs = [
        record_drop(TETRAHEDRON, drop, seed=3).down for drop in (0, 1, 2**40, 2**50)
    ]
    assert np.linalg.norm(downs, axis=1) == pytest.approx(1.0, abs=ROUNDED)
    assert (np.array(downs) @ np.array(downs).T - 2.0 * np.eye(4)).max() < 0.999999


@pytest.mark.parametrize("height", [1.01, 20.0])
@pytest.mark.parametrize("name", ["clamp", "box"])
def test_a_drop_depends_on_its_own_start_alone(name, height):
    """Face down, the most symmetric start of all, before and after other drops.

    A flat landing on many corners is one great tie, decided by the smallest things.
    """
    part = part_from_mesh(
        *(shapes.box(1.0, 2.0, 3.0) if name == "box" else DEMO_PARTS[name]())
    )
    first = simulate(part, 1, seed=1)
    downs = np.array([pose.down for pose in first.poses])
    mixed = np.concatenate([np.repeat(downs, 3, axis=0), starts(1, 20), downs])
    mixed_poses = outcomes(part, starts=mixed, drop_height=height * first.radius)
    for i, down in enumerate(mixed):
        single_poses = outcomes(
            part, starts=down[None], drop_height=height * first.radius
        )
        assert [
            mixed_poses.pose[i],
            mixed_poses.impacts[i],
            mixed_poses.energy_left[i],
        ] == [
            single_poses.pose[0],
            single_poses.impacts[0],
            single_poses.energy_left[0],
        ]


def test_equal_starts_end_alike_whatever_the_workers():
    part = part_from_mesh(*random_polyhedron(9, 3))
    expected = record_drop(part, start=[0.0, 0.0, -1.0]).pose
    for workers in (1, 2):
        statistics = simulate(part, starts=[[0.0, 0.0, -1.0]] * 300, workers=workers)
        assert {pose.index: pose.count for pose in statistics.poses if pose.count} == {
            expected: 300
        }


def groups(statistics):
    """Counts of the poses of each symmetry group, the smallest group first."""
    members = {}
    for pose in statistics.poses:
        members.setdefault(pose.group, []).append(pose.count)
    return sorted(members.values(), key=len)


@pytest.mark.parametrize(
    ("name", "restitution", "faces"),
    [
        ("cube", 0.0, 6),
        ("cube", 0.4, 6),
        ("tetrahedron", 0.4, 4),
        ("octahedron", 0.0, 8),
    ],
)
def test_all_faces_of_a_regular_solid_are_alike(name, restitution, faces):
    (counts,) = groups(
        simulate(part_from_mesh(*REGULAR_SOLIDS[name]), DROPS, restitution, 11)
    )
    assert (len(counts), sum(counts)) == (faces, DROPS)
    assert chisquare(counts).pvalue > SURE


@pytest.mark.parametrize("restitution", [0.0, 0.4])
def test_a_square_prism_has_two_kinds_of_faces(restitution):
    ends, sides = groups(
        simulate(part_from_mesh(*shapes.box(1.0, 1.0, 2.0)), DROPS, restitution, 12)
    )
    assert (len(ends), len(sides)) == (2, 4)
    assert sum(sides) > 0.9 * DROPS
    assert chisquare(sides).pvalue > SURE
    assert chisquare(ends).pvalue > SURE


def test_mirror_images_are_alike():
    """Poses of the mirrored part are not of the same group, yet have the same
    shares.
    """
    surface = random_polyhedron(9, 2)
    mirrored = surface[0] * (-1.0, 1.0, 1.0), surface[1][:, ::-1]
    first, second = (
        simulate(part_from_mesh(*s), 10_000, 0.3, seed)
        for seed, s in enumerate((surface, mirrored))
    )
    assert alike(first, second, turn=np.diag((-1.0, 1.0, 1.0))) > SURE


def test_a_turned_copy_has_the_same_shares():
    surface = random_polyhedron(9, 1)
    turn = rotation(1)
    copy = moved(shuffled(surface, 1), turn, (3.0, -1.0, 2.0), scale=0.01)
    first, second = (
        simulate(part_from_mesh(*s), 10_000, 0.3, 5) for s in (surface, copy)
    )
    assert alike(first, second, turn) > SURE


def test_a_turned_copy_from_turned_starts_has_the_same_drops():
    """Without restitution few impacts follow each other: rounding rarely grows to
    matter.
    """
    surface = random_polyhedron(9, 3)
    turn = rotation(3)
    starts = np.random.default_rng(1).standard_normal((2000, 3))
    plain = simulate(part_from_mesh(*surface), restitution=0.0, starts=starts)
    turned = simulate(
        part_from_mesh(*moved(surface, turn)), restitution=0.0, starts=starts @ turn.T
    )
    partners = matched(plain.poses, turned.poses, turn)
    assert (
        sum(abs(a.count - b.count) for a, b in zip(plain.poses, partners, strict=True))
        <= 40
    )


@pytest.mark.parametrize("length", [0.0, 5e-324, 1e-310, 1e-15, 0.1, 20.0, 1e300])
def test_lengths_are_rounded_to_a_share_of_themselves(length):
    """Next to none, too, of which no step is left."""
    assert abs(round_length(length) - length) <= max(2.0**-36 * length, 2.0**-101)

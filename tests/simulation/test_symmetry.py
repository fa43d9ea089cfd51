"""Equal faces get equal shares, and turning a mesh changes nothing.

Chi-square with fixed seeds, p > 1e-4: with a dozen comparisons a right simulation fails one
with a chance of a thousandth, whereas 40 000 drops betray a shift of one share of 1/6 by 0.01.
"""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chisquare

from ros_pose_stats import part_from_mesh, shapes, simulate

from ..bodies import REGULAR_SOLIDS, moved, random_polyhedron, rotation, shuffled
from .dropping import alike

DROPS = 40_000
SURE = 1e-4


def groups(statistics):
    """Counts of the poses of each symmetry group."""
    found = {}
    for pose in statistics.poses:
        found.setdefault(pose.group, []).append(pose.count)
    return list(found.values())


@pytest.mark.parametrize("restitution", [0.0, 0.4])
@pytest.mark.parametrize("name", ["cube", "tetrahedron", "octahedron"])
def test_all_faces_of_a_regular_solid_are_alike(name, restitution):
    found = simulate(part_from_mesh(*REGULAR_SOLIDS[name]), DROPS, restitution, 11)
    counts, = groups(found)
    assert len(counts) == {"cube": 6, "tetrahedron": 4, "octahedron": 8}[name]
    assert sum(counts) == DROPS
    assert chisquare(counts).pvalue > SURE


@pytest.mark.parametrize("restitution", [0.0, 0.4])
def test_a_square_prism_has_two_kinds_of_faces(restitution):
    found = simulate(part_from_mesh(*shapes.box(1.0, 1.0, 2.0)), DROPS, restitution, 12)
    ends, sides = sorted(groups(found), key=len)
    assert (len(ends), len(sides)) == (2, 4)
    assert sum(sides) > 0.9 * DROPS
    assert chisquare(sides).pvalue > SURE
    assert chisquare(ends).pvalue > SURE


def test_mirror_images_of_each_other_are_alike():
    """Poses of the mirrored part are not of the same group, yet have the same shares."""
    surface = random_polyhedron(9, 2)
    mirrored = surface[0] * (-1.0, 1.0, 1.0), surface[1][:, ::-1]
    found, other = (simulate(part_from_mesh(*s), 15_000, 0.3, seed)
                    for seed, s in enumerate((surface, mirrored)))
    assert alike(found, other, turn=np.diag((-1.0, 1.0, 1.0))) > SURE


@pytest.mark.long
@pytest.mark.parametrize("seed", range(2))
def test_a_turned_copy_has_the_same_shares(seed):
    surface, turn = random_polyhedron(9, seed), rotation(seed)
    copy = moved(shuffled(surface, seed), turn, (3.0, -1.0, 2.0), scale=0.01)
    found, other = (simulate(part_from_mesh(*s), 15_000, 0.3, 5) for s in (surface, copy))
    assert alike(found, other, turn) > SURE


def test_a_turned_copy_from_turned_starts_has_the_same_drops():
    """Without restitution few impacts follow each other: rounding rarely grows to matter."""
    surface, turn = random_polyhedron(9, 3), rotation(3)
    part, copy = part_from_mesh(*surface), part_from_mesh(*moved(surface, turn))
    starts = np.random.default_rng(1).standard_normal((2000, 3))
    for each in range(0, 2000, 400):
        rows = starts[each:each + 400]
        found = simulate(part, restitution=0.0, starts=rows)
        other = simulate(copy, restitution=0.0, starts=rows @ turn.T)
        counts = {tuple(np.round(turn @ pose.down, 6)): pose.count for pose in found.poses}
        moved_over = sum(abs(pose.count - counts[tuple(np.round(pose.down, 6))])
                         for pose in other.poses)
        assert moved_over <= 8

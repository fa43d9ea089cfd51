"""Parts that roll to and fro on a rim for long: none is given up, and none is decided
wrongly.
"""

import numpy as np
import pytest
from manifold3d import Manifold

from lab.bodies.fine_parts import surface
from ros_pose_stats import part_from_mesh, resting_poses, sensitivity, simulate
from tests.answers import counts
from tests.truth.drops.recorded import outcomes


def part_of(solid):
    return part_from_mesh(*surface(solid))


def cylinder(height, radius, above=0.0, offset=0.0):
    return Manifold.cylinder(height, radius, circular_segments=96).translate(
        (offset, 0.0, above)
    )


RING = part_of(cylinder(0.6, 1.0) - cylinder(1.0, 0.6, above=-0.1))
# A disc with a large hole beside its axis: upright it swings about its heaviest side.
COVER = part_of(cylinder(0.2, 1.0) - cylinder(1.0, 0.4, above=-0.5, offset=0.45))
TUBE = cylinder(0.3, 0.4, above=1.0) - cylinder(0.3, 0.38, above=1.0)
# A shaft that half a tube goes on from: the long sides of that lie along the axis.
SHAFT = part_of(cylinder(1.0, 0.4) + TUBE.trim_by_plane((1.0, 0.0, 0.0), 0.0))


def test_drops_that_roll_are_counted():
    """Released nearly upright: an even cap on the steps would take those that stay
    so.
    """
    random = np.random.default_rng(3)
    angle = random.uniform(0.0, 2.0 * np.pi, 40)
    starts = np.stack(
        (np.cos(angle), np.sin(angle), random.uniform(-0.02, 0.02, 40)), axis=1
    )
    statistics = simulate(COVER, starts=starts, drop_height=1e-6)
    assert statistics.unsettled == 0
    assert not any(warning.code == "UNSETTLED" for warning in statistics.warnings)
    assert counts(statistics)[2] > 10


def compare_facet_by_facet(part, drops, restitution, sides):
    """Drops in each pose, and how many ended sooner than on a facet; all must end
    alike.

    With every facet a pose a drop goes on until one holds it. What is given up tells
    nothing.
    """
    pose_of = np.full(500, -1)
    for pose in resting_poses(part, round_sides=sides).poses:
        pose_of[list(pose.members)] = pose.index
    whole = outcomes(
        part, drops, restitution, 11, cluster_tolerance=0.0, round_sides=sides
    )
    short = outcomes(part, drops, restitution, 11, round_sides=sides)
    settled = whole.pose >= 0
    np.testing.assert_array_equal(short.pose[settled], pose_of[whole.pose[settled]])
    assert (short.impacts <= whole.impacts).all()
    return np.bincount(short.pose[settled]), int(
        (short.impacts < whole.impacts)[settled].sum()
    )


@pytest.mark.parametrize(
    ("part", "drops", "restitution", "sides", "least"),
    [
        (RING, 200, 0.5, 192, 10),
        (COVER, 300, 0.5, 48, 3),
        (COVER, 300, 0.8, 48, 3),
        (SHAFT, 100, 0.5, 96, 2),
    ],
)
def test_rolls_are_decided_before_they_end(part, drops, restitution, sides, least):
    """A drop that is told on the rim while it rolls is the same drop in the same
    pose.
    """
    number, sooner = compare_facet_by_facet(part, drops, restitution, sides)
    assert number[-1] > least and sooner > least


def test_edges_along_the_axis_tip_nothing_over():
    """Half a tube goes on from a shaft, which rolls no longer for it."""
    assert outcomes(SHAFT, 100, 0.5, 11, round_sides=96).impacts.mean() < 40


def test_a_leaning_part_does_not_roll_upright():
    """A boss beside the axis: the rim's pose goes on over the boss, where the part
    still falls.
    """
    cam = part_of(cylinder(0.43, 1.0) + cylinder(0.85, 0.45, above=0.42, offset=0.45))
    number, _ = compare_facet_by_facet(cam, 100, 0.1, 96)
    assert number[1] > number[2]


@pytest.mark.long
def test_a_changed_part_may_have_lost_a_round_surface():
    """The cone that a headed pin leans on moved in until nothing of the head's rim is
    left.
    """
    pin = part_of(cylinder(0.04, 1.0) + cylinder(1.2, 0.5))
    for pose in resting_poses(pin).poses:
        analysis = sensitivity(pin, [pose.index], drops=20, checks=50, seed=1)
        assert analysis.drops == 20

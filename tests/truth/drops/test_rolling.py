"""Parts that roll to and fro on a rim for long: none is given up, and none is decided
wrongly.
"""

import numpy as np
import pytest
from manifold3d import CrossSection, Manifold
from scipy.stats import chisquare

from lab.bodies.fine_parts import surface
from ros_pose_stats import (
    DropScene,
    part_from_mesh,
    resting_poses,
    sensitivity,
    simulate,
)
from ros_pose_stats.core.simulation.drop_body import drop_body
from ros_pose_stats.core.simulation.drops import (
    compute_drops,
    drop_rules,
    release_directions,
)
from tests.answers import counts
from tests.truth.drops.recorded import SURE, outcomes


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


def starts_of(part, drops):
    """Where the drops of a seed begin: told, no roll is ended by a draw."""
    return release_directions(drop_body(part, DropScene()), 11, 0, drops)


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

    With every facet a pose a drop goes on until one holds it, where it begins as it is
    told to. What is given up tells nothing.
    """
    starts = starts_of(part, drops)
    pose_of = np.full(500, -1)
    for pose in resting_poses(part, round_sides=sides).poses:
        pose_of[list(pose.members)] = pose.index
    whole = outcomes(
        part,
        drops,
        restitution,
        starts=starts,
        cluster_tolerance=0.0,
        round_sides=sides,
    )
    short = outcomes(part, drops, restitution, starts=starts, round_sides=sides)
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
        (COVER, 300, 0.8, 48, 1),
        (SHAFT, 100, 0.5, 96, 1),
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
    starts = starts_of(SHAFT, 100)
    assert outcomes(SHAFT, 100, 0.5, starts=starts, round_sides=96).impacts.mean() < 40


def oval(sides, width, length):
    """An elliptic cylinder, and one with two flats cut into it."""
    angle = np.arange(sides) * 2.0 * np.pi / sides
    outline = np.column_stack((np.cos(angle), width * np.sin(angle)))
    return Manifold.extrude(CrossSection([outline]), length)


def flats(width, length):
    block = Manifold.cube((3.0, 2.0 * width, 3.0 * length), center=True)
    return cylinder(length, 1.0) ^ block


@pytest.mark.parametrize(
    ("part", "restitution"),
    [
        (part_of(oval(96, 0.9, 1.5)), 0.5),
        (part_of(oval(96, 0.9, 1.5)), 0.8),
        (part_of(oval(60, 0.7, 0.8)), 0.2),
        (part_of(flats(0.95, 1.5)), 0.5),
    ],
)
def test_rolls_over_equal_poses_are_drawn(part, restitution):
    """A roll that will end on one of two equal sides is over; run on it ends there."""
    chunks = []
    simulate(part, 400, restitution, 5, workers=1, on_drops=chunks.append)
    pose, drawn, events = (
        np.concatenate([getattr(chunk.outcomes, name) for chunk in chunks])
        for name in ("pose", "drawn", "events")
    )
    scene = DropScene(restitution)
    body = drop_body(part, scene)
    whole = compute_drops(
        body, drop_rules(scene, body.radius), release_directions(body, 5, 0, 400)
    )
    unit = body.resting.unit
    np.testing.assert_array_equal(unit[pose], unit[whole.pose])
    np.testing.assert_array_equal(pose[~drawn], whole.pose[~drawn])
    assert drawn.mean() > 0.5 and events.sum() < 0.5 * whole.events.sum()
    sides = np.bincount(pose[drawn])
    sides = sides[sides > 0]
    assert len(sides) == 2 and chisquare(sides).pvalue > SURE


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
        assert analysis.drops == (20 if analysis.checked else 0)

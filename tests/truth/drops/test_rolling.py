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

"""Parts that roll to and fro on a rim for long: none is given up, and none is decided
wrongly.
"""

import numpy as np
import pytest
from scipy.stats import chisquare

from lab.bodies.rolling import (
    ROLLING,
    cylinder,
    oval,
    part_of,
    run_on,
    shaft_between,
)
from ros_pose_stats import DropScene, resting_poses, sensitivity, simulate
from ros_pose_stats.core.kernels.drops import layout
from ros_pose_stats.core.simulation.drop_body import drop_body
from ros_pose_stats.core.simulation.drops import (
    compute_drops,
    drop_rules,
    release_directions,
)
from ros_pose_stats.core.tolerances import TOUCHING
from tests.answers import counts
from tests.truth.drops.recorded import SURE, outcomes

RING = ROLLING["ring"]()
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


def compare_run_on(part, restitution, drops):
    """Outcomes of drops, their units, and the events that the same ones take run on.

    All must end in the same unit, those of which no pose is drawn in the same pose.
    """
    scene = DropScene(restitution)
    body = drop_body(part, scene)
    rules = drop_rules(scene, body.radius, draws=True)
    downs = release_directions(body, 5, 0, drops)
    short = compute_drops(body, rules, downs)
    whole = compute_drops(run_on(body), rules, downs)
    unit = body.resting.unit
    np.testing.assert_array_equal(unit[short.pose], unit[whole.pose])
    settled = ~short.drawn
    np.testing.assert_array_equal(short.pose[settled], whole.pose[settled])
    return short, unit, int(whole.events.sum())


@pytest.mark.parametrize(
    ("part", "restitution"),
    [
        (part_of(oval(96, 0.9, 1.5)), 0.5),
        (part_of(oval(96, 0.9, 1.5)), 0.8),
        (part_of(oval(60, 0.7, 0.8)), 0.2),
        (part_of(shaft_between(-0.95, 0.95, 1.5)), 0.5),
        (part_of(shaft_between(-0.8, 0.8, 3.0)), 0.5),
        (ROLLING["hexagonal cap nut"](), 0.5),
    ],
)
def test_long_drops_over_equal_poses_are_drawn(part, restitution):
    """A drop that will end on one of several equal poses is over; run on it ends
    there.
    """
    short, unit, whole_events = compare_run_on(part, restitution, 300)
    assert short.drawn.mean() > 0.4 and short.events.sum() < 0.5 * whole_events
    chunks = []
    simulate(part, 300, restitution, 5, workers=1, on_drops=chunks.append)
    pose, drawn = (
        np.concatenate([getattr(chunk.outcomes, name) for chunk in chunks])
        for name in ("pose", "drawn")
    )
    np.testing.assert_array_equal(unit[pose], unit[short.pose])
    np.testing.assert_array_equal(drawn, short.drawn)
    most_drawn = np.bincount(unit[pose[drawn]]).argmax()
    members = np.flatnonzero(unit == most_drawn)
    sides = np.bincount(pose[drawn], minlength=unit.size)[members]
    assert len(sides) > 1 and chisquare(sides).pvalue > SURE


@pytest.mark.parametrize(
    ("name", "fewer"), [("half cylinder", 0.5), ("oval with a flat", 0.7)]
)
def test_a_roll_that_keeps_to_an_arc_is_over(name, fewer):
    """A flat beside the arc is another pose, which the roll no longer reaches; nor do
    its ends.
    """
    short, _, whole_events = compare_run_on(ROLLING[name](), 0.5, 300)
    assert not short.drawn.any()
    assert short.events.sum() < fewer * whole_events


def test_a_facet_is_as_wide_as_it_is():
    """Chamfers cut the ends of an octagon's sides to pieces: it hardly rolls on
    these.
    """
    compare_run_on(ROLLING["octagonal cap nut"](), 0.5, 150)


def test_no_corner_that_lands_is_missed():
    """An egg rolls over some of thousands of corners: at no event is one below the
    plate, and the one that arrives is there.
    """
    body = drop_body(ROLLING["cut egg"](), DropScene())
    rules = drop_rules(DropScene(), body.radius)
    corners = np.column_stack((body.arrays.x, body.arrays.y, body.arrays.z))
    tape = np.zeros((3_000, layout.TAPE))
    for down in release_directions(body, 5, 0, 4):
        compute_drops(body, rules, down[None], tape)
        rows = tape[1 : int(tape[0, 0]) + 1]
        states = rows[:, layout.TAPE_STATE : layout.TAPE_STATE + layout.STATE]
        ups = states[:, layout.P : layout.P + 3]
        heights = states[:, layout.Z, None] + ups @ corners.T
        assert heights.min() > -2.0 * TOUCHING
        arrivals = np.flatnonzero(rows[:, layout.TAPE_EVENT] == layout.ARRIVAL)
        arrived = rows[arrivals, layout.TAPE_VERTEX].astype(np.int64)
        assert arrivals.size > 5
        assert heights[arrivals, arrived].max() < TOUCHING


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

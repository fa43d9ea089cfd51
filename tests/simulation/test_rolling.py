"""Parts that roll to and fro on a rim for long: none is given up, whatever it takes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from manifold3d import Manifold

from ros_pose_stats import part_from_mesh, resting_poses, simulate
from ros_pose_stats.design.changes import DesignSpace
from ros_pose_stats.records import DropScene
from ros_pose_stats.simulation.drop_body import drop_body
from ros_pose_stats.simulation.drops import compute_drops, drop_rules
from ros_pose_stats.simulation.starts import random_starts
from ros_pose_stats.tolerances import MOST_STEPS
from training.families import family_part

from ..fine_parts import surface
from .dropping import counts


@pytest.fixture(scope="module")
def cover():
    """A disc with a large hole beside its axis: upright it swings about its heaviest side."""
    disc = Manifold.cylinder(0.2, 1.0, circular_segments=96)
    hole = Manifold.cylinder(1.0, 0.4, circular_segments=96).translate((0.45, 0.0, -0.5))
    return part_from_mesh(*surface(disc - hole))


def upright(count, seed=3):
    """Directions (count, 3) that point down at release, close to those on the rim."""
    random = np.random.default_rng(seed)
    angle = random.uniform(0.0, 2.0 * np.pi, count)
    return np.stack((np.cos(angle), np.sin(angle), random.uniform(-0.02, 0.02, count)), axis=1)


def test_drops_that_roll_are_counted(cover):
    found = simulate(cover, starts=upright(40), drop_height=1e-6)
    assert found.unsettled == 0
    assert found.warnings == () or not any("UNSETTLED" in one for one in found.warnings)
    assert counts(found)[2] > 10


def without_rims(body):
    """The same body, whose drops go on as long as they have the energy to leave a pose at all."""
    nowhere = np.full_like(body.arrays.roll_pose, -1)
    return replace(body, arrays=body.arrays._replace(roll_pose=nowhere))


def compare_to_whole_drops(part, restitution, drops, seed=11):
    """Number of drops that end sooner on a rim; all must end as the drop that goes on does.

    What goes on and is given up after the most steps tells nothing.
    """
    body = drop_body(part, 0.0025, 192)
    rules = drop_rules(DropScene(restitution), body.radius)
    downs = random_starts(seed, 0, drops)
    short = compute_drops(body, rules, downs)
    whole = compute_drops(without_rims(body), rules, downs)
    told = whole.pose >= 0
    np.testing.assert_array_equal(short.pose[told], whole.pose[told])
    assert (short.impacts <= whole.impacts).all()
    return int((short.impacts < whole.impacts).sum())


def test_rolls_are_decided_before_they_end():
    """A drop that is told on the rim while it rolls is the same drop in the same pose."""
    ring = Manifold.cylinder(0.6, 1.0, circular_segments=96) - Manifold.cylinder(
        1.0, 0.6, circular_segments=96).translate((0.0, 0.0, -0.1))
    assert compare_to_whole_drops(part_from_mesh(*surface(ring)), 0.5, 1000) > 20


@pytest.mark.long
@pytest.mark.parametrize("restitution", [0.2, 0.5, 0.8])
def test_lopsided_rolls_are_decided_before_they_end(cover, restitution):
    """The centre of mass rises and falls as the part rolls, which some drops do for long."""
    assert compare_to_whole_drops(cover, restitution, 400) > 5


@pytest.mark.long
@pytest.mark.parametrize("restitution", [0.3, 0.9])
def test_turned_parts_roll_alike(restitution):
    """Turned parts of all kinds, also with a flat along the rim or a bore."""
    sooner = 0
    for family in ("rounds", "stepped", "hollow", "gears"):
        for number in range(12):
            sooner += compare_to_whole_drops(family_part(family, 88, number), restitution, 100)
    assert sooner > 20


def test_steps_are_granted_for_progress_alone(cover):
    """The same drops with half of the steps at a time end alike, to the last bit."""
    body = drop_body(cover, 0.0025, 192)
    rules = drop_rules(DropScene(0.5, 1e-6), body.radius)
    downs = upright(6)
    usual = compute_drops(body, rules, downs)
    assert usual.pose.min() >= 0
    few = compute_drops(body, rules._replace(most_steps=MOST_STEPS // 2), downs)
    for name in ("pose", "impacts", "seconds", "energy_left"):
        np.testing.assert_array_equal(getattr(few, name), getattr(usual, name))


def test_no_drop_goes_on_for_ever(cover):
    """From such a height the energy falls by a little each time, for hours."""
    body = drop_body(cover, 0.0025, 192)
    rules = drop_rules(DropScene(0.5, 1e160), body.radius)._replace(most_steps=1000)
    assert (compute_drops(body, rules, upright(3)).pose == -1).all()


def test_a_changed_part_may_have_lost_a_round_surface():
    """The cone that a headed pin leans on moved in until nothing of the head's rim is left."""
    pin = Manifold.cylinder(0.04, 1.0, circular_segments=96) + Manifold.cylinder(
        1.2, 0.5, circular_segments=96)
    space = DesignSpace(part_from_mesh(*surface(pin)))
    changed = [space.change_one(number, -0.05 * space.body.radius).part
               for number, one in enumerate(space.features) if one.kind == "face"]
    runs = np.arange(len(space.body.runs))
    lost = [part for part in changed
            if not np.isin(runs, resting_poses(part).body.run_of_face).all()]
    assert lost
    assert all(simulate(part, 20, seed=1).unsettled == 0 for part in lost)
